/* Copies a chunk file with another codec, or another default threshold. */
#include "formats/chunk/convert.h"

#include "base/memory.h"
#include "base/sort.h"
#include "formats/chunk/attribute/attribute_file.h"
#include "formats/chunk/block/block_cut.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/layout.h"

#include <cjson/cJSON.h>
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#define THRESHOLD_KEY "threshold_px"
/* Chunks converted at once, for each thread. */
#define BATCH_PER_THREAD 4u

/* ---- metadata ---- */

/* A number above 0 in the metadata; otherwise 0. */
static double noted(const stp_chunk_file_info *info, const char *key)
{
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(metadata, key);
    double value = cJSON_IsNumber(number) ? number->valuedouble : 0.0;
    cJSON_Delete(metadata);
    return isfinite(value) && value > 0.0 ? value : 0.0;
}

double stp_chunk_file_threshold(const stp_chunk_file_info *info)
{
    return noted(info, THRESHOLD_KEY);
}

double stp_chunk_file_intensity_top(const stp_chunk_file_info *info)
{
    return noted(info, "intensity_max") * noted(info, "intensity_full") / 65535.0;
}

bool stp_chunk_file_unlit(const stp_chunk_file_info *info)
{
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const char *shade = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(metadata, "shade"));
    bool unlit = shade && strcmp(shade, "unlit") == 0;
    cJSON_Delete(metadata);
    return unlit;
}

/* The metadata with another threshold; the same bytes if there is none to set. */
static stp_status make_metadata(const stp_chunk_file_info *info, double threshold_px, char **out,
                                stp_error *err)
{
    if (threshold_px <= 0.0)
        return stp_text_copy(out, info->metadata_json, "metadata", err);
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    if (!cJSON_IsObject(metadata)) {
        cJSON_Delete(metadata);
        return stp_error_set(err, STP_CORRUPT, "the metadata is no JSON object: repair the file");
    }
    cJSON_DeleteItemFromObjectCaseSensitive(metadata, THRESHOLD_KEY);
    cJSON_AddNumberToObject(metadata, THRESHOLD_KEY, threshold_px);
    *out = cJSON_PrintUnformatted(metadata);
    cJSON_Delete(metadata);
    return *out ? STP_OK : stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the metadata");
}

/* ---- payloads ---- */

/* A chunk being converted. */
typedef struct piece {
    stp_chunk_entry entry;
    uint8_t *payload;
} piece;

typedef struct conversion {
    stp_chunk_file *file;
    const stp_convert_params *params;
    uint32_t count;
    bool blocks;       /* the output has blocks */
    bool copies;       /* payloads stay as they are */
    bool linked;       /* all chunks with children are linked: chunks can be cut */
    uint32_t *order;   /* ids, in the order of payloads in the file */
    uint32_t *handles; /* by id */
    piece *pieces;     /* of one batch */
    uint32_t first;    /* the batch's first place in the order */
    stp_chunk_writer *writer;
    stp_attribute_file *attributes;
} conversion;

static stp_status check_payload(const conversion *c, uint32_t id, const piece *p, stp_error *err)
{
    uint32_t begin = 0;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        uint32_t end = p->entry.segment_end[s];
        if (stp_hash(p->payload + begin, end - begin) != p->entry.segment_hash[s])
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: chunk %" PRIu32 ": the checksum of segment %d does not "
                                 "match: the file is damaged; copy it again",
                                 stp_chunk_file_path(c->file), id, s);
        begin = end;
    }
    return STP_OK;
}

/* The codec that a chunk gets. */
static stp_codec new_codec(const conversion *c, const piece *p)
{
    const stp_codec kept = (stp_codec)p->entry.codec;
    const stp_codec codec = stp_codec_of_part(c->params->keep_codec ? kept : c->params->codec);
    if (c->blocks)
        return stp_codec_in_blocks(codec);
    return codec == STP_CODEC_PAPER ? STP_CODEC_DRACO : codec; /* squares are of blocks alone */
}

/* Cuts a decoded chunk into blocks at the patches of its parent. The root is one block. */
static stp_status cut(const conversion *c, const piece *p, stp_chunk *chunk, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_entry above;
    stp_chunk *parent = NULL;
    free(chunk->block_ends);
    chunk->block_ends = NULL;
    chunk->block_count = 0;
    if (!c->blocks || !c->linked || p->entry.parent == STP_CHUNK_NONE)
        return STP_OK;
    STP_TRY(stp_chunk_file_entry(c->file, p->entry.parent, &above, err));
    STP_TRY(stp_chunk_file_read(c->file, p->entry.parent, 2, &parent, err));
    const uint32_t least = c->params->block_samples;
    STP_TRY(stp_chunk_cut_by_parent(chunk, parent, chunk->id - above.first_child,
                                    least ? least : stp_block_samples_least(new_codec(c, p)), err));
done:
    stp_chunk_destroy(&parent);
    return status;
}

