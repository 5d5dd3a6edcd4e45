/* Keeps blocks in the Object Texture. */
#include "runtime/stream/cache/block_cache_parts.h"

#include "base/memory.h"
#include "runtime/gl/gl_context.h"
#include "runtime/stream/cache/shrink.h"

#include <stdlib.h>
#include <string.h>

/* After so many frames without use, the need of a block counts half. */
#define AGE_FRAMES 120.0f

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

uint64_t stp_block_cache_state(const stp_block_cache *cache)
{
    return cache->from.number + cache->changes;
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
    c->changes++;
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

/* Takes from the next block in use the samples of levels that the view does not ask for. False if
 * no block has any. Each block is looked at once for a view. */
static bool shrink_next(stp_block_cache *c, stp_status *status, stp_error *err)
{
    for (uint32_t n = 0; n < c->texture.slot_capacity; n++) {
        stp_resident *r = &c->slots[c->shrink_next];
        const uint64_t bytes = stp_placement_bytes(&r->placement);
        c->shrink_next = (c->shrink_next + 1) % c->texture.slot_capacity;
        if (r->block == STP_BLOCK_NONE || r->shown == c->from.number ||
            stp_scene_is_root(c->scene, r->block))
            continue;
        r->shown = c->from.number;
        if (!stp_patch_levels_shown(&c->from, r, c->levels))
            continue;
        c->changes++;
        const bool shrunk = stp_shrink(&c->texture, &c->ring, r, c->levels, status, err);
        c->gpu_used -= bytes - stp_placement_bytes(&r->placement);
        return shrunk;
    }
    return false;
}

uint64_t stp_block_cache_gpu_pinned(stp_block_cache *c, uint64_t stamp)
{
    uint64_t bytes = 0;
    for (uint32_t s = 0; s < c->texture.slot_capacity; s++) {
        const stp_resident *r = &c->slots[s];
        stp_placement at = r->placement;
        const bool root = r->block != STP_BLOCK_NONE && stp_scene_is_root(c->scene, r->block);
        if (r->block == STP_BLOCK_NONE || (r->last_used != stamp && !root))
            continue;
        if (!root && stp_patch_levels_shown(&c->from, r, c->levels))
            at.texels.count = stp_shrink_texels(r, c->levels);
        bytes += stp_placement_bytes(&at);
    }
    return bytes;
}

/* Evicts until there are a slot and a place; then blocks in use give back levels that the view does
 * not ask for. False if all of that is not enough. */
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
        if (victim != STP_SLOT_NONE)
            evict(c, victim);
        else if (*status != STP_OK || limit < INFINITY || c->free_count == 0 ||
                 !shrink_next(c, status, err))
            return false;
    }
}

static void give_place(stp_block_cache *c, const stp_load_place *place)
{
    stp_object_texture_release(&c->texture, &place->placement);
    c->free_slots[c->free_count++] = place->slot;
}

stp_status stp_block_cache_place(stp_block_cache *c, stp_load *load, uint64_t stamp, float limit,
                                 bool waits, bool *room, bool *ring_full, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t count[STP_LEVEL_COUNT], samples = 0;
    stp_load_place p = {.look = c->from.number};
    stp_patch_look look = c->from;
    *room = *ring_full = false;
    const uint32_t slot = c->slot_of[load->want.block];
    look.ahead = look.ahead && c->tight != look.number;
    STP_TRY(stp_patch_levels_choose(&p, count, &look, &load->want,
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
        p.mirror = stp_patch_store_at(&c->patches, p.placement.patches);
        stp_stream_decode(c->stream, load, &p);
        p.finest = NULL;
        p.view = NULL;
    } else {
        stp_upload_ring_give(&c->ring, p.piece);
    }
done:
    stp_patch_levels_clear(&p);
    if (status == STP_OK && !*room && !*ring_full && look.ahead && limit == INFINITY) {
        c->tight = c->from.number;
        return stp_block_cache_place(c, load, stamp, limit, waits, room, ring_full, err);
    }
    return status;
}

/* ---- taking in what has arrived ---- */

/* Makes a DONE load resident. It replaces a coarser version of the block. */
static void commit(stp_block_cache *c, stp_load *load, uint64_t stamp)
{
    stp_load_place *p = &load->place;
    stp_placement *at = &p->placement;
    uint64_t begin = stp_upload_ring_offset(p->piece), patches = stp_placement_patches(at);
    c->changes++;
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

bool stp_block_cache_is_damage(const stp_load *load)
{
    bool placed = load->place.memory != NULL;
    return load->error.status == STP_CORRUPT || (placed && load->error.status == STP_UNSUPPORTED);
}

void stp_block_cache_take_in(stp_block_cache *c, stp_load *load, uint64_t stamp, uint64_t *bytes)
{
    if (load->state == STP_LOAD_DONE) {
        *bytes += stp_placement_bytes(&load->place.placement);
        commit(c, load, stamp);
        c->rest = (stp_rest){0}; /* the stream rests only while there is trouble */
    } else {
        give_back(c, load);
        c->changes++;
        if (stp_block_cache_is_damage(load))
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
        stp_block_cache_take_in(c, load, stamp, &bytes);
    stp_upload_ring_fence(&c->ring);
    while ((load = stp_stream_next_fetched(c->stream)) != NULL) {
        bool room = false, ring_full = false, ahead = !c->wanted[load->want.block];
        float limit =
            ahead ? stp_need_of(c->scene, load->want.block, &c->from.frame, c->from.eye) : INFINITY;
        stp_status status =
            stp_block_cache_place(c, load, stamp, limit, false, &room, &ring_full, err);
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
