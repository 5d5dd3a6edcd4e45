/* Joins the directories of several models. */
#include "runtime/cut/scene.h"

#include "base/memory.h"

#include <stdlib.h>

static stp_status count_all(stp_scene *s, const stp_model *const *models, size_t count,
                            stp_error *err)
{
    uint64_t chunks = 0, blocks = 0;
    for (size_t i = 0; i < count; i++) {
        s->models[i] = (stp_scene_model){models[i], (uint32_t)chunks, (uint32_t)blocks};
        chunks += models[i]->info->chunk_count;
        blocks += models[i]->first_block[models[i]->info->chunk_count];
        if (chunks >= STP_CHUNK_NONE || blocks >= STP_BLOCK_NONE)
            return stp_error_set(
                err, STP_LIMIT,
                "%llu chunks of %llu blocks in one scene are too many: show fewer models",
                (unsigned long long)chunks, (unsigned long long)blocks);
    }
    s->chunk_count = (uint32_t)chunks;
    s->block_count = (uint32_t)blocks;
    return STP_OK;
}

/* Copies the directory of a model, renumbered for the scene. */
static void join(stp_scene *s, const stp_scene_model *m)
{
    const stp_model *model = m->model;
    uint32_t chunks = model->info->chunk_count;
    for (uint32_t i = 0; i < chunks; i++) {
        stp_chunk_entry *e = &s->joined_entries[m->first + i];
        *e = model->entries[i];
        e->parent += e->parent != STP_CHUNK_NONE ? m->first : 0;
        e->first_child += e->first_child != STP_CHUNK_NONE ? m->first : 0;
        s->joined_first[m->first + i] = m->first_block + model->first_block[i];
    }
    for (uint32_t i = 0; i < model->first_block[chunks]; i++) {
        s->joined_blocks[m->first_block + i] = model->blocks[i];
        s->joined_blocks[m->first_block + i].chunk += m->first;
    }
}

static stp_status join_all(stp_scene *s, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(
        stp_alloc(&s->joined_entries, s->chunk_count, sizeof *s->joined_entries, "chunks", err));
    STP_TRY(stp_alloc(&s->joined_blocks, s->block_count, sizeof *s->joined_blocks, "blocks", err));
    STP_TRY(
        stp_alloc(&s->joined_first, s->chunk_count + 1u, sizeof *s->joined_first, "chunks", err));
    for (size_t i = 0; i < s->model_count; i++)
        join(s, &s->models[i]);
    s->joined_first[s->chunk_count] = s->block_count;
    s->entries = s->joined_entries;
    s->blocks = s->joined_blocks;
    s->first_block = s->joined_first;
done:
    return status;
}

