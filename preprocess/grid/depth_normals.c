/* Lets normals of pixels follow from merged ones. */
#include "preprocess/grid/depth_normals.h"

#include "base/memory.h"
#include "formats/chunk/codec/predict/predict_normal.h"
#include "formats/chunk/codec/square/square_normal.h"
#include "formats/chunk/codec/square/square_slope.h"
#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/patch/patch_build.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The rectangle around the squares that a block has of one piece may hold SPARSEST squares for each
 * of them, and SPARSE_FREE more: a codec allows as many (square_map.c). */
#define SPARSEST 4u
#define SPARSE_FREE 256u
/* Normals of level 2 are means; those of levels 1 and 0 follow. */
#define COARSEST 2
/* A normal that is farther off has an edge, and stays as it is. By level: the cosines of 10 and 5
 * degrees. */
static const double alike_least[COARSEST] = {0.9848, 0.9962};

/* The samples of a level of a block's squares of one piece, as a codec sees them. */
typedef struct merged {
    stp_square_level on;
    double *value[3]; /* of unit normals */
    uint32_t count;
} merged;

typedef struct piece {
    const stp_depth_block *block;
    uint32_t rays;
    uint32_t least[2], greatest[2]; /* columns and rows of squares */
    uint32_t square_count;
    merged level[COARSEST + 1]; /* that of level 0 is empty */
} piece;

/* The samples of a square: their places, and the sums of their pixels' normals. */
typedef struct square_samples {
    unsigned counts[COARSEST + 1];
    double column[COARSEST + 1][STP_SQUARE_SAMPLES], row[COARSEST + 1][STP_SQUARE_SAMPLES];
    stp_dvec3 sum[COARSEST + 1][STP_SQUARE_SAMPLES];
} square_samples;

/* ---- making room ---- */

/* Finds the rectangle. False if it is too large. */
static bool find_extent(piece *p)
{
    const stp_depth_block *b = p->block;
    p->least[0] = p->least[1] = UINT32_MAX;
    for (uint32_t i = b->begin; i < b->end; i++) {
        const stp_depth_square *square = &b->squares[b->order[i]];
        const uint32_t at[2] = {square->column, square->row};
        if (square->rays != p->rays)
            continue;
        p->square_count++;
        for (int k = 0; k < 2; k++) {
            p->least[k] = at[k] < p->least[k] ? at[k] : p->least[k];
            p->greatest[k] = at[k] > p->greatest[k] ? at[k] : p->greatest[k];
        }
    }
    const uint64_t all =
        ((uint64_t)p->greatest[0] - p->least[0] + 1) * ((uint64_t)p->greatest[1] - p->least[1] + 1);
    return all <= (uint64_t)SPARSEST * p->square_count + SPARSE_FREE;
}

static stp_status allocate(piece *p, int level, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t side = STP_SQUARE_SIDE >> level;
    const size_t most = (size_t)p->square_count * STP_SQUARE_SAMPLES >> level;
    merged *m = &p->level[level];
    m->on.cell_columns = (int)((p->greatest[0] - p->least[0] + 1) * side);
    m->on.cell_rows = (int)((p->greatest[1] - p->least[1] + 1) * side);
    const size_t cells = (size_t)m->on.cell_columns * (size_t)m->on.cell_rows;
    STP_TRY(stp_alloc(&m->on.column, most, sizeof *m->on.column, "normals", err));
    STP_TRY(stp_alloc(&m->on.row, most, sizeof *m->on.row, "normals", err));
    STP_TRY(stp_alloc(&m->on.cells, cells, sizeof *m->on.cells, "normals", err));
    for (int k = 0; k < 3; k++)
        STP_TRY(stp_alloc(&m->value[k], most, sizeof *m->value[k], "normals", err));
    for (size_t i = 0; i < cells; i++)
        m->on.cells[i] = -1;
done:
    return status;
}

static void clear(piece *p)
{
    for (int level = 1; level <= COARSEST; level++) {
        merged *m = &p->level[level];
        free(m->on.column);
        free(m->on.row);
        free(m->on.cells);
        for (int k = 0; k < 3; k++)
            free(m->value[k]);
    }
}

/* ---- one square ---- */

static uint32_t first_item(const stp_depth_block *b, uint32_t index)
{
    return index > 0 ? b->ends[index - 1] : 0;
}

static const stp_depth_square *square_of(const stp_depth_block *b, uint32_t index)
{
    return &b->squares[b->order[index]];
}

