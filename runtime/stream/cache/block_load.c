/* Waits for blocks: loads wants in order until there is no more room. */
#include "runtime/stream/cache/block_cache_parts.h"

#include "runtime/gl/gl_context.h"

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
        bool failed = load->state == STP_LOAD_FAILED,
             broken = failed && stp_block_cache_is_damage(load);
        bool own = is_own(l, load);
        stp_error error = load->error;
        stp_block_cache_take_in(c, load, l->stamp, &bytes);
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
    stp_status status =
        stp_block_cache_place(c, load, l->stamp, INFINITY, true, placed, &l->ring_full, err);
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
        if (l->full && l->there == l->begun && l->tried <= l->begun) {
            /* blocks that were on their way can give back levels now */
            l->tried = l->begun + 1;
            l->full = false;
            STP_TRY(load_round(c, l, err));
        }
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
