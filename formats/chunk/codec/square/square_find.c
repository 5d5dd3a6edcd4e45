/* Finds the squares of a block: which samples of which raster its patches are. */
#include "formats/chunk/codec/square/square.h"

#include "base/wide.h"
#include "formats/chunk/codec/inline.h"
#include "formats/chunk/layout.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#define DELTA_MOST 32767
/* A block of more patches is not coded as tilted: steps from square to square of a raster, and from
 * raster to raster, are then sure to be no greater. */
#define TILTED_PATCHES_MOST 8000u
/* A sample lies this near to its place in a tilted grid, in columns and rows: else one of several
 * grids would do as well as another. */
#define TILTED_OFF_MOST 0.125
/* The same of one that spreads: a scanner's angles are rough, and the nearest raster is asked for.
 */
#define SPREAD_OFF_MOST 0.375
/* Squares of fewer samples may lie on several tilted grids by chance: they belong to the one that
 * they are nearest to. */
#define SURE_SAMPLES 8u
/* But to that of the square before, if they are this near to it: rounding takes as much. */
#define ROUNDED_OFF 0.03

/* How many columns and rows samples are looked for in. */
STP_INLINE double raster_side(const stp_raster *raster)
{
    return raster->side ? raster->side : (double)STP_SQUARE_PLACES_LIMIT * STP_SQUARE_SIDE;
}

/* The column and row of a tilted raster that are nearest to a position. *off: how far it is off at
 * most, if it was less. */
STP_INLINE bool find_place(const stp_raster *raster, const double position[3], uint32_t out[2],
                           double *off)
{
    const double(*a)[6] = raster->across;
    const double off_most = stp_raster_spreads(raster) ? SPREAD_OFF_MOST : TILTED_OFF_MOST;
    const double most = raster_side(raster);
    const double height = position[raster->axis];
    double rest[2], by[2][2], place[2]; /* by column and row, at this height */
    for (unsigned k = 0; k < 2; k++) {
        rest[k] = position[(raster->axis + 1 + k) % 3] - a[k][0] - a[k][3] * height;
        for (unsigned i = 0; i < 2; i++)
            by[k][i] = a[k][1 + i] + a[k][4 + i] * height;
    }
    const double det = by[0][0] * by[1][1] - by[0][1] * by[1][0];
    place[0] = (rest[0] * by[1][1] - rest[1] * by[0][1]) / det;
    place[1] = (rest[1] * by[0][0] - rest[0] * by[1][0]) / det;
    for (unsigned k = 0; k < 2; k++) {
        const double nearest = floor(place[k] + 0.5);
        if (!(nearest >= raster->first[k] && nearest < raster->first[k] + most) ||
            fabs(place[k] - nearest) > off_most)
            return false;
        out[k] = (uint32_t)nearest;
        *off = stp_max(*off, fabs(place[k] - nearest));
    }
    return true;
}

/* The same of all samples of a patch on a level raster, where heights do not matter. */
STP_INLINE bool find_level_places(const stp_raster *raster, const stp_patch *patch,
                                  const stp_sample *samples, uint32_t out[2][STP_PATCH_SAMPLES],
                                  double *off)
{
    const double(*a)[6] = raster->across;
    const double step = stp_power_of_two(patch->exponent);
    const double det = a[0][1] * a[1][2] - a[0][2] * a[1][1];
    double rest[2][STP_PATCH_SAMPLES], apart[STP_PATCH_SAMPLES];
    int inside = 1;
    for (unsigned i = 0; i < patch->counts[0]; i++)
        for (unsigned k = 0; k < 2; k++)
            rest[k][i] = ((double)patch->origin[k] + samples[i].position[k]) * step - a[k][0];
    for (unsigned k = 0; k < 2; k++) {
        const double along = a[1 - k][2 - k], across = a[k][2 - k], first = raster->first[k];
        const double end = first + raster_side(raster);
        for (unsigned i = 0; i < patch->counts[0]; i++) {
            const double place = (rest[k][i] * along - rest[1 - k][i] * across) / det;
            const double nearest = floor(place + 0.5);
            const bool in = (nearest >= first) & (nearest < end);
            inside &= in;
            apart[i] = fabs(place - nearest);
            out[k][i] = (uint32_t)(int32_t)(in ? nearest : 0.0);
        }
        for (unsigned i = 0; i < patch->counts[0]; i++)
            *off = stp_max(*off, apart[i]);
    }
    return inside != 0;
}