/* Decodes and encodes again. The entry keeps what it says of the chunk; segment ends, hashes and
 * codec change. If the payload already has the codec, it stays, but it must be readable. */
static stp_status recode(const conversion *c, uint32_t id, piece *p, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    stp_bytes bytes = {0};
    const stp_codec codec = new_codec(c, p);
    STP_TRY(stp_chunk_file_decode(c->file, id, 0, p->payload, NULL, &chunk, err));
    if (p->entry.codec == codec && !c->params->block_samples)
        goto done;
    STP_TRY(cut(c, p, chunk, err));
    STP_TRY(stp_segments_encode(chunk, codec, &p->entry, &bytes, err));
    free(p->payload);
    p->payload = bytes.data;
    bytes.data = NULL;
done:
    free(bytes.data);
    stp_chunk_destroy(&chunk);
    return status;
}

static stp_status convert_piece(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    const conversion *c = context;
    uint32_t id = c->order[c->first + index];
    piece *p = &c->pieces[index];
    (void)worker;
    STP_TRY(stp_chunk_file_entry(c->file, id, &p->entry, err));
    uint32_t size = p->entry.segment_end[STP_SEGMENT_COUNT - 1];
    STP_TRY(stp_alloc(&p->payload, (size_t)size + 1, 1, "payload", err));
    STP_TRY(stp_chunk_file_fetch(c->file, id, 0, size, p->payload, err));
    if (c->copies)
        STP_TRY(check_payload(c, id, p, err));
    else
        STP_TRY(recode(c, id, p, err));
done:
    return status;
}

static stp_status run_batch(conversion *c, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    if (c->params->pool)
        STP_TRY(stp_pool_run(c->params->pool, count, convert_piece, c, err));
    for (uint32_t i = 0; !c->params->pool && i < count; i++)
        STP_TRY(convert_piece(c, i, 0, err));
    for (uint32_t i = 0; i < count; i++) {
        STP_TRY(stp_chunk_writer_append(c->writer, c->pieces[i].payload, &c->pieces[i].entry,
                                        &c->handles[c->order[c->first + i]], err));
        free(c->pieces[i].payload);
        c->pieces[i].payload = NULL;
    }
done:
    return status;
}

static stp_status convert_payloads(conversion *c, uint32_t batch, stp_error *err)
{
    stp_status status = STP_OK;
    for (c->first = 0; c->first < c->count; c->first += batch) {
        uint32_t left = c->count - c->first;
        STP_TRY(run_batch(c, left < batch ? left : batch, err));
        uint32_t done_count = left < batch ? c->count : c->first + batch;
        STP_TRY(stp_progress_update(c->params->progress, "convert", done_count, c->count, err));
    }
done:
    return status;
}

/* ---- attributes ---- */

/* Copies the parts of one chunk, attribute by attribute. rows: room for all attributes. */
static stp_status copy_numbers(const conversion *c, uint32_t id, stp_attribute_row *rows,
                               stp_error *err)
{
    stp_status status = STP_OK;
    const stp_attribute_list *list = stp_attribute_file_list(c->attributes);
    stp_bytes bytes = {0};
    for (uint32_t a = 0; a < list->count; a++) {
        const size_t begin = bytes.size;
        size_t size = 0;
        STP_TRY(stp_attribute_file_row(c->attributes, a, id, &rows[a], err));
        for (int k = 0; k < STP_LEVEL_COUNT; k++)
            size += rows[a].bytes[k];
        STP_TRY(stp_bytes_append(&bytes, NULL, size, err));
        if (size > 0)
            STP_TRY(stp_attribute_file_parts(c->attributes, &rows[a], bytes.data + begin, err));
        rows[a].offset = begin;
    }
    STP_TRY(stp_chunk_writer_append_numbers(c->writer, c->handles[id], list, bytes.data, bytes.size,
                                            rows, err));
done:
    free(bytes.data);
    return status;
}

static stp_status copy_attributes(const conversion *c, stp_error *err)
{
    stp_status status = STP_OK;
    stp_attribute_row *rows = NULL;
    const stp_attribute_list *list = stp_attribute_file_list(c->attributes);
    if (list->count == 0 || c->params->drop_attributes)
        return STP_OK;
    STP_TRY(stp_alloc(&rows, list->count, sizeof *rows, "attributes", err));
    for (uint32_t id = 0; id < c->count; id++)
        STP_TRY(copy_numbers(c, id, rows, err));
done:
    free(rows);
    return status;
}

/* ---- order and tree ---- */

