/* Reads a file forwards in large blocks. */
#include "formats/scan/source.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/scan/remote/mirror.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Large enough that reading costs little beside decoding, small enough for the second-level cache.
 */
#define STP_SOURCE_BLOCK ((size_t)1 << 19)

stp_status stp_source_open(stp_source *source, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_source s = {.descriptor = -1, .path = path};
    STP_TRY(stp_file_open(path, &s.descriptor, &s.size, err));
    STP_TRY(stp_grow(&s.buffer, &s.capacity, STP_SOURCE_BLOCK, 1, "bytes of a block", err));
    *source = s;
    s = (stp_source){.descriptor = -1};
done:
    stp_source_close(&s);
    return status;
}

void stp_source_close(stp_source *source)
{
    if (source->descriptor >= 0)
        close(source->descriptor);
    free(source->buffer);
    *source = (stp_source){.descriptor = -1};
}

void stp_source_seek(stp_source *source, uint64_t offset, uint64_t line)
{
    source->offset = offset;
    source->line = line;
    source->begin = source->end = 0;
}

/* Whether bytes are plain characters and zeros in turns. */
static uint8_t wide_without_mark(const unsigned char *bytes)
{
    size_t zeros[2] = {0, 0}, characters = 0;
    for (size_t i = 0; i < STP_WIDE_BYTES; i++) {
        zeros[i % 2] += bytes[i] == 0;
        characters += (bytes[i] >= ' ' && bytes[i] <= '~') || bytes[i] == '\t' ||
                      bytes[i] == '\r' || bytes[i] == '\n';
    }
    const size_t half = STP_WIDE_BYTES / 2;
    if (characters < half || zeros[0] + zeros[1] != half)
        return 0;
    return zeros[0] == half ? 1 : zeros[1] == half ? 2 : 0;
}

uint8_t stp_source_is_wide(const unsigned char *bytes, size_t length, size_t *begin)
{
    *begin = 1;
    if (length >= 2 && bytes[0] == 0xfe && bytes[1] == 0xff)
        return 1;
    if (length >= 2 && bytes[0] == 0xff && bytes[1] == 0xfe)
        return 2;
    *begin = 0;
    return length >= STP_WIDE_BYTES ? wide_without_mark(bytes) : 0;
}

void stp_source_narrow(unsigned char *out, const unsigned char *characters, size_t count,
                       uint8_t wide)
{
    const size_t high = wide - 1u;
    for (size_t i = 0; i < count; i++)
        out[i] = characters[2 * i + high] == 0 ? characters[2 * i + 1 - high] : '?';
}

void stp_source_widen(stp_source *source, uint8_t wide)
{
    source->wide = wide;
    source->size /= 2;
    stp_source_seek(source, 0, 0);
}

void stp_source_skip(stp_source *source, uint64_t size)
{
    if (size <= source->end - source->begin)
        stp_source_consume(source, (size_t)size);
    else
        stp_source_seek(source, source->offset + size, source->line);
}

/* Reads on until the buffer holds at least `needed` unread bytes, or the file ends. */
static stp_status fill(stp_source *source, size_t needed, stp_error *err)
{
    stp_status status = STP_OK;
    size_t held = source->end - source->begin;
    if (needed > STP_SOURCE_REQUEST_MAX)
        return stp_error_set(err, STP_LIMIT,
                             "%s: a line or record of more than %zu bytes at byte %llu: is it the "
                             "right file?",
                             source->path, STP_SOURCE_REQUEST_MAX,
                             (unsigned long long)source->offset);
    memmove(source->buffer, source->buffer + source->begin, held);
    source->begin = 0;
    source->end = held;
    const size_t bytes = source->wide ? 2 : 1; /* of a character */
    STP_TRY(
        stp_grow(&source->buffer, &source->capacity, needed * bytes, 1, "bytes of a block", err));
    uint64_t at = source->offset + held;
    uint64_t left = at < source->size ? source->size - at : 0;
    size_t part = (source->narrow ? needed : source->capacity / bytes) - held;
    if (part > left)
        part = (size_t)left;
    if (source->mirror)
        STP_TRY(stp_mirror_need(source->mirror, at * bytes, (at + part) * bytes, err));
    unsigned char *to = source->buffer + held;
    STP_TRY(stp_file_read_at(source->descriptor, source->path, at * bytes, to, part * bytes, err));
    if (source->wide)
        stp_source_narrow(to, to, part, source->wide);
    source->end += part;
done:
    return status;
}

stp_status stp_source_peek(stp_source *source, size_t size, const unsigned char **bytes,
                           size_t *available, stp_error *err)
{
    stp_status status = STP_OK;
    if (source->end - source->begin < size)
        STP_TRY(fill(source, size, err));
    *bytes = source->buffer + source->begin;
    *available = source->end - source->begin;
    if (*available > size)
        *available = size;
done:
    return status;
}

stp_status stp_source_line(stp_source *source, const char **begin, const char **end, stp_error *err)
{
    stp_status status = STP_OK;
    size_t searched = 0;
    const unsigned char *newline = NULL;
    const char mark = source->cr_lines ? '\r' : '\n';
    for (;;) {
        size_t held = source->end - source->begin;
        if (held > searched)
            newline = memchr(source->buffer + source->begin + searched, mark, held - searched);
        if (newline || source->offset + held >= source->size)
            break;
        searched = held;
        STP_TRY(fill(source, held + STP_SOURCE_BLOCK / 2, err));
    }
    const unsigned char *start = source->buffer + source->begin;
    size_t length = newline ? (size_t)(newline - start) : source->end - source->begin;
    if (length == 0 && !newline) {
        *begin = *end = NULL;
        goto done;
    }
    stp_source_consume(source, length + (newline ? 1 : 0));
    source->line++;
    if (length > 0 && start[length - 1] == '\r')
        length--;
    *begin = (const char *)start;
    *end = *begin + length;
done:
    return status;
}