/* The same on a tilted raster. */
STP_INLINE bool find_tilted_places(const stp_raster *raster, const stp_patch *patch,
                                   const stp_sample *samples, uint32_t out[2][STP_PATCH_SAMPLES],
                                   double *off)
{
    for (unsigned i = 0; i < patch->counts[0]; i++) {
        const stp_dvec3 p = stp_sample_position(&samples[i], patch);
        uint32_t at[2];
        if (!find_place(raster, (const double[3]){p.x, p.y, p.z}, at, off))
            return false;
        out[0][i] = at[0];
        out[1][i] = at[1];
    }
    return true;
}

STP_WIDE
static bool find_square(const stp_raster *raster, const stp_patch *patch, const stp_sample *samples,
                        stp_square *out, double *off)
{
    uint32_t at[2][STP_PATCH_SAMPLES];
    int before = -1;
    at[0][0] = at[1][0] = 0;
    *out = (stp_square){0};
    *off = 0.0;
    if (raster->level ? !find_level_places(raster, patch, samples, at, off)
                      : !find_tilted_places(raster, patch, samples, at, off))
        return false;
    out->column = at[0][0] / STP_SQUARE_SIDE;
    out->row = at[1][0] / STP_SQUARE_SIDE;
    for (unsigned i = 0; i < patch->counts[0]; i++) {
        const uint32_t c = at[0][i], r = at[1][i];
        const int bit = (int)stp_square_morton(c % STP_SQUARE_SIDE, r % STP_SQUARE_SIDE);
        if (bit <= before || c / STP_SQUARE_SIDE != out->column || r / STP_SQUARE_SIDE != out->row)
            return false;
        out->samples |= UINT64_C(1) << bit;
        before = bit;
    }
    return true;
}

/* Finds the square in one of the rasters: the first one, from `first` on; the nearest one, if the
 * square has few samples. */
static bool find_square_in(const stp_chunk *block, uint32_t p, uint32_t first, stp_square *out)
{
    const bool is_sure = block->patches[p].counts[0] >= SURE_SAMPLES;
    double least = INFINITY;
    for (uint32_t i = 0; i < block->raster_count; i++) {
        stp_square found;
        double off;
        const uint32_t raster = (first + i) % block->raster_count;
        if (!find_square(&block->rasters[raster], &block->patches[p],
                         block->samples[0] + block->level_begin[0][p], &found, &off) ||
            off >= least)
            continue;
        found.raster = raster;
        *out = found;
        least = off;
        if (is_sure || (i == 0 && off < ROUNDED_OFF))
            break;
    }
    return least < INFINITY;
}

static bool follows(uint32_t place, uint32_t before)
{
    return labs((long)place - (long)before) <= DELTA_MOST;
}

/* Whether a tilted raster comes back as it is. */
static bool is_of_floats(const stp_raster *raster)
{
    for (int k = 0; k < 2; k++)
        for (int i = 1; i < 6; i++)
            if ((double)(float)raster->across[k][i] != raster->across[k][i])
                return false;
    return true;
}

/* Whether a square can be coded in the block of the one before, which may be the same. */
static bool may_follow(const stp_chunk *block, const stp_square *before, const stp_square *square)
{
    const stp_raster *raster = &block->rasters[square->raster];
    if (raster->level)
        return before->raster == square->raster && follows(square->column, before->column) &&
               follows(square->row, before->row);
    return !block->rasters[before->raster].level && is_of_floats(raster) &&
           block->patch_count <= TILTED_PATCHES_MOST;
}

bool stp_squares_find(const stp_chunk *block, stp_square *out)
{
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const stp_square *before = &out[p ? p - 1 : 0];
        if (!find_square_in(block, p, p ? before->raster : 0, &out[p]))
            return false;
        if (!may_follow(block, before, &out[p]))
            return false;
    }
    return true;
}
