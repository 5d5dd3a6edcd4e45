/* The end of a chunk file: sections, metadata, directory, and at last the header, in this order. */
#include "formats/chunk/chunk_writer_parts.h"

#include "base/memory.h"
#include "formats/chunk/block/block_table.h"
#include "formats/chunk/block/packed_table.h"
#include "formats/chunk/chunk_reader.h"
#include "formats/chunk/chunk_tree.h"
#include "formats/chunk/free_ranges.h"

#include <stdlib.h>
#include <string.h>

static stp_status write_directory(stp_output *output, const stp_header *header,
                                  const stp_chunk_entry *entries, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t bytes[STP_PAGE_ENTRIES * STP_ENTRY_BYTES + STP_HASH_BYTES];
    for (uint32_t p = 0; p < stp_page_count(header); p++) {
        uint32_t count = stp_page_entry_count(header, p);
        size_t hashed = (size_t)count * STP_ENTRY_BYTES;
        for (uint32_t i = 0; i < count; i++)
            stp_entry_write(&entries[p * STP_PAGE_ENTRIES + i], bytes + i * STP_ENTRY_BYTES);
        stp_put_u64(bytes + hashed, stp_hash(bytes, hashed));
        STP_TRY(stp_output_write(output, bytes, hashed + STP_HASH_BYTES, err));
    }
done:
    return status;
}

static stp_status write_section(stp_chunk_writer *writer, stp_header *header, uint32_t kind,
                                const void *bytes, size_t size, stp_error *err)
{
    header->sections[header->section_count++] =
        (stp_section){.kind = kind,
                      .flags = stp_section_flags(kind, writer->blocks.size / STP_BLOCK_BYTES),
                      .offset = stp_output_size(writer->output),
                      .bytes = size,
                      .hash = stp_hash(bytes, size)};
    return stp_output_write(writer->output, bytes, size, err);
}

/* Writes the records of blocks in the order of the chunks' ids, and numbers them so. */
static stp_status write_blocks(stp_chunk_writer *writer, const stp_chunk_tree *n,
                               stp_header *header, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    stp_bytes packed = {0};
    size_t at = 0;
    if (!stp_chunk_writer_has_blocks(writer))
        return STP_OK;
    STP_TRY(stp_alloc(&bytes, writer->blocks.size + 1, 1, "the table of blocks", err));
    for (uint32_t id = 0; id < n->count; id++) {
        stp_chunk_entry *e = &n->entries[id];
        const size_t size = (size_t)e->block_count * STP_BLOCK_BYTES;
        memcpy(bytes + at, writer->blocks.data + (size_t)e->first_block * STP_BLOCK_BYTES, size);
        e->first_block = (uint32_t)(at / STP_BLOCK_BYTES);
        at += size;
    }
    STP_TRY(stp_table_pack(bytes, at / STP_BLOCK_BYTES, &packed, err));
    STP_TRY(packed.size > 0 ? write_section(writer, header, STP_SECTION_PACKED_BLOCKS, packed.data,
                                            packed.size, err)
                            : write_section(writer, header, STP_SECTION_BLOCKS, bytes, at, err));
done:
    free(packed.data);
    free(bytes);
    return status;
}

/* Lists the bytes among the payloads that an extended file does not use any more. */
static stp_status write_free(stp_chunk_writer *writer, const stp_chunk_tree *n, stp_header *header,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes records = {0};
    if (!writer->extended)
        return STP_OK;
    STP_TRY(stp_free_ranges_find(n->entries, n->count, stp_header_span(header),
                                 stp_output_size(writer->output), &records, err));
    for (size_t at = 0; at < records.size; at += STP_FREE_BYTES)
        writer->unused_bytes += stp_get_u64(records.data + at + 8);
    if (records.size == 0)
        goto done;
    STP_TRY(write_section(writer, header, STP_SECTION_FREE, records.data, records.size, err));
    header->version_minor = STP_CHUNK_FILE_MINOR;
done:
    free(records.data);
    return status;
}

