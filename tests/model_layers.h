/* The patches of a model as the file has them, chunk by chunk: which of the parent's patches stands
 * for each, found by where samples and vertices lie, and the points under those of leaves. Failures
 * end the test. */
#ifndef STP_TESTS_MODEL_LAYERS_H
#define STP_TESTS_MODEL_LAYERS_H

#include "base/memory.h"
#include "runtime/level_choice.h"
#include "runtime/model.h"
#include "runtime/object_texture.h"
#include "tests/support/check.h"

typedef struct layer_vertex {
    double at[3]; /* world */
    uint32_t patch;
    bool taken;
} layer_vertex;

typedef struct model_layer {
    stp_patch_brief *briefs;
    uint32_t *above;        /* the parent's patch */
    layer_vertex *vertices; /* by place */
    stp_rule_bound *points; /* of a leaf, each with its normal; relative to its origin */
    uint32_t *first_point;  /* of each patch, and the end */
} model_layer;

static inline layer_vertex layer_vertex_of(const stp_sample *sample, const stp_patch *patch,
                                           stp_dvec3 origin, uint32_t index)
{
    stp_dvec3 p = stp_dvec3_add(origin, stp_sample_position(sample, patch));
    return (layer_vertex){.at = {p.x, p.y, p.z}, .patch = index};
}

static inline int layer_vertex_compare(const void *a, const void *b)
{
    const layer_vertex *x = a, *y = b;
    for (int i = 0; i < 3; i++)
        if (x->at[i] != y->at[i])
            return x->at[i] < y->at[i] ? -1 : 1;
    return 0;
}

static inline void layer_add_points(model_layer *out, const stp_chunk *chunk)
{
    const uint32_t *begin = chunk->level_begin[0];
    out->points = calloc(begin[chunk->patch_count], sizeof *out->points);
    out->first_point = calloc(chunk->patch_count + 1, sizeof *out->first_point);
    assert_true(out->points != NULL && out->first_point != NULL);
    memcpy(out->first_point, begin, (chunk->patch_count + 1) * sizeof *begin);
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = begin[p]; i < begin[p + 1]; i++) {
            stp_dvec3 at = stp_sample_position(&chunk->samples[0][i], &chunk->patches[p]);
            vec3s n = stp_normal_decode(chunk->samples[0][i].normal);
            out->points[i] =
                (stp_rule_bound){.centre = {(float)at.x, (float)at.y, (float)at.z},
                                 .cone_axis = {n.x, n.y, n.z},
                                 .cone_cos = 1.0f,
                                 .two_sided = (chunk->patches[p].flags & STP_PATCH_TWO_SIDED) != 0,
                                 .closed = (chunk->patches[p].flags & STP_PATCH_CLOSED) != 0};
        }
}

static inline void layer_fill(model_layer *out, const stp_chunk *chunk, const stp_chunk_entry *e)
{
    uint32_t count = chunk->patch_count;
    stp_gpu_patch *patches = calloc(count, sizeof *patches);
    *out = (model_layer){.briefs = calloc(count, sizeof *out->briefs),
                         .above = calloc(count, sizeof *out->above),
                         .vertices = calloc(count, sizeof *out->vertices)};
    assert_true(patches && out->briefs && out->above && out->vertices);
    stp_gpu_patches_fill(patches, chunk, &(stp_placement){0}, 0, STP_PATCH_SHAPES);
    for (uint32_t p = 0; p < count; p++) {
        out->briefs[p] = stp_patch_brief_of(&patches[p], &chunk->patches[p]);
        out->vertices[p] = layer_vertex_of(&chunk->samples[STP_LEVEL_COUNT - 1][p],
                                           &chunk->patches[p], e->origin, p);
    }
    qsort(out->vertices, count, sizeof *out->vertices, layer_vertex_compare);
    if (e->child_count == 0)
        layer_add_points(out, chunk);
    free(patches);
}

/* Takes the vertex at the place of a level-0 sample of the parent's patch; of equals the one that
 * the parent is linked to, if it is. */
static inline void layer_take(model_layer *child, uint32_t count, const layer_vertex *sample,
                              bool linked, uint32_t link)
{
    const layer_vertex *found =
        bsearch(sample, child->vertices, count, sizeof *sample, layer_vertex_compare);
    assert_non_null(found);
    layer_vertex *v = child->vertices + (found - child->vertices);
    while (v > child->vertices && layer_vertex_compare(v - 1, sample) == 0)
        v--;
    for (; v < child->vertices + count && layer_vertex_compare(v, sample) == 0; v++)
        if (!v->taken && (!linked || v->patch == link))
            break;
    assert_true(v < child->vertices + count && layer_vertex_compare(v, sample) == 0);
    v->taken = true;
    child->above[v->patch] = sample->patch;
}

static inline void layers_join(const stp_model *model, model_layer *layers, uint32_t id,
                               const stp_chunk *chunk)
{
    const stp_chunk_entry *e = &model->entries[id];
    for (uint32_t p = 0; e->child_count > 0 && p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        uint32_t child = e->first_child + patch->child, begin = chunk->level_begin[0][p];
        for (uint32_t i = 0; i < patch->counts[0]; i++) {
            layer_vertex sample =
                layer_vertex_of(&chunk->samples[0][begin + i], patch, e->origin, p);
            layer_take(&layers[child], model->entries[child].patch_count, &sample, chunk->linked,
                       patch->first_below + i);
        }
    }
}

/* By chunk; free with model_layers_free. */
static inline model_layer *model_layers_load(const stp_model *model)
{
    model_layer *layers = NULL;
    check_ok(stp_alloc(&layers, model->info->chunk_count, sizeof *layers, "layers", err));
    for (uint32_t id = model->info->chunk_count; id-- > 0;) { /* children have higher numbers */
        stp_chunk *chunk = NULL;
        check_ok(stp_chunk_file_read(model->file, id, 0, &chunk, err));
        layer_fill(&layers[id], chunk, &model->entries[id]);
        layers_join(model, layers, id, chunk);
        stp_chunk_destroy(&chunk);
    }
    return layers;
}

static inline void model_layers_free(const stp_model *model, model_layer *layers)
{
    for (uint32_t id = 0; id < model->info->chunk_count; id++) {
        free(layers[id].briefs);
        free(layers[id].above);
        free(layers[id].vertices);
        free(layers[id].points);
        free(layers[id].first_point);
    }
    free(layers);
}

#endif