/* Room for a square's merged normals of a level. */
static stp_dvec3 *room_of(const stp_depth_block *b, uint32_t index, int level)
{
    return b->merged + (size_t)index * STP_DEPTH_MERGED + (level > 1 ? STP_SQUARE_SAMPLES / 4 : 0);
}

static void find_samples(const piece *p, uint32_t index, square_samples *out)
{
    const stp_depth_block *b = p->block;
    const stp_depth_square *square = square_of(b, index);
    const uint32_t first = first_item(b, index);
    unsigned count = 0;
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++) {
        if (!(square->samples >> k & 1u))
            continue;
        out->column[0][count] =
            (square->column - p->least[0]) * STP_SQUARE_SIDE + stp_square_column(k);
        out->row[0][count] = (square->row - p->least[1]) * STP_SQUARE_SIDE + stp_square_row(k);
        out->sum[0][count] =
            stp_dvec3_from_float(stp_cloud_normal(b->cloud, b->points[first + count]));
        count++;
    }
    out->counts[0] = count;
    for (int l = 1; l <= COARSEST; l++) {
        out->counts[l] = stp_level_count_above(out->counts[l - 1]);
        for (unsigned j = 0; j < out->counts[l]; j++) {
            const unsigned begin = stp_level_children_begin(j, out->counts[l], out->counts[l - 1]);
            const unsigned end =
                stp_level_children_begin(j + 1, out->counts[l], out->counts[l - 1]);
            stp_dvec3 sum = {0.0, 0.0, 0.0};
            double column = 0.0, row = 0.0;
            for (unsigned i = begin; i < end; i++) {
                sum = stp_dvec3_add(sum, out->sum[l - 1][i]);
                column += out->column[l - 1][i];
                row += out->row[l - 1][i];
            }
            out->sum[l][j] = sum;
            out->column[l][j] = column / (end - begin);
            out->row[l][j] = row / (end - begin);
        }
    }
}

/* Adds a sample of a square, whose normal has a code, to a level. */
static void add_sample(int level, const square_samples *s, unsigned j, const uint8_t code[3],
                       merged *m)
{
    int32_t uv[2];
    stp_normal_codes_get(code, uv);
    const stp_ivec3 unit = stp_unit_normal(stp_integer_normal(uv[0], uv[1]));
    const uint32_t sample = m->count++;
    for (int k = 0; k < 3; k++)
        m->value[k][sample] = unit.v[k];
    m->on.column[sample] = s->column[level][j];
    m->on.row[sample] = s->row[level][j];
    const size_t row = (size_t)stp_square_cell(m->on.row[sample], level);
    m->on.cells[row * (size_t)m->on.cell_columns +
                (size_t)stp_square_cell(m->on.column[sample], level)] = (int32_t)sample;
}

/* The code that a codec expects of a direction, on a grid. own: the normal's own code, or NULL. If
 * it is given, the code is the one nearest to it that is whole strides off what is expected. */
static void encode_expected(const double toward[3], unsigned bits, int level, const uint8_t *own,
                            uint8_t code[3])
{
    const unsigned shift = STP_NORMAL_BITS - bits, stride = stp_square_stride(level, shift);
    const int32_t top = stp_normal_grid_place(STP_NORMAL_CODE_MAX, shift);
    double direction[2];
    int32_t place[2], to[2];
    stp_square_direction(toward, direction);
    for (int i = 0; i < 2; i++)
        place[i] = stp_square_whole(direction[i] / (double)(1 << shift));
    if (own) {
        stp_normal_codes_get(own, to);
        for (int i = 0; i < 2; i++)
            to[i] = stp_normal_grid_place(to[i], shift);
        (void)stp_square_unfold(to, place, top, true, 0);
        for (int i = 0; i < 2; i++)
            place[i] += ((to[i] - place[i] + (1 << stride >> 1)) >> stride) * (1 << stride);
    }
    stp_square_fold(place, top);
    for (int i = 0; i < 2; i++)
        place[i] = place[i] < 0 ? 0 : place[i] > top ? top : place[i];
    stp_normal_side(place, top);
    for (int i = 0; i < 2; i++)
        place[i] = stp_normal_grid_code(place[i], shift);
    stp_normal_codes_put(place, code);
}

static void encode_own(stp_dvec3 sum, unsigned bits, uint8_t code[3])
{
    stp_normal_encode_on(stp_dvec3_to_float(stp_dvec3_normalize(sum)), bits, code);
    stp_normal_code_side(code, bits);
}

/* ---- levels ---- */

