/* Codes blocks of squares without an entropy coder. */
#include "formats/chunk/codec/paper.h"

#include "base/memory.h"
#include "formats/chunk/codec/part.h"
#include "formats/chunk/codec/predict/predict_normal.h"
#include "formats/chunk/codec/raw.h"
#include "formats/chunk/codec/square/block_squares.h"
#include "formats/chunk/codec/square/square_normal.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/normal_grid.h"

#include <stdlib.h>
#include <string.h>

/* The first byte of segment 0. */
enum { KIND_RAW, KIND_LEVEL, KIND_TILTED };

/* What a level has of its samples, in the order of the file. The first WIDE_COUNT take two bytes a
 * sample, the others one. */
enum {
    HEIGHT,
    AZIMUTH,
    INCLINATION,
    WIDE_COUNT,
    RADIUS = WIDE_COUNT,
    FLAGS,
    CLASS,
    RED,
    GREEN,
    BLUE,
    INTENSITY,
    FIELD_COUNT
};
#define MASK_BYTES 2u
/* Behind the fields: how many samples are moved, that is, do not lie where the raster has them. Of
 * each its number, and how far it lies off along both axes across its height. */
#define MOVED_COUNT_BYTES 4u
#define MOVED_BYTES 6u

static const uint8_t share_of[FIELD_COUNT] = {
    [HEIGHT] = STP_SHARE_POSITIONS,    [AZIMUTH] = STP_SHARE_NORMALS,
    [INCLINATION] = STP_SHARE_NORMALS, [RADIUS] = STP_SHARE_RADII,
    [FLAGS] = STP_SHARE_CLASSES,       [CLASS] = STP_SHARE_CLASSES,
    [RED] = STP_SHARE_COLOURS,         [GREEN] = STP_SHARE_COLOURS,
    [BLUE] = STP_SHARE_COLOURS,        [INTENSITY] = STP_SHARE_INTENSITIES,
};

/* Columns of the table of squares (square.h) that are bytes; others are numbers of 16 bits. */
static bool is_mask_column(unsigned column)
{
    return column >= 2 && column < 10;
}

static size_t width_of(unsigned field)
{
    return field < WIDE_COUNT ? 2 : 1;
}

/* ---- normals ---- */

/* Angles are amid their steps, so none is that of an axis, and signs of x and y are never in doubt.
 * A step is less than a third of that of codes, so rounding errors of sin and cos change no code
 * that a writer means. */
#define TURN_STEP (2.0 * M_PI / 65536.0)
#define FALL_STEP (M_PI / 65536.0)

void stp_paper_normal(const uint16_t angles[2], uint8_t out[3])
{
    const double turn = (angles[0] + 0.5) * TURN_STEP, fall = (angles[1] + 0.5) * FALL_STEP;
    const double n[3] = {sin(fall) * cos(turn), sin(fall) * sin(turn), cos(fall)};
    double at[2];
    stp_square_direction(n, at);
    stp_normal_codes_put((const int32_t[2]){stp_square_whole(at[0]), stp_square_whole(at[1])}, out);
}

/* Two codes may have one direction, on the sides of the octahedron's square, and four have that of
 * its corners. One of the steps around has the wanted one. */
void stp_paper_angles(const uint8_t normal[3], uint16_t out[2])
{
    int32_t uv[2];
    stp_normal_codes_get(normal, uv);
    const stp_ivec3 n = stp_integer_normal(uv[0], uv[1]);
    const bool corner = n.v[0] == 0 && n.v[1] == 0;
    const double x = corner ? 2 * uv[0] - STP_NORMAL_CODE_MAX : n.v[0];
    const double y = corner ? 2 * uv[1] - STP_NORMAL_CODE_MAX : n.v[1];
    const int turn = (int)floor(atan2(y, x) / TURN_STEP);
    const int fall = (int)floor(atan2(corner ? 0.0 : hypot(x, y), n.v[2]) / FALL_STEP);
    static const int8_t around[9][2] = {{0, 0},   {-1, 0}, {1, 0},  {0, -1}, {0, 1},
                                        {-1, -1}, {1, -1}, {-1, 1}, {1, 1}};
    for (int i = 0; i < 9; i++) {
        const int at = fall + around[i][1];
        uint8_t back[3];
        out[0] = (uint16_t)(turn + around[i][0]);
        out[1] = (uint16_t)(at < 0 ? 0 : at > 65535 ? 65535 : at);
        stp_paper_normal(out, back);
        if (memcmp(back, normal, sizeof back) == 0)
            return;
    }
}

/* ---- levels ---- */

