/* The chunk file's writer: takes payloads, and numbers of attributes, in the order they come. */
#include "formats/chunk/chunk_writer_parts.h"

#include "base/memory.h"
#include "formats/chunk/block/block.h"
#include "formats/chunk/block/block_table.h"
#include "formats/chunk/chunk_reader.h"

#include <stdlib.h>
#include <string.h>

stp_status stp_chunk_writer_create(stp_chunk_writer **out, const char *path,
                                   const stp_chunk_writer_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_writer *writer = NULL;
    static const uint8_t blank[2 * STP_HEADER_BYTES_2] = {0};
    STP_TRY(stp_alloc(&writer, 1, sizeof *writer, "chunk writer", err));
    writer->params = *params;
    STP_TRY(params->shared ? stp_output_create_shared(&writer->output, path, params->force, err)
                           : stp_output_create(&writer->output, path, params->force, err));
    STP_TRY(stp_output_write(writer->output, blank,
                             stp_chunk_writer_has_blocks(writer) ? sizeof blank : STP_HEADER_BYTES,
                             err));
    *out = writer;
    writer = NULL;
done:
    stp_chunk_writer_destroy(&writer);
    return status;
}

/* The copy of the header that a reader does not take is written first: at byte 0 if that copy is
 * damaged or older, else the second. */
static stp_status choose_copy(stp_chunk_writer *writer, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file *file = writer->extended;
    uint8_t bytes[STP_HEADER_BYTES_2];
    stp_header first;
    STP_TRY(stp_chunk_file_bytes(file, 0, bytes, sizeof bytes, false, err));
    const bool sound = stp_header_read(bytes, sizeof bytes, stp_byte_source_size(file->source),
                                       &first, NULL) == STP_OK;
    const bool taken = sound && first.generation == file->header.generation;
    writer->first_header = taken ? STP_HEADER_BYTES_2 : 0;
done:
    return status;
}

stp_status stp_chunk_writer_extend(stp_chunk_writer **out, stp_output **output,
                                   stp_chunk_file *file, const stp_chunk_writer_params *params,
                                   uint64_t *unused_bytes, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_writer *writer = NULL;
    STP_TRY(stp_alloc(&writer, 1, sizeof *writer, "chunk writer", err));
    writer->params = *params;
    writer->extended = file;
    writer->unused_out = unused_bytes;
    writer->output = *output;
    *output = NULL;
    if (file->header.version_major < 2 || file->header.header_bytes != STP_HEADER_BYTES_2 ||
        !stp_chunk_writer_has_blocks(writer) ||
        stp_header_section(&file->header, STP_SECTION_ATTRIBUTES)) {
        status = stp_error_set(err, STP_INVALID_ARGUMENT,
                               "%s: a file of this version, or with attributes, cannot be extended",
                               file->path);
        goto done;
    }
    STP_TRY(choose_copy(writer, err));
    STP_TRY(stp_output_keep(writer->output, file->header.file_bytes, err));
    *out = writer;
    writer = NULL;
done:
    stp_output_destroy(output);
    stp_chunk_writer_destroy(&writer);
    return status;
}

void stp_chunk_writer_destroy(stp_chunk_writer **writer)
{
    stp_chunk_writer *w = *writer;
    if (!w)
        return;
    stp_output_destroy(&w->output);
    free(w->entries);
    free(w->blocks.data);
    free(w->numbers.rows);
    XXH3_freeState(w->numbers.hash);
    free(w);
    *writer = NULL;
}

/* Keeps the records of a chunk's blocks. */
static stp_status keep_blocks(stp_chunk_writer *writer, const stp_bytes *records,
                              stp_chunk_entry *entry, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t begin = writer->blocks.size;
    entry->first_block = entry->block_count = 0;
    entry->blocks_hash = 0;
    if (!stp_codec_has_blocks((stp_codec)entry->codec))
        return STP_OK;
    if (!stp_chunk_writer_has_blocks(writer))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "a chunk in blocks for a file of version 1");
    if (begin / STP_BLOCK_BYTES > UINT32_MAX - STP_CHUNK_PATCHES_LIMIT)
        return stp_error_set(err, STP_LIMIT, "more than 2^32 blocks");
    STP_TRY(stp_bytes_append(&writer->blocks, records->data, records->size, err));
    entry->block_count = (uint32_t)(records->size / STP_BLOCK_BYTES);
    entry->first_block = (uint32_t)(begin / STP_BLOCK_BYTES);
    entry->blocks_hash = stp_hash(writer->blocks.data + begin, writer->blocks.size - begin);
