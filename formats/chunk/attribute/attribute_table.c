/* The section ATTR: the list of attributes, and where their numbers lie. */
#include "formats/chunk/attribute/attribute_table.h"

#include "base/checked.h"
#include "formats/chunk/attribute/attribute_json.h"

#include <stdlib.h>
#include <string.h>

static void row_write(const stp_attribute_row *row, uint8_t *bytes)
{
    stp_put_u64(bytes, row->offset);
    for (int k = 0; k < STP_LEVEL_COUNT; k++) {
        stp_put_u32(bytes + 8 + 4 * k, row->bytes[k]);
        stp_put_u64(bytes + 24 + 8 * k, row->hash[k]);
    }
}

static uint32_t rows_of_page(uint32_t chunk_count, uint32_t first)
{
    const uint32_t left = chunk_count - first;
    return left < STP_ATTRIBUTE_PAGE_ROWS ? left : STP_ATTRIBUTE_PAGE_ROWS;
}

stp_status stp_attribute_table_write(const stp_attribute_list *list, uint32_t chunk_count,
                                     const stp_attribute_row *(*row)(const void *context,
                                                                     uint32_t attribute,
                                                                     uint32_t id),
                                     const void *context, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    char *json = NULL;
    uint8_t head[STP_ATTRIBUTE_HEAD_BYTES] = {0};
    uint8_t page[STP_ATTRIBUTE_PAGE_ROWS * STP_ATTRIBUTE_ROW_BYTES + STP_HASH_BYTES];
    STP_TRY(stp_attribute_list_write(list, &json, err));
    const size_t json_bytes = strlen(json);
    stp_put_u32(head, (uint32_t)json_bytes);
    stp_put_u64(head + 8, stp_hash(json, json_bytes));
    STP_TRY(stp_bytes_append(out, head, sizeof head, err));
    STP_TRY(stp_bytes_append(out, json, json_bytes, err));
    for (uint32_t a = 0; a < list->count; a++)
        for (uint32_t first = 0; first < chunk_count; first += STP_ATTRIBUTE_PAGE_ROWS) {
            const uint32_t rows = rows_of_page(chunk_count, first);
            const size_t hashed = (size_t)rows * STP_ATTRIBUTE_ROW_BYTES;
            for (uint32_t i = 0; i < rows; i++)
                row_write(row(context, a, first + i), page + (size_t)i * STP_ATTRIBUTE_ROW_BYTES);
            stp_put_u64(page + hashed, stp_hash(page, hashed));
            STP_TRY(stp_bytes_append(out, page, hashed + STP_HASH_BYTES, err));
        }
done:
    free(json);
    return status;
}

stp_status stp_attribute_head_read(const uint8_t bytes[STP_ATTRIBUTE_HEAD_BYTES],
                                   uint32_t *json_bytes, uint64_t *json_hash, stp_error *err)
{
    const uint32_t size = stp_get_u32(bytes);
    if (size > STP_ATTRIBUTE_JSON_LIMIT || stp_get_u32(bytes + 4) != 0)
        return stp_error_set(err, STP_CORRUPT, "the table of attributes has an unknown head");
    *json_bytes = size;
    *json_hash = stp_get_u64(bytes + 8);
    return STP_OK;
}

stp_status stp_attribute_row_read(const uint8_t *page, uint32_t rows, uint32_t index,
                                  uint64_t data_bytes, stp_attribute_row *out, stp_error *err)
{
    const size_t hashed = (size_t)rows * STP_ATTRIBUTE_ROW_BYTES;
    const uint8_t *at = page + (size_t)index * STP_ATTRIBUTE_ROW_BYTES;
    uint64_t total = 0;
    if (stp_hash(page, hashed) != stp_get_u64(page + hashed))
        return stp_error_set(err, STP_CORRUPT,
                             "the checksum of a page of the table of attributes does not match");
    out->offset = stp_get_u64(at);
    for (int k = 0; k < STP_LEVEL_COUNT; k++) {
        out->bytes[k] = stp_get_u32(at + 8 + 4 * k);
        out->hash[k] = stp_get_u64(at + 24 + 8 * k);
        total += out->bytes[k];
    }
    return stp_range_inside(out->offset, total, data_bytes)
               ? STP_OK
               : stp_error_set(err, STP_CORRUPT, "numbers of an attribute lie outside the file");
}