/* Sets the positions across the height of a sample to where the raster has them. */
static void place_across(const stp_square_map *map, const stp_chunk *block, uint32_t p, int level,
                         uint32_t i, uint16_t position[3])
{
    const stp_square_grid *grid = stp_square_grid_of(map, p);
    const unsigned axis = grid->raster->axis;
    for (unsigned k = 0; k < 2; k++)
        position[(axis + 1 + k) % 3] =
            (uint16_t)stp_square_across(grid, level, i, (int)k, &block->patches[p], position[axis]);
}

/* A level's fields, one behind the other. */
typedef struct fields {
    uint16_t *values;
    size_t count; /* of samples */
} fields;

static uint16_t *field_of(const fields *f, unsigned field)
{
    return f->values + field * f->count;
}

static void get_sample(const stp_square_map *map, const stp_chunk *block, uint32_t p, int level,
                       uint32_t i, const fields *out)
{
    const stp_square_grid *grid = stp_square_grid_of(map, p);
    const stp_sample *s = &block->samples[level][i];
    const unsigned axis = grid->raster->axis;
    const uint8_t bytes[FIELD_COUNT - WIDE_COUNT] = {s->radius, s->flags,  s->class_id, s->rgb[0],
                                                     s->rgb[1], s->rgb[2], s->intensity};
    uint16_t angles[2];
    stp_paper_angles(s->normal, angles);
    field_of(out, HEIGHT)[i] = s->position[axis];
    field_of(out, AZIMUTH)[i] = angles[0];
    field_of(out, INCLINATION)[i] = angles[1];
    for (unsigned f = WIDE_COUNT; f < FIELD_COUNT; f++)
        field_of(out, f)[i] = bytes[f - WIDE_COUNT];
}

static void put_sample(const stp_square_map *map, const fields *from, uint32_t p, int level,
                       uint32_t i, stp_chunk *block)
{
    const stp_square_grid *grid = stp_square_grid_of(map, p);
    stp_sample *s = &block->samples[level][i];
    const unsigned axis = grid->raster->axis;
    uint8_t *const bytes[FIELD_COUNT - WIDE_COUNT] = {
        &s->radius, &s->flags, &s->class_id, &s->rgb[0], &s->rgb[1], &s->rgb[2], &s->intensity};
    s->position[axis] = field_of(from, HEIGHT)[i];
    place_across(map, block, p, level, i, s->position);
    stp_paper_normal(
        (const uint16_t[2]){field_of(from, AZIMUTH)[i], field_of(from, INCLINATION)[i]}, s->normal);
    for (unsigned f = WIDE_COUNT; f < FIELD_COUNT; f++)
        *bytes[f - WIDE_COUNT] = (uint8_t)field_of(from, f)[i];
}

/* Appends the samples that are moved. */
static stp_status moved_encode(const stp_square_map *map, const stp_chunk *block, int level,
                               stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t bytes[MOVED_BYTES] = {0};
    const size_t begin = out->size;
    uint32_t count = 0;
    STP_TRY(stp_bytes_append(out, bytes, MOVED_COUNT_BYTES, err));
    for (uint32_t p = 0; p < block->patch_count; p++)
        for (uint32_t i = block->level_begin[level][p]; i < block->level_begin[level][p + 1]; i++) {
            const unsigned axis = stp_square_grid_of(map, p)->raster->axis;
            const uint16_t *own = block->samples[level][i].position;
            uint16_t at[3] = {own[0], own[1], own[2]};
            place_across(map, block, p, level, i, at);
            if (memcmp(at, own, sizeof at) == 0)
                continue;
            stp_put_u16(bytes, (uint16_t)i);
            for (unsigned k = 1; k < 3; k++)
                stp_put_u16(bytes + 2 * k, (uint16_t)(own[(axis + k) % 3] - at[(axis + k) % 3]));
            STP_TRY(stp_bytes_append(out, bytes, MOVED_BYTES, err));
            count++;
        }
    stp_put_u32(out->data + begin, count);
done:
    return status;
}

/* Moves the samples that are moved. Errors: CORRUPT. */
static stp_status moved_decode(stp_cursor *c, const stp_square_map *map, stp_chunk *block,
                               int level, stp_error *err)
{
    const size_t count = c->left < MOVED_COUNT_BYTES ? SIZE_MAX : stp_get_u32(c->bytes);
    if (count > (c->left - MOVED_COUNT_BYTES) / MOVED_BYTES)
        return stp_error_set(err, STP_CORRUPT, "it ends within the moved samples of a level");
    stp_cursor_skip(c, MOVED_COUNT_BYTES);
    uint32_t p = 0, next = 0;
    for (size_t m = 0; m < count; m++, stp_cursor_skip(c, MOVED_BYTES)) {
        const uint32_t i = stp_get_u16(c->bytes);
        if (i < next || i >= block->level_begin[level][block->patch_count])
            return stp_error_set(err, STP_CORRUPT, "moved samples of a level are out of order");
        while (i >= block->level_begin[level][p + 1])
            p++;
        const unsigned axis = stp_square_grid_of(map, p)->raster->axis;
        uint16_t *position = block->samples[level][i].position;
        for (unsigned k = 1; k < 3; k++)
            position[(axis + k) % 3] =
                (uint16_t)(position[(axis + k) % 3] + stp_get_u16(c->bytes + 2 * k));
        next = i + 1;
    }
    return STP_OK;
}

