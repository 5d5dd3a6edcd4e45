/* Keeps blocks in the Object Texture. */
#include "runtime/stream/block_cache.h"

#include "base/memory.h"
#include "runtime/cut/need.h"
#include "runtime/gl/gl_context.h"
#include "runtime/stream/damage_log.h"
#include "runtime/stream/patch_levels.h"
#include "runtime/stream/rest.h"
#include "runtime/stream/upload_ring.h"
#include "runtime/stream/victims.h"

#include <stdlib.h>
#include <string.h>

/* After so many frames without use, the need of a block counts half. */
#define AGE_FRAMES 120.0f

struct stp_block_cache {
    const stp_scene *scene;
    stp_budget budget;
    stp_stream *stream;
    stp_upload_ring ring;
    stp_object_texture texture;
    stp_resident *slots;
    uint32_t *free_slots; /* stack */
    uint32_t free_count;
    uint32_t *slot_of; /* by block */
    stp_damage_log damage;
    stp_patch_look from; /* need is measured from this view */
    bool views_follow;
    uint32_t damage_seen;   /* blocks that were damaged when it began */
    stp_victims victims;    /* as of victims_stamp and this view; some may no longer have to go */
    uint64_t victims_stamp; /* 0: there is no list */
    uint64_t gpu_used;      /* bytes of the Object Texture */
    stp_want *wants;
    size_t want_count, want_capacity, ahead;
    bool *wanted;       /* by block: it is one of wants[0..ahead) */
    bool refused;       /* a want found no room; wants are not asked for again */
    bool ahead_refused; /* the same for blocks that will be wanted soon */
    stp_rest rest;
};

const stp_object_texture *stp_block_cache_texture(const stp_block_cache *cache)
{
    return &cache->texture;
}

const stp_budget *stp_block_cache_budget(const stp_block_cache *cache)
{
    return &cache->budget;
}

int stp_block_cache_finest(const stp_block_cache *cache, uint32_t block)
{
    uint32_t slot = cache->slot_of[block];
    return slot == STP_SLOT_NONE ? STP_NOT_RESIDENT : cache->slots[slot].finest;
}

bool stp_block_cache_damaged(const stp_block_cache *cache, uint32_t block)
{
    return cache->damage.damaged[block];
}

bool stp_block_cache_used(const stp_block_cache *cache, uint32_t block, uint64_t stamp)
{
    uint32_t slot = cache->slot_of[block];
    return slot != STP_SLOT_NONE && cache->slots[slot].last_used == stamp;
}

uint32_t stp_block_cache_slot(const stp_block_cache *cache, uint32_t block)
{
    return cache->slot_of[block];
}

const stp_resident *stp_block_cache_get(const stp_block_cache *cache, uint32_t slot)
{
    return &cache->slots[slot];
}

uint64_t stp_block_cache_bytes_read(const stp_block_cache *cache)
{
    return stp_stream_bytes_read(cache->stream);
}

uint64_t stp_block_cache_gpu_used(const stp_block_cache *cache)
{
    return cache->gpu_used;
}

const char *stp_block_cache_damage(const stp_block_cache *cache)
{
    return cache->damage.words;
}

const char *stp_block_cache_trouble(const stp_block_cache *cache)
{
    return cache->rest.words;
}

size_t stp_block_cache_pending(const stp_block_cache *cache)
{
    return stp_stream_pending(cache->stream);
}

bool stp_block_cache_rests(const stp_block_cache *cache)
{
    return stp_rest_lasts(&cache->rest);
}

bool stp_block_cache_has_news(const stp_block_cache *cache)
{
    return stp_stream_has_news(cache->stream);
}

