/* Finds normals from heights. */
#include "formats/chunk/codec/square_normal.h"

#include "formats/chunk/codec/predict_normal.h"

#include <math.h>

/* Sums of a row of a window: samples, their columns, squares of columns, heights, and columns
 * times heights. Columns count from the middle. */
enum { N, I, II, Z, IZ, SUMS };
_Static_assert(SUMS == STP_SQUARE_SUMS, "the map has room for the sums");

static double *sums_at(const stp_square_normals *n, int column, int row)
{
    const stp_square_level *on = &n->map->level[n->level];
    return n->map->sums + ((size_t)row * (size_t)on->width + (size_t)column) * SUMS;
}

static void sum_row(const stp_square_normals *n, int column, int row)
{
    const stp_square_level *on = &n->map->level[n->level];
    double *out = sums_at(n, column, row);
    for (int s = 0; s < SUMS; s++)
        out[s] = 0.0;
    for (int i = -n->reach; i <= n->reach; i++) {
        const int32_t sample = stp_square_at(on, column + i, row);
        if (sample < 0)
            continue;
        out[N] += 1.0;
        out[I] += i;
        out[II] += i * i;
        out[Z] += on->z[sample];
        out[IZ] += i * on->z[sample];
    }
}

stp_square_normals stp_square_normals_begin(const stp_chunk *block, const stp_square_map *map,
                                            int level, unsigned reach)
{
    const stp_square_level *on = &map->level[level];
    const double step = ldexp(1.0, map->exponent - level);
    const stp_square_normals out = {map, level, (int)reach, step / block->raster.dx,
                                    step / block->raster.dy};
    for (int row = 0; row < on->height && reach > 0; row++)
        for (int column = 0; column < on->width; column++)
            sum_row(&out, column, row);
    return out;
}

/* The slopes of the plane through a window, by column and by row. */
static void fit(const stp_square_normals *n, int column, int row, double out[2])
{
    const stp_square_level *on = &n->map->level[n->level];
    double w[SUMS] = {0.0}, y = 0.0, xy = 0.0, yy = 0.0, yz = 0.0;
    for (int j = -n->reach; j <= n->reach; j++) {
        if (row + j < 0 || row + j >= on->height)
            continue;
        const double *sums = sums_at(n, column, row + j);
        for (int s = 0; s < SUMS; s++)
            w[s] += sums[s];
        y += j * sums[N];
        xy += j * sums[I];
        yy += j * j * sums[N];
        yz += j * sums[Z];
    }
    const double xx = w[II] - w[I] * w[I] / w[N], xz = w[IZ] - w[I] * w[Z] / w[N];
    yy -= y * y / w[N];
    xy -= w[I] * y / w[N];
    yz -= y * w[Z] / w[N];
    const double det = xx * yy - xy * xy;
    out[0] = out[1] = 0.0;
    if (det > 0x1p-20) {
        out[0] = (xz * yy - yz * xy) / det;
        out[1] = (yz * xx - xz * xy) / det;
    } else if (xx > 0x1p-20) { /* all on one line */
        out[0] = xz / xx;
    } else if (yy > 0x1p-20) {
        out[1] = yz / yy;
    }
}

void stp_square_slopes_at(const stp_square_normals *normals, uint32_t sample, double out[2])
{
    const stp_square_level *on = &normals->map->level[normals->level];
    fit(normals, stp_square_cell(on->column[sample], normals->level),
        stp_square_cell(on->row[sample], normals->level), out);
}

void stp_square_normal_of(const stp_square_normals *normals, const double slopes[2], double out[2])
{
    const double x = -slopes[0] * normals->by_column, y = -slopes[1] * normals->by_row;
    const double all = fabs(x) + fabs(y) + 1.0;
    out[0] = (x / all + 1.0) * (0.5 * STP_NORMAL_CODE_MAX);
    out[1] = (y / all + 1.0) * (0.5 * STP_NORMAL_CODE_MAX);
}
