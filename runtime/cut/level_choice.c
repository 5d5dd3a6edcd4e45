/* Chooses the levels of a patch on the CPU, by the rules of shaders/project/choose.glsl. */
#include "runtime/cut/level_choice.h"

#include "runtime/cut/level_rule.h"

static float dot3(const float a[3], const float b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void set_axis(float out[4], stp_dvec3 axis, double back)
{
    out[0] = (float)axis.x;
    out[1] = (float)axis.y;
    out[2] = (float)axis.z;
    out[3] = (float)back;
}

stp_gpu_frame stp_gpu_frame_from_view(const stp_view *view)
{
    stp_gpu_frame frame = {
        .viewport = {(float)view->width, (float)view->height, (float)view->f,
                     (float)view->near_depth},
        .centre = {(float)stp_view_axis_x(view), (float)stp_view_axis_y(view), 1.0f, 1.0f},
        .quality = {0.0f, 0.0f, (float)view->ball_near, (float)view->ball_far},
        .modes = {view->orthographic, 0, 0, 0},
    };
    double x = stp_view_axis_x(view), y = stp_view_axis_y(view);
    const double sides[4] = {x, view->width - x, y, view->height - y};
    for (int i = 0; i < 4; i++) {
        double length = sqrt(view->f * view->f + sides[i] * sides[i]);
        frame.frustum[i / 2][2 * (i % 2)] = (float)(view->f / length);
        frame.frustum[i / 2][2 * (i % 2) + 1] = (float)(sides[i] / length);
    }
    set_axis(frame.axis_right, view->right, view->back.x);
    set_axis(frame.axis_up, view->up, view->back.y);
    set_axis(frame.axis_back, view->back, view->back.z);
    return frame;
}

void stp_gpu_frame_exaggerate(stp_gpu_frame *frame, double times)
{
    float *const axes[3] = {frame->axis_right, frame->axis_up, frame->axis_back};
    const stp_dvec3 back =
        stp_dvec3_normalize((stp_dvec3){(double)frame->axis_right[3], (double)frame->axis_up[3],
                                        (double)frame->axis_back[3] / times});
    for (int i = 0; i < 3; i++)
        axes[i][2] = (float)((double)axes[i][2] * times);
    axes[0][3] = (float)back.x;
    axes[1][3] = (float)back.y;
    axes[2][3] = (float)back.z;
    frame->centre[2] = (float)times;
    frame->centre[3] = (float)(1.0 / (times * times));
}

static bool is_exaggerated(const stp_gpu_frame *frame)
{
    return frame->centre[3] != 1.0f;
}

/* Where an orthographic view looks from, in the world. */
static void back_of(const stp_gpu_frame *frame, float out[3])
{
    out[0] = frame->axis_right[3];
    out[1] = frame->axis_up[3];
    out[2] = frame->axis_back[3];
}

static void to_eye(const stp_gpu_frame *frame, const float world[3], float out[3])
{
    out[0] = dot3(frame->axis_right, world);
    out[1] = dot3(frame->axis_up, world);
    out[2] = dot3(frame->axis_back, world);
}

static bool outside_frustum(const stp_gpu_frame *frame, const float centre[3], float radius)
{
    float depth = -centre[2];
    if (depth + radius <= frame->viewport[3])
        return true;
    for (int i = 0; i < 2; i++) {
        const float *planes = frame->frustum[i];
        float low = frame->centre[i], high = frame->viewport[i] - low, f = frame->viewport[2];
        bool flat = frame->modes[0] != 0;
        if ((flat ? -centre[i] - low / f : -centre[i] * planes[0] - depth * planes[1]) > radius ||
            (flat ? centre[i] - high / f : centre[i] * planes[2] - depth * planes[3]) > radius)
            return true;
    }
    return false;
}

/* How the eye sees a bound. */
typedef struct aspect {
    float range, sin_beta, cos_phi;
} aspect;

static aspect aspect_of(const stp_gpu_frame *frame, const stp_rule_bound *bound)
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
static bool faces_away(const stp_gpu_frame *frame, const stp_rule_bound *bound)
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
    return bound->cone_cos > 0.0f && along > 0.0f && cos2 * tangent2 > (1.0f - cos2) * r2 &&
           along * along > (1.0f - cos2) * tangent2;
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

/* Whether all samples in the bound are left out as hidden backs: every normal turns away so far
 * that no sample can be at an outline. */
static bool is_culled(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    bool known = frame->modes[1] & STP_SAMPLE_CLOSED ? bound->closed : !bound->two_sided;
    if (frame->modes[1] == 0 || frame->modes[1] & STP_BACKS_DRAWN || !known ||
        !faces_away(frame, bound))
        return false;
    stp_rule_bound wide = *bound;
    float sine = sqrtf(fmaxf(0.0f, 1.0f - bound->cone_cos * bound->cone_cos));
    wide.cone_cos = bound->cone_cos * CULL_SINE - sine * CULL_COSINE;
    return faces_away(frame, &wide) &&
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

stp_rule_sight stp_rule_look(const stp_gpu_frame *frame, const stp_rule_bound *bound)
{
    aspect a = aspect_of(frame, bound);
    float sin_alpha = stp_rule_sin_alpha(a.cos_phi, bound->cone_cos, a.sin_beta);
    float stretch = stp_frame_stretch(frame); /* errors and radii are drawn as much longer */
    return (stp_rule_sight){
        stretch * stp_rule_scale(-dot3(frame->axis_back, bound->centre), a.range,
                                 bound->radius * stretch, frame->viewport[2], frame->viewport[3],
                                 frame->modes[0] != 0),
        sin_alpha,
        stp_rule_is_silhouette(sin_alpha) ? frame->terms[1] : 1.0f,
    };
}

stp_ball stp_block_ball(const stp_block *b, stp_dvec3 origin, stp_dvec3 eye)
{
    vec3s half = glms_vec3_scale(glms_vec3_sub(b->box_max, b->box_min), 0.5f);
    stp_dvec3 centre = stp_dvec3_from_float(glms_vec3_add(b->box_min, half));
    return (stp_ball){
        .centre = stp_dvec3_sub(stp_dvec3_add(origin, centre), eye),
        .radius = (double)(glms_vec3_norm(half) * 1.000001f),
    };
}

static stp_rule_bound bound_of(const stp_mirror_patch *patch)
{
    stp_rule_bound bound = {.radius = patch->bound_radius,
                            .cone_cos = patch->cone_cos,
                            .two_sided = (patch->flags & STP_PATCH_TWO_SIDED) != 0,
                            .closed = (patch->flags & STP_PATCH_CLOSED) != 0};
    for (int i = 0; i < 3; i++) {
        bound.centre[i] = patch->bound_centre[i];
        bound.cone_axis[i] = patch->cone_axis[i];
    }
    return bound;
}

/* How much the colours vary that a level's samples average, 0 to 1. */
static float variation_of(const stp_mirror_patch *patch, int level)
{
    return (float)patch->colour_error[level] / 255.0f;
}

stp_patch_brief stp_patch_brief_of(const stp_scene *scene, uint32_t chunk,
                                   const stp_mirror_patch *patch, const stp_patch *stored)
{
    uint16_t first_below = 0;
    uint32_t block = stp_scene_block_below(scene, chunk, stored, &first_below);
    return (stp_patch_brief){
        .bound = bound_of(patch),
        .vertex_error = {patch->vertex_error[0], patch->vertex_error[1]},
        .vertex_radius = patch->radius[STP_LEVEL_COUNT - 1],
        .vertex_variation = variation_of(patch, STP_LEVEL_COUNT - 1),
        .block = block,
        .first_below = first_below,
        .below_count = stored->counts[0],
        .shape = patch->flags & STP_PATCH_SHAPES,
    };
}

static stp_rule_bound bound_from_eye(stp_rule_bound bound, const stp_gpu_chunk *chunk)
{
    for (int i = 0; i < 3; i++)
        bound.centre[i] += chunk->offset[i];
    return bound;
}

stp_rule_bound stp_patch_bound(const stp_patch_brief *brief, const stp_gpu_chunk *chunk)
{
    return bound_from_eye(brief->bound, chunk);
}

static stp_rule_sight look_at_patch(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                                    const stp_mirror_patch *patch)
{
    stp_rule_bound bound = bound_from_eye(bound_of(patch), chunk);
    return stp_rule_look(frame, &bound);
}

bool stp_patch_visible(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                       const stp_mirror_patch *patch)
{
    const stp_rule_bound bound = bound_from_eye(bound_of(patch), chunk);
    float eye[3];
    return stp_rule_visible(frame, &bound, eye);
}

/* The perpendicular and the tangential error. */
static void errors_of(const stp_mirror_patch *patch, int level, int quarter, float out[2])
{
    for (int kind = 0; kind < 2; kind++)
        out[kind] = level == 0   ? patch->finest_error[kind]
                    : level == 3 ? patch->vertex_error[kind]
                                 : patch->quarter_error[2 - level][kind][quarter];
}

static bool is_small(const stp_gpu_frame *frame, const stp_rule_sight *sight, const float error[2],
                     float radius, float variation)
{
    return stp_rule_fits(stp_rule_error(sight->scale, sight->sin_alpha, error[0], error[1]),
                         sight->scale * radius, variation, sight->error_weight, frame->terms[0],
                         frame->quality[0], frame->quality[1]);
}

static bool fits(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                 const stp_mirror_patch *patch, int level, int quarter)
{
    float error[2];
    errors_of(patch, level, quarter, error);
    return is_small(frame, sight, error, patch->radius[level], variation_of(patch, level));
}

static bool must_refine(const stp_gpu_frame *frame, const stp_rule_sight *sight)
{
    return frame->quality[0] <= 0.0f || sight->scale < 0.0f;
}

bool stp_vertex_does(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                     const stp_patch_brief *brief)
{
    return !must_refine(frame, sight) && is_small(frame, sight, brief->vertex_error,
                                                  brief->vertex_radius, brief->vertex_variation);
}

bool stp_finest_does(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                     const stp_mirror_patch *patch, int finest)
{
    bool does = !must_refine(frame, sight);
    for (int q = 0; q < STP_PATCH_QUARTERS && does; q++)
        does = fits(frame, sight, patch, finest, q); /* a missing quarter has no error */
    return does;
}

/* The levels that the rule asks for, not finer than `finest`. */
static stp_levels choose(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                         const stp_mirror_patch *patch, int finest)
{
    stp_levels out;
    for (int q = 0; q < STP_PATCH_QUARTERS; q++)
        out.of[q] = STP_LEVEL_SKIP;
    stp_rule_sight sight = look_at_patch(frame, chunk, patch);
    bool refine = must_refine(frame, &sight);
    if (!refine && fits(frame, &sight, patch, STP_LEVEL_COUNT - 1, 0)) {
        out.of[0] = 3;
        return out;
    }
    for (int q = 0; q < (finest > 2 ? 1 : patch->count[2]); q++) {
        int level = refine || finest > 2 ? finest : 2;
        while (level > finest && !fits(frame, &sight, patch, level, q))
            level--;
        out.of[q] = level;
    }
    return out;
}

stp_levels stp_levels_choose(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                             const stp_mirror_patch *patch)
{
    return choose(frame, chunk, patch, stp_level_resident(patch, (int)chunk->finest));
}

int stp_level_asked(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                    const stp_mirror_patch *patch, int finest)
{
    const stp_levels levels = choose(frame, chunk, patch, finest);
    int asked = STP_LEVEL_COUNT - 1;
    for (int q = 0; q < STP_PATCH_QUARTERS; q++)
        if (levels.of[q] != STP_LEVEL_SKIP && levels.of[q] < asked)
            asked = levels.of[q];
    return asked;
}

unsigned stp_levels_select(const stp_mirror_patch *patch, const stp_levels *levels,
                           stp_range out[STP_PATCH_QUARTERS])
{
    unsigned count = 0;
    for (unsigned q = 0; q < STP_PATCH_QUARTERS && levels->of[q] != STP_LEVEL_SKIP; q++) {
        int level = levels->of[q];
        uint32_t begin = stp_quarter_begin(patch->count, level, q);
        uint32_t end = stp_quarter_begin(patch->count, level, q + 1);
        stp_range range = {stp_name_of(patch->number, level, begin), end - begin};
        if (count > 0 && out[count - 1].begin + out[count - 1].count == range.begin)
            out[count - 1].count += range.count;
        else
            out[count++] = range;
    }
    return count;
}

unsigned stp_levels_shape(const stp_mirror_patch *patch, const stp_levels *levels)
{
    int level = levels->of[0];
    if ((patch->flags & STP_PATCH_STRIP) && level >= 0 && patch->count[level] >= 2)
        return STP_PATCH_STRIP;
    return (patch->flags & STP_PATCH_TRIANGLES) && level == 0 ? STP_PATCH_TRIANGLES : 0;
}

float stp_level_error_px(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                         const stp_mirror_patch *patch, int level, int quarter)
{
    float error[2];
    stp_rule_sight sight = look_at_patch(frame, chunk, patch);
    if (sight.scale < 0.0f)
        return 0.0f;
    errors_of(patch, level, quarter, error);
    return stp_rule_error(sight.scale, sight.sin_alpha, error[0], error[1]);
}
