/* The attributes of a chunk's points, as writers of points take them. */
#include "tools/file/export_numbers.h"

#include "base/memory.h"

#include <stdlib.h>

stp_status export_numbers_open(export_numbers *out, stp_chunk_file *file, stp_error *err)
{
    stp_status status = stp_attribute_file_open(&out->file, file, err);
    if (status != STP_OK)
        return status;
    const stp_attribute_list *list = stp_attribute_file_list(out->file);
    out->list = list->count > 0 ? list : NULL;
    out->stride = stp_attribute_list_bytes(list);
    return STP_OK;
}

stp_status export_numbers_read(export_numbers *n, const stp_chunk *chunk, int level, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = chunk->level_begin[level][chunk->patch_count];
    uint64_t *words = NULL;
    size_t at = 0;
    if (!n->list)
        return STP_OK;
    STP_TRY(stp_alloc(&words, count, sizeof *words, "attributes", err));
    STP_TRY(stp_grow(&n->packed, &n->capacity, count * n->stride, 1, "attributes", err));
    for (uint32_t a = 0; a < n->list->count; a++) {
        const stp_attribute_type type = n->list->items[a].type;
        STP_TRY(stp_attribute_file_read(n->file, a, chunk, level, words, err));
        for (uint32_t i = 0; i < count; i++)
            stp_attribute_put(type, words[i], n->packed + i * n->stride + at);
        at += stp_attribute_bytes(type);
    }
done:
    free(words);
    return status;
}

void export_numbers_clear(export_numbers *n)
{
    stp_attribute_file_close(&n->file);
    free(n->packed);
    *n = (export_numbers){0};
}
