/* Codes where patches of squares are, and how many samples they have. */
#include "formats/chunk/codec/square/placed.h"

#include "base/wide.h"
#include "formats/chunk/codec/predict/predict_origin.h"
#include "formats/chunk/codec/square/square.h"
#include "formats/chunk/sample/patch.h"

/* Two each, along the axes across the height, then along it. */
#define ORIGIN_COLUMN 1u
#define HEIGHT_COLUMN (ORIGIN_COLUMN + 4u)
#define COUNT_COLUMN 9u
#define VERTEX_LEVEL (STP_LEVEL_COUNT - 1)

const uint8_t stp_placed_first[STP_LINKED_PATCH_COLUMN_COUNT] = {
    4, 3,  8,  3,  8,  12, 8,  0,  0,  3,  12, 9,  10, 8, 13, 11, 11, 11, 11, 10, 10, 10, 10,
    4, 13, 11, 11, 11, 10, 10, 10, 10, 10, 13, 11, 9,  9, 12, 9,  3,  3,  9,  12, 17, 17, 16,
};

typedef struct coder {
    const stp_square_map *map;
    const stp_table *table;
    uint32_t patch;
    bool decode;
} coder;

/* The place along axis k across the height that a vertex should have at a height, both relative to
 * the chunk's origin, in steps. */
STP_INLINE double place_at(const coder *c, int k, double height)
{
    const stp_square_grid *grid = stp_square_grid_of(c->map, c->patch);
    return grid->level[VERTEX_LEVEL].across[k][c->patch] +
           stp_square_tilt(grid, VERTEX_LEVEL, c->patch, k) * height;
}

STP_INLINE unsigned axis_across(const coder *c, int k)
{
    const unsigned along = stp_square_grid_of(c->map, c->patch)->raster->axis;
    return (along + 1 + (unsigned)k) % 3;
}

/* The vertex before, on this patch's lattice. */
STP_INLINE int32_t vertex_before(const stp_patch *before, const stp_patch *p, unsigned axis)
{
    return stp_predict_origin(before, p->exponent, (int)axis, before->bound_centre[axis]);
}

/* The height of the vertex, if it is on the plane through the one before. */
STP_INLINE double expected_height(const coder *c, const stp_patch *before, const stp_patch *p)
{
    const stp_square_grid *grid = stp_square_grid_of(c->map, c->patch);
    const unsigned along = grid->raster->axis;
    const stp_ivec3 one = stp_cone_axis_of(before), other = stp_cone_axis_of(p);
    const double height = vertex_before(before, p, along);
    double rise = 0.0, steep = one.v[along] + other.v[along];
    for (int k = 0; k < 2; k++) {
        const unsigned axis = axis_across(c, k);
        const double n = one.v[axis] + other.v[axis];
        rise += n * (place_at(c, k, height) - vertex_before(before, p, axis));
        steep += n * stp_square_tilt(grid, VERTEX_LEVEL, c->patch, k);
    }
    return height - stp_square_whole(rise / steep);
}

/* Codes a coordinate of the origin whose vertex is expected to be near a place. */
STP_INLINE void code_coordinate(const coder *c, unsigned column, unsigned axis, double place,
                                stp_patch *p)
{
    int16_t *cell = stp_table_column(c->table, column) + c->patch;
    const uint32_t predicted = (uint32_t)stp_square_whole(place) - p->bound_centre[axis] + 3u;
    p->origin[axis] = stp_code_eighths(cell, cell + c->table->stride, c->decode,
                                       (int32_t)(predicted & ~UINT32_C(7)), p->origin[axis]);
}

STP_INLINE void code_origin(const coder *c, const stp_patch *before, stp_patch *p)
{
    const unsigned along = stp_square_grid_of(c->map, c->patch)->raster->axis;
    code_coordinate(c, HEIGHT_COLUMN, along, before ? expected_height(c, before, p) : 0.0, p);
    const double height = (double)p->origin[along] + p->bound_centre[along];
    for (int k = 0; k < 2; k++)
        code_coordinate(c, ORIGIN_COLUMN + 2u * (unsigned)k, axis_across(c, k),
                        place_at(c, k, height), p);
}

void stp_placed_count(const stp_chunk *block, const stp_table *table)
{
    int16_t *cell = stp_table_column(table, COUNT_COLUMN);
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const int missing = STP_PATCH_SAMPLES - __builtin_popcountll(block->squares[p].samples);
        cell[p] = (int16_t)(cell[p] - missing);
    }
}

void stp_placed_encode(const stp_chunk *block, const stp_square_map *map, const stp_table *table)
{
    for (uint32_t i = 0; i < block->patch_count; i++) {
        const coder c = {map, table, i, false};
        stp_patch patch = block->patches[i];
        code_origin(&c, i > 0 ? &block->patches[i - 1] : NULL, &patch);
        /* The square has as many samples as the patch. */
        stp_table_column(table, COUNT_COLUMN)[i] = 0;
    }
}

void stp_placed_decode(stp_chunk *block, const stp_square_map *map, const stp_table *table)
{
    for (uint32_t i = 0; i < block->patch_count; i++) {
        const coder c = {map, table, i, true};
        code_origin(&c, i > 0 ? &block->patches[i - 1] : NULL, &block->patches[i]);
    }
}
