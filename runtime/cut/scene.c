/* Joins the chunk directories of several models. */
#include "runtime/cut/scene.h"

#include "base/memory.h"

#include <stdlib.h>

static stp_status count_chunks(const stp_model *const *models, size_t count, uint32_t *out,
                               stp_error *err)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += models[i]->info->chunk_count;
    if (sum >= STP_CHUNK_NONE)
        return stp_error_set(err, STP_LIMIT,
                             "%llu chunks in one scene are too many: show fewer models",
                             (unsigned long long)sum);
    *out = (uint32_t)sum;
    return STP_OK;
}

/* Copies the entries of a model, with links renumbered for the scene. */
static void join(stp_chunk_entry *out, const stp_scene_model *m)
{
    for (uint32_t i = 0; i < m->model->info->chunk_count; i++) {
        out[i] = m->model->entries[i];
        out[i].parent += out[i].parent != STP_CHUNK_NONE ? m->first : 0;
        out[i].first_child += out[i].first_child != STP_CHUNK_NONE ? m->first : 0;
    }
}

stp_status stp_scene_create(stp_scene *out, const stp_model *const *models, size_t count,
                            stp_error *err)
{
    stp_status status = STP_OK;
    stp_scene s = {.model_count = count};
    if (count < 1 || count > STP_SCENE_MODELS_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%zu models in one scene: give 1 to %d",
                             count, STP_SCENE_MODELS_LIMIT);
    STP_TRY(count_chunks(models, count, &s.chunk_count, err));
    if (count > 1)
        STP_TRY(
            stp_alloc(&s.joined, s.chunk_count, sizeof *s.joined, "a directory of chunks", err));
    uint32_t first = 0;
    for (size_t i = 0; i < count; i++) {
        s.models[i] = (stp_scene_model){models[i], first};
        if (count > 1)
            join(s.joined + first, &s.models[i]);
        first += models[i]->info->chunk_count;
    }
    s.entries = count > 1 ? s.joined : models[0]->entries;
    *out = s;
done:
    return status;
}

void stp_scene_destroy(stp_scene *scene)
{
    free(scene->joined);
    *scene = (stp_scene){0};
}

const stp_scene_model *stp_scene_find(const stp_scene *scene, uint32_t chunk)
{
    size_t i = scene->model_count - 1;
    while (i > 0 && chunk < scene->models[i].first)
        i--;
    return &scene->models[i];
}

unsigned stp_scene_shapes(const stp_scene *scene)
{
    uint32_t attributes = 0;
    for (size_t i = 0; i < scene->model_count; i++)
        attributes |= scene->models[i].model->info->attributes;
    return (attributes & STP_HAS_LINES ? STP_PATCH_STRIP : 0u) |
           (attributes & STP_HAS_TRIANGLES ? STP_PATCH_TRIANGLES : 0u);
}

bool stp_scene_has_openings(const stp_scene *scene)
{
    for (size_t i = 0; i < scene->model_count; i++)
        if (scene->models[i].model->outside.opening_count > 0)
            return true;
    return false;
}
