/* Records of blocks as bytes, and their checks. */
#include "formats/chunk/block/block_table.h"

#include "base/memory.h"
#include "formats/chunk/codec/segment.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/describe.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

/* Offsets in a record. */
enum {
    AT_PATCHES = 0,   /* u16, less 1 */
    AT_COUNTS = 2,    /* 3 u16, less 1: samples of levels 0, 1, 2 */
    AT_BYTES = 8,     /* 3 numbers of PART_BYTES */
    AT_ANGLE = 17,    /* of the cone, u8 */
    AT_AXIS = 18,     /* of the cone, 3 bytes */
    AT_RADIUS = 21,   /* u8 */
    AT_EXPONENT = 22, /* i16: errors and radius are codes on a step of 2^exponent */
    AT_ERROR = 24,    /* 4 u8 */
    AT_TANGENTIAL = 28,
    AT_COLOUR = 32,
    AT_HASH = 36, /* 3 u32 */
    AT_BOX = 48   /* u64: 6 places of BOX_BITS, then flags */
};
#define PART_BYTES 3
#define BOX_BITS 10
#define BOX_TOP ((1 << BOX_BITS) - 1)
#define TWO_SIDED_BIT 60
#define CLOSED_BIT 61

/* Offsets in a wide record, where they are others. */
enum {
    WIDE_FLAGS = 2,  /* u8 */
    WIDE_COUNTS = 4, /* 3 u16 */
    WIDE_EXPONENT = 10,
    WIDE_BYTES = 12, /* 3 u32 */
    WIDE_HASH = 24,  /* 3 u64 */
    WIDE_BOX = 48,   /* 6 f32 */
    WIDE_CONE = 72,  /* 3 f32 axis, f32 angle */
    WIDE_ERROR = 88,
    WIDE_TANGENTIAL = 92,
    WIDE_COLOUR = 96,
    WIDE_RADIUS = 100
};

/* ---- places in the chunk's box ---- */

/* The place k of BOX_TOP along an axis of the chunk's box, rounded outwards. */
static float box_low(const stp_chunk_entry *e, int axis, unsigned k)
{
    const double min = (double)e->box_min.raw[axis], max = (double)e->box_max.raw[axis];
    return fmaxf(stp_round_down(min + (max - min) * k / BOX_TOP), e->box_min.raw[axis]);
}

static float box_high(const stp_chunk_entry *e, int axis, unsigned k)
{
    const double min = (double)e->box_min.raw[axis], max = (double)e->box_max.raw[axis];
    return k == BOX_TOP
               ? e->box_max.raw[axis]
               : fminf(stp_round_up(min + (max - min) * k / BOX_TOP), e->box_max.raw[axis]);
}

/* The greatest place at or below `low`, and the least at or above `high`. */
static uint64_t box_places(const stp_chunk_entry *e, int axis, float low, float high)
{
    const double min = (double)e->box_min.raw[axis], span = (double)e->box_max.raw[axis] - min;
    double k = span > 0.0 ? floor(((double)low - min) / span * BOX_TOP) + 1.0 : 0.0;
    unsigned from = (unsigned)fmin(fmax(k, 0.0), BOX_TOP), to;
    while (from > 0 && box_low(e, axis, from) > low)
        from--;
    k = span > 0.0 ? ceil(((double)high - min) / span * BOX_TOP) - 1.0 : 0.0;
    to = (unsigned)fmin(fmax(k, 0.0), BOX_TOP);
    while (to < BOX_TOP && box_high(e, axis, to) < high)
        to++;
    return (uint64_t)from | (uint64_t)to << 3 * BOX_BITS;
}

/* ---- making ---- */

stp_block stp_block_of_entry(const stp_chunk_entry *e, uint32_t id)
{
    stp_block block = {
        .chunk = id,
        .patch_count = e->patch_count,
        .flags = (uint8_t)(e->flags & (STP_PATCH_TWO_SIDED | STP_CHUNK_CLOSED)),
        .box_min = e->box_min,
        .box_max = e->box_max,
        .cone_axis = e->cone_axis,
        .cone_angle = e->cone_angle,
        .radius_max = e->radius_max,
    };
    uint32_t begin = 0;
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        block.parts[s] = (stp_block_part){.offset = e->offset + begin,
                                          .hash = (uint32_t)e->segment_hash[s],
                                          .bytes = e->segment_end[s] - begin};
        begin = e->segment_end[s];
    }
    memcpy(block.sample_count, e->sample_count, sizeof block.sample_count);
    memcpy(block.error, e->error, sizeof block.error);
    memcpy(block.tangential_error, e->tangential_error, sizeof block.tangential_error);
    memcpy(block.colour_error, e->colour_error, sizeof block.colour_error);
    return block;
}

