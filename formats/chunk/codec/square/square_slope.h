/* Slopes of heights and colours at the samples of a level of squares, by which the next finer level
 * is predicted (SPEC.md, "Squares"). Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_SLOPE_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_SQUARE_SLOPE_H

#include "formats/chunk/codec/square/square_map.h"
#include "formats/chunk/sample/sample.h"

/* The depth jumps between samples whose heights differ by more than so many sides of a cell. */
#define STP_JUMP_SIDES 8.0

/* What may tell of a sample: those whose heights differ by no more than `most`. */
typedef struct stp_slope_limit {
    const double *height;
    double own, most;
} stp_slope_limit;

STP_INLINE stp_slope_limit stp_slope_limit_at(const stp_square_map *map,
                                              const stp_square_grid *grid, int level,
                                              int32_t sample)
{
    const double(*a)[6] = grid->raster->across;
    const double *height = grid->level[level].height, own = height[sample];
    const double at = own * stp_power_of_two(map->exponent);
    double side = 0.0;
    for (int k = 0; k < 2; k++)
        for (int i = 1; i <= 2; i++) {
            const double along = fabs(a[k][i] + a[k][i + 3] * at);
            side = along > side ? along : side;
        }
    side *= STP_JUMP_SIDES * (double)(1 << level);
    return (stp_slope_limit){height, own, side * stp_power_of_two(-map->exponent)};
}

/* The sample in a cell that tells of another one; -1: none. limit: NULL: none. */
STP_INLINE int32_t stp_slope_near(const stp_square_level *on, const stp_slope_limit *limit,
                                  int column, int row)
{
    const int32_t near = stp_square_at(on, column, row);
    const bool far = limit && near >= 0 && fabs(limit->height[near] - limit->own) > limit->most;
    return far ? -1 : near;
}

/* The samples that tell a slope along an axis: one before and one after, or the sample itself; and
 * if the slope is a smooth one, those before and after these. */
typedef struct stp_slope_samples {
    int32_t before, after, before_2, after_2;
    double wide; /* from before to after, in sides of a cell */
    bool smooth;
} stp_slope_samples;

/* Of a sample of a level, along columns or rows. limit: NULL: none. */
STP_INLINE stp_slope_samples stp_slope_find(const stp_square_level *on, int level, int32_t sample,
                                            bool by_column, const stp_slope_limit *limit)
{
    const double side = (double)(1 << level), *place = by_column ? on->column : on->row;
    const int column = stp_square_cell(on->column[sample], level), x = by_column;
    const int row = stp_square_cell(on->row[sample], level), y = !by_column;
    stp_slope_samples n = {.before = stp_slope_near(on, limit, column - x, row - y),
                           .after = stp_slope_near(on, limit, column + x, row + y),
                           .before_2 = stp_slope_near(on, limit, column - 2 * x, row - 2 * y),
                           .after_2 = stp_slope_near(on, limit, column + 2 * x, row + 2 * y)};
    n.before = n.before >= 0 ? n.before : sample;
    n.after = n.after >= 0 ? n.after : sample;
    n.wide = (place[n.after] - place[n.before]) / side;
    n.smooth = n.wide == 2.0 && n.before_2 >= 0 && n.after_2 >= 0 &&
               place[n.after_2] - place[n.before_2] == 4.0 * side;
    return n;
}

/* By the side of a cell. values: of all samples. */
STP_INLINE double stp_slope_of(const stp_slope_samples *n, const double *values)
{
    if (n->before == n->after)
        return 0.0;
    const double rise = values[n->after] - values[n->before];
    return n->smooth ? (22.0 * rise - 3.0 * (values[n->after_2] - values[n->before_2])) / 32.0
                     : rise / n->wide;
}

/* How the slope by column changes by row; 0 if a corner is missing. */
STP_INLINE double stp_slope_twist(const int32_t corner[4], const double *values)
{
    if (corner[0] < 0 || corner[1] < 0 || corner[2] < 0 || corner[3] < 0)
        return 0.0;
    return ((values[corner[3]] - values[corner[2]]) - (values[corner[1]] - values[corner[0]])) /
           4.0;
}

/* What a value is expected to be around a sample of a level. */
typedef struct stp_slope_field {
    double value, by_column, by_row, across;
} stp_slope_field;

/* limit: NULL: none. */
STP_INLINE stp_slope_field stp_slope_field_at(const stp_square_level *on, int level, int32_t sample,
                                              const stp_slope_limit *limit, const double *values)
{
    const int column = stp_square_cell(on->column[sample], level);
    const int row = stp_square_cell(on->row[sample], level);
    const stp_slope_samples by_column = stp_slope_find(on, level, sample, true, limit);
    const stp_slope_samples by_row = stp_slope_find(on, level, sample, false, limit);
    int32_t corner[4];
    for (int k = 0; k < 4; k++)
        corner[k] = stp_slope_near(on, limit, column + (k & 1 ? 1 : -1), row + (k & 2 ? 1 : -1));
    return (stp_slope_field){values[sample], stp_slope_of(&by_column, values),
                             stp_slope_of(&by_row, values), stp_slope_twist(corner, values)};
}

/* At a child, off by so many sides of the sample's cell. children: of the sample. */
STP_INLINE double stp_slope_field_value(const stp_slope_field *f, double column, double row,
                                        unsigned children)
{
    const double plane = f->value + (column * f->by_column + row * f->by_row);
    return children == 4 ? plane + column * row * f->across : plane;
}

/* Several values at once: the most. */
#define STP_SQUARE_VALUES 4

/* What to expect around a parent of several values. Offsets are in sides of its cell. */
typedef struct stp_square_field {
    double value[STP_SQUARE_VALUES];
    double by_column[STP_SQUARE_VALUES], by_row[STP_SQUARE_VALUES], across[STP_SQUARE_VALUES];
    double column, row;
} stp_square_field;

/* level: the parent's. values: of all its samples. */
STP_INLINE stp_square_field stp_square_field_at(const stp_square_level *on, int level,
                                                int32_t parent, const double *const *values,
                                                int count)
{
    const int column = stp_square_cell(on->column[parent], level);
    const int row = stp_square_cell(on->row[parent], level);
    const stp_slope_samples by_column = stp_slope_find(on, level, parent, true, NULL);
    const stp_slope_samples by_row = stp_slope_find(on, level, parent, false, NULL);
    int32_t corner[4];
    stp_square_field out = {.column = on->column[parent], .row = on->row[parent]};
    for (int k = 0; k < 4; k++)
        corner[k] = stp_square_at(on, column + (k & 1 ? 1 : -1), row + (k & 2 ? 1 : -1));
    for (int v = 0; v < count; v++) {
        out.value[v] = values[v][parent];
        out.by_column[v] = stp_slope_of(&by_column, values[v]);
        out.by_row[v] = stp_slope_of(&by_row, values[v]);
        out.across[v] = stp_slope_twist(corner, values[v]);
    }
    return out;
}

/* What is expected of a child of a level; children: of its parent. */
STP_INLINE void stp_square_expect(const stp_square_field *f, const stp_square_level *on, int level,
                                  uint32_t child, unsigned children, int count, double *out)
{
    const double side = (double)(1 << (level + 1));
    const double column = (on->column[child] - f->column) / side;
    const double row = (on->row[child] - f->row) / side;
    for (int v = 0; v < count; v++) {
        out[v] = f->value[v] + (column * f->by_column[v] + row * f->by_row[v]);
        if (children == 4)
            out[v] += column * row * f->across[v];
    }
}

#endif
