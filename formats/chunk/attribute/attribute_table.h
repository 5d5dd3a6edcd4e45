/* Where the numbers of attributes lie in a file: the section ATTR (formats/SPEC.md, "Attributes").
 *
 * ATTR is a head, the list of attributes as JSON, and then, attribute by attribute, pages of rows:
 * a row for each chunk, 64 rows and a checksum a page. The numbers are parts in the section ATTD.
 * Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_TABLE_H
#define STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_TABLE_H

#include "formats/attribute/attribute.h"
#include "formats/chunk/codec/table/column.h"
#include "formats/chunk/layout.h"

#define STP_ATTRIBUTE_HEAD_BYTES 16u
#define STP_ATTRIBUTE_ROW_BYTES 56u
#define STP_ATTRIBUTE_PAGE_ROWS 64u
#define STP_ATTRIBUTE_JSON_LIMIT (1u << 20)

/* The parts of one attribute of one chunk, coarse to fine: level 3 first. */
typedef struct stp_attribute_row {
    uint64_t offset; /* of the first part, from the begin of ATTD; the others follow it */
    uint32_t bytes[STP_LEVEL_COUNT];
    uint64_t hash[STP_LEVEL_COUNT]; /* XXH3 of each part */
} stp_attribute_row;

/* The bytes of ATTR before the first page. json_bytes: of the list. */
static inline uint64_t stp_attribute_pages_begin(uint32_t json_bytes)
{
    return STP_ATTRIBUTE_HEAD_BYTES + (uint64_t)json_bytes;
}

/* Bytes of a page of `rows` rows. */
static inline size_t stp_attribute_page_bytes(uint32_t rows)
{
    return (size_t)rows * STP_ATTRIBUTE_ROW_BYTES + STP_HASH_BYTES;
}

/* Bytes of all pages of one attribute. */
static inline uint64_t stp_attribute_pages_bytes(uint32_t chunk_count)
{
    const uint64_t pages =
        ((uint64_t)chunk_count + STP_ATTRIBUTE_PAGE_ROWS - 1) / STP_ATTRIBUTE_PAGE_ROWS;
    return (uint64_t)chunk_count * STP_ATTRIBUTE_ROW_BYTES + pages * STP_HASH_BYTES;
}

/* Appends the section. row(context, attribute, chunk id) gives the rows. Errors: OUT_OF_MEMORY. */
stp_status stp_attribute_table_write(const stp_attribute_list *list, uint32_t chunk_count,
                                     const stp_attribute_row *(*row)(const void *context,
                                                                     uint32_t attribute,
                                                                     uint32_t id),
                                     const void *context, stp_bytes *out, stp_error *err);

/* Reads the head: bytes and checksum of the JSON. Errors: CORRUPT. */
stp_status stp_attribute_head_read(const uint8_t bytes[STP_ATTRIBUTE_HEAD_BYTES],
                                   uint32_t *json_bytes, uint64_t *json_hash, stp_error *err);
/* Reads row `index` of a page of `rows` rows, and checks it: its parts lie in ATTD, which has
 * data_bytes. Errors: CORRUPT. */
stp_status stp_attribute_row_read(const uint8_t *page, uint32_t rows, uint32_t index,
                                  uint64_t data_bytes, stp_attribute_row *out, stp_error *err);

#endif
