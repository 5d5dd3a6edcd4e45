/* Overhang of merged discs over all level-0 discs near them. */
#include "formats/chunk/overhang.h"

#include "formats/chunk/disc_grid.h"
#include "formats/chunk/patch_bounds.h"

/* A merged disc over the discs under it, and the greatest error of its quarter or patch so far. */
typedef struct measure {
    const stp_disc_grid *grid;
    const stp_carry *carry, *carry_around;
    stp_overhang_doubt doubt;
    stp_dvec3 normal;
    double error;    /* the perpendicular error that is stored */
    uint32_t latest; /* the disc nearest to an earlier point */
    double greatest;
} measure;

/* What a disc brings from below. */
static stp_carry carry_of(const measure *m, uint32_t disc)
{
    const stp_carry none = {0.0, 0.0};
    uint32_t own = m->grid->own_count;
    if (disc < own)
        return m->carry ? m->carry[disc] : none;
    return m->carry_around ? m->carry_around[disc - own] : none;
}

/* What of the height over a disc the stored perpendicular error does not cover. */
static double uncovered(const measure *m, const stp_disc_position *at)
{
    double carried = carry_of(m, at->disc).error;
    double cosine = stp_dvec3_dot(m->normal, m->grid->discs[at->disc].normal);
    if (at->height + carried > m->error)
        return at->height;
    return at->height * sqrt(stp_max(0.0, 1.0 - cosine * cosine));
}

static double carried_overhang(const measure *m, uint32_t disc)
{
    return carry_of(m, disc).tangential_error;
}

/* Both overhang and height are at most the distance, so their sum is at most 1.42 times that: no
 * more than the greatest where the distance is small enough. own: the nearest disc under the
 * point's merged disc. */
static void measure_point(measure *m, stp_dvec3 x, uint32_t own)
{
    double enough = m->carry ? 0.0 : m->greatest * m->greatest / 2.02;
    stp_disc_position best = stp_disc_grid_position(m->grid, own, x);
    double over_own = best.overhang + carried_overhang(m, own);
    if (over_own <= m->greatest || best.squared <= enough)
        return;
    bool found = stp_disc_grid_nearest(m->grid, x, enough, m->latest, &best);
    m->latest = best.disc;
    if (!found && m->doubt == STP_OVERHANG_LEAST)
        return;
    double over_all = INFINITY;
    if (found)
        over_all = best.overhang + carried_overhang(m, best.disc) + uncovered(m, &best);
    m->greatest = stp_max(m->greatest, stp_min(over_own, over_all));
}

static void measure_disc(measure *m, const stp_disc *disc, uint32_t first, uint32_t last)
{
    stp_dvec3 points[STP_DISC_POINTS];
    stp_disc_lanes lanes;
    unsigned count = stp_disc_points(disc, points);
    stp_disc_lanes_begin(&lanes, points, count, disc->centre, disc->radius, first);
    for (uint32_t i = first; i < last; i++) {
        const stp_flat_disc *own = &m->grid->discs[i];
        stp_disc_lanes_try(&lanes, own->centre, own->normal, own->radius, i);
    }
    m->normal = disc->normal;
    m->latest = first;
    for (unsigned i = 0; i < count; i++)
        measure_point(m, points[i], lanes.nearest[i]);
}

/* The samples of a quarter at a level. */
static void measure_level(measure *m, const stp_chunk *chunk, uint32_t p, int level, unsigned q)
{
    const stp_patch *patch = &chunk->patches[p];
    const stp_sample *samples = chunk->samples[level] + chunk->level_begin[level][p];
    uint32_t begin = chunk->level_begin[0][p];
    unsigned end = stp_quarter_begin(patch->counts, level, q + 1);
    m->error = stp_error_decode(stp_quarter_error(patch, level, q), patch->exponent) * (1.0 + 1e-6);
    for (unsigned i = stp_quarter_begin(patch->counts, level, q); i < end; i++) {
        stp_disc disc = stp_disc_from_sample(&samples[i], patch);
        measure_disc(m, &disc, begin + stp_covered_begin(patch->counts, level, i, 0),
                     begin + stp_covered_begin(patch->counts, level, i + 1, 0));
    }
}

static void measure_patch(stp_overhang *out, const measure *blank, const stp_chunk *chunk,
                          uint32_t p)
{
    const stp_patch *patch = &chunk->patches[p];
    measure m = *blank;
    double least = patch->counts[0] > 1
                       ? stp_radius_decode(patch->radius[0], patch->exponent) / STP_OVERHANG_PARTS
                       : 0.0;
    *out = (stp_overhang){0};
    for (unsigned q = 0; q < patch->counts[2]; q++) {
        double carried = 0.0;
        unsigned end = stp_quarter_begin(patch->counts, 0, q + 1);
        for (unsigned i = stp_quarter_begin(patch->counts, 0, q); i < end; i++)
            carried = stp_max(carried, carried_overhang(&m, chunk->level_begin[0][p] + i));
        out->level[0] = stp_max(out->level[0], carried);
        m.greatest = stp_max(carried, least);
        for (int level = 1; level <= 2; level++) {
            measure_level(&m, chunk, p, level, q);
            out->quarter[level - 1][q] = m.greatest;
            out->level[level] = stp_max(out->level[level], m.greatest);
        }
    }
    m.greatest = out->level[2];
    measure_level(&m, chunk, p, 3, 0);
    out->level[3] = m.greatest;
}

stp_status stp_overhang_measure(stp_overhang *out, const stp_chunk *chunk, const stp_carry *carry,
                                const stp_surroundings *around, stp_overhang_doubt doubt,
                                stp_error *err)
{
    stp_disc_grid grid;
    stp_status status = stp_disc_grid_create(&grid, chunk, around, err);
    const measure blank = {.grid = &grid,
                           .carry = carry,
                           .carry_around = around ? around->carry : NULL,
                           .doubt = doubt};
    for (uint32_t p = 0; status == STP_OK && p < chunk->patch_count; p++)
        measure_patch(&out[p], &blank, chunk, p);
    stp_disc_grid_clear(&grid);
    return status;
}
