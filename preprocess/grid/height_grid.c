/* Holds a grid of heights and measures its noise. */
#include "preprocess/grid/height_grid.h"

#include "base/memory.h"
#include "base/sort.h"

#include <math.h>
#include <stdlib.h>

/* The most that noise may turn normals, radians, if a wider window helps. */
#define NOISE_ANGLE 0.035
/* About how many fourth differences tell the noise. */
#define NOISE_SAMPLES 65536u
/* Samples of a fourth difference. Heights around a tile reach as far. */
#define NOISE_RUN 5u
_Static_assert(NOISE_RUN - 1 <= STP_GRID_REACH, "a rank has the samples of its differences");
/* Of a normal distribution: median of the absolute value, by the standard deviation. */
#define MEDIAN_SHARE 0.6745
/* Standard deviation of z0 - 4 z1 + 6 z2 - 4 z3 + z4, by that of one z. */
#define FOURTH_SHARE 8.3666

stp_status stp_height_grid_create(stp_height_grid *out, const stp_scan_raster *raster,
                                  const stp_dvec3 *nodes, bool coloured, bool sparse,
                                  stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    stp_status (*const alloc)(stp_spill *, void *, size_t, size_t, const char *, stp_error *) =
        sparse ? stp_spill_alloc_sparse : stp_spill_alloc;
    const size_t count = (size_t)raster->columns * raster->rows;
    stp_height_grid grid = {.raster = *raster,
                            .nodes = nodes,
                            .tile_columns = (raster->columns - 1) / STP_TILE_SIDE + 1,
                            .tile_rows = (raster->rows - 1) / STP_TILE_SIDE + 1,
                            .box = stp_dbox_empty(),
                            .reach = 1,
                            .spill = spill};
    STP_TRY(alloc(spill, &grid.z, count, sizeof *grid.z, "heights", err));
    if (nodes)
        STP_TRY(alloc(spill, &grid.xy, count, sizeof *grid.xy, "places", err));
    if (coloured)
        STP_TRY(alloc(spill, &grid.rgb, count, sizeof *grid.rgb, "colours", err));
    STP_TRY(stp_alloc(&grid.tile_samples, stp_height_grid_tile_count(&grid),
                      sizeof *grid.tile_samples, "tiles", err));
    *out = grid;
    grid = (stp_height_grid){0};
done:
    stp_height_grid_clear(&grid);
    return status;
}

void stp_height_grid_set(stp_height_grid *grid, uint64_t place, const stp_point *point)
{
    grid->z[place] = point->position.z;
    if (grid->xy) {
        grid->xy[place][0] = point->position.x;
        grid->xy[place][1] = point->position.y;
    }
    for (int c = 0; grid->rgb && c < 3; c++)
        grid->rgb[place][c] = point->rgb[c];
    stp_dbox_add(&grid->box, point->position);
    grid->tile_samples[stp_height_grid_tile_at(grid, place)]++;
    grid->count++;
}

size_t stp_height_grid_take(stp_height_grid *grid, uint64_t place, const stp_point *points,
                            size_t count)
{
    const uint32_t columns = grid->raster.columns;
    size_t i = 0, end = 0;
    while (i == end && end < count) {
        const uint32_t column = (uint32_t)((place + i) % columns);
        const uint32_t to_tile = STP_TILE_SIDE - column % STP_TILE_SIDE;
        const size_t left = columns - column < to_tile ? columns - column : to_tile, begin = i;
        stp_dbox box = stp_dbox_empty();
        end = begin + (left < count - begin ? left : count - begin);
        for (; i < end && points[i].reject == STP_REJECT_NONE &&
               !stp_scan_is_nowhere(points[i].position);
             i++) {
            grid->z[place + i] = points[i].position.z;
            for (int c = 0; grid->rgb && c < 3; c++)
                grid->rgb[place + i][c] = points[i].rgb[c];
            stp_dbox_add(&box, points[i].position);
        }
        stp_dbox_join(&grid->box, &box);
        grid->tile_samples[stp_height_grid_tile_at(grid, place + begin)] += (uint32_t)(i - begin);
        grid->count += (uint32_t)(i - begin);
    }
    return i;
}

void stp_height_grid_leave_out(stp_height_grid *grid, uint64_t place)
{
    grid->z[place] = NAN;
}

void stp_height_grid_unset(stp_height_grid *grid, uint64_t place)
{
    grid->z[place] = NAN;
    grid->tile_samples[stp_height_grid_tile_at(grid, place)]--;
    grid->count--;
}

/* The standard deviation of noise: a fourth difference along a row is noise, since the surface's
 * own is small. The median leaves out cliffs. 0 without enough samples. */
