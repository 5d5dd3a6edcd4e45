/* Finds the sections of a file whose headers are lost. */
#include "formats/chunk/repair/lost_places.h"

#include "base/memory.h"
#include "formats/chunk/attribute/attribute_json.h"
#include "formats/chunk/attribute/attribute_table.h"
#include "formats/chunk/block/packed_table.h"

#include <cjson/cJSON.h>
#include <stdlib.h>

/* Bytes that are searched at a time. */
#define PART_BYTES ((uint64_t)1 << 20)

static void add_section(stp_header *h, uint32_t kind, uint64_t bytes, uint64_t block_count)
{
    h->sections[h->section_count++] = (stp_section){.kind = kind,
                                                    .flags = stp_section_flags(kind, block_count),
                                                    .offset = h->metadata_offset,
                                                    .bytes = bytes};
    h->metadata_offset += bytes;
}

/* Looks from `begin` to `end` for `size` bytes of this checksum. *at: where they begin, or `end`.
 */
static stp_status search(const stp_damaged *d, uint64_t begin, uint64_t end, size_t size,
                         uint64_t hash, uint64_t *at, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    *at = end;
    STP_TRY(stp_alloc(&bytes, (size_t)PART_BYTES + size, 1, "sections", err));
    for (uint64_t part = begin; part + size <= end && *at == end; part += PART_BYTES) {
        const uint64_t left = end - part, most = PART_BYTES + size - 1;
        const size_t here = (size_t)(left < most ? left : most);
        STP_TRY(stp_damaged_read(d, part, bytes, here, err));
        for (size_t i = 0; i + size <= here && *at == end; i++)
            if (stp_hash(bytes + i, size) == hash)
                *at = part + i;
    }
done:
    free(bytes);
    return status;
}

/* Looks from `begin` to `end` for a packed table of blocks. *at: where it begins, or `end`; *size:
 * its bytes. */
static stp_status search_packed(const stp_damaged *d, uint64_t begin, uint64_t end,
                                uint64_t block_count, uint64_t *at, uint64_t *size, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    /* what does not pack is a little larger */
    const uint64_t packed_most = block_count * STP_BLOCK_BYTES * 2;
    const size_t most = (size_t)(packed_most < end - begin ? packed_most : end - begin);
    *at = end;
    STP_TRY(stp_alloc(&bytes, (size_t)PART_BYTES + most, 1, "sections", err));
    for (uint64_t part = begin; part < end && *at == end; part += PART_BYTES) {
        const uint64_t left = end - part;
        const size_t here = left < PART_BYTES + most ? (size_t)left : (size_t)PART_BYTES + most;
        STP_TRY(stp_damaged_read(d, part, bytes, here, err));
        for (size_t i = 0; i < here && i < PART_BYTES && *at == end; i++) {
            *size = stp_packed_table_bytes(bytes + i, here - i, block_count);
            if (*size > 0)
                *at = part + i;
        }
    }
done:
    free(bytes);
    return status;
}

static bool is_text(uint8_t byte)
{
    return byte >= ' ' || byte == '\t' || byte == '\n' || byte == '\r';
}

/* Looks from `begin` to `end` for the metadata: a JSON object that reaches to `end`. *at: where it
 * begins, or `end`. */
static stp_status search_metadata(const stp_damaged *d, uint64_t begin, uint64_t end, uint64_t *at,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t left = end - begin;
    const size_t size = (size_t)(left < STP_METADATA_BYTES_LIMIT ? left : STP_METADATA_BYTES_LIMIT);
    uint8_t *bytes = NULL;
    size_t i = size, next = 0;
    *at = end;
    STP_TRY(stp_alloc(&bytes, size + 1, 1, "the metadata", err));
    STP_TRY(stp_damaged_read(d, end - size, bytes, size, err));
    while (i > 0 && is_text(bytes[i - 1]))
        i--;
    for (; i < size && *at == end; i = next) {
        const char *text = (const char *)bytes + i, *stop = NULL;
        next = i + 1;
        if (*text != '{')
            continue;
        cJSON *json = cJSON_ParseWithLengthOpts(text, size + 1 - i, &stop, true);
        if (json)
            *at = end - size + i;
        else if (stop > text) /* so that each byte is looked at once */
            next = i + (size_t)(stop - text);
        cJSON_Delete(json);
    }
done:
    free(bytes);
    return status;
}