static stp_status find_order(conversion *c, stp_error *err)
{
    stp_status status = STP_OK;
    stp_placed *list = NULL;
    STP_TRY(stp_alloc(&list, c->count, sizeof *list, "chunks", err));
    for (uint32_t id = 0; id < c->count; id++) {
        stp_chunk_entry entry;
        STP_TRY(stp_chunk_file_entry(c->file, id, &entry, err));
        list[id] = (stp_placed){entry.offset, id};
        c->linked = c->linked && (entry.child_count == 0 || entry.flags & STP_CHUNK_LINKED);
    }
    stp_sort_placed(list, c->count);
    for (uint32_t i = 0; i < c->count; i++)
        c->order[i] = list[i].id;
done:
    free(list);
    return status;
}

/* Children have consecutive ids, so their handles, listed by id, are the tree. */
static stp_status finish(conversion *c, const char *metadata, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t **children = NULL;
    uint32_t *counts = NULL;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(c->file);
    STP_TRY(stp_alloc(&children, c->count, sizeof *children, "chunks", err));
    STP_TRY(stp_alloc(&counts, c->count, sizeof *counts, "chunks", err));
    for (uint32_t id = 0; id < c->count; id++) {
        stp_chunk_entry entry;
        STP_TRY(stp_chunk_file_entry(c->file, id, &entry, err));
        counts[c->handles[id]] = entry.child_count;
        children[c->handles[id]] =
            entry.child_count > 0 ? &c->handles[entry.first_child] : c->handles;
    }
    STP_TRY(stp_chunk_writer_finish(&c->writer, c->handles[0], children, counts, &info->box,
                                    metadata, NULL, err));
done:
    free(children);
    free(counts);
    return status;
}

stp_status stp_chunk_file_convert(stp_chunk_file *file, const char *output,
                                  const stp_convert_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    char *metadata = NULL;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    uint32_t threads = params->pool ? stp_pool_thread_count(params->pool) : 1;
    uint32_t batch = BATCH_PER_THREAD * threads;
    const bool has_blocks = info->version_major >= 2;
    const bool blocks = params->format ? params->format == 2 : has_blocks;
    conversion c = {.file = file,
                    .params = params,
                    .count = info->chunk_count,
                    .blocks = blocks,
                    .copies = params->keep_codec && blocks == has_blocks && !params->block_samples,
                    .linked = true};
    const stp_chunk_writer_params written = {.force = params->force,
                                             .codec = blocks ? STP_CODEC_RAW_BLOCKS : STP_CODEC_RAW,
                                             .attributes = info->attributes,
                                             .orientation = info->orientation,
                                             .lambda = info->lambda};
    if (stp_chunk_file_is_newer(info->version_major, info->version_minor))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: version %u.%u is newer than this program, which would lose what "
                             "it does not know: use a newer stipple",
                             stp_chunk_file_path(file), info->version_major, info->version_minor);
    STP_TRY(stp_attribute_file_open(&c.attributes, file, err));
    if (!blocks && !params->drop_attributes && stp_attribute_file_list(c.attributes)->count > 0) {
        status = stp_error_set(err, STP_INVALID_ARGUMENT,
                               "%s has attributes, which files of version 1 cannot hold: give "
                               "--drop-attributes to lose them",
                               stp_chunk_file_path(file));
        goto done;
    }
    STP_TRY(make_metadata(info, params->threshold_px, &metadata, err));
    STP_TRY(stp_alloc(&c.order, c.count, sizeof *c.order, "chunks", err));
    STP_TRY(stp_alloc(&c.handles, c.count, sizeof *c.handles, "chunks", err));
    STP_TRY(stp_alloc(&c.pieces, batch, sizeof *c.pieces, "chunks", err));
    STP_TRY(find_order(&c, err));
    STP_TRY(stp_chunk_writer_create(&c.writer, output, &written, err));
    STP_TRY(convert_payloads(&c, batch, err));
    STP_TRY(copy_attributes(&c, err));
    STP_TRY(finish(&c, metadata, err));
done:
    stp_attribute_file_close(&c.attributes);
    for (uint32_t i = 0; c.pieces && i < batch; i++)
        free(c.pieces[i].payload);
    stp_chunk_writer_destroy(&c.writer);
    free(c.pieces);
    free(c.order);
    free(c.handles);
    free(metadata);
    return status;
}

stp_status stp_chunk_file_set_threshold(const char *path, double threshold_px, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_file *file = NULL;
    const stp_convert_params params = {
        .keep_codec = true, .threshold_px = threshold_px, .force = true};
    if (!isfinite(threshold_px) || threshold_px <= 0.0)
        return stp_error_set(
            err, STP_INVALID_ARGUMENT,
            "a threshold of %g pixels cannot be a model's default: give one above 0", threshold_px);
    STP_TRY(stp_chunk_file_open(&file, path, err));
    if (stp_byte_source_is_remote(stp_chunk_file_source(file))) {
        status = stp_error_set(err, STP_INVALID_ARGUMENT,
                               "%s is on a server: its threshold cannot be changed",
                               stp_chunk_file_path(file));
        goto done;
    }
    STP_TRY(stp_chunk_file_convert(file, path, &params, err));
done:
    stp_chunk_file_close(&file);
    return status;
}
