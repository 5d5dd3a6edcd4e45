/* Chooses the levels of a patch on the CPU, by the rules of shaders/project/choose.glsl. */
#include "runtime/cut/level_choice.h"

#include "runtime/cut/level_rule.h"

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

static bool vertex_is_greatest(const stp_mirror_patch *patch)
{
    bool greatest = true;
    for (int l = 0; l < STP_LEVEL_COUNT - 1; l++)
        greatest = greatest && patch->radius[l] <= patch->radius[STP_LEVEL_COUNT - 1];
    return greatest;
}

/* A number that is not negative, rounded up to the upper half of a float. */
static uint16_t upper_half(float number)
{
    uint32_t bits;
    memcpy(&bits, &number, sizeof bits);
    return (uint16_t)((bits + 0xffffu) >> 16);
}

/* Tells what level 2 of a patch is at most. */
static void tell_quarters(stp_patch_brief *out, const stp_mirror_patch *patch)
{
    float error[2] = {0.0f, 0.0f};
    unsigned radius = 0;
    while (radius <= UINT8_MAX &&
           out->vertex_radius * ((float)radius * STP_BRIEF_RADIUS) < patch->radius[2])
        radius++;
    for (int kind = 0; kind < 2; kind++)
        for (int q = 0; q < STP_PATCH_QUARTERS; q++)
            error[kind] = fmaxf(error[kind], patch->quarter_error[0][kind][q]);
    out->quarter_error[0] = upper_half(radius <= UINT8_MAX ? error[0] : INFINITY);
    out->quarter_error[1] = upper_half(error[1]);
    out->quarter_radius = (uint8_t)radius;
}

stp_patch_brief stp_patch_brief_of(const stp_scene *scene, uint32_t chunk,
                                   const stp_mirror_patch *patch, const stp_patch *stored)
{
    uint16_t first_below = 0;
    uint32_t block = stp_scene_block_below(scene, chunk, stored, &first_below);
    stp_patch_brief brief = {
        .bound = bound_of(patch),
        .vertex_error = {patch->vertex_error[0], patch->vertex_error[1]},
        .vertex_radius = patch->radius[STP_LEVEL_COUNT - 1],
        .block = block,
        .first_below = first_below,
        .colour_error = {patch->colour_error[3], patch->colour_error[2]},
        .below_count = stored->counts[0],
        .shape = patch->flags & STP_PATCH_SHAPES & 7u,
        .finest = patch->finest & 3u,
        .has_spots = patch->spots != 0,
        .vertex_greatest = vertex_is_greatest(patch),
    };
    tell_quarters(&brief, patch);
    return brief;
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

bool stp_levels_do(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                   const stp_mirror_patch *patch, int finest)
{
    bool all = !must_refine(frame, sight);
    for (int q = 0; q < STP_PATCH_QUARTERS && all; q++) { /* a missing quarter has no error */
        bool any = false;
        for (int l = finest; l < STP_LEVEL_COUNT && !any; l++)
            any = fits(frame, sight, patch, l, q);
        all = any;
    }
    return all;
}

/* The levels that the rule asks for, not finer than `finest`. */
static stp_levels choose(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                         const stp_mirror_patch *patch, int finest)
{
    stp_levels out;
    for (int q = 0; q < STP_PATCH_QUARTERS; q++)
        out.of[q] = STP_LEVEL_SKIP;
    bool refine = must_refine(frame, sight);
    if (!refine && fits(frame, sight, patch, STP_LEVEL_COUNT - 1, 0)) {
        out.of[0] = 3;
        return out;
    }
    for (int q = 0; q < (finest > 2 ? 1 : patch->count[2]); q++) {
        int level = refine || finest > 2 ? finest : 2;
        while (level > finest && !fits(frame, sight, patch, level, q))
            level--;
        out.of[q] = level;
    }
    return out;
}

stp_levels stp_levels_choose(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                             const stp_mirror_patch *patch)
{
    const stp_rule_sight sight = look_at_patch(frame, chunk, patch);
    return choose(frame, &sight, patch, stp_level_resident(patch, (int)chunk->finest));
}

int stp_level_asked_seen(const stp_gpu_frame *frame, const stp_rule_sight *sight,
                         const stp_mirror_patch *patch, int finest)
{
    const stp_levels levels = choose(frame, sight, patch, finest);
    int asked = STP_LEVEL_COUNT - 1;
    for (int q = 0; q < STP_PATCH_QUARTERS; q++)
        if (levels.of[q] != STP_LEVEL_SKIP && levels.of[q] < asked)
            asked = levels.of[q];
    return asked;
}

int stp_level_asked(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                    const stp_mirror_patch *patch, int finest)
{
    const stp_rule_sight sight = look_at_patch(frame, chunk, patch);
    return stp_level_asked_seen(frame, &sight, patch, finest);
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