/* What a record says of patches. */
static void describe(const stp_patch *patches, uint32_t count, stp_block *out)
{
    stp_chunk_entry e = {0};
    double radius = 0.0;
    stp_patches_describe(patches, count, &e);
    for (uint32_t i = 0; i < count; i++)
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            radius = fmax(radius, stp_radius_decode(patches[i].radius[l], patches[i].exponent));
    e.radius_max = stp_round_up(radius);
    *out = stp_block_of_entry(&e, 0);
}

/* Errors and radii are codes' values, rounded up to floats: less of that, they get these codes
 * again, not the next. */
static double code_value(float rounded_up)
{
    return (double)rounded_up * (1.0 - 0x1p-23);
}

/* A step on which the codes of radius and errors reach as far as they must. */
static int find_exponent(const stp_block *b)
{
    float greatest = 0.0f;
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        greatest = fmaxf(greatest, fmaxf(b->error[l], b->tangential_error[l]));
    /* codes of errors reach from 2^-8 to 2^23 steps, those of radii from 1 to 2^15 */
    const int by_error = greatest > 0.0f ? ilogbf(greatest) - 21 : -STP_EXPONENT_LIMIT;
    const int by_radius = b->radius_max > 0.0f ? ilogbf(b->radius_max) - 8 : -STP_EXPONENT_LIMIT;
    const int exponent = by_error > by_radius ? by_error : by_radius;
    return exponent < -STP_EXPONENT_LIMIT ? -STP_EXPONENT_LIMIT : exponent;
}

static void put_cone(const stp_block *b, uint8_t *record)
{
    stp_normal_encode(b->cone_axis, record + AT_AXIS);
    const stp_dvec3 axis = stp_dvec3_normalize(stp_dvec3_from_float(b->cone_axis));
    const stp_dvec3 kept =
        stp_dvec3_normalize(stp_dvec3_from_float(stp_normal_decode(record + AT_AXIS)));
    const double off =
        atan2(stp_dvec3_length(stp_dvec3_cross(axis, kept)), stp_dvec3_dot(axis, kept));
    record[AT_ANGLE] = stp_cone_angle_encode((double)b->cone_angle + off);
}

static void put_record(const stp_block *b, const stp_chunk_entry *e, uint8_t *record)
{
    const int exponent = find_exponent(b);
    uint64_t box = 0;
    stp_put_u16(record + AT_PATCHES, (uint16_t)(b->patch_count - 1));
    for (int l = 0; l < STP_LEVEL_COUNT - 1; l++)
        stp_put_u16(record + AT_COUNTS + 2 * l, (uint16_t)(b->sample_count[l] - 1));
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        for (int i = 0; i < PART_BYTES; i++)
            record[AT_BYTES + PART_BYTES * s + i] = (uint8_t)(b->parts[s].bytes >> 8 * i);
        stp_put_u32(record + AT_HASH + 4 * s, b->parts[s].hash);
    }
    put_cone(b, record);
    record[AT_RADIUS] = stp_radius_encode(code_value(b->radius_max), exponent);
    stp_put_u16(record + AT_EXPONENT, (uint16_t)exponent);
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        record[AT_ERROR + l] = stp_error_encode(code_value(b->error[l]), exponent);
        record[AT_TANGENTIAL + l] = stp_error_encode(code_value(b->tangential_error[l]), exponent);
        record[AT_COLOUR + l] = (uint8_t)b->colour_error[l];
    }
    for (int i = 0; i < 3; i++)
        box |= box_places(e, i, b->box_min.raw[i], b->box_max.raw[i]) << BOX_BITS * i;
    box |= (uint64_t)((b->flags & STP_PATCH_TWO_SIDED) != 0) << TWO_SIDED_BIT;
    box |= (uint64_t)((b->flags & STP_CHUNK_CLOSED) != 0) << CLOSED_BIT;
    stp_put_u64(record + AT_BOX, box);
}

