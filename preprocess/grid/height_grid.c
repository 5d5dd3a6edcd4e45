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
/* Of a normal distribution: median of the absolute value, by the standard deviation. */
#define MEDIAN_SHARE 0.6745
/* Standard deviation of z0 - 4 z1 + 6 z2 - 4 z3 + z4, by that of one z. */
#define FOURTH_SHARE 8.3666

stp_status stp_height_grid_create(stp_height_grid *out, const stp_scan_raster *raster,
                                  const stp_dvec3 *nodes, bool coloured, stp_spill *spill,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    const size_t count = (size_t)raster->columns * raster->rows;
    stp_height_grid grid = {.raster = *raster,
                            .nodes = nodes,
                            .tile_columns = (raster->columns - 1) / STP_TILE_SIDE + 1,
                            .tile_rows = (raster->rows - 1) / STP_TILE_SIDE + 1,
                            .box = stp_dbox_empty(),
                            .reach = 1,
                            .spill = spill};
    STP_TRY(stp_spill_alloc(spill, &grid.z, count, sizeof *grid.z, "heights", err));
    if (nodes)
        STP_TRY(stp_spill_alloc(spill, &grid.xy, count, sizeof *grid.xy, "places", err));
    if (coloured)
        STP_TRY(stp_spill_alloc(spill, &grid.rgb, count, sizeof *grid.rgb, "colours", err));
    STP_TRY(stp_alloc(&grid.tile_samples, stp_height_grid_tile_count(&grid),
                      sizeof *grid.tile_samples, "tiles", err));
    *out = grid;
    grid = (stp_height_grid){0};
done:
    stp_height_grid_clear(&grid);
    return status;
}

static uint32_t *tile_samples_at(stp_height_grid *grid, uint64_t place)
{
    const uint32_t row = (uint32_t)(place / grid->raster.columns);
    const uint32_t column = (uint32_t)(place % grid->raster.columns);
    return &grid->tile_samples[row / STP_TILE_SIDE * grid->tile_columns + column / STP_TILE_SIDE];
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
    ++*tile_samples_at(grid, place);
    grid->count++;
}

void stp_height_grid_leave_out(stp_height_grid *grid, uint64_t place)
{
    grid->z[place] = NAN;
}

void stp_height_grid_unset(stp_height_grid *grid, uint64_t place)
{
    grid->z[place] = NAN;
    --*tile_samples_at(grid, place);
    grid->count--;
}

/* The standard deviation of noise: a fourth difference along a row is noise, since the surface's
 * own is small. The median leaves out cliffs. 0 without enough samples. */
static double measure_noise(const stp_height_grid *grid)
{
    const uint32_t columns = grid->raster.columns, rows = grid->raster.rows;
    const uint64_t all = (uint64_t)columns * rows;
    const uint32_t step = all / NOISE_SAMPLES > 1 ? (uint32_t)(all / NOISE_SAMPLES) : 1;
    double *found = NULL;
    size_t count = 0;
    if (columns < 5 ||
        stp_alloc(&found, (size_t)(all / step) + 1, sizeof *found, "heights", NULL) != STP_OK)
        return 0.0;
    for (uint64_t i = 0; i < all; i += step) {
        const double *z = grid->z + i;
        if (i % columns > columns - 5)
            continue;
        const double d = z[0] - 4.0 * z[1] + 6.0 * z[2] - 4.0 * z[3] + z[4];
        if (!isnan(d))
            found[count++] = fabs(d);
    }
    stp_sort_doubles(found, count);
    const double median = count > 0 ? found[count / 2] : 0.0;
    free(found);
    return median / (MEDIAN_SHARE * FOURTH_SHARE);
}

/* The standard error of a slope over a window, for noise of deviation 1 and samples 1 apart. */
static double slope_error(unsigned reach)
{
    double sum = 0.0;
    for (unsigned i = 1; i <= reach; i++)
        sum += 2.0 * i * i * (2.0 * reach + 1.0);
    return 1.0 / sqrt(sum);
}

void stp_height_grid_finish(stp_height_grid *grid, double step)
{
    const double rounding = step / sqrt(12.0);
    grid->noise = fmax(measure_noise(grid), rounding);
    const double noise = grid->noise / stp_raster_cell(&grid->raster, grid->nodes);
    grid->reach = 1;
    while (grid->reach < STP_GRID_REACH && noise * slope_error(grid->reach) > NOISE_ANGLE)
        grid->reach++;
    grid->normal_error = atan(noise * slope_error(grid->reach));
}

void stp_height_grid_clear(stp_height_grid *grid)
{
    stp_spill_free(grid->spill, grid->z);
    stp_spill_free(grid->spill, grid->xy);
    stp_spill_free(grid->spill, grid->rgb);
    free(grid->tile_samples);
    *grid = (stp_height_grid){0};
}