void stp_block_cache_look(stp_block_cache *cache, const stp_gpu_frame *frame, stp_dvec3 eye,
                          bool streams)
{
    /* NOLINTBEGIN(bugprone-suspicious-memory-comparison): zeros of two signs cost one look */
    cache->from.number += memcmp(&cache->from.frame, frame, sizeof *frame) != 0 ||
                          memcmp(&cache->from.eye, &eye, sizeof eye) != 0;
    /* NOLINTEND(bugprone-suspicious-memory-comparison) */
    cache->from.frame = *frame;
    cache->from.eye = eye;
    cache->from.ahead = streams || cache->views_follow || cache->from.number > 1;
    cache->victims_stamp = 0;
}

void stp_block_cache_touch(stp_block_cache *c, uint32_t block, uint64_t stamp)
{
    if (c->slot_of[block] != STP_SLOT_NONE)
        c->slots[c->slot_of[block]].last_used = stamp;
}

/* ---- making room ---- */

static void evict(stp_block_cache *c, uint32_t slot)
{
    stp_resident *r = &c->slots[slot];
    stp_object_texture_release(&c->texture, &r->placement);
    c->gpu_used -= stp_placement_bytes(&r->placement);
    stp_mirror_clear(&r->mirror);
    c->slot_of[r->block] = STP_SLOT_NONE;
    *r = (stp_resident){.block = STP_BLOCK_NONE};
    c->free_slots[c->free_count++] = slot;
}

/* Whether a slot's block may go: it was last used before stamp, and is not a root's. */
static bool may_go(const stp_block_cache *c, uint32_t slot, uint64_t stamp)
{
    const stp_resident *r = &c->slots[slot];
    return r->block != STP_BLOCK_NONE && r->last_used < stamp &&
           !stp_scene_is_root(c->scene, r->block);
}

/* Lists the blocks that may go. The list holds for all evictions at this stamp from this view:
 * blocks that arrive or are used meanwhile are used at this stamp. */
static void list_victims(stp_block_cache *c, uint64_t stamp)
{
    c->victims.count = 0;
    for (uint32_t s = 0; s < c->texture.slot_capacity; s++) {
        const stp_resident *r = &c->slots[s];
        if (!may_go(c, s, stamp))
            continue;
        float need = stp_need_of(c->scene, r->block, &c->from.frame, c->from.eye) /
                     (1.0f + (float)(stamp - r->last_used) / AGE_FRAMES);
        c->victims.items[c->victims.count++] = (stp_victim){need, s, r->block};
    }
    stp_victims_sort(&c->victims);
    c->victims_stamp = stamp;
}

/* The slot that is needed least among those last used before stamp, or STP_SLOT_NONE. A block
 * needed `limit` or more stays. */
static uint32_t find_victim(stp_block_cache *c, uint64_t stamp, float limit)
{
    if (c->victims_stamp != stamp)
        list_victims(c, stamp);
    while (c->victims.count > 0 && c->victims.items[0].need < limit) {
        stp_victim victim = stp_victims_take(&c->victims);
        if (c->slots[victim.slot].block == victim.block && may_go(c, victim.slot, stamp))
            return victim.slot;
    }
    return STP_SLOT_NONE;
}

/* Evicts until there are a slot and a place; false if evicting all that may go is not enough. */
static bool make_room(stp_block_cache *c, uint64_t stamp, float limit, stp_load_place *place,
                      stp_status *status, stp_error *err)
{
    for (;;) {
        if (c->free_count > 0 &&
            stp_object_texture_place(&c->texture, &place->placement, status, err)) {
            place->slot = c->free_slots[--c->free_count];
            return true;
        }
        uint32_t victim = *status == STP_OK ? find_victim(c, stamp, limit) : STP_SLOT_NONE;
        if (victim == STP_SLOT_NONE)
            return false;
        evict(c, victim);
    }
}

static void give_place(stp_block_cache *c, const stp_load_place *place)
{
    stp_object_texture_release(&c->texture, &place->placement);
    c->free_slots[c->free_count++] = place->slot;
}

/* Sends a FETCHED load to the decoders. *room is false if there is no room: in the ring at the
 * moment, or in the Object Texture. waits: another version of the block makes room, since none is
 * drawn before the new one is there. */
