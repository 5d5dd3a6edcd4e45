/* Measures the range of a grid's heights. */
#include "preprocess/grid/grid_range.h"

#include "base/memory.h"
#include "base/sort.h"

#include <math.h>
#include <stdlib.h>

/* How many samples are looked at, at most. */
#define RANGE_SAMPLES (UINT64_C(1) << 16)
/* One of so many samples may lie below the range, and one above. The range is widened by a part. */
#define OUTSIDE_PART 512
#define WIDER_PART 0.25
/* A height is odd if so many samples have it, one of so many at least, and no other lies nearer to
 * it than a part of the range of the others. */
#define ODD_LEAST 16
#define ODD_PART 1000
#define FAR_PART 0.03

static stp_status list_heights(const stp_height_grid *grid, stp_ranks *ranks, stp_bytes *out,
                               stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t all = (uint64_t)grid->raster.columns * grid->raster.rows;
    const uint64_t step = (all - 1) / RANGE_SAMPLES | 1u; /* odd: lest all lie in a few columns */
    for (uint64_t i = 0; i < all; i += step) {
        const double z = grid->z[i];
        if (!(grid->own && !grid->own[stp_height_grid_tile_at(grid, i)]) && !isnan(z))
            STP_TRY(stp_bytes_append(out, &z, sizeof z, err));
    }
    if (grid->own)
        STP_TRY(stp_ranks_join(ranks, out, err));
done:
    return status;
}

/* Of sorted heights. */
static stp_grid_range range_of(const double *z, size_t count)
{
    stp_grid_range out = {0};
    size_t begin = 1, end = count - 1; /* of what is not equal to the least or the greatest */
    while (begin < count && z[begin] == z[0])
        begin++;
    while (end > begin && z[end - 1] == z[count - 1])
        end--;
    if (begin >= end)
        return (stp_grid_range){.low = z[0], .high = z[count - 1], .share = 1.0};
    const size_t equal[2] = {begin, count - end};
    const double apart[2] = {z[begin] - z[0], z[count - 1] - z[end - 1]};
    const double range = z[end - 1] - z[begin];
    for (int i = 0; i < 2; i++) {
        out.odd[i] = z[i == 0 ? 0 : count - 1];
        if (equal[i] >= ODD_LEAST && equal[i] * ODD_PART >= count && apart[i] > FAR_PART * range)
            out.odd_share[i] = (double)equal[i] / (double)count;
    }
    begin = out.odd_share[0] > 0.0 ? begin : 0;
    end = out.odd_share[1] > 0.0 ? end : count;
    const size_t outside = (end - begin) / OUTSIDE_PART;
    out.low = z[begin + outside];
    out.high = z[end - 1 - outside];
    const double wider = WIDER_PART * (out.high - out.low);
    out.low = fmax(z[0], out.low - wider);
    out.high = fmin(z[count - 1], out.high + wider);
    out.share = (double)(end - begin - 2 * outside) / (double)count;
    return out;
}

stp_status stp_grid_range_measure(stp_grid_range *out, const stp_height_grid *grid,
                                  stp_ranks *ranks, stp_error *err)
{
    stp_status status = STP_OK;
    stp_bytes found = {0};
    *out = (stp_grid_range){0};
    STP_TRY(list_heights(grid, ranks, &found, err));
    double *z = (double *)(void *)found.data;
    const size_t count = found.size / sizeof *z;
    if (count > 0) {
        stp_sort_doubles(z, count);
        *out = range_of(z, count);
    }
done:
    free(found.data);
    return status;
}
