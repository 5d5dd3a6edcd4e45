/* How the eye sees bounds of patches and blocks. */
#include "runtime/cut/level_choice.h"

#include "base/wide.h"
#include "formats/chunk/codec/inline.h"
#include "runtime/cut/level_rule.h"

#include <stddef.h>
#include <string.h>

static inline float dot3(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline bool is_exaggerated(const stp_gpu_frame *frame)
{
    return frame->centre[3] != 1.0f;
}

/* Where an orthographic view looks from, in the world. */
static inline void back_of(const stp_gpu_frame *frame, float out[3])
{
    out[0] = frame->axis_right[3];
    out[1] = frame->axis_up[3];
    out[2] = frame->axis_back[3];
}

static inline void to_eye(const stp_gpu_frame *frame, const float world[3], float out[3])
{
    out[0] = dot3(frame->axis_right, world);
    out[1] = dot3(frame->axis_up, world);
    out[2] = dot3(frame->axis_back, world);
}

static inline bool outside_frustum(const stp_gpu_frame *frame, const float centre[3], float radius)
{
    float depth = -centre[2], low = frame->centre[0], beneath = frame->centre[1];
    float high = frame->viewport[0] - low, over = frame->viewport[1] - beneath;
    const float *x = frame->frustum[0], *y = frame->frustum[1];
    const float f = frame->viewport[2];
    bool flat = frame->modes[0] != 0, before = depth + radius <= frame->viewport[3];
    float left = flat ? -centre[0] - low / f : -centre[0] * x[0] - depth * x[1];
    float right = flat ? centre[0] - high / f : centre[0] * x[2] - depth * x[3];
    float down = flat ? -centre[1] - beneath / f : -centre[1] * y[0] - depth * y[1];
    float up = flat ? centre[1] - over / f : centre[1] * y[2] - depth * y[3];
    return before | (left > radius) | (right > radius) | (down > radius) | (up > radius);
}

static inline stp_window_disc window_disc(const stp_gpu_frame *frame, const float eye[3],
                                          float radius)
{
    const bool flat = frame->modes[0] != 0;
    const float f = frame->viewport[2], depth = -eye[2], inverse = 1.0f / depth;
    const float x = eye[0] * inverse, y = eye[1] * inverse, scale = flat ? f : f * inverse;
    const float wide = f * radius * sqrtf(1.0f + x * x + y * y) / (depth - radius);
    const bool near = depth - radius <= frame->viewport[3];
    return (stp_window_disc){{frame->centre[0] + eye[0] * scale, frame->centre[1] + eye[1] * scale},
                             flat   ? f * radius
                             : near ? INFINITY
                                    : wide};
}

stp_window_disc stp_ball_window_disc(const stp_gpu_frame *frame, const float eye[3], float radius)
{
    return window_disc(frame, eye, radius);
}

/* How the eye sees a bound. */
typedef struct aspect {
    float range, sin_beta, cos_phi;
} aspect;

static inline aspect aspect_of(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    bool orthographic = frame->modes[0] != 0;
    float eye[3], radius = bound->radius * stp_frame_stretch(frame);
    to_eye(frame, bound->centre, eye);
    float range =
        is_exaggerated(frame) ? sqrtf(dot3(eye, eye)) : sqrtf(dot3(bound->centre, bound->centre));
    float least = range > 1e-30f ? range : 1e-30f;
    float cos_phi = orthographic ? -dot3(frame->axis_back, bound->cone_axis)
                                 : dot3(bound->centre, bound->cone_axis) / least;
    cos_phi = is_exaggerated(frame) ? 0.0f : cos_phi; /* the cone is another: any normal may be */
    return (aspect){range,
                    orthographic     ? 0.0f
                    : radius < least ? radius / least
                                     : 1.0f,
                    cos_phi < -1.0f  ? -1.0f
                    : cos_phi > 1.0f ? 1.0f
                                     : cos_phi};
}

/* Whether every normal of the cone turns away from every eye ray through the bound:
 *
 *     phi + gamma + beta < 90 degrees
 *
 * phi: between the direction to the bound and the cone's axis; gamma: half-angle of the cone; beta:
 * half-angle under which the eye sees the bound. The code squares and scales sines and cosines by
 * the bound's distance to save time, since it runs for every patch. */
static inline bool faces_away(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    bool orthographic = frame->modes[0] != 0;
    float back[3];
    back_of(frame, back);
    float r2 = orthographic ? 0.0f : bound->radius * bound->radius;
    float range2 = orthographic ? 1.0f : dot3(bound->centre, bound->centre);
    float along = orthographic
                      ? -dot3(back, bound->cone_axis)
                      : dot3(bound->centre, bound->cone_axis) - bound->radius * bound->cone_cos;
    float cos2 = bound->cone_cos * bound->cone_cos, tangent2 = range2 - r2;
    return (bound->cone_cos > 0.0f) & (along > 0.0f) & (cos2 * tangent2 > (1.0f - cos2) * r2) &
           (along * along > (1.0f - cos2) * tangent2);
}

/* Whether an opening lies near the line of sight to a place, and not beyond it. straight: the eye
 * is at infinity, in the direction `back`. inverse: of the square of the place's distance. */
static inline bool is_before(const float ball[4], const float place[3], float radius, float inverse,
                             bool straight, const float back[3])
{
    float off[3], reach = ball[3] + radius * 1.00001f, nearer = 0.0f;
    float part = straight ? 1.0f : dot3(ball, place) * inverse;
    part = part < 0.0f ? 0.0f : part > 1.0f ? 1.0f : part;
    for (int k = 0; k < 3; k++)
        off[k] = ball[k] - part * place[k];
    if (straight) {
        nearer = dot3(off, back);
        for (int k = 0; k < 3; k++)
            off[k] -= nearer * back[k];
    }
    return nearer >= -reach && dot3(off, off) <= reach * reach;
}

/* shaders/project/project.glsl does the same. */
int stp_opening_next(const stp_gpu_frame *frame, int i, const float centre[3], float radius)
{
    const int count = frame->modes[3];
    const float square = dot3(centre, centre), inverse = 1.0f / (square > 1e-30f ? square : 1e-30f);
    float back[3];
    back_of(frame, back);
    if (frame->modes[0] != 0)
        while (i < count && !is_before(frame->openings[i], centre, radius, inverse, true, back))
            i++;
    else
        while (i < count && !is_before(frame->openings[i], centre, radius, inverse, false, back))
            i++;
    return i;
}

/* The limit of shaders/project/project.glsl, and its sine. */
#define CULL_COSINE 0.1f
#define CULL_SINE 0.99498744f

static bool culls(const stp_gpu_frame *frame)
{
    return frame->modes[1] != 0 && !(frame->modes[1] & STP_BACKS_DRAWN);
}

static bool knows_backs(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    return frame->modes[1] & STP_SAMPLE_CLOSED ? bound->closed : !bound->two_sided;
}

/* faces_away by more than what may be seen of a sample at an outline. */
static inline bool faces_far_away(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    stp_rule_bound wide = *bound;
    float square = 1.0f - bound->cone_cos * bound->cone_cos;
    float sine = sqrtf(square > 0.0f ? square : 0.0f);
    wide.cone_cos = bound->cone_cos * CULL_SINE - sine * CULL_COSINE;
    return faces_away(frame, &wide);
}

/* Whether all samples in the bound are left out as hidden backs: every normal turns away so far
 * that no sample can be at an outline. */
static bool is_culled(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    return culls(frame) && knows_backs(frame, bound) && faces_away(frame, bound) &&
           faces_far_away(frame, bound) &&
           stp_opening_next(frame, 0, bound->centre, bound->radius) == frame->modes[3];
}

/* Whether no centre in the bound can lie in the clip box and on the kept side of the planes. Floats
 * may be off in their last bits, so a near bound counts as inside; each sample is tested again. */
static bool outside_clip(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    for (int i = 0; i < (int)frame->light[3]; i++) {
        const float *plane = frame->planes[i], slack = fabsf(plane[3]) * 1e-6f;
        if (dot3(plane, bound->centre) + plane[3] < -(bound->radius * 1.00001f + slack))
            return true;
    }
    if (frame->modes[2] == 0)
        return false;
    for (int i = 0; i < 3; i++) {
        float reach = bound->radius * 1.00001f + fabsf(bound->centre[i]) * 1e-6f;
        if (bound->centre[i] + reach < frame->clip_min[i] ||
            bound->centre[i] - reach > frame->clip_max[i])
            return true;
    }
    return false;
}

bool stp_rule_visible(const stp_gpu_frame *frame, const stp_rule_bound *bound, float eye[3])
{
    if (is_culled(frame, bound)) /* first, since this takes half of a closed model */
        return false;
    to_eye(frame, bound->centre, eye);
    return !outside_frustum(frame, eye, bound->radius * stp_frame_stretch(frame)) &&
           !outside_clip(frame, bound);
}

bool stp_rule_faces_eye(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    stp_rule_bound turned = *bound;
    for (int i = 0; i < 3; i++)
        turned.cone_axis[i] = -bound->cone_axis[i];
    return faces_away(frame, &turned);
}

/* What errors count there. */
static inline float error_weight(const stp_gpu_frame *frame, float sin_alpha)
{
    return stp_rule_is_silhouette(sin_alpha) ? frame->terms[1] : 1.0f;
}

static inline stp_rule_sight look(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    aspect a = aspect_of(frame, bound);
    float sin_alpha = stp_rule_sin_alpha(a.cos_phi, bound->cone_cos, a.sin_beta);
    float stretch = stp_frame_stretch(frame); /* errors and radii are drawn as much longer */
    return (stp_rule_sight){
        stretch * stp_rule_scale(-dot3(frame->axis_back, bound->centre), a.range,
                                 bound->radius * stretch, frame->viewport[2], frame->viewport[3],
                                 frame->modes[0] != 0),
        sin_alpha,
        error_weight(frame, sin_alpha),
    };
}

stp_rule_sight stp_rule_look(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    return look(frame, bound);
}

/* Patches of a block, relative to the eye, value by value. */
typedef struct lanes {
    float centre[3][STP_LOOKS_LIMIT], radius[STP_LOOKS_LIMIT];
    float axis[3][STP_LOOKS_LIMIT], cone_cos[STP_LOOKS_LIMIT];
    /* Of level 3, and at most of level 2; how colours vary in 255ths. */
    float error[2][2][STP_LOOKS_LIMIT], radius_of[2][STP_LOOKS_LIMIT],
        colour_error[2][STP_LOOKS_LIMIT];
    uint32_t away[STP_LOOKS_LIMIT]; /* every normal, so far that no sample can be at an outline */
} lanes;

/* The float whose upper half this is. */
static inline float float_of_upper(uint16_t half)
{
    const uint32_t bits = (uint32_t)half << 16;
    float number;
    memcpy(&number, &bits, sizeof number);
    return number;
}

/* So many lanes go side by side at most. */
#define LANES 8u

/* Repeats the last patch up to a whole number of lanes, and returns that: blocks have some 15
 * patches, and each one left over would take as long as all lanes. */
static uint32_t fill_lanes(lanes *out, const stp_gpu_chunk *chunk, const stp_patch_brief *briefs,
                           uint32_t count)
{
    const uint32_t whole = (count + LANES - 1) / LANES * LANES;
    for (uint32_t i = 0; i < whole; i++) {
        const stp_patch_brief *b = &briefs[i < count ? i : count - 1];
        for (int k = 0; k < 3; k++) {
            out->centre[k][i] = b->bound.centre[k] + chunk->offset[k];
            out->axis[k][i] = b->bound.cone_axis[k];
        }
        out->radius[i] = b->bound.radius;
        out->cone_cos[i] = b->bound.cone_cos;
        for (int k = 0; k < 2; k++) {
            out->error[0][k][i] = b->vertex_error[k];
            out->error[1][k][i] = float_of_upper(b->quarter_error[k]);
            out->colour_error[k][i] = (float)b->colour_error[k];
        }
        out->radius_of[0][i] = b->vertex_radius;
        out->radius_of[1][i] = (float)b->quarter_radius;
    }
    return whole;
}

static inline stp_rule_bound bound_in(const lanes *l, uint32_t i)
{
    return (stp_rule_bound){.centre = {l->centre[0][i], l->centre[1][i], l->centre[2][i]},
                            .radius = l->radius[i],
                            .cone_axis = {l->axis[0][i], l->axis[1][i], l->axis[2][i]},
                            .cone_cos = l->cone_cos[i]};
}

/* Whether level 3, or level 2 as the brief tells it, does for a patch. */
STP_INLINE bool does(const lanes *restrict l, const stp_gpu_frame *restrict frame,
                     const stp_rule_sight *sight, int coarse, float radius, uint32_t i)
{
    const float threshold = frame->quality[0] > 0.0f ? frame->quality[0] : -1.0f;
    const float error = stp_rule_error(sight->scale, sight->sin_alpha, l->error[coarse][0][i],
                                       l->error[coarse][1][i]);
    return sight->scale >= 0.0f &&
           stp_rule_fits(error, sight->scale * radius, l->colour_error[coarse][i] / 255.0f,
                         sight->error_weight, frame->terms[0], threshold, frame->quality[1]);
}

/* No branch depends on a patch, so that lanes go side by side. */
STP_INLINE void look_at(stp_looks *restrict out, lanes *restrict l,
                        const stp_gpu_frame *restrict frame, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const stp_rule_bound bound = bound_in(l, i);
        float eye[3];
        to_eye(frame, bound.centre, eye);
        out->eye[0][i] = eye[0];
        out->eye[1][i] = eye[1];
        out->eye[2][i] = eye[2];
        out->visible[i] = !outside_frustum(frame, eye, bound.radius * stp_frame_stretch(frame));
        const stp_window_disc disc =
            window_disc(frame, eye, bound.radius * stp_frame_stretch(frame));
        out->window[0][i] = disc.centre[0];
        out->window[1][i] = disc.centre[1];
        out->reach_px[i] = disc.reach;
        l->away[i] = faces_away(frame, &bound) & faces_far_away(frame, &bound);
    }
    for (uint32_t i = 0; i < count; i++) {
        const stp_rule_bound bound = bound_in(l, i);
        const stp_rule_sight sight = look(frame, &bound);
        const float radius = l->radius_of[0][i];
        out->scale[i] = sight.scale;
        out->sin_alpha[i] = sight.sin_alpha;
        out->vertex[i] = does(l, frame, &sight, 0, radius, i);
        out->quarters[i] =
            does(l, frame, &sight, 1, radius * (l->radius_of[1][i] * STP_BRIEF_RADIUS), i);
    }
}

