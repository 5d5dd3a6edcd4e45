/* Reads a damaged file's bytes and chunks with the mends laid over them, and reports. */
#include "formats/chunk/repair/damaged.h"

#include "base/checked.h"
#include "base/file.h"
#include "base/memory.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/repair/mend_bit.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void stp_damaged_say(const stp_damaged *d, const char *format, ...)
{
    char line[512];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    if (d->params->say)
        d->params->say(d->params->context, line);
}

stp_status stp_damaged_read(const stp_damaged *d, uint64_t offset, void *bytes, size_t size,
                            stp_error *err)
{
    size_t there = offset < d->file_bytes ? size : 0;
    if (there > 0 && there > d->file_bytes - offset)
        there = (size_t)(d->file_bytes - offset);
    stp_status status = stp_file_read_at(d->descriptor, d->path, offset, bytes, there, err);
    memset((uint8_t *)bytes + there, 0, size - there);
    for (size_t i = 0; status == STP_OK && i < d->mend_count; i++) {
        const stp_mend *m = &d->mends[i];
        uint64_t begin = m->offset > offset ? m->offset : offset;
        uint64_t end = m->offset + m->size < offset + size ? m->offset + m->size : offset + size;
        if (begin < end)
            memcpy((uint8_t *)bytes + (begin - offset), m->bytes + (begin - m->offset),
                   (size_t)(end - begin));
    }
    return status;
}

stp_status stp_damaged_mend(stp_damaged *d, uint64_t offset, const void *bytes, size_t size,
                            stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *copy = NULL;
    STP_TRY(
        stp_grow(&d->mends, &d->mend_capacity, d->mend_count + 1, sizeof *d->mends, "mends", err));
    STP_TRY(stp_alloc(&copy, size, 1, "mends", err));
    memcpy(copy, bytes, size);
    d->mends[d->mend_count++] = (stp_mend){offset, size, copy};
done:
    return status;
}

stp_status stp_damaged_mend_bit(stp_damaged *d, uint64_t offset, uint8_t *bytes, size_t size,
                                stp_hash_place hash, const char *what, bool *mended, stp_error *err)
{
    stp_status status = STP_OK;
    size_t bit = STP_NO_BIT;
    *mended = false;
    STP_TRY(stp_mend_bit(bytes, size, hash.value, hash.mask, d->params->pool, d->params->progress,
                         &bit, err));
    if (bit == STP_NO_BIT || (bit / 8 >= size && !hash.follows))
        goto done;
    bytes[bit / 8] = (uint8_t)(bytes[bit / 8] ^ 1u << bit % 8);
    STP_TRY(stp_damaged_mend(d, offset + bit / 8, &bytes[bit / 8], 1, err));
    stp_damaged_say(d, "byte %" PRIu64 ": bit %zu was flipped in %s: put back", offset + bit / 8,
                    bit % 8, what);
    *mended = true;
done:
    return status;
}

stp_status stp_damaged_read_checked(stp_damaged *d, uint64_t offset, size_t size, uint64_t hash,
                                    uint64_t mask, const char *what, uint8_t **bytes, bool *sound,
                                    stp_error *err)
{
    stp_status status = STP_OK;
    const bool there = stp_range_inside(offset, size, d->file_bytes);
    *sound = false;
    STP_TRY(stp_alloc(bytes, (there ? size : 0) + 1, 1, what, err));
    if (!there)
        return STP_OK;
    STP_TRY(stp_damaged_read(d, offset, *bytes, size, err));
    *sound = ((stp_hash(*bytes, size) ^ hash) & mask) == 0;
    if (!*sound)
        STP_TRY(stp_damaged_mend_bit(d, offset, *bytes, size, (stp_hash_place){hash, mask, false},
                                     what, sound, err));
done:
    return status;
}

stp_status stp_damaged_chunk(const stp_damaged *d, uint32_t id, int finest_level, stp_chunk **out,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *e = &d->entries[id];
    stp_chunk *chunk = NULL;
    stp_chunk_scratch scratch = {0};
    uint8_t *bytes = NULL;
    uint32_t begin = 0;
    size_t size = e->segment_end[stp_segment_count(finest_level) - 1];
    STP_TRY(stp_alloc(&bytes, size + 1, 1, "payload", err));
    STP_TRY(stp_damaged_read(d, e->offset, bytes, size, err));
    STP_TRY(stp_chunk_create(&chunk, e->patch_count, e->sample_count, finest_level, err));
    chunk->id = id;
    chunk->linked = (e->flags & STP_CHUNK_LINKED) != 0;
    for (int s = 0; s < stp_segment_count(finest_level); s++) {
        stp_error inner = {0};
        status = stp_segment_decode(bytes + begin, e->segment_end[s] - begin, s, e->codec,
                                    e->child_count, chunk, &scratch, &inner);
        if (status != STP_OK) {
            stp_error_set(err, status, "%s: chunk %" PRIu32 ": segment %d: %s", d->path, id, s,
                          inner.message);
            goto done;
        }
        begin = e->segment_end[s];
    }
    *out = chunk;
    chunk = NULL;
done:
    stp_chunk_scratch_free(&scratch);
    stp_chunk_destroy(&chunk);
    free(bytes);
    return status;
}