/* Keeps the code of a sample's normal where the chunk is made from. */
static void keep(const piece *p, uint32_t index, int level, const square_samples *s, unsigned j,
                 const uint8_t code[3])
{
    const stp_depth_block *b = p->block;
    const stp_dvec3 normal = stp_dvec3_from_float(stp_normal_decode(code));
    if (level > 0) {
        room_of(b, index, level)[j] = normal;
        b->grids[index].merged[level - 1] = room_of(b, index, level);
        // cppcheck-suppress arrayIndexOutOfBoundsCond ; levels end with COARSEST
        b->grids[index].merged_counts[level - 1] = s->counts[level];
        return;
    }
    stp_item *item = &b->items[first_item(b, index) + j];
    memcpy(item->normal, code, sizeof item->normal);
    item->disc.normal = normal;
}

/* Means of the coarsest level. */
static void merge(piece *p, uint32_t index, const square_samples *s)
{
    for (unsigned j = 0; j < s->counts[COARSEST]; j++) {
        uint8_t code[3];
        encode_own(s->sum[COARSEST][j], p->block->merged_bits, code);
        add_sample(COARSEST, s, j, code, &p->level[COARSEST]);
        keep(p, index, COARSEST, s, j, code);
    }
}

/* The children of sample j of the next coarser level, which is `parent` there. */
static void derive_family(piece *p, uint32_t index, const square_samples *s, int level, unsigned j,
                          uint32_t parent)
{
    const merged *above = &p->level[level + 1];
    const unsigned above_count = s->counts[level + 1], count = s->counts[level];
    const unsigned begin = stp_level_children_begin(j, above_count, count);
    const unsigned end = stp_level_children_begin(j + 1, above_count, count);
    const unsigned bits = level > 0 ? p->block->merged_bits : p->block->bits;
    const double side = (double)(1 << (level + 1)), alike = alike_least[level];
    stp_slope_field field[3];
    for (int k = 0; k < 3; k++)
        field[k] =
            stp_slope_field_at(&above->on, level + 1, (int32_t)parent, NULL, above->value[k]);
    for (unsigned i = begin; i < end; i++) {
        const double c = (s->column[level][i] - above->on.column[parent]) / side;
        const double r = (s->row[level][i] - above->on.row[parent]) / side;
        double toward[3];
        uint8_t code[3], own[3];
        for (int k = 0; k < 3; k++)
            toward[k] = stp_slope_field_value(&field[k], c, r, end - begin);
        const stp_dvec3 way = stp_dvec3_normalize((stp_dvec3){toward[0], toward[1], toward[2]});
        encode_own(s->sum[level][i], bits, own);
        const bool near = stp_dvec3_dot(stp_dvec3_normalize(s->sum[level][i]), way) >= alike;
        encode_expected(toward, bits, level, near ? NULL : own, code);
        if (level > 0)
            // cppcheck-suppress arrayIndexOutOfBoundsCond ; likewise
            add_sample(level, s, i, code, &p->level[level]);
        keep(p, index, level, s, i, code);
    }
}

static void derive_level(piece *p, int level, square_samples *s)
{
    const stp_depth_block *b = p->block;
    uint32_t parent = 0;
    for (uint32_t i = b->begin; i < b->end; i++) {
        if (square_of(b, i)->rays != p->rays)
            continue;
        find_samples(p, i, s);
        if (level == COARSEST)
            merge(p, i, s);
        for (unsigned j = 0; level < COARSEST && j < s->counts[level + 1]; j++)
            derive_family(p, i, s, level, j, parent++);
    }
}

static stp_status derive_piece(const stp_depth_block *b, uint32_t rays, square_samples *s,
                               stp_error *err)
{
    stp_status status = STP_OK;
    piece p = {.block = b, .rays = rays};
    if (!find_extent(&p))
        return STP_OK;
    for (int level = 1; level <= COARSEST; level++)
        STP_TRY(allocate(&p, level, err));
    for (int level = COARSEST; level >= 0; level--)
        derive_level(&p, level, s);
done:
    clear(&p);
    return status;
}

stp_status stp_depth_normals_derive(const stp_depth_block *b, stp_error *err)
{
    stp_status status = STP_OK;
    square_samples *s = NULL;
    STP_TRY(stp_alloc(&s, 1, sizeof *s, "normals", err));
    for (uint32_t i = b->begin; i < b->end; i++) {
        const uint32_t rays = square_of(b, i)->rays;
        bool done = false;
        for (uint32_t j = b->begin; j < i && !done; j++)
            done = square_of(b, j)->rays == rays;
        if (!done)
            STP_TRY(derive_piece(b, rays, s, err));
    }
done:
    free(s);
    return status;
}