static stp_status place(stp_block_cache *c, stp_load *load, uint64_t stamp, float limit, bool waits,
                        bool *room, bool *ring_full, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t count[STP_LEVEL_COUNT], samples = 0;
    stp_load_place p = {.look = c->from.number};
    *room = *ring_full = false;
    const uint32_t slot = c->slot_of[load->want.block];
    STP_TRY(stp_patch_levels_choose(&p, count, &c->from, &load->want,
                                    slot == STP_SLOT_NONE ? NULL : &c->slots[slot], err));
    p.placement.patches.count = c->scene->blocks[load->want.block].patch_count;
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        samples += count[l];
    p.placement.texels.count = (uint32_t)stp_texels_most(samples, p.placement.patches.count);
    *ring_full =
        !stp_upload_ring_take(&c->ring, stp_placement_bytes(&p.placement), &p.piece, &status, err);
    if (*ring_full)
        goto done;
    if (waits && slot != STP_SLOT_NONE && !stp_scene_is_root(c->scene, load->want.block))
        evict(c, slot);
    *room = make_room(c, stamp, limit, &p, &status, err);
    if (*room) {
        p.memory = stp_upload_ring_memory(&c->ring, p.piece);
        stp_stream_decode(c->stream, load, &p);
        p.finest = NULL;
        p.view = NULL;
    } else {
        stp_upload_ring_give(&c->ring, p.piece);
    }
done:
    stp_patch_levels_clear(&p);
    return status;
}

/* ---- taking in what has arrived ---- */

/* Makes a DONE load resident. It replaces a coarser version of the block. */
static void commit(stp_block_cache *c, stp_load *load, uint64_t stamp)
{
    stp_load_place *p = &load->place;
    stp_placement *at = &p->placement;
    uint64_t begin = stp_upload_ring_offset(p->piece), patches = stp_placement_patches(at);
    stp_object_texture_trim(&c->texture, at, p->texels);
    stp_upload_ring_copy(&c->ring, &c->texture.samples, begin,
                         at->texels.begin * (uint64_t)STP_TEXEL_BYTES,
                         at->texels.count * (uint64_t)STP_TEXEL_BYTES);
    stp_upload_ring_copy(&c->ring, &c->texture.patches, begin + patches,
                         at->patches.begin * (uint64_t)sizeof(stp_gpu_patch),
                         at->patches.count * (uint64_t)sizeof(stp_gpu_patch));
    stp_upload_ring_copied(&c->ring, p->piece);
    if (c->slot_of[load->want.block] != STP_SLOT_NONE)
        evict(c, c->slot_of[load->want.block]);
    stp_resident *r = &c->slots[p->slot];
    *r = (stp_resident){.block = load->want.block,
                        .finest = load->want.finest,
                        .partial = p->finest != NULL,
                        .look = p->look,
                        .last_used = stamp,
                        .placement = *at,
                        .mirror = load->mirror};
    c->slot_of[r->block] = p->slot;
    c->gpu_used += stp_placement_bytes(at);
    load->mirror = (stp_mirror){0};
}

/* Gives back the place of a load that failed after it was placed. */
static void give_back(stp_block_cache *c, const stp_load *load)
{
    if (load->place.memory == NULL)
        return;
    give_place(c, &load->place);
    stp_upload_ring_give(&c->ring, load->place.piece);
}

/* Whether the block is damaged in the file, and not just held back by a server. */
static bool is_damage(const stp_load *load)
{
    bool placed = load->place.memory != NULL;
    return load->error.status == STP_CORRUPT || (placed && load->error.status == STP_UNSUPPORTED);
}

