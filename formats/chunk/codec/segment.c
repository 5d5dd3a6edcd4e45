/* Encodes and decodes segments: whole, or block by block. */
#include "formats/chunk/codec/segment.h"

#include "base/memory.h"
#include "formats/chunk/codec/part.h"
#include "formats/chunk/codec/shares.h"
#include "formats/chunk/codec/square_map.h"
#include "formats/chunk/layout.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#define COUNT_BYTES 4u
#define ROW_BYTES 4u        /* segments 1 and 2: u32 bytes */
#define ROW_BYTES_FIRST 12u /* segment 0: bytes, patches, samples of levels 2, 1, 0 */

static size_t row_bytes(int segment)
{
    return segment == 0 ? ROW_BYTES_FIRST : ROW_BYTES;
}

/* ---- a block of a chunk as a chunk ---- */

/* Patches [first, end) of a chunk. The samples are the chunk's own. */
typedef struct view {
    stp_chunk chunk;
    uint32_t *begins; /* memory of level_begin */
} view;

static stp_status view_create(view *v, const stp_chunk *whole, uint32_t first, uint32_t end,
                              stp_error *err)
{
    const uint32_t count = end - first;
    *v = (view){.chunk = *whole};
    v->chunk.memory = NULL;
    v->chunk.patches = whole->patches + first;
    v->chunk.patch_count = count;
    v->chunk.block_ends = NULL;
    v->chunk.block_count = 0;
    v->chunk.is_block = true;
    v->chunk.squares = NULL;
    v->chunk.map = NULL;
    v->chunk.rasters = NULL;
    v->chunk.raster_count = 0;
    stp_status status = stp_alloc(&v->begins, STP_LEVEL_COUNT * ((size_t)count + 1),
                                  sizeof *v->begins, "a block", err);
    for (int l = 0; status == STP_OK && l < STP_LEVEL_COUNT; l++)
        v->chunk.level_begin[l] = v->begins + (size_t)l * (count + 1);
    return status;
}

/* Takes level_begin, samples, squares and rasters from the chunk, whose levels have been placed. */
static void view_place(view *v, const stp_chunk *whole, uint32_t first)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        const uint32_t *begin = whole->level_begin[l] + first;
        for (uint32_t i = 0; i <= v->chunk.patch_count; i++)
            v->chunk.level_begin[l][i] = begin[i] - begin[0];
        v->chunk.samples[l] = whole->samples[l] ? whole->samples[l] + begin[0] : NULL;
    }
    v->chunk.squares = whole->squares ? whole->squares + first : NULL;
    v->chunk.rasters = whole->rasters;
    v->chunk.raster_count = whole->raster_count;
}

/* ---- encoding ---- */

static void put_row(const stp_chunk *block, int segment, size_t bytes, uint8_t *row)
{
    stp_put_u32(row, (uint32_t)bytes);
    if (segment > 0)
        return;
    stp_put_u16(row + 4, (uint16_t)(block->patch_count - 1));
    for (int l = 2; l >= 0; l--)
        stp_put_u16(row + 10 - 2 * l, (uint16_t)(block->level_begin[l][block->patch_count] - 1));
}

/* Encodes segments [first, end) of a block. If the chunk has rasters, all share the squares that
 * segment 0 finds, and their map. rows: of the block in each segment's index. */
static stp_status encode_block(const stp_chunk *chunk, uint32_t b, int first, int end,
                               stp_codec codec, const size_t *rows, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    view v = {0};
    stp_square_map map = {0};
    stp_square *squares = NULL;
    const uint32_t patch = b ? chunk->block_ends[b - 1] : 0;
    const uint32_t patch_end = chunk->block_count ? chunk->block_ends[b] : chunk->patch_count;
    STP_TRY(view_create(&v, chunk, patch, patch_end, err));
    view_place(&v, chunk, patch);
    if (chunk->raster_count > 0 && end - first > 1) {
        STP_TRY(stp_alloc(&squares, v.chunk.patch_count, sizeof *squares, "squares", err));
        v.chunk.squares = squares;
        v.chunk.map = &map;
    }
    for (int s = first; s < end; s++) {
        const size_t begin = out[s].size;
        STP_TRY(stp_part_encode(&v.chunk, s, stp_codec_of_part(codec), &out[s], err));
        put_row(&v.chunk, s, out[s].size - begin, out[s].data + rows[s] + b * row_bytes(s));
    }
done:
    stp_square_map_clear(&map);
    free(squares);
    free(v.begins);
    return status;
}

static stp_status encode(const stp_chunk *chunk, int first, int end, stp_codec codec,
                         stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = chunk->block_count ? chunk->block_count : 1;
    size_t rows[STP_SEGMENT_COUNT];
    for (int s = first; s < end; s++) {
        if (!stp_codec_has_blocks(codec)) {
            STP_TRY(stp_part_encode(chunk, s, codec, &out[s], err));
            continue;
        }
        rows[s] = out[s].size + COUNT_BYTES;
        STP_TRY(stp_bytes_append(&out[s], NULL, stp_block_index_bytes(count, s), err));
        stp_put_u32(out[s].data + rows[s] - COUNT_BYTES, count);
    }
    for (uint32_t b = 0; stp_codec_has_blocks(codec) && b < count; b++)
        STP_TRY(encode_block(chunk, b, first, end, codec, rows, out, err));
done:
    return status;
}

