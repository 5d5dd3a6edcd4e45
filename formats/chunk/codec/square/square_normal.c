/* Finds normals from heights. */
#include "formats/chunk/codec/square/square_normal.h"

#include "base/wide.h"
#include "formats/chunk/codec/predict/predict_normal.h"
#include "formats/chunk/codec/square/plane_fit.h"
#include "formats/chunk/sample/normal_grid.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Sums of a row of a window: samples, their columns, squares of columns, heights, and columns
 * times heights; then of a window: samples, columns times heights, rows times heights. Columns and
 * rows count from the middle. In place of the last two a whole window of a level grid has the code
 * of its normal. Each kind by cell. */
enum { N, I, II, Z, IZ, ROW_SUMS, ALL = ROW_SUMS, XZ, YZ, SUMS, U = XZ, V = YZ };
_Static_assert(SUMS == STP_SQUARE_SUMS, "the map has room for the sums");

/* Cells of a row that are summed up at a time. */
#define RUN 64
#define REACH_MOST ((int)STP_SQUARE_REACH_MOST)

static double *sums_of(const stp_square_grid *grid, int level, int kind)
{
    const stp_square_level *on = &grid->level[level];
    return grid->sums + (size_t)kind * (size_t)on->cell_columns * (size_t)on->cell_rows;
}

/* Samples of a row and their heights, 0 where there is none, `reach` more on either side. */
typedef struct run {
    double there[RUN + 2 * STP_SQUARE_REACH_MOST], height[RUN + 2 * STP_SQUARE_REACH_MOST];
} run;

/* Heights are whole numbers: sums are exact, whatever their order. known: those of samples are. */
STP_WIDE
static void sum_run(const run *r, int reach, int count, bool known, double *restrict out[ROW_SUMS])
{
    for (int i = 0; i <= 2 * reach; i++) {
        const double *there = r->there + i, *height = r->height + i, by = i - reach;
        for (int c = 0; c < count && !known; c++) {
            out[N][c] += there[c];
            out[I][c] += by * there[c];
            out[II][c] += by * by * there[c];
        }
        for (int c = 0; c < count; c++) {
            out[Z][c] += height[c];
            out[IZ][c] += by * height[c];
        }
    }
}

/* full: no cell is empty, so all rows have the same sums of samples. */
static void sum_row(const stp_square_normals *n, const stp_square_grid *grid, int row, bool full)
{
    const stp_square_level *on = &grid->level[n->level];
    const size_t begin = (size_t)row * (size_t)on->cell_columns;
    const bool known = full && row > 0;
    for (int column = 0; column < on->cell_columns; column += RUN) {
        const int left = on->cell_columns - column, count = left < RUN ? left : RUN;
        double *out[ROW_SUMS];
        run r;
        for (int i = 0; i < count + 2 * n->reach; i++) {
            const int32_t sample = stp_square_at(on, column + i - n->reach, row);
            r.there[i] = sample >= 0 ? 1.0 : 0.0;
            r.height[i] = sample >= 0 ? on->height[sample] : 0.0;
        }
        for (int s = 0; s < ROW_SUMS; s++) {
            const size_t bytes = (size_t)count * sizeof *out[s];
            out[s] = sums_of(grid, n->level, s) + begin + column;
            if (known && s < Z)
                memcpy(out[s], out[s] - begin, bytes);
            else
                memset(out[s], 0, bytes);
        }
        sum_run(&r, n->reach, count, known, out);
    }
}

