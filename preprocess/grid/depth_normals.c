/* Lets normals of pixels follow from merged ones. */
#include "preprocess/grid/depth_normals.h"

#include "base/memory.h"
#include "formats/chunk/codec/predict_normal.h"
#include "formats/chunk/codec/square/square_normal.h"
#include "formats/chunk/codec/square/square_slope.h"
#include "formats/chunk/normal_grid.h"
#include "preprocess/patch/patch_build.h"

#include <math.h>
#include <stdlib.h>

/* Squares of a rectangle in which a block's squares of one piece lie, for each of them. */
#define SPARSEST 4u
/* The level that normals of pixels follow from. */
#define LEVEL 1
/* A pixel whose normal is farther off, 10 degrees, has an edge: it keeps its own. As a cosine. */
#define ALIKE 0.985

/* The merged samples of a block's squares of one piece, as a codec sees them. */
typedef struct merged {
    stp_square_level on;
    double *value[3];               /* of unit normals */
    uint32_t least[2], greatest[2]; /* columns and rows of squares */
    uint32_t count, limit;
} merged;

static bool has_piece(const stp_depth_block *b, uint32_t i, uint32_t rays)
{
    return b->squares[b->order[i]].rays == rays;
}

/* Finds the rectangle. False if it is too large, or holds but one square. */
static bool find_extent(const stp_depth_block *b, uint32_t rays, merged *m)
{
    uint32_t squares = 0;
    m->least[0] = m->least[1] = UINT32_MAX;
    m->greatest[0] = m->greatest[1] = 0;
    for (uint32_t i = b->begin; i < b->end; i++) {
        const stp_depth_square *square = &b->squares[b->order[i]];
        const uint32_t at[2] = {square->column, square->row};
        if (square->rays != rays)
            continue;
        squares++;
        for (int k = 0; k < 2; k++) {
            m->least[k] = at[k] < m->least[k] ? at[k] : m->least[k];
            m->greatest[k] = at[k] > m->greatest[k] ? at[k] : m->greatest[k];
        }
    }
    m->limit = squares * STP_SQUARE_SAMPLES;
    const uint64_t all =
        ((uint64_t)m->greatest[0] - m->least[0] + 1) * ((uint64_t)m->greatest[1] - m->least[1] + 1);
    return all <= (uint64_t)SPARSEST * squares;
}

static stp_status allocate(merged *m, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t side = STP_SQUARE_SIDE >> LEVEL;
    stp_square_level *on = &m->on;
    on->cell_columns = (int)((m->greatest[0] - m->least[0] + 1) * side);
    on->cell_rows = (int)((m->greatest[1] - m->least[1] + 1) * side);
    const size_t cells = (size_t)on->cell_columns * (size_t)on->cell_rows;
    STP_TRY(stp_alloc(&on->column, m->limit, sizeof *on->column, "normals", err));
    STP_TRY(stp_alloc(&on->row, m->limit, sizeof *on->row, "normals", err));
    STP_TRY(stp_alloc(&on->cells, cells, sizeof *on->cells, "normals", err));
    for (int k = 0; k < 3; k++)
        STP_TRY(stp_alloc(&m->value[k], m->limit, sizeof *m->value[k], "normals", err));
    for (size_t i = 0; i < cells; i++)
        on->cells[i] = -1;
done:
    return status;
}

static void clear(merged *m)
{
    free(m->on.column);
    free(m->on.row);
    free(m->on.cells);
    for (int k = 0; k < 3; k++)
        free(m->value[k]);
}

/* Where a pixel of a square is, from the rectangle's corner on. */
typedef struct pixel {
    double column, row;
} pixel;

static unsigned find_pixels(const merged *m, const stp_depth_square *square,
                            pixel out[STP_SQUARE_SAMPLES])
{
    unsigned count = 0;
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++)
        if (square->samples >> k & 1u)
            out[count++] =
                (pixel){(square->column - m->least[0]) * STP_SQUARE_SIDE + stp_square_column(k),
                        (square->row - m->least[1]) * STP_SQUARE_SIDE + stp_square_row(k)};
    return count;
}

/* Room for a square's merged normals. */
static stp_dvec3 *merged_of(const stp_depth_block *b, uint32_t index)
{
    return b->merged + (size_t)index * (STP_SQUARE_SAMPLES / 4);
}

