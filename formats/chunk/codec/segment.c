/* Encodes and decodes segments: whole, or block by block. */
#include "formats/chunk/codec/segment.h"

#include "base/memory.h"
#include "formats/chunk/codec/part.h"
#include "formats/chunk/codec/shares.h"
#include "formats/chunk/codec/square/square_map.h"
#include "formats/chunk/layout.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

#define COUNT_BYTES 4u
/* Set in the count of blocks: the index is short. */
#define SHORT_INDEX (UINT32_C(1) << 31)
/* Rows that are not short. */
#define ROW_BYTES 4u        /* segments 1 and 2: u32 bytes */
#define ROW_BYTES_FIRST 12u /* segment 0: bytes, patches, samples of levels 2, 1, 0 */
/* A number of 32 bits takes at most so many bytes of 7 bits. */
#define NUMBER_BYTES 5u
#define ROW_NUMBERS 5u /* of a short row of segment 0; others have one */

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
static void view_begin(view *v, const stp_chunk *whole, uint32_t first)
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

/* Appends a number in bytes of 7 bits, the least ones first; bit 7 says that more follow. */
static size_t put_number(uint32_t number, uint8_t *to)
{
    size_t bytes = 0;
    for (; number >= 128; number >>= 7)
        to[bytes++] = (uint8_t)(number | 128u);
    to[bytes++] = (uint8_t)number;
    return bytes;
}

/* The least number of samples that can stand for so many. */
static uint32_t quarter(uint32_t samples)
{
    return (samples + 3) / 4;
}

static size_t put_row(const stp_block_row *row, int segment, uint8_t *to)
{
    const uint32_t *samples = row->sample_count;
    size_t bytes = put_number(row->bytes, to);
    if (segment > 0)
        return bytes;
    bytes += put_number(row->patch_count - 1, to + bytes);
    bytes += put_number(STP_PATCH_SAMPLES * row->patch_count - samples[0], to + bytes);
    for (int l = 1; l < STP_LEVEL_COUNT - 1; l++)
        bytes += put_number(samples[l] - quarter(samples[l - 1]), to + bytes);
    return bytes;
}

size_t stp_block_row_bytes(const stp_block_row *row, int segment)
{
    uint8_t bytes[ROW_NUMBERS * NUMBER_BYTES];
    return put_row(row, segment, bytes);
}

/* What a block's parts are, by segment. */
typedef struct encoded {
    stp_block_row *rows[STP_SEGMENT_COUNT];
    stp_bytes parts[STP_SEGMENT_COUNT];
} encoded;

/* Encodes segments [first, end) of block b. If the chunk has rasters, all share the squares that
 * segment 0 finds, and their map. */
static stp_status encode_block(const stp_chunk *chunk, uint32_t b, int first, int end,
                               stp_codec codec, encoded *out, stp_error *err)
{
    stp_status status = STP_OK;
    view v = {0};
    stp_square_map map = {0};
    stp_square *squares = NULL;
    const uint32_t patch = b ? chunk->block_ends[b - 1] : 0;
    const uint32_t patch_end = chunk->block_count ? chunk->block_ends[b] : chunk->patch_count;
    STP_TRY(view_create(&v, chunk, patch, patch_end, err));
    view_begin(&v, chunk, patch);
    if (chunk->raster_count > 0 && end - first > 1) {
        STP_TRY(stp_alloc(&squares, v.chunk.patch_count, sizeof *squares, "squares", err));
        v.chunk.squares = squares;
        v.chunk.map = &map;
    }
    for (int s = first; s < end; s++) {
        stp_block_row *row = &out->rows[s][b];
        const size_t begin = out->parts[s].size;
        STP_TRY(stp_part_encode(&v.chunk, s, stp_codec_of_part(codec), &out->parts[s], err));
        *row = (stp_block_row){.patch_count = patch_end - patch,
                               .bytes = (uint32_t)(out->parts[s].size - begin)};
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            row->sample_count[l] = v.chunk.level_begin[l][patch_end - patch];
    }
done:
    stp_square_map_clear(&map);
    free(squares);
    free(v.begins);
    return status;
}

static stp_status append_index(const stp_block_row *rows, uint32_t count, int segment,
                               stp_bytes *out, stp_error *err)
{
    uint8_t bytes[ROW_NUMBERS * NUMBER_BYTES];
    stp_put_u32(bytes, count | SHORT_INDEX);
    stp_status status = stp_bytes_append(out, bytes, COUNT_BYTES, err);
    for (uint32_t b = 0; b < count && status == STP_OK; b++)
        status = stp_bytes_append(out, bytes, put_row(&rows[b], segment, bytes), err);
    return status;
}

static stp_status encode_blocks(const stp_chunk *chunk, int first, int end, stp_codec codec,
                                stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = chunk->block_count ? chunk->block_count : 1;
    encoded e = {0};
    for (int s = first; s < end; s++)
        STP_TRY(stp_alloc(&e.rows[s], count, sizeof *e.rows[s], "blocks", err));
    for (uint32_t b = 0; b < count; b++)
        STP_TRY(encode_block(chunk, b, first, end, codec, &e, err));
    for (int s = first; s < end; s++) {
        STP_TRY(append_index(e.rows[s], count, s, &out[s], err));
        STP_TRY(stp_bytes_append(&out[s], e.parts[s].data, e.parts[s].size, err));
    }
done:
    for (int s = first; s < end; s++) {
        free(e.parts[s].data);
        free(e.rows[s]);
    }
    return status;
}