static stp_status measure_noise(const stp_height_grid *grid, stp_ranks *ranks, double *out,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t columns = grid->raster.columns, rows = grid->raster.rows;
    const uint64_t all = (uint64_t)columns * rows;
    const uint64_t step = all / NOISE_SAMPLES > 1 ? all / NOISE_SAMPLES : 1;
    stp_bytes found = {0};
    *out = 0.0;
    if (columns < NOISE_RUN)
        return STP_OK;
    for (uint64_t i = 0; i < all; i += step) {
        const double *z = grid->z + i;
        if (i % columns > columns - NOISE_RUN ||
            (grid->own && !grid->own[stp_height_grid_tile_at(grid, i)]))
            continue;
        const double d = fabs(z[0] - 4.0 * z[1] + 6.0 * z[2] - 4.0 * z[3] + z[4]);
        if (!isnan(d))
            STP_TRY(stp_bytes_append(&found, &d, sizeof d, err));
    }
    if (grid->own)
        STP_TRY(stp_ranks_join(ranks, &found, err));
    const size_t count = found.size / sizeof(double);
    double *differences = (double *)(void *)found.data;
    if (count > 0) {
        stp_sort_doubles(differences, count);
        *out = differences[count / 2] / (MEDIAN_SHARE * FOURTH_SHARE);
    }
done:
    free(found.data);
    return status;
}

/* The standard error of a slope over a window, for noise of deviation 1 and samples 1 apart. */
static double slope_error(unsigned reach)
{
    double sum = 0.0;
    for (unsigned i = 1; i <= reach; i++)
        sum += 2.0 * i * i * (2.0 * reach + 1.0);
    return 1.0 / sqrt(sum);
}

stp_status stp_height_grid_finish(stp_height_grid *grid, double step, stp_ranks *ranks,
                                  stp_error *err)
{
    const double rounding = step / sqrt(12.0);
    double measured = 0.0;
    const stp_status status = measure_noise(grid, ranks, &measured, err);
    if (status != STP_OK)
        return status;
    grid->noise = fmax(measured, rounding);
    const double noise = grid->noise / stp_raster_cell(&grid->raster, grid->nodes);
    grid->reach = 1;
    while (grid->reach < STP_GRID_REACH && noise * slope_error(grid->reach) > NOISE_ANGLE)
        grid->reach++;
    grid->normal_error = atan(noise * slope_error(grid->reach));
    return STP_OK;
}

/* The tiles of other ranks have no heights here: their bits are added. */
static stp_status join_holes(stp_holes *holes, stp_ranks *ranks, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *bits = NULL;
    const size_t count = (size_t)holes->columns[0] * holes->rows[0];
    STP_TRY(stp_alloc(&bits, count, sizeof *bits, "holes", err));
    for (size_t i = 0; i < count; i++)
        bits[i] = holes->words[0][i].bits;
    STP_TRY(stp_ranks_sum(ranks, bits, count, err));
    for (size_t i = 0; i < count; i++)
        holes->words[0][i].bits = bits[i];
done:
    free(bits);
    return status;
}

/* Whether this rank tells that a sample is missing. Tiles without samples are nobody's own: the
 * first rank tells of them. */
static bool is_known_missing(const stp_height_grid *grid, uint64_t place, bool first)
{
    const uint32_t tile = stp_height_grid_tile_at(grid, place);
    if (grid->own && !grid->own[tile])
        return first && grid->tile_samples[tile] == 0;
    return isnan(grid->z[place]);
}

/* stp_holes_place. */
static stp_dvec3 place_of(const void *context, int64_t column, int64_t row)
{
    const stp_height_grid *grid = context;
    const stp_scan_raster *r = &grid->raster;
    const uint32_t c = (uint32_t)fmax(0.0, fmin((double)column, r->columns - 1.0));
    const uint32_t d = (uint32_t)fmax(0.0, fmin((double)row, r->rows - 1.0));
    const stp_raster_frame frame = stp_raster_frame_at(r, grid->nodes, c, d);
    return stp_raster_frame_place(&frame, (double)column, (double)row);
}

stp_status stp_height_grid_keep_open(stp_height_grid *grid, stp_ranks *ranks, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t columns = grid->raster.columns;
    const stp_holes_grid of = {.columns = columns,
                               .rows = grid->raster.rows,
                               .cell = stp_raster_cell(&grid->raster, grid->nodes),
                               .place = place_of,
                               .context = grid};
    STP_TRY(stp_alloc(&grid->holes, 1, sizeof *grid->holes, "holes", err));
    STP_TRY(stp_holes_create(grid->holes, &of, err));
    for (uint64_t i = 0; i < (uint64_t)columns * grid->raster.rows; i++)
        if (is_known_missing(grid, i, stp_ranks_is_first(ranks)))
            stp_holes_add(grid->holes, (uint32_t)(i % columns), (uint32_t)(i / columns));
    if (grid->own)
        STP_TRY(join_holes(grid->holes, ranks, err));
    stp_holes_finish(grid->holes);
done:
    return status;
}

void stp_height_grid_clear(stp_height_grid *grid)
{
    if (grid->holes)
        stp_holes_clear(grid->holes);
    free(grid->holes);
    stp_spill_free(grid->spill, grid->z);
    stp_spill_free(grid->spill, grid->xy);
    stp_spill_free(grid->spill, grid->rgb);
    free(grid->tile_samples);
    free(grid->own);
    *grid = (stp_height_grid){0};
}