/* Adds up the rows of the windows around the samples of a row. */
STP_WIDE
static void sum_windows(const stp_square_normals *n, const stp_square_grid *grid, int row)
{
    const stp_square_level *on = &grid->level[n->level];
    const int columns = on->cell_columns;
    const size_t begin = (size_t)row * (size_t)columns;
    double *restrict all = sums_of(grid, n->level, ALL) + begin;
    double *restrict xz = sums_of(grid, n->level, XZ) + begin;
    double *restrict yz = sums_of(grid, n->level, YZ) + begin;
    for (double *restrict *out = (double *restrict[]){all, xz, yz, NULL}; *out; out++)
        memset(*out, 0, (size_t)columns * sizeof **out);
    for (int j = -n->reach; j <= n->reach; j++) {
        if (row + j < 0 || row + j >= on->cell_rows)
            continue;
        const size_t at = (size_t)(row + j) * (size_t)columns;
        const double *count = sums_of(grid, n->level, N) + at;
        const double *z = sums_of(grid, n->level, Z) + at, *iz = sums_of(grid, n->level, IZ) + at;
        for (int c = 0; c < columns; c++) {
            all[c] += count[c];
            xz[c] += iz[c];
            yz[c] += j * z[c];
        }
    }
}

/* What slopes add to the normal of a level grid, upwards, along both axes. */
STP_INLINE void level_factors(const stp_raster *r, double length, double out[2])
{
    out[0] = length / r->across[0][1];
    out[1] = length / r->across[1][2];
}

/* The slopes that sums of a whole window tell; xx: of its squares of columns, or of rows. */
STP_INLINE double whole_slope(double sum, double xx)
{
    return sum * xx / (xx * xx);
}

/* Samples of a whole window; *xx: the sum of the squares of their columns, or of their rows. */
STP_INLINE double whole_window(const stp_square_normals *n, double *xx)
{
    const int side = 2 * n->reach + 1, squares = n->reach * (n->reach + 1) * side / 3;
    *xx = side * squares;
    return side * side;
}

/* The code of a coordinate of a normal that points upwards. all: their magnitudes, summed up. */
STP_INLINE double code_of(double coordinate, double all)
{
    return (coordinate / all + 1.0) * (0.5 * STP_NORMAL_CODE_MAX);
}

/* Puts the codes of normals in place of the sums of whole windows around the samples of a row. */
STP_WIDE
static void find_codes(const stp_square_normals *n, const stp_square_grid *grid, int row)
{
    const int columns = grid->level[n->level].cell_columns;
    const size_t begin = (size_t)row * (size_t)columns;
    const double *restrict count = sums_of(grid, n->level, ALL) + begin;
    double *restrict u = sums_of(grid, n->level, U) + begin;
    double *restrict v = sums_of(grid, n->level, V) + begin;
    double by[2], xx;
    const double whole = whole_window(n, &xx);
    level_factors(grid->raster, n->length, by);
    for (int c = 0; c < columns; c++) {
        const double x = -whole_slope(u[c], xx) * by[0], y = -whole_slope(v[c], xx) * by[1];
        const double all = fabs(x) + fabs(y) + 1.0, own[2] = {u[c], v[c]};
        u[c] = count[c] == whole ? code_of(x, all) : own[0];
        v[c] = count[c] == whole ? code_of(y, all) : own[1];
    }
}

stp_square_normals stp_square_normals_begin(const stp_square_map *map, int level, unsigned reach)
{
    const stp_square_normals out = {level, (int)reach, ldexp(1.0, map->exponent - level)};
    for (uint32_t g = 0; g < map->grid_count && reach > 0; g++) {
        const stp_square_grid *grid = &map->grids[g];
        for (int row = 0; row < grid->level[level].cell_rows; row++)
            sum_row(&out, grid, row, map->full[level]);
        for (int row = 0; row < grid->level[level].cell_rows; row++) {
            sum_windows(&out, grid, row);
            if (grid->raster->level)
                find_codes(&out, grid, row);
        }
    }
    return out;
}

/* The cell of a sample in the sums of a grid. */
STP_INLINE size_t cell_of(const stp_square_level *on, int level, uint32_t sample)
{
    return (size_t)stp_square_cell(on->row[sample], level) * (size_t)on->cell_columns +
           (size_t)stp_square_cell(on->column[sample], level);
}

