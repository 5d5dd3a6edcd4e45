/* Recomputes a patch's errors, cone and bound from its decoded samples. */
#include "formats/chunk/verify/verify_errors.h"

#include "formats/chunk/measure/patch_bounds.h"
#include "formats/chunk/measure/strip.h"
#include "formats/chunk/measure/triangles.h"

typedef struct levels {
    stp_disc discs[STP_LEVEL_COUNT][STP_PATCH_SAMPLES];
} levels;

static void decode(const stp_chunk *chunk, uint32_t index, levels *out)
{
    const stp_patch *patch = &chunk->patches[index];
    for (int level = 0; level < STP_LEVEL_COUNT; level++) {
        const stp_sample *samples = chunk->samples[level] + chunk->level_begin[level][index];
        for (unsigned i = 0; i < patch->counts[level]; i++)
            out->discs[level][i] = stp_disc_from_sample(&samples[i], patch);
    }
}

static bool exceeds(double found, uint8_t stored, const stp_patch *patch)
{
    return found > stp_error_held(stored, patch);
}

static const char *check_sample(const levels *l, const stp_patch *patch, int level, unsigned q,
                                unsigned i)
{
    unsigned first = stp_covered_begin(patch->counts, level, i, 0);
    unsigned last = stp_covered_begin(patch->counts, level, i + 1, 0);
    stp_merge_error e = stp_merge_measure(&l->discs[level][i], &l->discs[0][first], last - first);
    if (exceeds(e.least_error, stp_quarter_error(patch, level, q), patch))
        return "the perpendicular error of a merged sample exceeds the stored one";
    return NULL;
}

static const char *check_level(const levels *l, const stp_patch *patch, int level)
{
    const char *fault = NULL;
    if (stp_colour_variation(l->discs[level], l->discs[0], patch->counts, level) >
        (double)patch->colour_error[level] + 1e-9)
        return "the colour error of a level exceeds the stored one";
    for (unsigned q = 0; !fault && q < patch->counts[2]; q++) {
        unsigned end = stp_quarter_begin(patch->counts, level, q + 1);
        for (unsigned i = stp_quarter_begin(patch->counts, level, q); !fault && i < end; i++)
            fault = check_sample(l, patch, level, q, i);
    }
    return fault;
}

/* Whether no quarter's error shrinks from level 1 to level 2. Whole levels, except level 0, follow
 * from their quarters. */
static bool quarters_grow(const stp_patch *patch)
{
    for (int q = 0; q < STP_PATCH_QUARTERS; q++)
        if (patch->quarter_error[1][q] < patch->quarter_error[0][q] ||
            patch->quarter_tangential_error[1][q] < patch->quarter_tangential_error[0][q])
            return false;
    return true;
}

static const char *check_bounds(const levels *l, const stp_patch *patch)
{
    stp_sample at = {
        .position = {patch->bound_centre[0], patch->bound_centre[1], patch->bound_centre[2]}};
    stp_dvec3 centre = stp_sample_position(&at, patch);
    stp_dvec3 axis = stp_dvec3_from_float(stp_normal_decode(patch->cone_axis));
    double radius = stp_radius_decode(patch->bound_radius, patch->exponent) * STP_STORED_SLACK;
    double angle = stp_cone_angle_decode(patch->cone_angle) * STP_STORED_SLACK;
    for (int level = 0; level < STP_LEVEL_COUNT; level++) {
        for (unsigned i = 0; i < patch->counts[level]; i++) {
            const stp_disc *d = &l->discs[level][i];
            if (stp_dvec3_length(stp_dvec3_sub(d->centre, centre)) + d->radius > radius)
                return "a disc reaches out of the patch's bound";
            double cosine = fmax(-1.0, fmin(1.0, stp_dvec3_dot(d->normal, axis)));
            bool known = d->normal.x != 0.0 || d->normal.y != 0.0 || d->normal.z != 0.0;
            if (known && acos(cosine) > angle)
                return "a normal lies outside the patch's cone";
        }
    }
    return NULL;
}

static const char *shape_fault(const stp_chunk *chunk, uint32_t index)
{
    switch (chunk->patches[index].flags & STP_PATCH_SHAPES) {
    case STP_PATCH_STRIP:
        return stp_strip_fault(chunk, index);
    case STP_PATCH_TRIANGLES:
        return stp_triangles_fault(chunk, index);
    default:
        return NULL;
    }
}

const char *stp_verify_patch_errors(const stp_chunk *chunk, uint32_t index)
{
    const stp_patch *patch = &chunk->patches[index];
    levels l;
    decode(chunk, index, &l);
    const char *fault = shape_fault(chunk, index);
    for (int level = 1; level < STP_LEVEL_COUNT; level++) {
        if (!fault && !(patch->flags & STP_PATCH_SHAPES))
            fault = check_level(&l, patch, level);
        if (fault)
            return fault;
        if (patch->error[level] < patch->error[level - 1] ||
            patch->tangential_error[level] < patch->tangential_error[level - 1])
            return "an error shrinks towards the root";
    }
    if (!quarters_grow(patch))
        return "an error of a quarter shrinks towards the root";
    return check_bounds(&l, patch);
}