static stp_status fields_create(const stp_chunk *block, int level, fields *out, stp_error *err)
{
    out->count = block->level_begin[level][block->patch_count];
    return stp_alloc(&out->values, FIELD_COUNT * out->count, sizeof *out->values, "a level", err);
}

static stp_status level_encode(const stp_chunk *block, int level, const stp_square_map *map,
                               stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    fields all = {0};
    unsigned varies = 0;
    uint8_t number[2];
    STP_TRY(fields_create(block, level, &all, err));
    for (uint32_t p = 0; p < block->patch_count; p++)
        for (uint32_t i = block->level_begin[level][p]; i < block->level_begin[level][p + 1]; i++)
            get_sample(map, block, p, level, i, &all);
    for (unsigned f = 0; f < FIELD_COUNT; f++)
        for (size_t i = 1; i < all.count; i++)
            varies |= (unsigned)(field_of(&all, f)[i] != field_of(&all, f)[0]) << f;
    stp_put_u16(number, (uint16_t)varies);
    STP_TRY(stp_bytes_append(out, number, MASK_BYTES, err));
    for (unsigned f = 0; f < FIELD_COUNT; f++)
        for (size_t i = 0; i < (varies >> f & 1u ? all.count : 1); i++) {
            stp_put_u16(number, field_of(&all, f)[i]);
            STP_TRY(stp_bytes_append(out, number, width_of(f), err));
        }
    STP_TRY(moved_encode(map, block, level, out, err));
done:
    free(all.values);
    return status;
}

/* Reads a level's fields. Errors: CORRUPT. */
static stp_status fields_read(stp_cursor *c, fields *out, stp_shares *shares, stp_error *err)
{
    const unsigned varies = c->left < MASK_BYTES ? UINT16_MAX : stp_get_u16(c->bytes);
    if (varies >> FIELD_COUNT)
        return stp_error_set(err, STP_CORRUPT, "a level of squares begins wrong");
    stp_cursor_skip(c, MASK_BYTES);
    if (shares)
        shares->bytes[STP_SHARE_FRAME] += MASK_BYTES;
    for (unsigned f = 0; f < FIELD_COUNT; f++) {
        const bool each = varies >> f & 1u;
        const size_t width = width_of(f), bytes = width * (each ? out->count : 1);
        if (bytes > c->left)
            return stp_error_set(err, STP_CORRUPT, "it ends within a level of squares");
        for (size_t i = 0; i < out->count; i++) {
            const uint8_t *at = c->bytes + (each ? width * i : 0);
            field_of(out, f)[i] = width == 2 ? stp_get_u16(at) : *at;
        }
        stp_cursor_skip(c, bytes);
        if (shares)
            shares->bytes[share_of[f]] += bytes;
    }
    return STP_OK;
}

static stp_status level_decode(stp_cursor *c, int level, const stp_square_map *map,
                               stp_chunk *block, stp_shares *shares, stp_error *err)
{
    stp_status status = STP_OK;
    fields all = {0};
    STP_TRY(fields_create(block, level, &all, err));
    STP_TRY(fields_read(c, &all, shares, err));
    for (uint32_t p = 0; p < block->patch_count; p++)
        for (uint32_t i = block->level_begin[level][p]; i < block->level_begin[level][p + 1]; i++)
            put_sample(map, &all, p, level, i, block);
    const size_t left = c->left;
    STP_TRY(moved_decode(c, map, block, level, err));
    if (shares)
        shares->bytes[STP_SHARE_POSITIONS] += left - c->left;
done:
    free(all.values);
    return status;
}

/* ---- squares ---- */

static stp_status squares_encode(const stp_chunk *block, const stp_square *squares, stp_bytes *out,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    stp_table table = {0};
    uint8_t number[2];
    STP_TRY(stp_squares_encode(block, squares, out, &table, err));
    for (unsigned column = 0; column < table.column_count; column++)
        for (uint32_t p = 0; p < block->patch_count; p++) {
            stp_put_u16(number, (uint16_t)stp_table_column(&table, column)[p]);
            STP_TRY(stp_bytes_append(out, number, is_mask_column(column) ? 1 : 2, err));
        }
done:
    free(table.values);
    return status;
}