/* Marks chunks from the leaves up: a parent has a lesser number than its children. */
static void mark_undivided(stp_scene *s)
{
    for (uint32_t i = s->chunk_count; i-- > 0;) {
        uint32_t parent = s->entries[i].parent;
        if (parent == STP_CHUNK_NONE)
            continue;
        if (!(s->entries[parent].flags & STP_CHUNK_LINKED))
            s->undivided[i] = true;
        if (s->undivided[i])
            s->undivided[parent] = true;
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
    STP_TRY(count_all(&s, models, count, err));
    s.entries = models[0]->entries;
    s.blocks = models[0]->blocks;
    s.first_block = models[0]->first_block;
    if (count > 1)
        STP_TRY(join_all(&s, err));
    STP_TRY(stp_alloc(&s.undivided, s.chunk_count, sizeof *s.undivided, "chunks", err));
    mark_undivided(&s);
    *out = s;
    s = (stp_scene){0};
done:
    stp_scene_destroy(&s);
    return status;
}

void stp_scene_destroy(stp_scene *scene)
{
    free(scene->joined_entries);
    free(scene->joined_blocks);
    free(scene->joined_first);
    free(scene->undivided);
    *scene = (stp_scene){0};
}

const stp_scene_model *stp_scene_find(const stp_scene *scene, uint32_t chunk)
{
    size_t i = scene->model_count - 1;
    while (i > 0 && chunk < scene->models[i].first)
        i--;
    return &scene->models[i];
}

const stp_scene_model *stp_scene_find_block(const stp_scene *scene, uint32_t block,
                                            const stp_block **out)
{
    const stp_scene_model *m = stp_scene_find(scene, scene->blocks[block].chunk);
    *out = &m->model->blocks[block - m->first_block];
    return m;
}

const stp_chunk_entry *stp_scene_entry(const stp_scene *scene, uint32_t block)
{
    return &scene->entries[scene->blocks[block].chunk];
}

bool stp_scene_is_root(const stp_scene *scene, uint32_t block)
{
    return stp_scene_entry(scene, block)->parent == STP_CHUNK_NONE;
}

stp_scene_run stp_scene_blocks(const stp_scene *scene, uint32_t chunk)
{
    return (stp_scene_run){scene->first_block[chunk], scene->first_block[chunk + 1]};
}

stp_scene_run stp_scene_blocks_below(const stp_scene *scene, uint32_t chunk)
{
    const stp_chunk_entry *e = &scene->entries[chunk];
    if (e->child_count == 0)
        return (stp_scene_run){0, 0};
    return (stp_scene_run){scene->first_block[e->first_child],
                           scene->first_block[e->first_child + e->child_count]};
}

/* The last block of a run that begins at or before a patch of its chunk. */
static uint32_t find_patch(const stp_scene *scene, stp_scene_run run, uint32_t patch)
{
    while (run.end - run.begin > 1) {
        uint32_t middle = run.begin + (run.end - run.begin) / 2;
        if (scene->blocks[middle].first_patch <= patch)
            run.begin = middle;
        else
            run.end = middle;
    }
    return run.begin;
}

uint32_t stp_scene_block_below(const stp_scene *scene, uint32_t chunk, const stp_patch *patch,
                               uint16_t *first_below)
{
    const stp_chunk_entry *e = &scene->entries[chunk];
    *first_below = 0;
    if (patch->child >= e->child_count)
        return STP_BLOCK_NONE;
    stp_scene_run run = stp_scene_blocks(scene, e->first_child + patch->child);
    if (!(e->flags & STP_CHUNK_LINKED))
        return run.begin; /* drawn if and only if all blocks of the child are */
    uint32_t found = find_patch(scene, run, patch->first_below);
    const stp_block *b = &scene->blocks[found];
    uint32_t first = patch->first_below - b->first_patch;
    if (first + patch->counts[0] > b->patch_count)
        return STP_BLOCK_NONE;
    *first_below = (uint16_t)first;
    return found;
}

unsigned stp_scene_shapes(const stp_scene *scene)
{
    uint32_t attributes = 0;
    for (size_t i = 0; i < scene->model_count; i++)
        attributes |= scene->models[i].model->info->attributes;
    return (attributes & STP_HAS_LINES ? STP_PATCH_STRIP : 0u) |
           (attributes & STP_HAS_TRIANGLES ? STP_PATCH_TRIANGLES : 0u);
}

bool stp_scene_is_chosen(const stp_scene *scene)
{
    bool chosen = false;
    for (size_t i = 0; i < scene->model_count; i++)
        chosen |= scene->models[i].model->chosen != NULL;
    return chosen;
}

bool stp_scene_has_openings(const stp_scene *scene)
{
    for (size_t i = 0; i < scene->model_count; i++)
        if (scene->models[i].model->outside.opening_count > 0)
            return true;
    return false;
}

bool stp_scene_is_grid(const stp_scene *scene)
{
    bool grid = true;
    for (size_t i = 0; i < scene->model_count; i++)
        grid &= scene->models[i].model->is_grid;
    return grid;
}

bool stp_scene_holes_grow(const stp_scene *scene)
{
    bool grow = false, grids = true;
    for (size_t i = 0; i < scene->model_count; i++) {
        const stp_model *model = scene->models[i].model;
        grow |= model->holes_grow;
        grids &= model->is_grid || model->holes_grow;
    }
    return grow && grids;
}

stp_gpu_chunk stp_scene_record(const stp_scene *scene, uint32_t block, int finest, stp_dvec3 eye)
{
    const stp_chunk_entry *e = stp_scene_entry(scene, block);
    const stp_dvec3 offset = stp_dvec3_sub(e->origin, eye);
    return (stp_gpu_chunk){
        .offset = {(float)offset.x, (float)offset.y, (float)offset.z},
        .finest = (uint32_t)finest,
        .id = scene->blocks[block].chunk,
        .depth = e->depth,
        .order = block - stp_scene_find(scene, scene->blocks[block].chunk)->first_block,
    };
}
