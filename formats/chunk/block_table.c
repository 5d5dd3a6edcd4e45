/* Records of blocks as bytes, and their checks. */
#include "formats/chunk/block_table.h"

#include "base/memory.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/describe.h"
#include "formats/chunk/layout.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* Offsets in a record. */
enum {
    AT_PATCHES = 0,   /* u16, less 1 */
    AT_FLAGS = 2,     /* u8 */
    AT_COUNTS = 4,    /* 3 u16, less 1: samples of levels 0, 1, 2 */
    AT_EXPONENT = 10, /* i16: errors and radius are codes on a step of 2^exponent */
    AT_BYTES = 12,    /* 3 u32 */
    AT_HASH = 24,     /* 3 u64 */
    AT_BOX = 48,      /* 6 f32 */
    AT_CONE = 72,     /* 3 f32 axis, f32 angle */
    AT_ERROR = 88,    /* 4 u8 */
    AT_TANGENTIAL = 92,
    AT_COLOUR = 96,
    AT_RADIUS = 100 /* u8; 3 bytes are zero */
};

/* ---- making ---- */

/* The greatest radius of any sample of the patches, and the coarsest of their steps. */
static double find_radius(const stp_patch *patches, uint32_t count, int *exponent)
{
    double radius = 0.0;
    *exponent = patches[0].exponent;
    for (uint32_t i = 0; i < count; i++) {
        *exponent = patches[i].exponent > *exponent ? patches[i].exponent : *exponent;
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            radius = fmax(radius, stp_radius_decode(patches[i].radius[l], patches[i].exponent));
    }
    return radius;
}

static void put_bounds(const stp_patch *patches, uint32_t count, uint8_t *record)
{
    stp_chunk_entry e = {0};
    int exponent = 0;
    const double radius = find_radius(patches, count, &exponent);
    stp_patches_describe(patches, count, &e);
    stp_put_u16(record + AT_PATCHES, (uint16_t)(count - 1));
    record[AT_FLAGS] = e.flags;
    stp_put_u16(record + AT_EXPONENT, (uint16_t)exponent);
    stp_put_floats(record + AT_BOX, e.box_min.raw, 3);
    stp_put_floats(record + AT_BOX + 12, e.box_max.raw, 3);
    stp_put_floats(record + AT_CONE, e.cone_axis.raw, 3);
    stp_put_floats(record + AT_CONE + 12, &e.cone_angle, 1);
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        record[AT_ERROR + l] = stp_error_encode((double)e.error[l], exponent);
        record[AT_TANGENTIAL + l] = stp_error_encode((double)e.tangential_error[l], exponent);
        record[AT_COLOUR + l] = (uint8_t)e.colour_error[l];
    }
    record[AT_RADIUS] = stp_radius_encode(radius, exponent);
}

/* Sizes and hashes of the blocks' parts of a segment. */
static stp_status put_parts(const uint8_t *segment, size_t size, int s, uint8_t *records,
                            uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_block_row *rows = NULL;
    STP_TRY(stp_alloc(&rows, count, sizeof *rows, "blocks", err));
    STP_TRY(stp_block_rows_read(segment, size, s, rows, count, err));
    for (uint32_t b = 0; b < count; b++) {
        uint8_t *record = records + (size_t)b * STP_BLOCK_BYTES;
        stp_put_u32(record + AT_BYTES + 4 * s, rows[b].bytes);
        stp_put_u64(record + AT_HASH + 8 * s, stp_hash(segment + rows[b].begin, rows[b].bytes));
        for (int l = 0; s == 0 && l < STP_LEVEL_COUNT - 1; l++)
            stp_put_u16(record + AT_COUNTS + 2 * l, (uint16_t)(rows[b].sample_count[l] - 1));
    }
done:
    free(rows);
    return status;
}

stp_status stp_block_records_of(const stp_chunk *chunk, const uint8_t *payload,
                                const stp_chunk_entry *entry, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t begin = out->size;
    const uint32_t whole[1] = {chunk->patch_count};
    const uint32_t *ends = chunk->block_count ? chunk->block_ends : whole;
    const uint32_t count = chunk->block_count ? chunk->block_count : 1;
    if (!stp_codec_has_blocks((stp_codec)entry->codec))
        return STP_OK;
    STP_TRY(stp_bytes_append(out, NULL, (size_t)count * STP_BLOCK_BYTES, err));
    for (uint32_t b = 0, first = 0; b < count; first = ends[b++])
        put_bounds(chunk->patches + first, ends[b] - first,
                   out->data + begin + (size_t)b * STP_BLOCK_BYTES);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        const uint32_t from = s ? entry->segment_end[s - 1] : 0;
        STP_TRY(put_parts(payload + from, entry->segment_end[s] - from, s, out->data + begin, count,
                          err));
    }
done:
    return status;
}