static stp_status squares_decode(stp_cursor *c, bool tilted, stp_square *first, stp_chunk *block,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    stp_table table = {0};
    STP_TRY(stp_alloc(&block->squares, block->patch_count, sizeof *block->squares, "squares", err));
    STP_TRY(stp_squares_table(block->patch_count, tilted, &table, err));
    for (unsigned column = 0; column < table.column_count; column++) {
        const size_t width = is_mask_column(column) ? 1 : 2;
        if (c->left / width < block->patch_count) {
            status = stp_error_set(err, STP_CORRUPT, "it ends within its squares");
            goto done;
        }
        for (uint32_t p = 0; p < block->patch_count; p++, stp_cursor_skip(c, width))
            stp_table_column(&table, column)[p] =
                width == 1 ? *c->bytes : (int16_t)stp_get_u16(c->bytes);
    }
    STP_TRY(stp_squares_decode(&table, block, first, block->squares, err));
    STP_TRY(stp_squares_check(block, err));
done:
    free(table.values);
    return status;
}

/* Reads what segment 0 has before its levels. */
static stp_status head_decode(stp_cursor *c, bool tilted, uint32_t child_count, stp_chunk *block,
                              stp_shares *shares, stp_error *err)
{
    stp_status status = STP_OK;
    stp_square *first = NULL;
    STP_TRY(stp_raw_patches_decode(c, child_count, block, shares, err));
    const size_t left = c->left;
    STP_TRY(stp_rasters_decode(c, tilted, block, &first, err));
    STP_TRY(squares_decode(c, tilted, first, block, err));
    if (shares)
        shares->bytes[STP_SHARE_PATCHES] += left - c->left;
done:
    free(first);
    return status;
}

/* ---- parts ---- */

stp_status stp_paper_encode(const stp_chunk *block, int segment, stp_bytes *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_block_squares squares = {0};
    STP_TRY(stp_block_squares_find(block, segment, &squares, err));
    const uint8_t kind = !squares.found                              ? KIND_RAW
                         : stp_squares_are_tilted(block, squares.of) ? KIND_TILTED
                                                                     : KIND_LEVEL;
    if (segment == 0)
        STP_TRY(stp_bytes_append(out, &kind, sizeof kind, err));
    if (kind == KIND_RAW) {
        status = stp_raw_encode(block, segment, out, err);
        goto done;
    }
    if (segment == 0) {
        STP_TRY(stp_raw_patches_encode(block, out, err));
        STP_TRY(squares_encode(block, squares.of, out, err));
    }
    for (int l = stp_segment_coarsest(segment); l >= stp_segment_finest(segment); l--)
        STP_TRY(level_encode(block, l, &squares.map, out, err));
done:
    stp_block_squares_clear(&squares);
    return status;
}

/* Reads the kind of a block. */
static stp_status kind_read(stp_cursor *c, uint8_t *out, stp_shares *shares, stp_error *err)
{
    if (c->left == 0 || *c->bytes > KIND_TILTED)
        return stp_error_set(err, STP_CORRUPT, "a block begins with byte %u",
                             c->left > 0 ? *c->bytes : 0u);
    *out = *c->bytes;
    stp_cursor_skip(c, 1);
    if (shares)
        shares->bytes[STP_SHARE_FRAME]++;
    return STP_OK;
}

stp_status stp_paper_decode(const uint8_t *bytes, size_t size, int segment, uint32_t child_count,
                            stp_chunk *block, stp_shares *shares, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cursor c = {bytes, size};
    stp_square_map map = {0};
    uint8_t kind = stp_chunk_is_squares(block) ? KIND_LEVEL : KIND_RAW;
    if (segment == 0)
        STP_TRY(kind_read(&c, &kind, shares, err));
    if (kind == KIND_RAW)
        return stp_raw_decode(c.bytes, c.left, segment, child_count, block, shares, err);
    if (segment == 0)
        STP_TRY(head_decode(&c, kind == KIND_TILTED, child_count, block, shares, err));
    STP_TRY(stp_square_map_create(block, block->squares, false, &map, err));
    for (int l = stp_segment_coarsest(segment); l >= stp_segment_finest(segment); l--)
        STP_TRY(level_decode(&c, l, &map, block, shares, err));
    block->reach = 1; /* what maps have, for a writer of codec 4 */
    if (c.left > 0)
        status = stp_error_set(err, STP_CORRUPT, "%zu bytes are left over at its end", c.left);
done:
    stp_square_map_clear(&map);
    return status;
}