stp_status stp_segment_encode(const stp_chunk *chunk, int segment, stp_codec codec, stp_bytes *out,
                              stp_error *err)
{
    stp_bytes segments[STP_SEGMENT_COUNT] = {{0}};
    segments[segment] = *out;
    const stp_status status = encode(chunk, segment, segment + 1, codec, segments, err);
    *out = segments[segment];
    return status;
}

stp_status stp_segments_encode(const stp_chunk *chunk, stp_codec codec, stp_chunk_entry *entry,
                               stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes segments[STP_SEGMENT_COUNT] = {{0}};
    STP_TRY(encode(chunk, 0, STP_SEGMENT_COUNT, codec, segments, err));
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        STP_TRY(stp_bytes_append(out, segments[s].data, segments[s].size, err));
        entry->segment_end[s] = (uint32_t)out->size;
        entry->segment_hash[s] = stp_hash(segments[s].data, segments[s].size);
    }
    entry->codec = (uint8_t)codec;
done:
    for (int s = 0; s < STP_SEGMENT_COUNT; s++)
        free(segments[s].data);
    return status;
}

/* ---- decoding ---- */

stp_status stp_block_count_read(const uint8_t *bytes, size_t size, uint32_t *out, stp_error *err)
{
    uint32_t count = size < COUNT_BYTES ? 0 : stp_get_u32(bytes);
    if (count == 0 || count > STP_CHUNK_PATCHES_LIMIT || count > (size - COUNT_BYTES) / ROW_BYTES)
        return stp_error_set(err, STP_CORRUPT, "it has %" PRIu32 " blocks in %zu bytes", count,
                             size);
    *out = count;
    return STP_OK;
}

size_t stp_block_segment_bytes(const uint8_t *bytes, size_t size, int segment)
{
    uint32_t count = 0;
    if (stp_block_count_read(bytes, size, &count, NULL) != STP_OK)
        return 0;
    uint64_t end = stp_block_index_bytes(count, segment);
    for (uint32_t b = 0; b < count && end <= size; b++)
        end += stp_get_u32(bytes + COUNT_BYTES + b * row_bytes(segment));
    return end <= size ? (size_t)end : 0;
}

static void get_counts(const uint8_t *row, stp_block_row *out)
{
    out->patch_count = stp_get_u16(row + 4) + 1u;
    for (int l = 2; l >= 0; l--)
        out->sample_count[l] = stp_get_u16(row + 10 - 2 * l) + 1u;
    out->sample_count[STP_LEVEL_COUNT - 1] = out->patch_count;
}

stp_status stp_block_rows_read(const uint8_t *bytes, size_t size, int segment, stp_block_row *rows,
                               uint32_t count, stp_error *err)
{
    uint64_t at = stp_block_index_bytes(count, segment);
    if (at > size)
        return stp_error_set(err, STP_CORRUPT, "its index of blocks does not fit into it");
    for (uint32_t b = 0; b < count; b++) {
        const uint8_t *row = bytes + COUNT_BYTES + b * row_bytes(segment);
        uint32_t part = stp_get_u32(row);
        if (part > size - at)
            return stp_error_set(err, STP_CORRUPT, "block %" PRIu32 " does not fit into it", b);
        rows[b].begin = (uint32_t)at;
        rows[b].bytes = part;
        at += part;
        if (segment == 0)
            get_counts(row, &rows[b]);
    }
    if (at != size)
        return stp_error_set(err, STP_CORRUPT, "%" PRIu64 " bytes are left over behind its blocks",
                             size - at);
    return STP_OK;
}

/* Checks that the blocks of segment 0 add up to the chunk, and keeps their ends in the chunk. */
static stp_status take_ends(stp_chunk *chunk, const stp_block_row *rows, uint32_t count,
                            stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *ends = NULL;
    uint64_t patches = 0, samples[STP_LEVEL_COUNT] = {0};
    STP_TRY(stp_alloc(&ends, count, sizeof *ends, "blocks", err));
    for (uint32_t b = 0; b < count; b++) {
        patches += rows[b].patch_count;
        ends[b] = (uint32_t)patches;
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            samples[l] += rows[b].sample_count[l];
    }
    bool whole = patches == chunk->patch_count;
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        whole = whole && samples[l] == chunk->level_begin[l][chunk->patch_count];
    if (!whole) {
        status = stp_error_set(err, STP_CORRUPT, "its blocks do not add up to the chunk's counts");
        goto done;
    }
    free(chunk->block_ends);
    chunk->block_ends = ends;
    chunk->block_count = count;
    ends = NULL;
done:
    free(ends);
    return status;
}

