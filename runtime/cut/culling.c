/* Decides whether backs are hidden from this eye. */
#include "runtime/cut/culling.h"

#include "runtime/cut/level_choice.h"
#include "runtime/cut/model.h"
#include "runtime/draw/filter.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static double depth_of(const stp_view *view, stp_dvec3 position)
{
    return -stp_dvec3_dot(view->back, stp_dvec3_sub(position, view->eye));
}

/* Whether the near plane, the view's or a host's, may cut the model open. */
static bool may_cut(const stp_view *view, const stp_ball *ball)
{
    double nearest = depth_of(view, ball->centre) - ball->radius;
    if (view->ndc[1] == 0.0)
        return view->orthographic && nearest <= view->near_depth;
    if (nearest <= view->near_depth)
        return true;
    double z = view->orthographic ? view->ndc[0] + view->ndc[1] * nearest
                                  : view->ndc[0] + view->ndc[1] / nearest;
    return !(fabs(z) <= 1.0);
}

/* Whether the picture shows the model's closed surfaces only from outside. */
static bool is_outside(const stp_view *view, const stp_draw_params *params, const stp_model *model)
{
    const stp_ball ball = stp_exaggerated_ball(params, &model->ball);
    /* the near plane reaches farther in the world as it is, if that is drawn smaller */
    const double longer = params->exaggerate > 0.0 ? fmax(1.0, 1.0 / params->exaggerate) : 1.0;
    if (may_cut(view, &ball))
        return false;
    if (view->orthographic)
        return true;
    double width = view->width + 2.0 * fabs(view->offset[0]);
    double height = view->height + 2.0 * fabs(view->offset[1]);
    double corner = sqrt(1.0 + (width * width + height * height) / (4.0 * view->f * view->f));
    return stp_outside_holds(&model->outside, stp_unexaggerated(params, view->eye),
                             longer * corner * view->near_depth);
}

/* Adds the openings of a model; false if there is no room for them. */
static bool add_openings(stp_gpu_frame *frame, const stp_outside *outside, stp_dvec3 eye)
{
    if ((uint32_t)frame->modes[3] + outside->opening_count > STP_OPENINGS_LIMIT)
        return false;
    for (uint32_t i = 0; i < outside->opening_count; i++) {
        const stp_opening *o = &outside->openings[i];
        stp_dvec3 at = stp_dvec3_sub(o->centre, eye);
        float *out = frame->openings[frame->modes[3]++];
        out[0] = (float)at.x;
        out[1] = (float)at.y;
        out[2] = (float)at.z;
        out[3] = (float)(o->radius * (1.0 + 1e-5) + 1e-6 * stp_dvec3_length(at));
    }
    return true;
}

/* Whether the backs of closed surfaces are hidden from the eye, except behind the openings
 * added. */
static bool are_hidden(stp_gpu_frame *frame, const stp_draw_params *params, const stp_view *view,
                       const stp_scene *scene)
{
    if (params->clip.enabled || params->plane_count > 0 || stp_filter_hides_classes(params) ||
        stp_scene_is_chosen(scene))
        return false;
    for (size_t i = 0; i < scene->model_count; i++) {
        const stp_model *model = scene->models[i].model;
        if (params->hidden_models >> i & 1 || model->outside.point_count == 0)
            continue;
        /* Nothing lies over an edge between maps. If one side is left out, the triangles at the
         * edge are seen from behind, and normals tell too little of them. */
        if (model->is_filled)
            return false;
        if (!is_outside(view, params, model) ||
            !add_openings(frame, &model->outside, stp_unexaggerated(params, view->eye)))
            return false;
    }
    return true;
}

/* Whether the picture shows grids of heights from above. Under the lowest height the eye sees none
 * but their backs. */
static bool is_over_grids(const stp_draw_params *params, const stp_view *view,
                          const stp_scene *scene)
{
    const stp_dvec3 eye = stp_unexaggerated(params, view->eye);
    bool over = scene->model_count > 0 && stp_scene_is_grid(scene);
    for (size_t i = 0; i < scene->model_count; i++)
        over &= view->orthographic ? view->back.z > 0.0
                                   : eye.z > scene->models[i].model->info->box.min.z;
    return over;
}

void stp_culling_place(stp_gpu_frame *frame, const stp_draw_params *params, const stp_view *view,
                       const stp_scene *scene)
{
    const int known = STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL;
    frame->modes[1] = frame->modes[3] = 0;
    if (params->cull == STP_CULL_BACK)
        frame->modes[1] = known;
    else if (is_over_grids(params, view, scene))
        frame->modes[1] = known | STP_BACKS_DRAWN;
    else if (are_hidden(frame, params, view, scene))
        frame->modes[1] = known | STP_SAMPLE_CLOSED;
    if (params->cull == STP_CULL_NONE && frame->modes[1] != 0) {
        frame->modes[1] |= STP_BACKS_DRAWN;
        frame->modes[3] = 0;
    }
}

const stp_gpu_frame *stp_culling_narrow(stp_gpu_frame *room, const stp_gpu_frame *frame,
                                        const stp_scene *scene, uint32_t block, stp_dvec3 eye,
                                        uint32_t set[STP_OPENING_WORDS])
{
    const stp_block *b = &scene->blocks[block];
    const stp_ball ball = stp_block_ball(b, stp_scene_entry(scene, block)->origin, eye);
    const stp_rule_bound bound = {
        .centre = {(float)ball.centre.x, (float)ball.centre.y, (float)ball.centre.z},
        .radius = (float)ball.radius * 1.001f, /* more than rounding takes */
        .cone_axis = {b->cone_axis.x, b->cone_axis.y, b->cone_axis.z},
        .cone_cos = b->cone_angle >= 3.14159f ? -1.0f : cosf(b->cone_angle),
    };
    if (set != NULL)
        memset(set, 0, STP_OPENING_WORDS * sizeof *set);
    if (frame->modes[3] == 0)
        return frame;
    memcpy(room, frame, offsetof(stp_gpu_frame, openings));
    room->modes[3] = 0;
    if (stp_rule_faces_eye(frame, &bound)) /* then no opening shows a back */
        return room;
    for (int i = stp_opening_next(frame, 0, bound.centre, bound.radius); i < frame->modes[3];
         i = stp_opening_next(frame, i + 1, bound.centre, bound.radius)) {
        if (set != NULL)
            set[i / 32] |= UINT32_C(1) << i % 32;
        memcpy(room->openings[room->modes[3]++], frame->openings[i], sizeof *room->openings);
    }
    return room;
}