static stp_status encode(const stp_chunk *chunk, int first, int end, stp_codec codec,
                         stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    if (stp_codec_has_blocks(codec))
        return encode_blocks(chunk, first, end, codec, out, err);
    for (int s = first; s < end && status == STP_OK; s++)
        status = stp_part_encode(chunk, s, codec, &out[s], err);
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
    const size_t least = count & SHORT_INDEX ? 1 : ROW_BYTES;
    count &= ~SHORT_INDEX;
    if (count == 0 || count > STP_CHUNK_PATCHES_LIMIT || count > (size - COUNT_BYTES) / least)
        return stp_error_set(err, STP_CORRUPT, "it has %" PRIu32 " blocks in %zu bytes", count,
                             size);
    *out = count;
    return STP_OK;
}

/* Takes a number of 7 bits a byte; false if it does not fit into the bytes or into 32 bits, or has
 * more bytes than it needs. */
static bool take_number(stp_cursor *c, uint32_t *out)
{
    uint64_t number = 0;
    for (unsigned i = 0; i < NUMBER_BYTES && c->left > 0; i++) {
        const uint8_t byte = *c->bytes;
        stp_cursor_skip(c, 1);
        number |= (uint64_t)(byte & 127u) << 7 * i;
        if (byte < 128) {
            *out = (uint32_t)number;
            return number <= UINT32_MAX && (byte > 0 || i == 0);
        }
    }
    return false;
}

static bool take_short_counts(stp_cursor *c, stp_block_row *row)
{
    uint32_t *samples = row->sample_count, number;
    if (!take_number(c, &number) || number >= STP_CHUNK_PATCHES_LIMIT)
        return false;
    row->patch_count = samples[STP_LEVEL_COUNT - 1] = number + 1;
    if (!take_number(c, &number) || number >= STP_PATCH_SAMPLES * row->patch_count)
        return false;
    samples[0] = STP_PATCH_SAMPLES * row->patch_count - number;
    for (int l = 1; l < STP_LEVEL_COUNT - 1; l++) {
        if (!take_number(c, &number) || number >= STP_PATCH_SAMPLES * row->patch_count)
            return false;
        samples[l] = quarter(samples[l - 1]) + number;
    }
    return samples[0] <= STP_CHUNK_SAMPLES_LIMIT && samples[1] <= STP_CHUNK_SAMPLES_LIMIT &&
           samples[2] <= STP_CHUNK_SAMPLES_LIMIT;
}

static bool take_counts(stp_cursor *c, stp_block_row *row)
{
    if (c->left < ROW_BYTES_FIRST - ROW_BYTES)
        return false;
    row->patch_count = row->sample_count[STP_LEVEL_COUNT - 1] = stp_get_u16(c->bytes) + 1u;
    for (int l = 2; l >= 0; l--)
        row->sample_count[l] = stp_get_u16(c->bytes + 6 - 2 * l) + 1u;
    stp_cursor_skip(c, ROW_BYTES_FIRST - ROW_BYTES);
    return true;
}

static bool take_row(stp_cursor *c, bool is_short, int segment, stp_block_row *row)
{
    if (is_short)
        return take_number(c, &row->bytes) && (segment > 0 || take_short_counts(c, row));
    if (c->left < ROW_BYTES)
        return false;
    row->bytes = stp_get_u32(c->bytes);
    stp_cursor_skip(c, ROW_BYTES);
    return segment > 0 || take_counts(c, row);
}

/* Reads the index, and where parts begin behind it. rows: NULL if nobody asks. Returns where the
 * last part ends, 0 if the index does not fit into the bytes. */
static uint64_t read_index(const uint8_t *bytes, size_t size, int segment, uint32_t count,
                           stp_block_row *rows)
{
    stp_cursor c = {bytes + COUNT_BYTES, size - COUNT_BYTES};
    const bool is_short = stp_get_u32(bytes) & SHORT_INDEX;
    uint64_t parts = 0;
    stp_block_row row = {0};
    for (uint32_t b = 0; b < count; b++) {
        if (!take_row(&c, is_short, segment, &row))
            return 0;
        row.begin = (uint32_t)parts;
        parts += row.bytes;
        if (rows)
            rows[b] = row;
    }
    const uint64_t index = size - c.left;
    for (uint32_t b = 0; b < count && rows; b++)
        rows[b].begin += (uint32_t)index;
    return index + parts;
}

size_t stp_block_segment_bytes(const uint8_t *bytes, size_t size, int segment)
{
    uint32_t count = 0;
    if (stp_block_count_read(bytes, size, &count, NULL) != STP_OK)
        return 0;
    const uint64_t end = read_index(bytes, size, segment, count, NULL);
    return end <= size ? (size_t)end : 0;
}

stp_status stp_block_rows_read(const uint8_t *bytes, size_t size, int segment, stp_block_row *rows,
                               uint32_t count, stp_error *err)
{
    const uint64_t end = read_index(bytes, size, segment, count, rows);
    if (end == 0)
        return stp_error_set(err, STP_CORRUPT, "its index of blocks does not fit into it");
    if (end != size)
        return stp_error_set(err, STP_CORRUPT, "its blocks end at byte %" PRIu64 " of %zu", end,
                             size);
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
        view_begin(&v, chunk, at->patch);
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
        scratch->shares->bytes[STP_SHARE_FRAME] += rows[0].begin;
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
