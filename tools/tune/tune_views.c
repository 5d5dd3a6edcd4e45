/* Makes views around a model and along a path. */
#include "tools/tune/tune_views.h"

#include "base/memory.h"
#include "base/vec.h"
#include "runtime/camera/path.h"

#include <stdio.h>
#include <stdlib.h>

#define DIRECTIONS 26
#define DISTANCES 3
#define PATH_RATE 30.0

/* A coarse threshold is enough to find the surface. */
#define SEEK_THRESHOLD_PX 4.0

/* ---- around the model ---- */

/* The i-th of the 26 directions: the 27 places of a cube without the middle. */
static stp_dvec3 direction_of(int i)
{
    int place = i < DIRECTIONS / 2 ? i : i + 1;
    int x = place % 3, y = place / 3 % 3, z = place / 9;
    return (stp_dvec3){x - 1, y - 1, z - 1};
}

/* Finds the covered pixel nearest to the middle. False if no pixel is covered. */
static bool find_middle(const float *depth, int width, int height, int out[2])
{
    long best = -1;
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            long dx = 2 * x + 1 - width, dy = 2 * y + 1 - height, away = dx * dx + dy * dy;
            if (depth[(size_t)y * (size_t)width + (size_t)x] <= 0.0f || (best >= 0 && away >= best))
                continue;
            best = away;
            out[0] = x;
            out[1] = y;
        }
    return best >= 0;
}

/* Finds where the whole view shows the surface, and its depth along the axis. False if it shows
 * none. */
static stp_status find_surface(const tune_views_params *p, const stp_view *view, float *depth,
                               bool *found, stp_dvec3 *at, double *away, stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw_params drawn = p->drawn;
    int pixel[2];
    drawn.threshold_px = SEEK_THRESHOLD_PX;
    drawn.every_sample = false;
    drawn.reconstruct = STP_RECONSTRUCT_GAUSS;
    STP_TRY(stp_renderer_draw(p->renderer, view, &drawn, NULL, err));
    STP_TRY(stp_renderer_read_depth(p->renderer, depth, err));
    *found = find_middle(depth, view->width, view->height, pixel);
    if (!*found)
        return STP_OK;
    double z = (double)depth[(size_t)pixel[1] * (size_t)view->width + (size_t)pixel[0]];
    double x = (pixel[0] + 0.5 - stp_view_axis_x(view)) * z / view->f;
    double y = (pixel[1] + 0.5 - stp_view_axis_y(view)) * z / view->f;
    stp_dvec3 aside = stp_dvec3_add(stp_dvec3_scale(view->right, x), stp_dvec3_scale(view->up, y));
    *at = stp_dvec3_sub(stp_dvec3_add(view->eye, aside), stp_dvec3_scale(view->back, z));
    *away = z;
done:
    return status;
}

static stp_status add(tune_views *out, const tune_views_params *p, const stp_camera *camera,
                      stp_error *err)
{
    stp_status status = stp_view_create(&out->views[out->count], camera, &p->model->ball,
                                        p->size[0], p->size[1], err);
    if (status == STP_OK)
        out->list[out->count++].camera = *camera;
    return status;
}

static stp_status add_around(tune_views *out, const tune_views_params *p, int k, float *depth,
                             stp_error *err)
{
    static const char *const words[DISTANCES] = {"whole", "nearer", "near"};
    static const double shares[DISTANCES] = {1.0, 1.0 / 3.0, 1.0 / 9.0};
    stp_status status = STP_OK;
    /* 26 and 3 have no common factor, and 26 and 11 have none, so each pair comes once. */
    int distance = k % DISTANCES, number = (25 + 11 * k) % DIRECTIONS;
    stp_dvec3 direction = direction_of(number), at;
    const stp_dbox *box = &p->model->info->box;
    stp_camera camera = stp_camera_around(&p->model->ball, direction, stp_camera_up(box),
                                          STP_CAMERA_FOVY_DEG, p->size[0], p->size[1]);
    stp_view view;
    double away;
    bool found;
    STP_TRY(stp_view_create(&view, &camera, &p->model->ball, p->size[0], p->size[1], err));
    STP_TRY(find_surface(p, &view, depth, &found, &at, &away, err));
    if (!found)
        return STP_OK;
    if (distance > 0) {
        camera.look = at;
        camera.eye = stp_dvec3_add(at, stp_dvec3_scale(view.back, away * shares[distance]));
    }
    snprintf(out->list[out->count].name, sizeof out->list[0].name, "%s from %+.0f%+.0f%+.0f",
             words[distance], direction.x, direction.y, direction.z);
    STP_TRY(add(out, p, &camera, err));
done:
    return status;
}