/* Takes in one load; adds the bytes copied to *bytes. */
static void take_in(stp_block_cache *c, stp_load *load, uint64_t stamp, uint64_t *bytes)
{
    if (load->state == STP_LOAD_DONE) {
        *bytes += stp_placement_bytes(&load->place.placement);
        commit(c, load, stamp);
        c->rest = (stp_rest){0}; /* the stream rests only while there is trouble */
    } else {
        give_back(c, load);
        if (is_damage(load))
            stp_damage_log_note(&c->damage, load->want.block, load->error.message);
        else if (load->error.status != STP_CANCELLED || !load->dropped) /* else it was given up */
            stp_rest_begin(&c->rest, load->error.message, load->dropped);
    }
    stp_stream_release(c->stream, load);
}

/* ---- beside the frame ---- */

stp_status stp_block_cache_update(stp_block_cache *c, uint64_t stamp, stp_error *err)
{
    stp_load *load = NULL;
    uint64_t bytes = 0;
    while (bytes < STP_CACHE_FRAME_BYTES && stp_upload_ring_may_copy(&c->ring) &&
           (load = stp_stream_next_done(c->stream)) != NULL)
        take_in(c, load, stamp, &bytes);
    stp_upload_ring_fence(&c->ring);
    while ((load = stp_stream_next_fetched(c->stream)) != NULL) {
        bool room = false, ring_full = false, ahead = !c->wanted[load->want.block];
        float limit =
            ahead ? stp_need_of(c->scene, load->want.block, &c->from.frame, c->from.eye) : INFINITY;
        stp_status status = place(c, load, stamp, limit, false, &room, &ring_full, err);
        if (status != STP_OK || ring_full)
            return status;
        if (room)
            continue;
        c->refused = c->refused || !ahead;
        c->ahead_refused = c->ahead_refused || ahead;
        stp_stream_release(c->stream, load);
    }
    stp_status status = stp_object_texture_check(&c->texture, err);
    return status == STP_OK ? stp_gl_check("uploading blocks", err) : status;
}

void stp_block_cache_want(stp_block_cache *c, const stp_want *wants, size_t count, size_t ahead)
{
    bool same = count == c->want_count &&
                (count == 0 || memcmp(wants, c->wants, count * sizeof *wants) == 0);
    for (size_t i = 0; i < c->ahead; i++)
        c->wanted[c->wants[i].block] = false;
    if (stp_grow(&c->wants, &c->want_capacity, count, sizeof *c->wants, "a list of blocks", NULL) !=
        STP_OK)
        count = 0;
    if (count > 0)
        memcpy(c->wants, wants, count * sizeof *wants);
    c->refused = c->refused && same;
    c->ahead_refused = c->ahead_refused && same;
    c->want_count = count;
    c->ahead = ahead < count ? ahead : count;
    for (size_t i = 0; i < c->ahead; i++)
        c->wanted[c->wants[i].block] = true;
    bool rests = stp_block_cache_rests(c);
    if (count == 0 && !rests)
        c->rest.words[0] = '\0';
    if (rests || c->refused)
        count = 0;
    else if (c->ahead_refused)
        count = c->ahead;
    stp_stream_want(c->stream, c->wants, count);
}

/* ---- waiting ---- */

/* Whether a failed load concerns this cache load: it had placed the load, even if it no longer asks
 * for it, or it has wanted the load since it began. Loads begun for another picture are asked for
 * again. */
static bool is_own(const stp_cache_load *l, const stp_load *load)
{
    if (load->place.memory == NULL)
        return !load->dropped;
    for (size_t i = l->there; i < l->begun; i++)
        if (l->wants[i].block == load->want.block)
            return true;
    return false;
}

/* Takes in all loads that are DONE or FAILED. Puts a fence behind their copies, which later frees
 * their pieces of the ring. */
static stp_status take_news(stp_block_cache *c, stp_cache_load *l, stp_error *err)
{
    stp_load *load = NULL;
    uint64_t bytes = 0;
    while ((load = stp_stream_next_done(c->stream)) != NULL) {
        bool failed = load->state == STP_LOAD_FAILED, broken = failed && is_damage(load);
        bool own = is_own(l, load);
        stp_error error = load->error;
        take_in(c, load, l->stamp, &bytes);
        if (failed && !broken && own)
            return stp_error_set(err, error.status, "%s", error.message);
        l->damaged = l->damaged || broken;
    }
    stp_upload_ring_fence(&c->ring);
    return stp_object_texture_check(&c->texture, err);
}

