/* Copies a file on a web server block by block, as it is needed. */
#include "formats/scan/remote/mirror.h"

#include "base/memory.h"
#include "base/temporary.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Blocks that one request brings, at most. */
#define RUN_BLOCKS 32u
/* Larger files would need a table of blocks too large for memory. */
#define BYTES_MOST (UINT64_C(1) << 46)

struct stp_file_mirror {
    stp_byte_source *source;
    int descriptor;
    char path[STP_MIRROR_PATH_BYTES], *folder;
    uint64_t size, fetched, block_count;
    uint8_t *there;  /* a bit for each block */
    uint8_t *buffer; /* RUN_BLOCKS */
};

static stp_status make_file(stp_file_mirror *m, const char *given, stp_error *err)
{
    stp_status status = STP_OK;
    const char *temporary = getenv("TMPDIR");
    const char *folder = given ? given : temporary && *temporary ? temporary : "/tmp";
    STP_TRY(stp_text_copy(&m->folder, folder, "a path", err));
    m->descriptor = stp_temporary_nameless(folder);
    if (m->descriptor < 0 || ftruncate(m->descriptor, (off_t)m->size) != 0)
        status =
            stp_error_set(err, STP_IO,
                          "%s: no temporary file of %llu bytes can be made there for %s: %s: "
                          "choose another folder (--temp)",
                          folder, (unsigned long long)m->size, stp_mirror_name(m), strerror(errno));
    snprintf(m->path, sizeof m->path, "/proc/self/fd/%d", m->descriptor);
done:
    return status;
}

stp_status stp_mirror_open(stp_file_mirror **out, const char *address,
                           const stp_mirror_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_file_mirror *m = NULL;
    STP_TRY(stp_alloc(&m, 1, sizeof *m, "an address", err));
    m->descriptor = -1;
    STP_TRY(stp_byte_source_open(&m->source, address, params->web, err));
    m->size = stp_byte_source_size(m->source);
    if (m->size > BYTES_MOST) {
        status = stp_error_set(err, STP_LIMIT,
                               "%s: the server says that it has %llu bytes, and at most %llu are "
                               "read: is it the right file?",
                               stp_mirror_name(m), (unsigned long long)m->size,
                               (unsigned long long)BYTES_MOST);
        goto done;
    }
    m->block_count = m->size / STP_MIRROR_BLOCK_BYTES + 1;
    STP_TRY(stp_alloc(&m->there, (size_t)(m->block_count / 8 + 1), 1, "blocks of a file", err));
    STP_TRY(stp_alloc(&m->buffer, RUN_BLOCKS, STP_MIRROR_BLOCK_BYTES, "bytes of a file", err));
    STP_TRY(make_file(m, params->folder, err));
    *out = m;
    m = NULL;
done:
    stp_mirror_close(&m);
    return status;
}

void stp_mirror_close(stp_file_mirror **mirror)
{
    stp_file_mirror *m = *mirror;
    if (!m)
        return;
    stp_byte_source_close(&m->source);
    if (m->descriptor >= 0)
        close(m->descriptor);
    free(m->folder);
    free(m->there);
    free(m->buffer);
    free(m);
    *mirror = NULL;
}

const char *stp_mirror_path(const stp_file_mirror *m)
{
    return m->path;
}

const char *stp_mirror_name(const stp_file_mirror *m)
{
    return stp_byte_source_name(m->source);
}

uint64_t stp_mirror_size(const stp_file_mirror *m)
{
    return m->size;
}

uint64_t stp_mirror_fetched(const stp_file_mirror *m)
{
    return m->fetched;
}

static bool is_there(const stp_file_mirror *m, uint64_t block)
{
    return m->there[block / 8] >> block % 8 & 1;
}

static stp_status write_all(const stp_file_mirror *m, uint64_t offset, size_t size, stp_error *err)
{
    for (size_t done = 0; done < size;) {
        const ssize_t part =
            pwrite(m->descriptor, m->buffer + done, size - done, (off_t)(offset + done));
        if (part < 0 && errno != EINTR)
            return stp_error_set(err, STP_IO,
                                 "%s: the copy of %s cannot be written: %s: make room there, or "
                                 "choose another folder (--temp)",
                                 m->folder, stp_mirror_name(m), strerror(errno));
        done += part > 0 ? (size_t)part : 0;
    }
    return STP_OK;
}

/* Fetches blocks [first, last], which are all missing. */
static stp_status fetch(stp_file_mirror *m, uint64_t first, uint64_t last, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t begin = first * STP_MIRROR_BLOCK_BYTES;
    const uint64_t stop = (last + 1) * STP_MIRROR_BLOCK_BYTES;
    const size_t size = (size_t)((stop < m->size ? stop : m->size) - begin);
    STP_TRY(stp_byte_source_read(m->source, begin, m->buffer, size, err));
    STP_TRY(write_all(m, begin, size, err));
    m->fetched += size;
    for (uint64_t b = first; b <= last; b++)
        m->there[b / 8] |= (uint8_t)(1u << b % 8);
done:
    return status;
}

stp_status stp_mirror_need(stp_file_mirror *m, uint64_t begin, uint64_t end, stp_error *err)
{
    stp_status status = STP_OK;
    end = end < m->size ? end : m->size;
    if (begin >= end)
        return STP_OK;
    const uint64_t stop = (end - 1) / STP_MIRROR_BLOCK_BYTES + 1;
    for (uint64_t b = begin / STP_MIRROR_BLOCK_BYTES; b < stop;) {
        uint64_t run = 0;
        while (b + run < stop && run < RUN_BLOCKS && !is_there(m, b + run))
            run++;
        if (run > 0)
            STP_TRY(fetch(m, b, b + run - 1, err));
        b += run > 0 ? run : 1;
    }
done:
    return status;
}