/* ---- ways ---- */

/* Adds a dolly towards the point that a camera looks at. */
static stp_status add_dolly(tune_views *out, const tune_views_params *p, const stp_camera *from,
                            stp_error *err)
{
    stp_status status = STP_OK;
    for (int i = 0; i < TUNE_DOLLY_FRAMES; i++) {
        double share = 1.0 - (1.0 - TUNE_DOLLY_SHARE) * i / (TUNE_DOLLY_FRAMES - 1);
        stp_camera camera = *from;
        stp_dvec3 back = stp_dvec3_sub(from->eye, from->look);
        camera.eye = stp_dvec3_add(from->look, stp_dvec3_scale(back, share));
        camera.height *= share;
        STP_TRY(stp_view_create(&out->dollies[out->dolly_count][i], &camera, &p->model->ball,
                                p->size[0], p->size[1], err));
    }
    out->dolly_count++;
done:
    return status;
}

/* Takes views spread over the path's time, and three stretches of it frame by frame. */
static stp_status follow_path(tune_views *out, const tune_views_params *p, stp_error *err)
{
    stp_status status = STP_OK;
    stp_path *path = NULL;
    STP_TRY(stp_path_load(&path, p->path, p->camera, err));
    double begin = stp_path_begin_s(path), length = stp_path_duration_s(path);
    for (size_t i = 0; i < p->count; i++) {
        double time = begin + length * ((double)i + 0.5) / (double)p->count;
        stp_camera camera = stp_path_camera(path, time);
        snprintf(out->list[out->count].name, sizeof out->list[0].name, "path at %.2f s", time);
        STP_TRY(add(out, p, &camera, err));
    }
    for (; out->dolly_count < TUNE_DOLLIES; out->dolly_count++)
        for (int i = 0; i < TUNE_DOLLY_FRAMES; i++) {
            double time = begin + length * (double)out->dolly_count / TUNE_DOLLIES + i / PATH_RATE;
            stp_camera camera = stp_path_camera(path, time);
            STP_TRY(stp_view_create(&out->dollies[out->dolly_count][i], &camera, &p->model->ball,
                                    p->size[0], p->size[1], err));
        }
done:
    stp_path_destroy(&path);
    return status;
}

stp_status tune_views_create(tune_views *out, const tune_views_params *p, stp_error *err)
{
    stp_status status = STP_OK;
    float *depth = NULL;
    *out = (tune_views){0};
    if (p->path != NULL)
        return follow_path(out, p, err);
    if (p->camera != NULL) {
        snprintf(out->list[0].name, sizeof out->list[0].name, "camera");
        STP_TRY(add(out, p, p->camera, err));
    }
    STP_TRY(
        stp_alloc(&depth, (size_t)p->size[0] * (size_t)p->size[1], sizeof *depth, "depths", err));
    for (int k = 0; p->camera == NULL && k < TUNE_VIEWS_LIMIT && out->count < p->count; k++)
        STP_TRY(add_around(out, p, k, depth, err));
    for (size_t i = 0; i < out->count && i < TUNE_DOLLIES; i++)
        STP_TRY(add_dolly(out, p, &out->list[i].camera, err));
    if (out->count == 0)
        status = stp_error_set(err, STP_EMPTY,
                               "%s: nothing of the model is seen from any side: try --cull none, "
                               "or a view of yours with --eye and --look",
                               stp_chunk_file_path(p->model->file));
done:
    free(depth);
    return status;
}