stp_status stp_block_records_write(const stp_block *blocks, const stp_chunk_entry *entry,
                                   stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t begin = out->size;
    STP_TRY(stp_bytes_append(out, NULL, (size_t)entry->block_count * STP_BLOCK_BYTES, err));
    for (uint32_t b = 0; b < entry->block_count; b++) {
        for (int s = 0; s < STP_SEGMENT_COUNT; s++)
            if (blocks[b].parts[s].bytes >> 8 * PART_BYTES)
                return stp_error_set(err, STP_LIMIT, "a block's part of %" PRIu32 " bytes",
                                     blocks[b].parts[s].bytes);
        put_record(&blocks[b], entry, out->data + begin + (size_t)b * STP_BLOCK_BYTES);
    }
done:
    return status;
}

/* Sizes and hashes of the blocks' parts of a segment. */
static stp_status find_parts(const uint8_t *segment, size_t size, int s, stp_block *blocks,
                             uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_block_row *rows = NULL;
    STP_TRY(stp_alloc(&rows, count, sizeof *rows, "blocks", err));
    STP_TRY(stp_block_rows_read(segment, size, s, rows, count, err));
    for (uint32_t b = 0; b < count; b++) {
        blocks[b].parts[s] =
            (stp_block_part){.bytes = rows[b].bytes,
                             .hash = (uint32_t)stp_hash(segment + rows[b].begin, rows[b].bytes)};
        for (int l = 0; s == 0 && l < STP_LEVEL_COUNT - 1; l++)
            blocks[b].sample_count[l] = rows[b].sample_count[l];
    }
done:
    free(rows);
    return status;
}

stp_status stp_block_records_of(const stp_chunk *chunk, const uint8_t *payload,
                                const stp_chunk_entry *entry, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_block *blocks = NULL;
    stp_chunk_entry counted = *entry;
    const uint32_t whole[1] = {chunk->patch_count};
    const uint32_t *ends = chunk->block_count ? chunk->block_ends : whole;
    const uint32_t count = chunk->block_count ? chunk->block_count : 1;
    if (!stp_codec_has_blocks((stp_codec)entry->codec))
        return STP_OK;
    counted.block_count = count;
    STP_TRY(stp_alloc(&blocks, count, sizeof *blocks, "blocks", err));
    for (uint32_t b = 0, first = 0; b < count; first = ends[b++])
        describe(chunk->patches + first, ends[b] - first, &blocks[b]);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        const uint32_t from = s ? entry->segment_end[s - 1] : 0;
        STP_TRY(find_parts(payload + from, entry->segment_end[s] - from, s, blocks, count, err));
    }
    STP_TRY(stp_block_records_write(blocks, &counted, out, err));
done:
    free(blocks);
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

static void get_codes(const uint8_t *error, const uint8_t *tangential, const uint8_t *colour,
                      uint8_t radius, int exponent, stp_block *b)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        b->error[l] = stp_round_up(stp_error_decode(error[l], exponent));
        b->tangential_error[l] = stp_round_up(stp_error_decode(tangential[l], exponent));
        b->colour_error[l] = colour[l];
    }
    b->radius_max = stp_round_up(stp_radius_decode(radius, exponent));
}

static void get_counts(const uint8_t *patches, const uint8_t *counts, stp_block *b)
{
    b->patch_count = stp_get_u16(patches) + 1u;
    for (int l = 0; l < STP_LEVEL_COUNT - 1; l++)
        b->sample_count[l] = stp_get_u16(counts + 2 * l) + 1u;
    b->sample_count[STP_LEVEL_COUNT - 1] = b->patch_count;
}

static int get_record(const uint8_t *record, const stp_chunk_entry *e, stp_block *b)
{
    const int exponent = (int16_t)stp_get_u16(record + AT_EXPONENT);
    const uint64_t box = stp_get_u64(record + AT_BOX);
    get_counts(record + AT_PATCHES, record + AT_COUNTS, b);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        const uint8_t *bytes = record + AT_BYTES + PART_BYTES * s;
        b->parts[s].bytes = bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16;
        b->parts[s].hash = stp_get_u32(record + AT_HASH + 4 * s);
    }
    for (int i = 0; i < 3; i++) {
        b->box_min.raw[i] = box_low(e, i, box >> BOX_BITS * i & BOX_TOP);
        b->box_max.raw[i] = box_high(e, i, box >> BOX_BITS * (3 + i) & BOX_TOP);
    }
    b->flags = (uint8_t)((box >> TWO_SIDED_BIT & 1u ? STP_PATCH_TWO_SIDED : 0) |
                         (box >> CLOSED_BIT & 1u ? STP_CHUNK_CLOSED : 0));
    b->cone_axis = stp_normal_decode(record + AT_AXIS);
    b->cone_angle = stp_round_up(stp_cone_angle_decode(record[AT_ANGLE]));
    get_codes(record + AT_ERROR, record + AT_TANGENTIAL, record + AT_COLOUR, record[AT_RADIUS],
              exponent, b);
    return exponent;
}

