/* What the parts of the block cache share: block_cache.c; block_load.c, which waits for blocks;
 * block_cache_create.c.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_STREAM_CACHE_BLOCK_CACHE_PARTS_H
#define STP_RUNTIME_STREAM_CACHE_BLOCK_CACHE_PARTS_H

#include "runtime/stream/cache/block_cache.h"
#include "runtime/stream/cache/damage_log.h"
#include "runtime/stream/cache/patch_levels.h"
#include "runtime/stream/cache/patch_store.h"
#include "runtime/stream/cache/victims.h"
#include "runtime/stream/rest.h"
#include "runtime/stream/upload_ring.h"

struct stp_block_cache {
    const stp_scene *scene;
    stp_budget budget;
    stp_stream *stream;
    stp_upload_ring ring;
    stp_object_texture texture;
    stp_patch_store patches;
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
    uint64_t changes;       /* of what is resident or damaged, so far */
    stp_want *wants;
    size_t want_count, want_capacity, ahead;
    bool *wanted;       /* by block: it is one of wants[0..ahead) */
    bool refused;       /* a want found no room; wants are not asked for again */
    bool ahead_refused; /* the same for blocks that will be wanted soon */
    stp_rest rest;
    uint8_t *levels;      /* room for those of a block's patches */
    uint32_t shrink_next; /* the slot whose block is the next to give back levels */
    uint32_t tight;       /* the view for which there is no room but for what it shows */
};

/* Whether a failed load tells of damage in the file, and not just of a server that holds it back.
 */
bool stp_block_cache_is_damage(const stp_load *load);
/* Takes in one load that is DONE or FAILED; adds the bytes copied to *bytes. */
void stp_block_cache_take_in(stp_block_cache *c, stp_load *load, uint64_t stamp, uint64_t *bytes);
/* Sends a FETCHED load to the decoders. *room is false if there is no room: in the ring at the
 * moment, or in the Object Texture. Blocks needed `limit` or more stay. waits: another version of
 * the block makes room, since none is drawn before the new one is there. */
stp_status stp_block_cache_place(stp_block_cache *c, stp_load *load, uint64_t stamp, float limit,
                                 bool waits, bool *room, bool *ring_full, stp_error *err);

#endif