/* Where the levels of a block begin in the chunk. */
typedef struct place {
    uint32_t patch, level[STP_LEVEL_COUNT];
    size_t raster_capacity; /* of the chunk's rasters */
} place;

/* Sets what the decoder of segment 0 expects of a chunk: counts, and where samples go. */
static void expect_row(view *v, const stp_chunk *whole, const stp_block_row *row, const place *at)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        v->chunk.level_begin[l][row->patch_count] = row->sample_count[l];
        v->chunk.samples[l] = whole->samples[l] ? whole->samples[l] + at->level[l] : NULL;
    }
}

/* Moves the squares and rasters that segment 0 of a block has to the chunk. */
static stp_status place_squares(stp_chunk *whole, const view *v, place *at, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk *block = &v->chunk;
    if (!block->squares)
        return STP_OK;
    if (!whole->squares)
        STP_TRY(
            stp_alloc(&whole->squares, whole->patch_count, sizeof *whole->squares, "squares", err));
    STP_TRY(stp_grow(&whole->rasters, &at->raster_capacity,
                     whole->raster_count + block->raster_count, sizeof *whole->rasters, "rasters",
                     err));
    for (uint32_t p = 0; p < block->patch_count; p++) {
        whole->squares[at->patch + p] = block->squares[p];
        whole->squares[at->patch + p].raster += whole->raster_count;
    }
    memcpy(whole->rasters + whole->raster_count, block->rasters,
           block->raster_count * sizeof *block->rasters);
    whole->raster_count += block->raster_count;
done:
    return status;
}

/* Copies a block's level_begin, now known, to the chunk; moves on to the next block. */
static void place_levels(stp_chunk *whole, const view *v, place *at)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        for (uint32_t i = 0; i < v->chunk.patch_count; i++)
            whole->level_begin[l][at->patch + i] = at->level[l] + v->chunk.level_begin[l][i];
        at->level[l] += v->chunk.level_begin[l][v->chunk.patch_count];
    }
    at->patch += v->chunk.patch_count;
}

static stp_status decode_block(const uint8_t *bytes, const stp_block_row *row, int segment,
                               int codec, uint32_t child_count, stp_chunk *chunk, place *at,
                               stp_chunk_scratch *scratch, stp_error *err)
{
    stp_status status = STP_OK;
    view v = {0};
    STP_TRY(view_create(&v, chunk, at->patch, at->patch + row->patch_count, err));
    if (segment == 0)
        expect_row(&v, chunk, row, at);
    else
        view_place(&v, chunk, at->patch);
    STP_TRY(stp_part_decode(bytes + row->begin, row->bytes, segment,
                            (int)stp_codec_of_part((stp_codec)codec), child_count, &v.chunk,
                            scratch, err));
    if (segment == 0) {
        STP_TRY(place_squares(chunk, &v, at, err));
        place_levels(chunk, &v, at);
    } else {
        at->patch += row->patch_count;
        chunk->reach = v.chunk.reach;
    }
done:
    if (segment == 0) {
        free(v.chunk.squares);
        free(v.chunk.rasters);
    }
    free(v.begins);
    return status;
}

static stp_status decode_blocks(const uint8_t *bytes, size_t size, int segment, int codec,
                                uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                                stp_error *err)
{
    stp_status status = STP_OK;
    stp_block_row *rows = NULL;
    uint32_t count = 0;
    place at = {0};
    STP_TRY(stp_block_count_read(bytes, size, &count, err));
    STP_TRY(stp_alloc(&rows, count, sizeof *rows, "blocks", err));
    STP_TRY(stp_block_rows_read(bytes, size, segment, rows, count, err));
    if (scratch->shares)
        scratch->shares->bytes[STP_SHARE_FRAME] += stp_block_index_bytes(count, segment);
    if (segment == 0) {
        free(chunk->rasters);
        free(chunk->squares);
        chunk->rasters = NULL;
        chunk->squares = NULL;
        chunk->raster_count = 0;
        STP_TRY(take_ends(chunk, rows, count, err));
    }
    if (count != chunk->block_count) {
        status =
            stp_error_set(err, STP_CORRUPT, "it has %" PRIu32 " blocks, segment 0 has %" PRIu32,
                          count, chunk->block_count);
        goto done;
    }
    for (uint32_t b = 0; b < count; b++) {
        rows[b].patch_count = chunk->block_ends[b] - (b ? chunk->block_ends[b - 1] : 0);
        STP_TRY(
            decode_block(bytes, &rows[b], segment, codec, child_count, chunk, &at, scratch, err));
    }
done:
    free(rows);
    return status;
}

stp_status stp_segment_decode(const uint8_t *bytes, size_t size, int segment, int codec,
                              uint32_t child_count, stp_chunk *chunk, stp_chunk_scratch *scratch,
                              stp_error *err)
{
    return codec >= STP_CODEC_RAW_BLOCKS && codec < STP_CODEC_COUNT
               ? decode_blocks(bytes, size, segment, codec, child_count, chunk, scratch, err)
               : stp_part_decode(bytes, size, segment, codec, child_count, chunk, scratch, err);
}
