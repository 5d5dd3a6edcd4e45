/* Reads pictures, depths and normals from the renderer, turns them upside down and writes them. */
#include "tools/draw/draw_save.h"

#include "base/memory.h"
#include "formats/image/image.h"
#include "runtime/camera/camera_json.h"
#include "tools/draw/draw_beside.h"
#include "tools/draw/draw_fine.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Reverses the order of the rows. */
static stp_status flip(void *pixels, size_t row_bytes, int height, stp_error *err)
{
    uint8_t *rows = pixels, *row = NULL;
    stp_status status = stp_alloc(&row, row_bytes, 1, "a row of a picture", err);
    if (status != STP_OK)
        return status;
    for (size_t low = 0, high = (size_t)height - 1; low < high; low++, high--) {
        memcpy(row, rows + low * row_bytes, row_bytes);
        memcpy(rows + low * row_bytes, rows + high * row_bytes, row_bytes);
        memcpy(rows + high * row_bytes, row, row_bytes);
    }
    free(row);
    return STP_OK;
}

stp_status draw_picture_draw(draw_picture *picture, stp_renderer *renderer, const stp_view *view,
                             const stp_draw_params *params, bool whole, stp_draw_stats *stats,
                             stp_error *err)
{
    stp_status status = STP_OK;
    int times = draw_aa_times(picture->aa);
    if (times > 1) {
        if (picture->fine == NULL)
            STP_TRY(stp_alloc(&picture->fine, (size_t)view->width * (size_t)view->height, 4,
                              "a picture", err));
        STP_TRY(draw_fine(renderer, view, params, times, picture->fine, stats, err));
    }
    if (times == 1 || whole)
        STP_TRY(stp_renderer_draw(renderer, view, params, times > 1 ? NULL : stats, err));
done:
    return status;
}

stp_status draw_picture_read(const draw_picture *picture, stp_renderer *renderer,
                             const stp_view *view, uint8_t *rgba, stp_error *err)
{
    stp_status status = STP_OK;
    if (picture->fine != NULL)
        memcpy(rgba, picture->fine, (size_t)view->width * (size_t)view->height * 4);
    else
        STP_TRY(stp_renderer_read(renderer, rgba, err));
    STP_TRY(flip(rgba, (size_t)view->width * 4, view->height, err));
    if (picture->right != NULL)
        draw_beside_put(rgba, picture->right, view->width, view->height);
done:
    return status;
}

static stp_status save_picture(const draw_picture *picture, stp_renderer *renderer,
                               const stp_view *view, const char *path, bool force, stp_error *err)
{
    stp_status status = STP_OK;
    stp_image image = {view->width, view->height, NULL};
    STP_TRY(
        stp_alloc(&image.rgba, (size_t)view->width * (size_t)view->height, 4, "a picture", err));
    STP_TRY(draw_picture_read(picture, renderer, view, image.rgba, err));
    draw_straighten(&image);
    STP_TRY(stp_image_save(&image, path, force, err));
done:
    stp_image_destroy(&image);
    return status;
}

/* The text that --camera reads, with the picture's size; the caller frees it. NULL if memory is
 * exhausted. */
static char *camera_text(const stp_camera *camera, const stp_view *view)
{
    const int size[2] = {view->width, view->height};
    cJSON *json = cJSON_CreateObject();
    stp_camera_write(camera, json);
    cJSON_AddItemToObject(json, "size", cJSON_CreateIntArray(size, 2));
    char *text = json != NULL ? cJSON_PrintUnformatted(json) : NULL;
    cJSON_Delete(json);
    return text;
}

static stp_status save_floats(const stp_view *view, const stp_camera *camera, float *values,
                              stp_float_image image, const char *meaning, const char *path,
                              bool force, stp_error *err)
{
    char *text = camera_text(camera, view);
    const stp_image_note notes[2] = {{"stipple:camera", text}, {"stipple:values", meaning}};
    stp_status status = STP_OK;
    if (text == NULL)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for %s", path);
    STP_TRY(flip(values, (size_t)view->width * (size_t)image.channel_count * 4, view->height, err));
    image.width = view->width;
    image.height = view->height;
    image.values = values;
    image.notes = notes;
    image.note_count = 2;
    STP_TRY(stp_image_save_floats(&image, path, force, err));
done:
    free(text);
    return status;
}

static stp_status save_depth(stp_renderer *renderer, const stp_view *view, const stp_camera *camera,
                             const char *path, bool force, stp_error *err)
{
    stp_status status = STP_OK;
    size_t count = (size_t)view->width * (size_t)view->height;
    stp_float_image image = {.channel_count = 1, .channel_names = {"Z"}};
    float *depth = NULL;
    STP_TRY(stp_alloc(&depth, count, sizeof *depth, "depths", err));
    STP_TRY(stp_renderer_read_depth(renderer, depth, err));
    for (size_t i = 0; i < count; i++)
        depth[i] = depth[i] > 0.0f ? depth[i] : INFINITY;
    STP_TRY(save_floats(view, camera, depth, image,
                        "depth along the camera's axis in world units, inf where nothing is", path,
                        force, err));
done:
    free(depth);
    return status;
}

static stp_status save_normals(stp_renderer *renderer, const stp_view *view,
                               const stp_camera *camera, const char *path, bool force,
                               stp_error *err)
{
    stp_status status = STP_OK;
    stp_float_image image = {.channel_count = 3, .channel_names = {"N.X", "N.Y", "N.Z"}};
    float *xyz = NULL;
    STP_TRY(stp_alloc(&xyz, (size_t)view->width * (size_t)view->height, 3 * sizeof *xyz, "normals",
                      err));
    STP_TRY(stp_renderer_read_normals(renderer, xyz, err));
    STP_TRY(save_floats(view, camera, xyz, image,
                        "unit normals in the world's axes, 0 0 0 where nothing is", path, force,
                        err));
done:
    free(xyz);
    return status;
}

stp_status draw_save(const draw_picture *picture, stp_renderer *renderer, const stp_view *view,
                     const stp_camera *camera, const draw_outputs *outputs, bool force,
                     stp_error *err)
{
    stp_status status = STP_OK;
    if (outputs->depth != NULL)
        STP_TRY(save_depth(renderer, view, camera, outputs->depth, force, err));
    if (outputs->normals != NULL)
        STP_TRY(save_normals(renderer, view, camera, outputs->normals, force, err));
    if (outputs->picture != NULL)
        STP_TRY(save_picture(picture, renderer, view, outputs->picture, force, err));
done:
    return status;
}
