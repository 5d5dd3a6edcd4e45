/* Opens a chunk file and reads its whole directory into memory. */
#include "runtime/cut/model.h"

#include "base/memory.h"
#include "formats/chunk/convert.h"
#include "formats/chunk/verify/verify_tree.h"
#include "runtime/camera/camera_json.h"
#include "runtime/stream/chosen.h"
#include "runtime/stream/shown.h"

#include <stdlib.h>
#include <string.h>

/* A ball around the boxes of the leaves, which lie closer than the corners of the whole box. The
 * radius is at least the error of the leaves' samples, for models that are a single point. */
static stp_ball ball_around(const stp_model *model)
{
    stp_ball ball = stp_ball_from_box(&model->info->box);
    double radius = 0.0, error = 0.0;
    for (uint32_t id = 0; id < model->info->chunk_count; id++) {
        const stp_chunk_entry *e = &model->entries[id];
        for (int i = 0; e->child_count == 0 && i < 8; i++) {
            stp_dvec3 corner = {(double)(i & 1 ? e->box_max.x : e->box_min.x),
                                (double)(i & 2 ? e->box_max.y : e->box_min.y),
                                (double)(i & 4 ? e->box_max.z : e->box_min.z)};
            corner = stp_dvec3_sub(stp_dvec3_add(e->origin, corner), ball.centre);
            radius = fmax(radius, stp_dvec3_length(corner));
        }
        error = fmax(error, e->child_count == 0 ? (double)e->error[0] : 0.0);
    }
    if (radius > 0.0 && radius < ball.radius)
        ball.radius = radius;
    ball.radius = fmax(ball.radius, error);
    return ball;
}

/* Reads the up axis, the first view and whether this is a grid from the metadata; ignores values
 * that are not valid. */
static void read_view(stp_model *model)
{
    const stp_chunk_file_info *info = model->info;
    cJSON *metadata = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *json = cJSON_GetObjectItemCaseSensitive(metadata, "first_view");
    stp_camera camera = {0};
    stp_view view;
    double aspect = 1.0, up[3] = {0.0};
    model->has_first =
        cJSON_IsObject(json) && stp_camera_read(&camera, json, "first_view", NULL) == STP_OK &&
        stp_json_numbers(json, "aspect", &aspect, 1, "first_view", NULL) == STP_OK &&
        aspect > 0.0 && stp_view_create(&view, &camera, &model->ball, 1, 1, NULL) == STP_OK;
    if (cJSON_IsObject(metadata) && stp_json_numbers(metadata, "up", up, 3, "up", NULL) == STP_OK)
        model->up = stp_dvec3_normalize((stp_dvec3){up[0], up[1], up[2]});
    model->is_grid = cJSON_IsTrue(cJSON_GetObjectItemCaseSensitive(metadata, "grid"));
    const cJSON *holes = cJSON_GetObjectItemCaseSensitive(metadata, "holes");
    model->holes_grow = cJSON_IsString(holes) && strcmp(holes->valuestring, "grow") == 0;
    const cJSON *resampled = cJSON_GetObjectItemCaseSensitive(metadata, "resampled");
    model->is_maps = cJSON_IsObject(resampled);
    model->is_filled = cJSON_HasObjectItem(resampled, "between");
    model->first = camera;
    model->first_aspect = aspect;
    cJSON_Delete(metadata);
}

stp_camera stp_model_camera(const stp_model *model, stp_home home, int width, int height)
{
    bool whole = home == STP_HOME_WHOLE || !model->has_first;
    if (whole && stp_dvec3_length(model->up) > 0.0)
        return stp_camera_whole(&model->ball, model->up, width, height);
    if (whole)
        return stp_camera_default(&model->info->box, &model->ball, width, height);
    return stp_camera_widened(&model->first, model->first_aspect, width, height);
}

/* Reads the directory: chunks, and their blocks. */
static stp_status read_directory(stp_model *model, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t chunks = model->info->chunk_count, count = 0;
    STP_TRY(stp_alloc(&model->entries, chunks, sizeof *model->entries, "chunks", err));
    STP_TRY(stp_alloc(&model->first_block, chunks + 1u, sizeof *model->first_block, "chunks", err));
    for (uint32_t id = 0; id < chunks; id++) {
        uint32_t *first = &model->first_block[id];
        STP_TRY(stp_chunk_file_entry(model->file, id, &model->entries[id], err));
        STP_TRY(stp_chunk_file_block_count(model->file, id, &count, err));
        if (count >= STP_BLOCK_NONE - *first) {
            status = stp_error_set(err, STP_LIMIT, "%s: too many blocks to be drawn",
                                   stp_chunk_file_path(model->file));
            goto done;
        }
        first[1] = first[0] + count;
    }
    STP_TRY(stp_verify_tree_entries(model->file, model->entries, err));
    STP_TRY(stp_alloc(&model->blocks, model->first_block[chunks], sizeof *model->blocks, "blocks",
                      err));
    for (uint32_t id = 0; id < chunks; id++)
        STP_TRY(
            stp_chunk_file_blocks(model->file, id, model->blocks + model->first_block[id], err));
done:
    return status;
}

stp_status stp_model_open(stp_model **out, const char *path, stp_error *err)
{
    return stp_model_open_at(out, path, NULL, err);
}

stp_status stp_model_open_at(stp_model **out, const char *path,
                             const stp_byte_source_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_model *model = NULL;
    STP_TRY(stp_alloc(&model, 1, sizeof *model, "a model", err));
    STP_TRY(stp_chunk_file_open_at(&model->file, path, params, err));
    model->info = stp_chunk_file_get_info(model->file);
    STP_TRY(read_directory(model, err));
    model->ball = ball_around(model);
    STP_TRY(stp_outside_read(&model->outside, model->info->metadata_json,
                             model->info->metadata_bytes, err));
    read_view(model);
    *out = model;
    model = NULL;
done:
    stp_model_close(&model);
    return status;
}

void stp_model_close(stp_model **model)
{
    if (*model == NULL)
        return;
    stp_shown_destroy(&(*model)->shown);
    stp_chosen_destroy(&(*model)->chosen);
    stp_chunk_file_close(&(*model)->file);
    stp_outside_clear(&(*model)->outside);
    free((*model)->entries);
    free((*model)->blocks);
    free((*model)->first_block);
    free(*model);
    *model = NULL;
}

stp_status stp_model_show_attribute(stp_model *model, const char *name, double range[2],
                                    stp_error *err)
{
    stp_shown_destroy(&model->shown);
    return stp_shown_create(&model->shown, model->file, name, range, err);
}

stp_status stp_model_choose(stp_model *model, const char *condition, stp_error *err)
{
    stp_chosen_destroy(&model->chosen);
    return stp_chosen_create(&model->chosen, model->file, condition, err);
}

stp_ball stp_model_ball(const stp_model *model)
{
    return model->ball;
}

stp_dbox stp_model_box(const stp_model *model)
{
    return model->info->box;
}

uint64_t stp_model_point_count(const stp_model *model)
{
    return model->info->point_count;
}

stp_shade stp_model_shade(const stp_model *model)
{
    return stp_chunk_file_unlit(model->info) ? STP_SHADE_UNLIT : STP_SHADE_PHONG;
}
