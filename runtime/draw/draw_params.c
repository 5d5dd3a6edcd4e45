/* Compares what two frames ask for, field by field. */
#include "runtime/draw/draw_params.h"

#include "base/vec.h"

#include <string.h>

/* Every field of stp_draw_params, in its order and with its kind. */
#define FIELDS(VALUE, ARRAY, FADE, CLIP, PLANES)                                                   \
    VALUE(lod)                                                                                     \
    VALUE(reconstruct)                                                                             \
    VALUE(shade)                                                                                   \
    VALUE(colour)                                                                                  \
    VALUE(palette)                                                                                 \
    VALUE(hidden_models)                                                                           \
    VALUE(threshold_px)                                                                            \
    VALUE(radius_cap_px)                                                                           \
    VALUE(terms)                                                                                   \
    ARRAY(colour_range)                                                                            \
    VALUE(overlay)                                                                                 \
    VALUE(edl)                                                                                     \
    ARRAY(light)                                                                                   \
    VALUE(contour_step)                                                                            \
    VALUE(contour_base)                                                                            \
    VALUE(exaggerate)                                                                              \
    VALUE(exaggerate_about)                                                                        \
    FADE(fade)                                                                                     \
    CLIP(clip)                                                                                     \
    PLANES(planes)                                                                                 \
    VALUE(plane_count)                                                                             \
    ARRAY(hidden_classes)                                                                          \
    VALUE(smooth_edges)                                                                            \
    VALUE(cull)                                                                                    \
    VALUE(occlusion)                                                                               \
    VALUE(grid_draw)                                                                               \
    VALUE(maps_as)                                                                                 \
    VALUE(every_sample)                                                                            \
    VALUE(stream)                                                                                  \
    VALUE(refine)                                                                                  \
    VALUE(keep_pixels)                                                                             \
    VALUE(timed)

/* One initializer for each field. If FIELDS lacks one, -Wmissing-field-initializers stops the
 * build. */
#define ZERO(field) 0,
#define ZEROS(field) {0},
#define ZERO_PLANES(field) {{{0.0, 0.0, 0.0}, 0.0}},
_Static_assert(sizeof((stp_draw_params){FIELDS(ZERO, ZEROS, ZERO, ZEROS, ZERO_PLANES)}) ==
                   sizeof(stp_draw_params),
               "FIELDS has every field");

static bool clips_equal(const stp_clip *a, const stp_clip *b)
{
    return a->enabled == b->enabled && stp_dvec3_equal(a->box.min, b->box.min) &&
           stp_dvec3_equal(a->box.max, b->box.max);
}

static bool planes_equal(const stp_draw_params *a, const stp_draw_params *b)
{
    bool same = a->plane_count == b->plane_count;
    for (unsigned i = 0; i < a->plane_count && i < STP_PLANES_LIMIT && same; i++)
        same = stp_dvec3_equal(a->planes[i].normal, b->planes[i].normal) &&
               a->planes[i].offset == b->planes[i].offset;
    return same;
}

#define SAME_VALUE(field) &&a->field == b->field
#define SAME_ARRAY(field) &&memcmp(a->field, b->field, sizeof a->field) == 0
#define SAME_FADE(field) &&(a->field > 0.0) == (b->field > 0.0)
#define SAME_CLIP(field) &&clips_equal(&a->field, &b->field)
#define SAME_PLANES(field) &&planes_equal(a, b)

bool stp_draw_params_equal(const stp_draw_params *a, const stp_draw_params *b)
{
    /* NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): zeros of two signs cost one frame */
    return true FIELDS(SAME_VALUE, SAME_ARRAY, SAME_FADE, SAME_CLIP, SAME_PLANES);
}
