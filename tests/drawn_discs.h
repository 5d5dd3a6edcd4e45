/* The samples of a chunk as the discs that the CPU reference draws.
 * Threads: any (pure functions). */
#ifndef STP_TESTS_DRAWN_DISCS_H
#define STP_TESTS_DRAWN_DISCS_H

#include "formats/chunk/chunk_file.h"
#include "runtime/level_choice.h"
#include "tests/support/reference.h"

/* Whether the line of sight to a place in eye space goes through an opening of the frame. */
static inline bool drawn_seen_through(const stp_gpu_frame *frame, const stp_view *view,
                                      stp_dvec3 position)
{
    for (int i = 0; i < frame->modes[3]; i++) {
        const float *ball = frame->openings[i];
        stp_dvec3 from_eye = {(double)ball[0], (double)ball[1], (double)ball[2]};
        stp_dvec3 at = reference_turn_to_eye(view, from_eye);
        double part = stp_dvec3_dot(at, position) / stp_dvec3_dot(position, position);
        part = view->orthographic ? 1.0 : stp_max(0.0, stp_min(1.0, part));
        stp_dvec3 off = stp_dvec3_sub(at, stp_dvec3_scale(position, part));
        double nearer = view->orthographic ? off.z : 0.0, radius = (double)ball[3];
        off.z -= nearer;
        if (nearer >= -radius && stp_dvec3_length(off) <= radius)
            return true;
    }
    return false;
}

/* frame: tells which backs are left out. */
static inline reference_disc drawn_disc(const stp_chunk_entry *entry, const stp_patch *patch,
                                        const stp_sample *sample, const stp_view *view,
                                        const stp_gpu_frame *frame)
{
    stp_dvec3 n = stp_dvec3_from_float(stp_normal_decode(sample->normal));
    stp_dvec3 p = stp_dvec3_add(entry->origin, stp_sample_position(sample, patch));
    const unsigned both = STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL;
    const unsigned culled = (unsigned)frame->modes[1] & (STP_BACKS_DRAWN - 1u);
    stp_dvec3 position = reference_to_eye(view, p);
    return (reference_disc){
        .position = position,
        .normal = stp_dvec3_normalize(reference_turn_to_eye(view, n)),
        .radius = stp_sample_radius(sample, patch),
        .rgb = {sample->rgb[0] / 255.0, sample->rgb[1] / 255.0, sample->rgb[2] / 255.0},
        .kind = (unsigned)(sample->flags & STP_SAMPLE_KIND_MASK) >> STP_SAMPLE_KIND_SHIFT,
        .has_normal = (sample->flags & STP_SAMPLE_HAS_NORMAL) != 0,
        .oriented = (sample->flags & both) == both,
        .culled = culled != 0 && (sample->flags & culled) == culled,
        .seen_through =
            (frame->modes[1] & STP_BACKS_DRAWN) != 0 || drawn_seen_through(frame, view, position),
    };
}

/* Appends the samples of one patch, drawn as what `shape` says. splat: strips are wide. Errors:
 * OUT_OF_MEMORY. */
static inline stp_status drawn_append_samples(const stp_view *view, const reference_disc *samples,
                                              unsigned count, unsigned shape, bool splat,
                                              reference_disc_list *out, stp_error *err)
{
    stp_status status = STP_OK;
    for (unsigned i = 0; i < count && status == STP_OK; i++) {
        if (shape == STP_PATCH_STRIP && i + 1 < count &&
            reference_ribbon_is_flat(view, &samples[i], &samples[i + 1]))
            status = reference_ribbon(view, samples, count, i, out, err);
        else if (shape == STP_PATCH_STRIP && i + 1 < count && splat)
            status = reference_segment_wide(view, &samples[i], &samples[i + 1], out, err);
        else if (shape == STP_PATCH_STRIP && i + 1 < count)
            status = reference_segment(view, &samples[i], &samples[i + 1], out, err);
        else if (shape == STP_PATCH_TRIANGLES && i % 3 == 0)
            status = reference_triangle(view, &samples[i], out, err);
        else if (shape == 0)
            status = reference_append(out, &samples[i], err);
    }
    return status;
}

/* A patch at the levels chosen; gpu: the patch as it is in the Object Texture. */
typedef struct drawn_patch {
    const stp_chunk_entry *entry;
    const stp_chunk *chunk;
    uint32_t index;
    const stp_gpu_patch *gpu;
    stp_levels levels;
} drawn_patch;

/* Appends a patch's samples in the order they are drawn. Errors: OUT_OF_MEMORY. */
static inline stp_status drawn_append(const drawn_patch *drawn, const stp_view *view,
                                      const stp_gpu_frame *frame, bool splat,
                                      reference_disc_list *out, stp_error *err)
{
    const stp_chunk *chunk = drawn->chunk;
    const stp_patch *patch = &chunk->patches[drawn->index];
    reference_disc discs[STP_PATCH_SAMPLES];
    unsigned count = 0;
    for (unsigned q = 0; q < STP_PATCH_QUARTERS && drawn->levels.of[q] != STP_LEVEL_SKIP; q++) {
        int level = drawn->levels.of[q];
        const stp_sample *samples = chunk->samples[level] + chunk->level_begin[level][drawn->index];
        unsigned end = stp_quarter_begin(patch->counts, level, q + 1);
        for (unsigned i = stp_quarter_begin(patch->counts, level, q); i < end; i++)
            discs[count++] = drawn_disc(drawn->entry, patch, &samples[i], view, frame);
    }
    unsigned shape = stp_levels_shape(drawn->gpu, &drawn->levels);
    return drawn_append_samples(view, discs, count, shape, splat, out, err);
}

#endif