/* The same of a view in perspective that shows heights as they are, which most are: told so, the
 * compiler leaves no branch. */
STP_WIDE static void look_straight(stp_looks *restrict out, lanes *restrict l,
                                   const stp_gpu_frame *restrict frame, uint32_t count)
{
    stp_gpu_frame plain;
    memcpy(&plain, frame, offsetof(stp_gpu_frame, openings));
    plain.modes[0] = 0;
    plain.centre[2] = plain.centre[3] = 1.0f;
    look_at(out, l, &plain, count);
}

void stp_patches_look(stp_looks *out, const stp_gpu_frame *frame, const stp_gpu_frame *openings,
                      const stp_gpu_chunk *chunk, const stp_patch_brief *briefs, uint32_t count)
{
    lanes l;
    const bool clips = frame->modes[2] != 0 || frame->light[3] > 0.0f;
    const uint32_t whole = fill_lanes(&l, chunk, briefs, count);
    if (frame->modes[0] == 0 && !is_exaggerated(frame))
        look_straight(out, &l, frame, whole);
    else
        look_at(out, &l, frame, whole);
    for (uint32_t i = 0; i < count; i++) {
        /* NOLINTNEXTLINE(clang-analyzer-core.uninitialized.Branch): look_at has set it */
        const bool away = l.away[i] && culls(frame) && knows_backs(frame, &briefs[i].bound);
        if (!out->visible[i] || !(away || clips))
            continue;
        const stp_rule_bound bound = bound_in(&l, i);
        out->visible[i] = !(away && stp_opening_next(openings, 0, bound.centre, bound.radius) ==
                                        openings->modes[3]) &&
                          !outside_clip(frame, &bound);
    }
}

stp_rule_sight stp_looks_sight(const stp_looks *looks, const stp_gpu_frame *frame, uint32_t i)
{
    const float sin_alpha = looks->sin_alpha[i];
    return (stp_rule_sight){looks->scale[i], sin_alpha, error_weight(frame, sin_alpha)};
}
