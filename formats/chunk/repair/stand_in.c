/* Builds leaf chunks that stand in for lost ones. */
#include "formats/chunk/repair/stand_in.h"

#include "formats/chunk/measure/patch_bounds.h"
#include "formats/chunk/sample/patch.h"

#include <string.h>

static int source_level(int level, int shift)
{
    return level + shift < STP_LEVEL_COUNT ? level + shift : STP_LEVEL_COUNT - 1;
}

static uint8_t greater(uint8_t a, uint8_t b)
{
    return a > b ? a : b;
}

static bool raise_code(uint8_t *code, uint8_t least)
{
    bool raised = *code < least;
    *code = greater(*code, least);
    return raised;
}

bool stp_patch_raise(stp_patch *patch, uint8_t error, uint8_t tangential_error)
{
    bool raised = false;
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        raised |= raise_code(&patch->error[l], error);
        raised |= raise_code(&patch->tangential_error[l], tangential_error);
    }
    for (int l = 0; l < 2; l++)
        for (unsigned q = 0; q < patch->counts[2]; q++) {
            raised |= raise_code(&patch->quarter_error[l][q], error);
            raised |= raise_code(&patch->quarter_tangential_error[l][q], tangential_error);
        }
    return raised;
}

/* Sets the patch's flags two-sided and closed from its samples. */
static void mark_sides(stp_patch *patch, const stp_sample *samples)
{
    unsigned common = UINT8_MAX;
    for (unsigned i = 0; i < patch->counts[0]; i++)
        common &= samples[i].flags;
    if (~common & (STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL))
        patch->flags |= STP_PATCH_TWO_SIDED;
    if (common & STP_SAMPLE_CLOSED)
        patch->flags |= STP_PATCH_CLOSED;
}

/* Copies a patch's level errors into its quarters: it has one quarter. */
static void fill_quarter(stp_patch *patch)
{
    memset(patch->quarter_error, 0, sizeof patch->quarter_error);
    memset(patch->quarter_tangential_error, 0, sizeof patch->quarter_tangential_error);
    for (int l = 0; l < 2; l++) {
        patch->quarter_error[l][0] = patch->error[l + 1];
        patch->quarter_tangential_error[l][0] = patch->tangential_error[l + 1];
    }
}

/* ---- from coarser levels ---- */

/* Moves levels towards level 0. A strip stays a strip, through fewer vertices; triangles become
 * discs. */
static stp_patch shift_patch(const stp_patch *in, int shift)
{
    stp_patch out = *in;
    out.child = STP_PATCH_NO_CHILD;
    out.first_below = 0;
    if (out.flags & STP_PATCH_TRIANGLES)
        out.flags &= (uint8_t)~STP_PATCH_TRIANGLES;
    if (in->counts[source_level(0, shift)] < 2)
        out.flags &= (uint8_t)~STP_PATCH_JOINTS;
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        int from = source_level(l, shift);
        out.counts[l] = in->counts[from];
        out.radius[l] = in->radius[from];
        out.error[l] = in->error[from];
        out.tangential_error[l] = in->tangential_error[from];
        out.colour_error[l] = in->colour_error[from];
    }
    return out;
}

/* Measures errors of a level over the new level 0. They are hardly greater than the stored ones. */
static void measure_level(const stp_chunk *chunk, uint32_t p, int level)
{
    stp_patch *patch = &chunk->patches[p];
    stp_disc finest[STP_PATCH_SAMPLES], merged[STP_PATCH_SAMPLES];
    const uint32_t *begin[2] = {chunk->level_begin[0], chunk->level_begin[level]};
    for (unsigned i = 0; i < patch->counts[0]; i++)
        finest[i] = stp_disc_from_sample(&chunk->samples[0][begin[0][p] + i], patch);
    for (unsigned i = 0; i < patch->counts[level]; i++) {
        unsigned first = stp_covered_begin(patch->counts, level, i, 0);
        unsigned last = stp_covered_begin(patch->counts, level, i + 1, 0);
        stp_disc disc = stp_disc_from_sample(&chunk->samples[level][begin[1][p] + i], patch);
        stp_merge_error e = stp_merge_measure(&disc, &finest[first], last - first);
        raise_code(&patch->error[level], stp_error_encode(e.error, patch->exponent));
        merged[i] = disc;
    }
    double variation = stp_colour_variation(merged, finest, patch->counts, level);
    raise_code(&patch->colour_error[level], (uint8_t)stp_min(255.0, ceil(variation)));
}