static int get_wide_record(const uint8_t *record, stp_block *b)
{
    const int exponent = (int16_t)stp_get_u16(record + WIDE_EXPONENT);
    get_counts(record + AT_PATCHES, record + WIDE_COUNTS, b);
    b->flags = record[WIDE_FLAGS] & (STP_PATCH_TWO_SIDED | STP_CHUNK_CLOSED);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        b->parts[s].bytes = stp_get_u32(record + WIDE_BYTES + 4 * s);
        b->parts[s].hash = stp_get_u32(record + WIDE_HASH + 8 * s);
    }
    stp_get_floats(record + WIDE_BOX, b->box_min.raw, 3);
    stp_get_floats(record + WIDE_BOX + 12, b->box_max.raw, 3);
    stp_get_floats(record + WIDE_CONE, b->cone_axis.raw, 3);
    stp_get_floats(record + WIDE_CONE + 12, &b->cone_angle, 1);
    get_codes(record + WIDE_ERROR, record + WIDE_TANGENTIAL, record + WIDE_COLOUR,
              record[WIDE_RADIUS], exponent, b);
    return exponent;
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

/* Bytes of a segment's index: of long rows if these are what is left beside its parts, else of
 * short ones. */
static uint64_t index_bytes(const stp_block *blocks, const stp_chunk_entry *e, int s, uint64_t left)
{
    uint64_t bytes = stp_block_long_index_bytes(0, s);
    if (left == stp_block_long_index_bytes(e->block_count, s))
        return left;
    for (uint32_t b = 0; b < e->block_count; b++) {
        stp_block_row row = {.patch_count = blocks[b].patch_count,
                             .bytes = blocks[b].parts[s].bytes};
        memcpy(row.sample_count, blocks[b].sample_count, sizeof row.sample_count);
        bytes += stp_block_row_bytes(&row, s);
    }
    return bytes;
}

/* Places the parts of each segment one behind the other, behind the segment's index. */
static const char *place_parts(stp_block *blocks, const stp_chunk_entry *e)
{
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        const uint64_t begin = s ? e->segment_end[s - 1] : 0;
        uint64_t parts = 0;
        for (uint32_t b = 0; b < e->block_count; b++)
            parts += blocks[b].parts[s].bytes;
        uint64_t at = e->segment_end[s] - parts;
        if (begin + parts > e->segment_end[s] ||
            index_bytes(blocks, e, s, at - begin) != at - begin)
            return "its blocks do not fill its segments";
        for (uint32_t b = 0; b < e->block_count; b++) {
            blocks[b].parts[s].offset = e->offset + at;
            at += blocks[b].parts[s].bytes;
        }
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

stp_status stp_block_records_read(const uint8_t *records, size_t record_bytes,
                                  const stp_chunk_entry *entry, uint32_t id, stp_block *out,
                                  stp_error *err)
{
    uint32_t first = 0;
    const char *fault = NULL;
    for (uint32_t b = 0; b < entry->block_count; b++) {
        const uint8_t *record = records + (size_t)b * record_bytes;
        out[b] = (stp_block){.chunk = id, .first_patch = first};
        const int exponent = record_bytes == STP_BLOCK_BYTES ? get_record(record, entry, &out[b])
                                                             : get_wide_record(record, &out[b]);
        first += out[b].patch_count;
        fault = block_fault(&out[b], entry, exponent);
        if (fault)
            return stp_error_set(err, STP_CORRUPT, "block %" PRIu32 " of chunk %" PRIu32 ": %s", b,
                                 id, fault);
    }
    fault = sum_fault(out, entry);
    if (!fault)
        fault = place_parts(out, entry);
    return fault ? stp_error_set(err, STP_CORRUPT, "chunk %" PRIu32 ": %s", id, fault) : STP_OK;
}