done:
    return status;
}

/* Makes room for an entry behind the others. */
static stp_status next_entry(stp_chunk_writer *writer, const stp_chunk_entry *entry,
                             stp_chunk_entry **out, stp_error *err)
{
    stp_status status = STP_OK;
    if (writer->entry_count >= STP_CHUNK_NONE)
        return stp_error_set(err, STP_LIMIT, "more than 2^32 - 1 chunks");
    STP_TRY(stp_grow(&writer->entries, &writer->entry_capacity, writer->entry_count + 1,
                     sizeof *writer->entries, "directory", err));
    *out = &writer->entries[writer->entry_count];
    **out = *entry;
done:
    return status;
}

stp_status stp_chunk_writer_append(stp_chunk_writer *writer, const void *payload,
                                   const stp_chunk_entry *entry, uint32_t *handle, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes records = {0};
    uint32_t block_count;
    STP_TRY(stp_block_records_make(payload, entry, &records, &block_count, err));
    STP_TRY(stp_chunk_writer_append_made(writer, payload, &records, entry, handle, err));
done:
    free(records.data);
    return status;
}

stp_status stp_chunk_writer_append_made(stp_chunk_writer *writer, const void *payload,
                                        const stp_bytes *records, const stp_chunk_entry *entry,
                                        uint32_t *handle, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry *kept = NULL;
    STP_TRY(next_entry(writer, entry, &kept, err));
    kept->offset = stp_output_size(writer->output);
    STP_TRY(keep_blocks(writer, records, kept, err));
    const uint64_t size = entry->segment_end[STP_SEGMENT_COUNT - 1];
    STP_TRY(payload ? stp_output_write(writer->output, payload, size, err)
                    : stp_output_skip(writer->output, size, err));
    *handle = (uint32_t)writer->entry_count++;
done:
    return status;
}

const char *stp_chunk_writer_next(const stp_chunk_writer *writer, uint64_t *offset)
{
    *offset = stp_output_size(writer->output);
    return stp_output_temporary_path(writer->output);
}

stp_status stp_chunk_writer_keep(stp_chunk_writer *writer, uint32_t id, uint32_t *handle,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry entry, *kept = NULL;
    stp_bytes records = {0};
    STP_TRY(stp_chunk_file_entry(writer->extended, id, &entry, err));
    if (entry.block_count > 0)
        STP_TRY(stp_chunk_file_records(writer->extended, id, &records, err));
    STP_TRY(next_entry(writer, &entry, &kept, err));
    STP_TRY(keep_blocks(writer, &records, kept, err));
    *handle = (uint32_t)writer->entry_count++;
done:
    free(records.data);
    return status;
}

/* ---- attributes ---- */

static stp_status begin_numbers(stp_chunk_writer *writer, const stp_attribute_list *list,
                                stp_error *err)
{
    stp_written_numbers *n = &writer->numbers;
    if (n->list)
        return STP_OK;
    if (!stp_chunk_writer_has_blocks(writer))
        return stp_error_set(err, STP_INVALID_ARGUMENT, "attributes for a file of version 1");
    n->hash = XXH3_createState();
    if (!n->hash || XXH3_64bits_reset(n->hash) != XXH_OK)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for attributes");
    n->list = list;
    n->offset = stp_output_size(writer->output);
    return STP_OK;
}

stp_status stp_chunk_writer_append_numbers(stp_chunk_writer *writer, uint32_t handle,
                                           const stp_attribute_list *list, const void *bytes,
                                           size_t size, const stp_attribute_row *rows,
                                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_written_numbers *n = &writer->numbers;
    STP_TRY(begin_numbers(writer, list, err));
    if (handle >= n->chunk_count) {
        const size_t before = (size_t)n->chunk_count * list->count;
        const size_t after = ((size_t)handle + 1) * list->count;
        STP_TRY(stp_grow(&n->rows, &n->capacity, after, sizeof *n->rows, "attributes", err));
        memset(n->rows + before, 0, (after - before) * sizeof *n->rows);
        n->chunk_count = handle + 1;
    }
    for (uint32_t a = 0; a < list->count; a++) {
        stp_attribute_row *row = &n->rows[(size_t)handle * list->count + a];
        *row = rows[a];
        row->offset += n->bytes;
    }
    STP_TRY(stp_output_write(writer->output, bytes, size, err));
    n->bytes += size;
    if (size > 0 && XXH3_64bits_update(n->hash, bytes, size) != XXH_OK)
        status = stp_error_set(err, STP_INTERNAL, "XXH3 failed");
done:
    return status;
}