bool stp_square_code_at(const stp_square_normals *n, const stp_square_grid *grid, uint32_t sample,
                        double out[2])
{
    const size_t cell = cell_of(&grid->level[n->level], n->level, sample);
    double xx;
    if (n->reach == 0 || !grid->raster->level ||
        sums_of(grid, n->level, ALL)[cell] != whole_window(n, &xx))
        return false;
    out[0] = sums_of(grid, n->level, U)[cell];
    out[1] = sums_of(grid, n->level, V)[cell];
    return true;
}

void stp_square_slopes_at(const stp_square_normals *n, const stp_square_grid *grid, uint32_t sample,
                          double out[2])
{
    const stp_square_level *on = &grid->level[n->level];
    const int row = stp_square_cell(on->row[sample], n->level);
    const size_t kind = (size_t)on->cell_columns * (size_t)on->cell_rows;
    const double *own = grid->sums + cell_of(on, n->level, sample);
    double xx;
    stp_plane_sums w = {.n = own[ALL * kind], .xz = own[XZ * kind], .yz = own[YZ * kind]};
    if (w.n == whole_window(n, &xx)) { /* none is missing: the other sums are known */
        out[0] = whole_slope(w.xz, xx);
        out[1] = whole_slope(w.yz, xx);
        return;
    }
    for (int j = -n->reach; j <= n->reach; j++) {
        if (row + j < 0 || row + j >= on->cell_rows)
            continue;
        const double *sums = own + j * on->cell_columns;
        w.x += sums[I * kind];
        w.y += j * sums[N * kind];
        w.z += sums[Z * kind];
        w.xx += sums[II * kind];
        w.xy += j * sums[I * kind];
        w.yy += j * j * sums[N * kind];
    }
    (void)stp_plane_slopes(&w, out);
}

/* The normal of a level grid, upwards. */
static void find_level(const stp_raster *r, double length, const double slopes[2], double out[3])
{
    double by[2];
    level_factors(r, length, by);
    out[0] = -slopes[0] * by[0];
    out[1] = -slopes[1] * by[1];
    out[2] = 1.0;
}

/* The product of the tangents by column and by row. */
static void find_tilted(const stp_raster *r, double length, const stp_square_place *at,
                        const double slopes[2], double out[3])
{
    double rise[2], along[2][2]; /* of a tangent: along the height's axis, and the other two */
    for (int i = 0; i < 2; i++) {
        rise[i] = slopes[i] * length;
        for (int k = 0; k < 2; k++)
            along[i][k] =
                (r->across[k][1 + i] + r->across[k][4 + i] * at->height) + at->tilt[k] * rise[i];
    }
    const unsigned axis = r->axis;
    out[axis] = along[0][0] * along[1][1] - along[0][1] * along[1][0];
    out[(axis + 1) % 3] = along[0][1] * rise[1] - rise[0] * along[1][1];
    out[(axis + 2) % 3] = rise[0] * along[1][0] - along[0][0] * rise[1];
}

stp_square_place stp_square_place_of(const stp_square_normals *normals, const stp_square_grid *grid,
                                     uint32_t sample)
{
    const int level = normals->level;
    return (stp_square_place){
        {stp_square_tilt(grid, level, sample, 0), stp_square_tilt(grid, level, sample, 1)},
        grid->level[level].height[sample] * ldexp(normals->length, level)};
}

void stp_square_normal_of(const stp_square_normals *normals, const stp_raster *raster,
                          const stp_square_place *at, const double slopes[2], double out[2])
{
    double n[3];
    if (raster->level)
        find_level(raster, normals->length, slopes, n);
    else
        find_tilted(raster, normals->length, at, slopes, n);
    stp_square_direction(n, out);
}

