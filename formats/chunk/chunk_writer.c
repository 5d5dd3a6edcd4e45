/* The chunk file's writer: payloads in the order they come, then metadata, directory and header. */
#include "base/file.h"
#include "base/memory.h"
#include "formats/chunk/attribute/attribute_table.h"
#include "formats/chunk/block/block.h"
#include "formats/chunk/block/block_table.h"
#include "formats/chunk/block/packed_table.h"
#include "formats/chunk/chunk_reader.h"
#include "formats/chunk/free_ranges.h"
#include "formats/chunk/layout.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

/* What is written of attributes. */
typedef struct written_numbers {
    const stp_attribute_list *list; /* NULL: none yet */
    stp_attribute_row *rows;        /* by handle, then attribute */
    size_t capacity;
    uint32_t chunk_count; /* that have rows */
    uint64_t offset, bytes;
    XXH3_state_t *hash;
} written_numbers;

struct stp_chunk_writer {
    stp_output *output;
    stp_chunk_writer_params params;
    stp_chunk_entry *entries; /* by handle */
    size_t entry_count, entry_capacity;
    stp_bytes blocks; /* records; entries say which are theirs */
    written_numbers numbers;
    stp_chunk_file *extended; /* the file that is changed in place, borrowed; NULL: a new one */
    uint64_t unused_bytes;    /* of the changed file, among the payloads */
    uint64_t *unused_out;     /* borrowed: finish says it there */
    uint64_t first_header;    /* byte of the copy of its header to write first */
};

/* Files of codecs with blocks have version 2. */
static bool has_blocks(const stp_chunk_writer *writer)
{
    return stp_codec_has_blocks(writer->params.codec);
}

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
                             has_blocks(writer) ? sizeof blank : STP_HEADER_BYTES, err));
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
        !has_blocks(writer) || stp_header_section(&file->header, STP_SECTION_ATTRIBUTES)) {
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
    if (!has_blocks(writer))
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
    const size_t begin = writer->blocks.size;
    STP_TRY(stp_chunk_file_entry(writer->extended, id, &entry, err));
    STP_TRY(next_entry(writer, &entry, &kept, err));
    if (begin / STP_BLOCK_BYTES > UINT32_MAX - STP_CHUNK_PATCHES_LIMIT)
        return stp_error_set(err, STP_LIMIT, "more than 2^32 blocks");
    kept->first_block = (uint32_t)(begin / STP_BLOCK_BYTES);
    if (entry.block_count > 0) {
        STP_TRY(stp_chunk_file_records(writer->extended, id, &writer->blocks, err));
        kept->blocks_hash = stp_hash(writer->blocks.data + begin, writer->blocks.size - begin);
    }
    *handle = (uint32_t)writer->entry_count++;
done:
    return status;
}

/* ---- attributes ---- */

static stp_status begin_numbers(stp_chunk_writer *writer, const stp_attribute_list *list,
                                stp_error *err)
{
    written_numbers *n = &writer->numbers;
    if (n->list)
        return STP_OK;
    if (!has_blocks(writer))
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
    written_numbers *n = &writer->numbers;
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

/* ---- finishing ---- */

/* The tree in its final order. */
typedef struct numbering {
    uint32_t *handle;         /* by id */
    stp_chunk_entry *entries; /* by id, links filled in */
    uint32_t count;
    uint32_t depth;
} numbering;

/* Gives the children of chunk `id` the next ids. `seen`: by handle. */
static stp_status number_children(const stp_chunk_writer *writer, numbering *n, uint32_t id,
                                  const uint32_t *children, uint32_t child_count, bool *seen,
                                  stp_error *err)
{
    stp_chunk_entry *parent = &n->entries[id];
    if (child_count > STP_CHUNK_CHILDREN_LIMIT)
        return stp_error_set(err, STP_LIMIT, "a chunk of %" PRIu32 " children: use at most %u",
                             child_count, STP_CHUNK_CHILDREN_LIMIT);
    if (child_count > 0 && parent->depth + 1u >= STP_DEPTH_LIMIT)
        return stp_error_set(err, STP_LIMIT, "a tree of more than %u levels", STP_DEPTH_LIMIT);
    parent->child_count = child_count;
    parent->first_child = child_count > 0 ? n->count : STP_CHUNK_NONE;
    for (uint32_t c = 0; c < child_count; c++) {
        uint32_t handle = children[c];
        if (handle >= writer->entry_count || seen[handle])
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "chunk handle %" PRIu32 " does not exist or has two parents",
                                 handle);
        seen[handle] = true;
        stp_chunk_entry *child = &n->entries[n->count];
        *child = writer->entries[handle];
        child->parent = id;
        child->depth = (uint8_t)(parent->depth + 1u);
        n->handle[n->count++] = handle;
    }
    return STP_OK;
}