/* What stp_attribute_table_write asks for rows. */
typedef struct row_source {
    const stp_written_numbers *numbers;
    const uint32_t *handle; /* by id */
} row_source;

static const stp_attribute_row *row_of(const void *context, uint32_t attribute, uint32_t id)
{
    static const stp_attribute_row none = {0};
    const row_source *from = context;
    const stp_written_numbers *n = from->numbers;
    const uint32_t handle = from->handle[id];
    return handle < n->chunk_count ? &n->rows[(size_t)handle * n->list->count + attribute] : &none;
}

/* Says where the numbers of attributes lie, which are written, before the other sections. */
static void begin_sections(const stp_chunk_writer *writer, stp_header *header)
{
    const stp_written_numbers *n = &writer->numbers;
    if (!n->list)
        return;
    header->sections[header->section_count++] = (stp_section){.kind = STP_SECTION_NUMBERS,
                                                              .offset = n->offset,
                                                              .bytes = n->bytes,
                                                              .hash = XXH3_64bits_digest(n->hash)};
}

static stp_status write_attributes(stp_chunk_writer *writer, const stp_chunk_tree *n,
                                   stp_header *header, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes table = {0};
    const row_source from = {&writer->numbers, n->handle};
    if (!writer->numbers.list)
        return STP_OK;
    STP_TRY(stp_attribute_table_write(writer->numbers.list, n->count, row_of, &from, &table, err));
    STP_TRY(write_section(writer, header, STP_SECTION_ATTRIBUTES, table.data, table.size, err));
done:
    free(table.data);
    return status;
}

/* Checks the directory as a reader will. */
static stp_status check_entries(const stp_header *header, const stp_chunk_entry *entries,
                                stp_error *err)
{
    for (uint32_t id = 0; id < header->chunk_count; id++) {
        uint8_t bytes[STP_ENTRY_BYTES];
        stp_chunk_entry read;
        stp_error inner = {0};
        stp_entry_write(&entries[id], bytes);
        if (stp_entry_read(bytes, id, header, &read, &inner) != STP_OK)
            return stp_error_set(err, STP_INVALID_ARGUMENT, "a chunk cannot be written: %s",
                                 inner.message);
    }
    return STP_OK;
}

/* What the header says before the places of directory and metadata are known. */
static stp_header begin_header(const stp_chunk_writer *writer, const stp_chunk_tree *n,
                               const stp_dbox *box)
{
    const bool blocks = stp_chunk_writer_has_blocks(writer);
    return (stp_header){
        .version_major = blocks ? 2 : 1,
        .version_minor = blocks ? 0 : stp_chunk_file_minor(writer->params.attributes),
        .header_bytes = blocks ? STP_HEADER_BYTES_2 : STP_HEADER_BYTES,
        .chunk_count = n->count,
        .page_entries = STP_PAGE_ENTRIES,
        .entry_bytes = STP_ENTRY_BYTES,
        .depth = n->depth,
        .point_count = n->entries[0].points_under,
        .attributes = writer->params.attributes,
        .orientation = writer->params.orientation,
        .lambda = writer->params.lambda,
        .box = *box,
        .generation = writer->extended ? writer->extended->header.generation + 1 : 1,
    };
}

static stp_status write_copy(stp_chunk_writer *writer, uint64_t at, const uint8_t *bytes,
                             stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_output_write_at(writer->output, at, bytes, STP_HEADER_BYTES_2, err));
    STP_TRY(stp_output_sync(writer->output, err));
done:
    return status;
}

/* Writes the copies of the header one after the other, when all before it is on the disk. With the
 * first one the file is changed: if the second cannot be written, readers take the first, and the
 * next change writes both. If the first cannot be written, the old header goes back to its place,
 * as far as the disk lets it; the second copy is whole. */