void stp_square_direction(const double n[3], double out[2])
{
    const double all = fabs(n[0]) + fabs(n[1]) + fabs(n[2]), x = n[0] / all, y = n[1] / all;
    const bool below = n[2] < 0.0;
    out[0] = ((below ? copysign(1.0 - fabs(y), x) : x) + 1.0) * (0.5 * STP_NORMAL_CODE_MAX);
    out[1] = ((below ? copysign(1.0 - fabs(x), y) : y) + 1.0) * (0.5 * STP_NORMAL_CODE_MAX);
}

void stp_square_fold(int32_t place[2], int32_t top)
{
    for (int i = 0; i < 2; i++) {
        const int32_t p = place[i];
        if (p >= 0 && p <= top)
            continue;
        place[i] = p < 0 ? -p : 2 * top - p;
        place[1 - i] = top - place[1 - i];
    }
}

/* The place that folds to `own` and is nearest to what is expected, of those whole strides off. */
typedef struct unfolding {
    const int32_t *own, *expected;
    int32_t top;
    int32_t between; /* a stride less 1: these bits are 0 in what a place is off */
    int32_t least;   /* what the nearest place so far is off, both coordinates together */
    bool mirrored;   /* it is on a side, and stands for its mirror, too */
    int32_t place[2];
} unfolding;

/* Tries a place, and those beyond the sides and corners of the grid that may fold to it. */
static void unfold(unfolding *f, int32_t u, int32_t v)
{
    const int32_t top = f->top, beyond = 2 * top;
    const int32_t places[9][2] = {{u, v},
                                  {-u, top - v},
                                  {beyond - u, top - v},
                                  {top - u, -v},
                                  {top - u, beyond - v},
                                  {u - top, v - top},
                                  {u - top, v + top},
                                  {u + top, v - top},
                                  {u + top, v + top}};
    for (int i = 0; i < 9; i++) {
        int32_t back[2] = {places[i][0], places[i][1]};
        const int32_t by[2] = {back[0] - f->expected[0], back[1] - f->expected[1]};
        const int32_t off = abs(by[0]) + abs(by[1]);
        stp_square_fold(back, top);
        if (f->mirrored)
            stp_normal_side(back, top);
        if (off >= f->least || (by[0] | by[1]) & f->between || back[0] != f->own[0] ||
            back[1] != f->own[1])
            continue;
        f->least = off;
        memcpy(f->place, places[i], sizeof f->place);
    }
}

/* Whether no place beyond a side or corner, of those that fold to `own`, is nearer to what is
 * expected than `own`, which is so much off. */
STP_INLINE bool is_nearest(const int32_t own[2], const int32_t expected[2], int32_t top,
                           int32_t off)
{
    bool nearest = off <= top;
    for (int i = 0; i < 2; i++) {
        const int32_t sum = own[i] + expected[i];
        nearest &= sum >= off && 2 * top - sum >= off;
    }
    return nearest;
}

bool stp_square_unfold(int32_t own[2], const int32_t expected[2], int32_t top, bool sides,
                       unsigned stride)
{
    const bool mirrored = sides && (own[0] == 0 || own[0] == top || own[1] == 0 || own[1] == top);
    const int32_t between = (1 << stride) - 1;
    const int32_t by[2] = {own[0] - expected[0], own[1] - expected[1]};
    if (!mirrored && ((by[0] | by[1]) & between) == 0 &&
        is_nearest(own, expected, top, abs(by[0]) + abs(by[1])))
        return true;
    unfolding f = {.own = own,
                   .expected = expected,
                   .top = top,
                   .between = between,
                   .least = INT32_MAX,
                   .mirrored = mirrored,
                   .place = {own[0], own[1]}};
    for (int mirror = 0; mirror < (mirrored ? 4 : 1); mirror++)
        unfold(&f, mirror & 1 ? top - own[0] : own[0], mirror & 2 ? top - own[1] : own[1]);
    memcpy(own, f.place, sizeof f.place);
    return f.least < INT32_MAX;
}
