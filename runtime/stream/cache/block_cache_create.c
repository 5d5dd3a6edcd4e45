/* Makes the block cache, with all of its memory, and loads the roots. */
#include "runtime/stream/cache/block_cache_parts.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* Lists the blocks of the root of each model. Free *out with free(). */
static stp_status list_roots(const stp_block_cache *c, stp_want **out, size_t *count,
                             stp_error *err)
{
    stp_status status = stp_alloc(out, c->scene->block_count, sizeof **out, "blocks", err);
    *count = 0;
    for (uint32_t b = 0; status == STP_OK && b < c->scene->block_count; b++)
        if (stp_scene_is_root(c->scene, b))
            (*out)[(*count)++] = (stp_want){b, 0};
    return status;
}

static stp_status load_roots(stp_block_cache *c, const stp_want *roots, size_t count,
                             stp_error *err)
{
    stp_cache_load load = {.wants = roots, .count = count, .stamp = 1};
    stp_status status = stp_block_cache_load(c, &load, err);
    if (status == STP_OK && load.damaged)
        status = stp_error_set(err, STP_CORRUPT, "%s", c->damage.words);
    if (status == STP_OK && load.there < load.count)
        status = stp_error_set(err, STP_LIMIT,
                               "%zu models do not fit in the GPU memory given: give a larger "
                               "--gpu-memory",
                               c->scene->model_count);
    return status;
}

static stp_status create_tables(stp_block_cache *c, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t count = c->scene->block_count, slots = c->budget.slot_capacity;
    STP_TRY(stp_alloc(&c->slot_of, count, sizeof *c->slot_of, "slots", err));
    memset(c->slot_of, 0xff, count * sizeof *c->slot_of);
    STP_TRY(stp_damage_log_create(&c->damage, count, err));
    STP_TRY(stp_alloc(&c->slots, slots, sizeof *c->slots, "slots", err));
    STP_TRY(stp_alloc(&c->wanted, count, sizeof *c->wanted, "slots", err));
    STP_TRY(stp_alloc(&c->victims.items, slots, sizeof *c->victims.items, "slots", err));
    STP_TRY(stp_alloc(&c->free_slots, slots, sizeof *c->free_slots, "slots", err));
    uint32_t most = 0;
    for (uint32_t b = 0; b < count; b++)
        most = c->scene->blocks[b].patch_count > most ? c->scene->blocks[b].patch_count : most;
    STP_TRY(stp_alloc(&c->levels, most, 1, "levels of patches", err));
    for (uint32_t s = 0; s < slots; s++) {
        c->slots[s].block = STP_BLOCK_NONE;
        c->free_slots[slots - 1 - s] = s;
    }
    c->free_count = slots;
    c->from.scene = c->scene;
done:
    return status;
}

stp_status stp_block_cache_create(stp_block_cache **out, const stp_block_cache_params *params,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    stp_block_cache *c = NULL;
    stp_want *roots = NULL;
    size_t root_count = 0;
    stp_budget b;
    const stp_budget_limits limits = {params->gpu_bytes, params->cpu_bytes,
                                      stp_object_texture_texels(), params->thread_count,
                                      params->software};
    STP_TRY(stp_budget_plan(&b, params->scene, &limits, err));
    STP_TRY(stp_alloc(&c, 1, sizeof *c, "a block cache", err));
    c->scene = params->scene;
    c->budget = b;
    c->views_follow = params->views_follow;
    STP_TRY(create_tables(c, err));
    STP_TRY(stp_stream_create(&c->stream,
                              &(stp_stream_params){.scene = params->scene,
                                                   .payload_bytes = b.payload_bytes,
                                                   .decoder_count = b.decoder_count,
                                                   .wake = params->wake,
                                                   .wake_context = params->wake_context},
                              err));
    /* Roots are read while GL makes its buffers. */
    STP_TRY(list_roots(c, &roots, &root_count, err));
    stp_stream_want(c->stream, roots, root_count);
    STP_TRY(stp_object_texture_create(&c->texture, b.texel_capacity, b.patch_capacity,
                                      b.slot_capacity, params->software, err));
    STP_TRY(stp_patch_store_create(&c->patches, b.patch_capacity, err));
    STP_TRY(stp_upload_ring_create(&c->ring, b.ring_bytes, params->software, err));
    STP_TRY(load_roots(c, roots, root_count, err));
    *out = c;
    c = NULL;
done:
    free(roots);
    stp_block_cache_destroy(&c);
    return status;
}

void stp_block_cache_destroy(stp_block_cache **cache)
{
    stp_block_cache *c = *cache;
    if (c == NULL)
        return;
    stp_stream_destroy(&c->stream); /* first, since decoders write into the ring */
    for (uint32_t s = 0; c->slots != NULL && s < c->texture.slot_capacity; s++)
        stp_mirror_clear(&c->slots[s].mirror);
    stp_upload_ring_destroy(&c->ring);
    stp_object_texture_destroy(&c->texture);
    stp_patch_store_destroy(&c->patches);
    free(c->slots);
    free(c->free_slots);
    free(c->slot_of);
    stp_damage_log_destroy(&c->damage);
    free(c->wants);
    free(c->wanted);
    free(c->levels);
    free(c->victims.items);
    free(c);
    *cache = NULL;
}