static stp_status replace_header(stp_chunk_writer *writer, const uint8_t *bytes, stp_error *err)
{
    const uint64_t first = writer->first_header, second = first == 0 ? STP_HEADER_BYTES_2 : 0;
    uint8_t old[STP_HEADER_BYTES_2];
    stp_status status = stp_output_sync(writer->output, err);
    if (status != STP_OK)
        return status;
    status = write_copy(writer, first, bytes, err);
    if (status == STP_OK) {
        (void)write_copy(writer, second, bytes, NULL);
        return STP_OK;
    }
    stp_header_write(&writer->extended->header, old);
    if (write_copy(writer, first, old, NULL) == STP_OK)
        (void)stp_output_keep(writer->output, writer->extended->header.file_bytes, NULL);
    return status;
}

/* Writes the header, twice in version 2, after checking it as a reader will. */
static stp_status write_header(stp_chunk_writer *writer, const stp_header *header, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t bytes[STP_HEADER_BYTES_2];
    stp_header read;
    stp_error inner = {0};
    stp_header_write(header, bytes);
    if (stp_header_read(bytes, header->header_bytes, header->file_bytes, &read, &inner) != STP_OK)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "the file cannot be written: %s",
                             inner.message);
    if (writer->extended)
        return replace_header(writer, bytes, err);
    for (uint64_t at = 0; at < stp_header_span(header); at += header->header_bytes)
        STP_TRY(stp_output_write_at(writer->output, at, bytes, header->header_bytes, err));
done:
    return status;
}

static stp_status write_end(stp_chunk_writer *writer, const stp_chunk_tree *n, const stp_dbox *box,
                            const char *metadata_json, uint64_t *file_bytes, stp_error *err)
{
    stp_status status = STP_OK;
    size_t metadata_bytes = strlen(metadata_json);
    stp_header header = begin_header(writer, n, box);
    if (metadata_bytes > STP_METADATA_BYTES_LIMIT)
        return stp_error_set(err, STP_LIMIT, "metadata of %zu bytes: use at most %u",
                             metadata_bytes, STP_METADATA_BYTES_LIMIT);
    begin_sections(writer, &header);
    STP_TRY(write_free(writer, n, &header, err));
    STP_TRY(write_blocks(writer, n, &header, err));
    STP_TRY(write_attributes(writer, n, &header, err));
    header.metadata_offset = stp_output_size(writer->output);
    header.metadata_bytes = metadata_bytes;
    header.metadata_hash = stp_hash(metadata_json, metadata_bytes);
    header.directory_offset = header.metadata_offset + metadata_bytes;
    STP_TRY(check_entries(&header, n->entries, err));
    STP_TRY(stp_output_write(writer->output, metadata_json, metadata_bytes, err));
    STP_TRY(write_directory(writer->output, &header, n->entries, err));
    header.file_bytes = stp_output_size(writer->output);
    STP_TRY(write_header(writer, &header, err));
    if (writer->extended) {
        *file_bytes = header.file_bytes;
        *writer->unused_out = writer->unused_bytes;
        return STP_OK;
    }
    if (writer->params.check)
        STP_TRY(writer->params.check(writer->params.check_context,
                                     stp_output_temporary_path(writer->output), err));
    STP_TRY(stp_output_commit(&writer->output, err));
    *file_bytes = header.file_bytes;
done:
    return status;
}

stp_status stp_chunk_writer_finish(stp_chunk_writer **writer, uint32_t root,
                                   const uint32_t *const *children, const uint32_t *child_counts,
                                   const stp_dbox *box, const char *metadata_json,
                                   uint64_t *file_bytes, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_tree n = {0};
    uint64_t bytes = 0;
    STP_TRY(stp_chunk_tree_number((*writer)->entries, (*writer)->entry_count, root, children,
                                  child_counts, &n, err));
    STP_TRY(write_end(*writer, &n, box, metadata_json, &bytes, err));
    if (file_bytes)
        *file_bytes = bytes;
done:
    stp_chunk_tree_clear(&n);
    stp_chunk_writer_destroy(writer);
    return status;
}