/* Whether a want needs nothing more. */
static bool settled(stp_block_cache *c, const stp_want *want, uint64_t stamp)
{
    if (c->damage.damaged[want->block])
        return true;
    if (stp_block_cache_finest(c, want->block) > want->finest ||
        stp_patch_levels_lack(&c->from, &c->slots[c->slot_of[want->block]], want->finest))
        return false;
    stp_block_cache_touch(c, want->block, stamp);
    return true;
}

/* Places the next want in order, if its payload has been read. */
static stp_status place_next(stp_block_cache *c, stp_cache_load *l, bool *placed, stp_error *err)
{
    const stp_want *want = &l->wants[l->begun];
    stp_load *load = stp_stream_find(c->stream, want->block);
    *placed = false;
    if (load == NULL || load->state != STP_LOAD_FETCHED)
        return STP_OK;
    if (load->want.finest > want->finest) { /* it was begun for another picture */
        stp_stream_release(c->stream, load);
        return STP_OK;
    }
    stp_status status = place(c, load, l->stamp, INFINITY, true, placed, &l->ring_full, err);
    l->full = !*placed && !l->ring_full;
    return status;
}

/* Takes in loads that are done, and places loads that are read. */
static stp_status load_round(stp_block_cache *c, stp_cache_load *l, stp_error *err)
{
    stp_status status = take_news(c, l, err);
    bool placed = true;
    l->ring_full = false;
    while (status == STP_OK && l->begun < l->count && placed && !l->full) {
        placed = settled(c, &l->wants[l->begun], l->stamp);
        if (!placed)
            status = place_next(c, l, &placed, err);
        l->begun += placed;
    }
    while (l->there < l->begun && settled(c, &l->wants[l->there], l->stamp))
        l->there++;
    return status;
}

stp_status stp_block_cache_load_step(stp_block_cache *c, stp_cache_load *l, bool *finished,
                                     stp_error *err)
{
    stp_status status = STP_OK;
    bool more = false;
    if (!l->started) {
        stp_stream_want(c->stream, NULL, 0);
        c->from.number += c->damage.count != c->damage_seen; /* patches above are drawn instead */
        c->damage_seen = c->damage.count;
    }
    l->started = true;
    c->from.below = l->below;
    do {
        STP_TRY(load_round(c, l, err));
        more = l->begun < l->count && !l->full;
        *finished = l->there == l->begun && !more;
    } while (!*finished && l->ring_full && stp_upload_ring_wait(&c->ring));
    if (more && stp_stream_find(c->stream, l->wants[l->begun].block) == NULL)
        stp_stream_want(c->stream, l->wants + l->begun, l->count - l->begun);
    STP_TRY(stp_gl_check("uploading blocks", err));
done:
    c->from.below = NULL;
    if (status != STP_OK || *finished)
        stp_stream_want(c->stream, NULL, 0);
    return status;
}

stp_status stp_block_cache_load(stp_block_cache *c, stp_cache_load *l, stp_error *err)
{
    bool finished = false;
    c->rest.until = 0.0;
    while (!finished) {
        uint64_t seen = stp_stream_news_count(c->stream);
        stp_status status = stp_block_cache_load_step(c, l, &finished, err);
        bool did = false;
        if (status == STP_OK && !finished && l->idle != NULL)
            status = l->idle->step(l->idle->context, &did, err);
        if (status != STP_OK)
            return status;
        if (!finished && !did)
            stp_stream_wait(c->stream, seen);
    }
    return STP_OK;
}

/* ---- creation ---- */

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
    free(c->slots);
    free(c->free_slots);
    free(c->slot_of);
    stp_damage_log_destroy(&c->damage);
    free(c->wants);
    free(c->wanted);
    free(c->victims.items);
    free(c);
    *cache = NULL;
}