/* Numbers chunks breadth first from the root, and gives entries their links as ids and their
 * depths. */
static stp_status number_tree(const stp_chunk_writer *writer, uint32_t root,
                              const uint32_t *const *children, const uint32_t *child_counts,
                              numbering *n, stp_error *err)
{
    stp_status status = STP_OK;
    bool *seen = NULL;
    size_t total = writer->entry_count;
    if (root >= total)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "the root's handle does not exist");
    STP_TRY(stp_alloc(&seen, total, sizeof *seen, "directory", err));
    STP_TRY(stp_alloc(&n->handle, total, sizeof *n->handle, "directory", err));
    STP_TRY(stp_alloc(&n->entries, total, sizeof *n->entries, "directory", err));
    n->handle[0] = root;
    n->entries[0] = writer->entries[root];
    n->entries[0].parent = STP_CHUNK_NONE;
    n->entries[0].depth = 0;
    n->count = 1;
    seen[root] = true;
    for (uint32_t id = 0; id < n->count; id++) {
        uint32_t handle = n->handle[id];
        STP_TRY(number_children(writer, n, id, children[handle], child_counts[handle], seen, err));
    }
    n->depth = n->entries[n->count - 1].depth + 1u;
    if (n->count != total)
        status = stp_error_set(err, STP_INVALID_ARGUMENT,
                               "%zu of %zu chunks are not under the root", total - n->count, total);
done:
    free(seen);
    return status;
}

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
static stp_status write_blocks(stp_chunk_writer *writer, const numbering *n, stp_header *header,
                               stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *bytes = NULL;
    stp_bytes packed = {0};
    size_t at = 0;
    if (!has_blocks(writer))
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
static stp_status write_free(stp_chunk_writer *writer, const numbering *n, stp_header *header,
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
    const written_numbers *numbers;
    const uint32_t *handle; /* by id */
} row_source;

static const stp_attribute_row *row_of(const void *context, uint32_t attribute, uint32_t id)
{
    static const stp_attribute_row none = {0};
    const row_source *from = context;
    const written_numbers *n = from->numbers;
    const uint32_t handle = from->handle[id];
    return handle < n->chunk_count ? &n->rows[(size_t)handle * n->list->count + attribute] : &none;
}

/* Says where the numbers of attributes lie, which are written, before the other sections. */
static void begin_sections(const stp_chunk_writer *writer, stp_header *header)
{
    const written_numbers *n = &writer->numbers;
    if (!n->list)
        return;
    header->sections[header->section_count++] = (stp_section){.kind = STP_SECTION_NUMBERS,
                                                              .offset = n->offset,
                                                              .bytes = n->bytes,
                                                              .hash = XXH3_64bits_digest(n->hash)};
}

static stp_status write_attributes(stp_chunk_writer *writer, const numbering *n, stp_header *header,
                                   stp_error *err)
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
static stp_header begin_header(const stp_chunk_writer *writer, const numbering *n,
                               const stp_dbox *box)
{
    const bool blocks = has_blocks(writer);
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

static stp_status write_end(stp_chunk_writer *writer, const numbering *n, const stp_dbox *box,
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
    numbering n = {0};
    uint64_t bytes = 0;
    STP_TRY(number_tree(*writer, root, children, child_counts, &n, err));
    STP_TRY(write_end(*writer, &n, box, metadata_json, &bytes, err));
    if (file_bytes)
        *file_bytes = bytes;
done:
    free(n.handle);
    free(n.entries);
    stp_chunk_writer_destroy(writer);
    return status;
}