/* The bytes of a table of attributes that begins at `offset`; 0: none does. */
static stp_status table_bytes(const stp_damaged *d, uint64_t offset, uint64_t *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_header *h = &d->header;
    uint8_t head[STP_ATTRIBUTE_HEAD_BYTES], *json = NULL;
    uint32_t size = 0;
    uint64_t hash = 0;
    stp_attribute_list list;
    *out = 0;
    if (offset + sizeof head > h->directory_offset)
        return STP_OK;
    STP_TRY(stp_damaged_read(d, offset, head, sizeof head, err));
    if (stp_attribute_head_read(head, &size, &hash, NULL) != STP_OK ||
        size > h->directory_offset - offset - sizeof head)
        return STP_OK;
    STP_TRY(stp_alloc(&json, (size_t)size + 1, 1, "attributes", err));
    STP_TRY(stp_damaged_read(d, offset + sizeof head, json, size, err));
    if (stp_hash(json, size) == hash &&
        stp_attribute_list_read(&list, (const char *)json, size, NULL) == STP_OK)
        *out = stp_attribute_pages_begin(size) +
               list.count * stp_attribute_pages_bytes(h->chunk_count);
done:
    free(json);
    return status;
}

/* The kind and bytes of a table of blocks that is not found: all from `begin` to the metadata. If
 * these are as many as records would take, it is not packed. *more: that they are far more, so
 * there were attributes. */
static stp_status guess_blocks(const stp_damaged *d, uint64_t begin, uint64_t block_count,
                               uint32_t *kind, uint64_t *blocks, bool *more, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t directory = d->header.directory_offset, plain = block_count * STP_BLOCK_BYTES;
    uint64_t metadata = directory;
    STP_TRY(search_metadata(d, begin, directory, &metadata, err));
    *kind = STP_SECTION_PACKED_BLOCKS;
    *blocks = metadata - begin;
    if (*blocks == block_count * STP_WIDE_BLOCK_BYTES)
        *kind = STP_SECTION_WIDE_BLOCKS;
    if (*blocks == plain || (metadata == directory && *blocks > plain)) {
        *kind = STP_SECTION_BLOCKS;
        *blocks = plain;
    }
    *more = *blocks > 2 * plain && *kind == STP_SECTION_PACKED_BLOCKS;
done:
    return status;
}

stp_status stp_lost_places_find(stp_damaged *d, uint64_t block_count,
                                const uint8_t root[STP_ENTRY_BYTES], stp_error *err)
{
    stp_status status = STP_OK;
    stp_header *h = &d->header;
    static const uint32_t kinds[] = {STP_SECTION_WIDE_BLOCKS, STP_SECTION_BLOCKS};
    const uint64_t begin = h->metadata_offset, own = stp_get_u32(root + 212);
    uint64_t at = h->directory_offset, attributes = 0, blocks = 0;
    uint32_t kind = 0;
    bool more = false;
    if (begin < h->directory_offset) {
        STP_TRY(search_packed(d, begin, h->directory_offset, block_count, &at, &blocks, err));
        kind = STP_SECTION_PACKED_BLOCKS;
    }
    for (int i = 0; i < 2 && at == h->directory_offset; i++) {
        const size_t record = stp_record_bytes(&(stp_section){.kind = kinds[i]});
        kind = kinds[i];
        blocks = block_count * record;
        if (own > 0 && own <= block_count && begin < h->directory_offset)
            STP_TRY(search(d, begin, h->directory_offset, (size_t)own * record,
                           stp_get_u64(root + 216), &at, err));
    }
    if (at == h->directory_offset && begin < at)
        STP_TRY(guess_blocks(d, begin, block_count, &kind, &blocks, &more, err));
    if (at < h->directory_offset && at > begin)
        STP_TRY(table_bytes(d, at + blocks, &attributes, err));
    if (attributes > 0)
        add_section(h, STP_SECTION_NUMBERS, at - begin, 0);
    else if (at > begin && at < h->directory_offset)
        add_section(h, STP_SECTION_FREE, at - begin, 0); /* all that can lie here besides */
    add_section(h, kind, blocks, block_count);
    if (attributes > 0 || more) /* if nobody knows where, their loss is said */
        add_section(h, STP_SECTION_ATTRIBUTES, attributes, 0);
done:
    return status;
}