stp_status stp_block_records_make(const uint8_t *payload, const stp_chunk_entry *entry,
                                  stp_bytes *out, uint32_t *count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    stp_chunk_scratch scratch = {0};
    *count = 0;
    if (!stp_codec_has_blocks((stp_codec)entry->codec))
        return STP_OK;
    STP_TRY(
        stp_chunk_create_blank(&chunk, entry->patch_count, entry->sample_count, 2, &scratch, err));
    chunk->linked = (entry->flags & STP_CHUNK_LINKED) != 0;
    STP_TRY(stp_segment_decode(payload, entry->segment_end[0], 0, entry->codec,
                               STP_CHUNK_CHILDREN_LIMIT, chunk, &scratch, err));
    *count = chunk->block_count;
    STP_TRY(stp_block_records_of(chunk, payload, entry, out, err));
done:
    stp_chunk_scratch_free(&scratch);
    stp_chunk_destroy(&chunk);
    return status;
}

/* ---- reading ---- */

static void get_record(const uint8_t *record, stp_block *b)
{
    const int exponent = (int16_t)stp_get_u16(record + AT_EXPONENT);
    b->patch_count = stp_get_u16(record + AT_PATCHES) + 1u;
    b->flags = record[AT_FLAGS] & (STP_PATCH_TWO_SIDED | STP_CHUNK_CLOSED);
    for (int l = 0; l < STP_LEVEL_COUNT - 1; l++)
        b->sample_count[l] = stp_get_u16(record + AT_COUNTS + 2 * l) + 1u;
    b->sample_count[STP_LEVEL_COUNT - 1] = b->patch_count;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        b->parts[s].bytes = stp_get_u32(record + AT_BYTES + 4 * s);
        b->parts[s].hash = stp_get_u64(record + AT_HASH + 8 * s);
    }
    stp_get_floats(record + AT_BOX, b->box_min.raw, 3);
    stp_get_floats(record + AT_BOX + 12, b->box_max.raw, 3);
    stp_get_floats(record + AT_CONE, b->cone_axis.raw, 3);
    stp_get_floats(record + AT_CONE + 12, &b->cone_angle, 1);
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        b->error[l] = stp_round_up(stp_error_decode(record[AT_ERROR + l], exponent));
        b->tangential_error[l] =
            stp_round_up(stp_error_decode(record[AT_TANGENTIAL + l], exponent));
        b->colour_error[l] = record[AT_COLOUR + l];
    }
    b->radius_max = stp_round_up(stp_radius_decode(record[AT_RADIUS], exponent));
}

/* What is wrong with a block's numbers, or NULL. A box inside the chunk's is finite. */
static const char *block_fault(const stp_block *b, const stp_chunk_entry *e, int exponent)
{
    if (exponent < -STP_EXPONENT_LIMIT || exponent > STP_EXPONENT_LIMIT)
        return "its exponent is out of range";
    for (int i = 0; i < 3; i++)
        if (!(b->box_min.raw[i] >= e->box_min.raw[i] && b->box_max.raw[i] <= e->box_max.raw[i] &&
              b->box_min.raw[i] <= b->box_max.raw[i]) ||
            !isfinite(b->cone_axis.raw[i]))
            return "its box is empty or reaches outside the chunk's, or its cone is not finite";
    if (!(b->cone_angle >= 0.0f && isfinite(b->cone_angle)))
        return "its cone's angle is negative or not finite";
    bool near = b->radius_max <= (float)STP_REACH_LIMIT;
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        near = near && b->error[l] <= (float)STP_REACH_LIMIT &&
               b->tangential_error[l] <= (float)STP_REACH_LIMIT;
    if (!near)
        return "an error or a radius reaches too far";
    return NULL;
}

/* Places the parts of each segment one behind the other, behind the segment's index. */
static const char *place_parts(stp_block *blocks, const stp_chunk_entry *e)
{
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        uint64_t at = (s ? e->segment_end[s - 1] : 0) + stp_block_index_bytes(e->block_count, s);
        for (uint32_t b = 0; b < e->block_count; b++) {
            blocks[b].parts[s].offset = e->offset + at;
            at += blocks[b].parts[s].bytes;
        }
        if (at != e->segment_end[s])
            return "its blocks do not fill its segments";
    }
    return NULL;
}

static const char *sum_fault(const stp_block *blocks, const stp_chunk_entry *e)
{
    uint64_t sums[STP_LEVEL_COUNT] = {0};
    for (uint32_t b = 0; b < e->block_count; b++)
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            sums[l] += blocks[b].sample_count[l];
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        if (sums[l] != e->sample_count[l])
            return "its blocks do not add up to its counts";
    return NULL;
}

stp_status stp_block_records_read(const uint8_t *records, const stp_chunk_entry *entry, uint32_t id,
                                  stp_block *out, stp_error *err)
{
    uint32_t first = 0;
    const char *fault = NULL;
    for (uint32_t b = 0; b < entry->block_count; b++) {
        const uint8_t *record = records + (size_t)b * STP_BLOCK_BYTES;
        out[b] = (stp_block){.chunk = id, .first_patch = first};
        get_record(record, &out[b]);
        first += out[b].patch_count;
        fault = block_fault(&out[b], entry, (int16_t)stp_get_u16(record + AT_EXPONENT));
        if (fault)
            return stp_error_set(err, STP_CORRUPT, "block %" PRIu32 " of chunk %" PRIu32 ": %s", b,
                                 id, fault);
    }
    fault = sum_fault(out, entry);
    if (!fault)
        fault = place_parts(out, entry);
    return fault ? stp_error_set(err, STP_CORRUPT, "chunk %" PRIu32 ": %s", id, fault) : STP_OK;
}