/* Merges the normals of a square's items, which begin at `first`. */
static void merge_square(const stp_depth_block *b, uint32_t index, uint32_t first, merged *m)
{
    pixel pixels[STP_SQUARE_SAMPLES];
    const unsigned finer = find_pixels(m, &b->squares[b->order[index]], pixels);
    const unsigned count = stp_level_count_above(finer);
    for (unsigned j = 0; j < count; j++) {
        const unsigned begin = stp_level_children_begin(j, count, finer);
        const unsigned end = stp_level_children_begin(j + 1, count, finer);
        stp_dvec3 sum = {0.0, 0.0, 0.0};
        double column = 0.0, row = 0.0;
        uint8_t code[3];
        int32_t uv[2];
        for (unsigned i = begin; i < end; i++) {
            const vec3s normal = stp_cloud_normal(b->cloud, b->points[first + i]);
            sum = stp_dvec3_add(sum, stp_dvec3_from_float(normal));
            column += pixels[i].column;
            row += pixels[i].row;
        }
        stp_normal_encode_on(stp_dvec3_to_float(stp_dvec3_normalize(sum)), b->merged_bits, code);
        stp_normal_code_side(code, b->merged_bits);
        stp_normal_codes_get(code, uv);
        const stp_ivec3 unit = stp_unit_normal(stp_integer_normal(uv[0], uv[1]));
        const uint32_t sample = m->count++;
        for (int k = 0; k < 3; k++)
            m->value[k][sample] = unit.v[k];
        m->on.column[sample] = column / (end - begin);
        m->on.row[sample] = row / (end - begin);
        m->on.cells[(size_t)stp_square_cell(m->on.row[sample], LEVEL) * (size_t)m->on.cell_columns +
                    (size_t)stp_square_cell(m->on.column[sample], LEVEL)] = (int32_t)sample;
        merged_of(b, index)[j] = stp_dvec3_from_float(stp_normal_decode(code));
    }
}

/* The code that a codec expects of a direction, on the grid of the block's pixels. */
static void encode_expected(const double toward[3], unsigned bits, uint8_t code[3])
{
    const unsigned shift = STP_NORMAL_BITS - bits;
    const int32_t top = stp_normal_grid_place(STP_NORMAL_CODE_MAX, shift);
    double direction[2];
    int32_t place[2];
    stp_square_direction(toward, direction);
    for (int i = 0; i < 2; i++)
        place[i] = stp_square_whole(direction[i] / (double)(1 << shift));
    stp_square_fold(place, top);
    for (int i = 0; i < 2; i++)
        place[i] = place[i] < 0 ? 0 : place[i] > top ? top : place[i];
    stp_normal_side(place, top);
    for (int i = 0; i < 2; i++)
        place[i] = stp_normal_grid_code(place[i], shift);
    stp_normal_codes_put(place, code);
}

static bool is_alike(const stp_depth_block *b, uint32_t item, const double toward[3])
{
    const stp_dvec3 own = stp_dvec3_from_float(stp_cloud_normal(b->cloud, b->points[item]));
    const stp_dvec3 other = {toward[0], toward[1], toward[2]};
    return stp_dvec3_dot(own, stp_dvec3_normalize(other)) >= ALIKE;
}

/* Sets the normals of a square's items. sample: the first merged one of the square. */
static void derive_square(const stp_depth_block *b, uint32_t index, uint32_t first, const merged *m,
                          uint32_t sample)
{
    pixel pixels[STP_SQUARE_SAMPLES];
    const unsigned finer = find_pixels(m, &b->squares[b->order[index]], pixels);
    const unsigned count = stp_level_count_above(finer);
    const double side = (double)(1 << LEVEL);
    for (unsigned j = 0; j < count; j++, sample++) {
        const unsigned begin = stp_level_children_begin(j, count, finer);
        const unsigned end = stp_level_children_begin(j + 1, count, finer);
        stp_slope_field field[3];
        for (int k = 0; k < 3; k++)
            field[k] = stp_slope_field_at(&m->on, LEVEL, (int32_t)sample, m->value[k]);
        for (unsigned i = begin; i < end; i++) {
            const double c = (pixels[i].column - m->on.column[sample]) / side;
            const double r = (pixels[i].row - m->on.row[sample]) / side;
            double toward[3];
            for (int k = 0; k < 3; k++)
                toward[k] = stp_slope_field_value(&field[k], c, r, end - begin);
            stp_item *item = &b->items[first + i];
            if (!is_alike(b, first + i, toward))
                continue;
            encode_expected(toward, b->bits, item->normal);
            item->disc.normal = stp_dvec3_from_float(stp_normal_decode(item->normal));
        }
    }
}

static uint32_t first_item(const stp_depth_block *b, uint32_t index)
{
    return index > 0 ? b->ends[index - 1] : 0;
}

static stp_status derive_piece(const stp_depth_block *b, uint32_t rays, stp_error *err)
{
    stp_status status = STP_OK;
    merged m = {0};
    uint32_t sample = 0;
    if (!find_extent(b, rays, &m))
        return STP_OK;
    STP_TRY(allocate(&m, err));
    for (uint32_t i = b->begin; i < b->end; i++)
        if (has_piece(b, i, rays))
            merge_square(b, i, first_item(b, i), &m);
    for (uint32_t i = b->begin; i < b->end; i++) {
        if (!has_piece(b, i, rays))
            continue;
        derive_square(b, i, first_item(b, i), &m, sample);
        const unsigned count =
            stp_level_count_above((unsigned)__builtin_popcountll(b->squares[b->order[i]].samples));
        sample += count;
        b->grids[i].merged = merged_of(b, i);
        b->grids[i].merged_count = count;
    }
done:
    clear(&m);
    return status;
}

stp_status stp_depth_normals_derive(const stp_depth_block *b, stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t i = b->begin; i < b->end; i++) {
        const uint32_t rays = b->squares[b->order[i]].rays;
        bool done = false;
        for (uint32_t j = b->begin; j < i && !done; j++)
            done = has_piece(b, j, rays);
        if (!done)
            STP_TRY(derive_piece(b, rays, err));
    }
done:
    return status;
}