static void measure_patch(const stp_chunk *chunk, uint32_t p)
{
    stp_patch *patch = &chunk->patches[p];
    for (int l = 1; l < STP_LEVEL_COUNT; l++) {
        raise_code(&patch->error[l], patch->error[l - 1]);
        raise_code(&patch->tangential_error[l], patch->tangential_error[l - 1]);
        raise_code(&patch->colour_error[l], patch->colour_error[l - 1]);
        if (!(patch->flags & STP_PATCH_STRIP)) /* a strip's errors hold over fewer vertices, too */
            measure_level(chunk, p, l);
    }
    fill_quarter(patch);
}

stp_status stp_stand_in_coarse(const stp_chunk *in, stp_chunk **out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    uint32_t counts[STP_LEVEL_COUNT];
    const int shift = in->finest_level;
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        counts[l] = in->level_begin[source_level(l, shift)][in->patch_count];
    STP_TRY(stp_chunk_create(&chunk, in->patch_count, counts, 0, err));
    chunk->id = in->id;
    for (uint32_t p = 0; p < in->patch_count; p++)
        chunk->patches[p] = shift_patch(&in->patches[p], shift);
    stp_patches_place(chunk);
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        memcpy(chunk->samples[l], in->samples[source_level(l, shift)],
               counts[l] * sizeof(stp_sample));
    for (uint32_t p = 0; p < in->patch_count; p++) {
        measure_patch(chunk, p);
        mark_sides(&chunk->patches[p], &chunk->samples[0][chunk->level_begin[0][p]]);
    }
    *out = chunk;
done:
    return status;
}

/* ---- from the parent ---- */

static stp_patch patch_of_sample(const stp_patch *from, int level, const stp_sample *sample)
{
    stp_patch out = {.origin = {from->origin[0], from->origin[1], from->origin[2]},
                     .exponent = from->exponent,
                     .child = STP_PATCH_NO_CHILD,
                     .cone_angle = stp_cone_angle_encode(1e-6),
                     .bound_radius = sample->radius};
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        out.counts[l] = 1;
        out.radius[l] = sample->radius;
        out.error[l] = from->error[level];
        out.tangential_error[l] = from->tangential_error[level];
        out.colour_error[l] = from->colour_error[level];
    }
    memcpy(out.bound_centre, sample->position, sizeof out.bound_centre);
    memcpy(out.cone_axis, sample->normal, sizeof out.cone_axis);
    fill_quarter(&out);
    mark_sides(&out, sample);
    return out;
}

stp_status stp_stand_in_samples(const stp_chunk *parent, uint32_t child_index, stp_chunk **out,
                                stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    uint32_t count = 0, next = 0;
    const int level = parent->finest_level;
    const uint32_t *begin = parent->level_begin[level];
    const bool linked = parent->linked && level == 0; /* links are of level 0 */
    for (uint32_t p = 0; p < parent->patch_count; p++)
        count += parent->patches[p].child == child_index ? parent->patches[p].counts[level] : 0u;
    if (count == 0)
        return stp_error_set(err, STP_EMPTY, "no patch stands for child %u", child_index);
    const uint32_t counts[STP_LEVEL_COUNT] = {count, count, count, count};
    STP_TRY(stp_chunk_create(&chunk, count, counts, 0, err));
    for (uint32_t p = 0; p < parent->patch_count; p++) {
        const stp_patch *patch = &parent->patches[p];
        if (patch->child != child_index)
            continue;
        uint32_t at = linked ? patch->first_below : next;
        next += patch->counts[level];
        for (uint32_t i = begin[p]; i < begin[p + 1] && at < count; i++, at++) {
            chunk->patches[at] = patch_of_sample(patch, level, &parent->samples[level][i]);
            for (int l = 0; l < STP_LEVEL_COUNT; l++)
                chunk->samples[l][at] = parent->samples[level][i];
        }
    }
    stp_patches_place(chunk);
    *out = chunk;
done:
    return status;
}
