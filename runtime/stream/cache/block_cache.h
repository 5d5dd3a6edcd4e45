/* Decides which blocks are in the Object Texture: takes in blocks that the stream delivers, and
 * evicts the blocks that are needed least.
 *
 * The stream's threads (runtime/stream/stream.h) read and decode straight into the upload ring. The
 * render thread decides where a block goes and issues its copy. All memory is allotted at creation
 * (runtime/stream/cache/budget.h). The blocks of roots are loaded at creation and never leave.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_STREAM_CACHE_BLOCK_CACHE_H
#define STP_RUNTIME_STREAM_CACHE_BLOCK_CACHE_H

#include "runtime/cut/level_choice.h"
#include "runtime/stream/cache/budget.h"
#include "runtime/stream/cache/object_texture.h"
#include "runtime/stream/stream.h"

#define STP_NOT_RESIDENT STP_LEVEL_COUNT
#define STP_SLOT_NONE UINT32_MAX
/* Copies at most so much to the GPU in one frame, unless the caller waits. */
#define STP_CACHE_FRAME_BYTES (UINT64_C(8) << 20)

typedef struct stp_resident {
    uint32_t block; /* STP_BLOCK_NONE: the slot is free, or its block is on its way */
    int finest;     /* levels >= finest are resident */
    bool partial;   /* but not of each patch (stp_mirror_patch.finest) */
    uint32_t look;  /* partial: of the view that asks for no more */
    uint32_t shown; /* of the view that was asked which levels it shows, to give back others */
    uint64_t last_used;
    stp_placement placement;
    stp_mirror mirror; /* for choosing on the CPU */
} stp_resident;

typedef struct stp_block_cache stp_block_cache;

typedef struct stp_block_cache_params {
    const stp_scene *scene; /* borrowed; outlives the cache */
    uint64_t gpu_bytes;     /* 0: 1 GiB */
    uint64_t cpu_bytes;     /* 0: 1 GiB */
    unsigned thread_count;  /* for decoding, at least 1 */
    bool software;          /* the driver draws on the CPU */
    bool views_follow;      /* see stp_renderer_params */
    void (*wake)(void *);   /* see stp_stream_params */
    void *wake_context;
} stp_block_cache_params;

/* Loads the roots. Errors: LIMIT (a budget is too small), GL, OUT_OF_MEMORY, and those of reading
 * the roots. */
stp_status stp_block_cache_create(stp_block_cache **out, const stp_block_cache_params *params,
                                  stp_error *err);
void stp_block_cache_destroy(stp_block_cache **cache);

const stp_object_texture *stp_block_cache_texture(const stp_block_cache *cache);
const stp_budget *stp_block_cache_budget(const stp_block_cache *cache);
/* The finest resident level of a block; STP_NOT_RESIDENT if none. */
int stp_block_cache_finest(const stp_block_cache *cache, uint32_t block);
/* Whether a block is damaged; what is above is drawn instead. */
bool stp_block_cache_damaged(const stp_block_cache *cache, uint32_t block);
/* Whether a block is resident and was used at `stamp`. */
bool stp_block_cache_used(const stp_block_cache *cache, uint32_t block, uint64_t stamp);
/* The slot of a block, or STP_SLOT_NONE if it is not resident; and the contents of a slot. */
uint32_t stp_block_cache_slot(const stp_block_cache *cache, uint32_t block);
const stp_resident *stp_block_cache_get(const stp_block_cache *cache, uint32_t slot);

/* Sets where the scene is seen from: near blocks are needed more than far ones. streams: pictures
 * do not wait for blocks. Blocks that arrive for the first view, if it waits and no views follow,
 * have no levels that only others need. */
void stp_block_cache_look(stp_block_cache *cache, const stp_gpu_frame *frame, stp_dvec3 eye,
                          bool streams);

/* A number that is another one as soon as the view (stp_block_cache_look), what is resident, or
 * what is known to be damaged is another. Never 0 after a look. */
uint64_t stp_block_cache_state(const stp_block_cache *cache);

/* ---- beside the frame ---- */

/* Takes in what has arrived since the last call, without waiting. Starts decoding payloads that
 * were read, and evicts blocks last used before `stamp` for them. A failed read is not an error:
 * see stp_block_cache_trouble. Errors: OUT_OF_MEMORY, GL. */
stp_status stp_block_cache_update(stp_block_cache *cache, uint64_t stamp, stp_error *err);
/* Replaces the list of wanted blocks, most wanted first. wants[ahead..count) will be wanted
 * soon. */
void stp_block_cache_want(stp_block_cache *cache, const stp_want *wants, size_t count,
                          size_t ahead);
/* The number of blocks on their way. */
size_t stp_block_cache_pending(const stp_block_cache *cache);
/* Whether the cache pauses for some seconds after a failed read, and asks for nothing. */
bool stp_block_cache_rests(const stp_block_cache *cache);
/* Whether stp_block_cache_update would take something in. */
bool stp_block_cache_has_news(const stp_block_cache *cache);

/* ---- waiting ---- */

/* What the render thread does while blocks are on their way. step: *did is false if nothing is left
 * to do. A step must leave resident blocks and wants alone. */
typedef struct stp_idle_work {
    stp_status (*step)(void *context, bool *did, stp_error *err);
    void *context;
} stp_idle_work;

/* Loads wants in order until there is no more room. The caller sets wants, count and stamp; the
 * rest starts as zero. Evicts only blocks last used before `stamp` (frames count up). Blocks that
 * are loaded, or were resident, are marked as used at `stamp`. */
typedef struct stp_cache_load {
    const stp_want *wants;              /* borrowed until the load ends */
    const struct stp_need_below *below; /* likewise; the blocks of the cut; may be NULL */
    const stp_idle_work *idle;          /* likewise; for stp_block_cache_load; may be NULL */
    size_t count;
    uint64_t stamp;
    bool started; /* the list of stp_block_cache_want is cleared */
    size_t there; /* wants[0..there) are resident; a damaged block counts as resident */
    size_t begun; /* wants[there..begun) are being decoded */
    bool damaged; /* some block was found damaged */
    bool full;    /* there is no room for wants[begun] */
    size_t tried; /* so many wants begun, plus 1, when there was no room with none on its way */
    bool ring_full;
} stp_cache_load;

/* Continues a load without waiting. *finished: the load has ended. An error ends the load, too.
 * Errors: IO, OUT_OF_MEMORY, GL. */
stp_status stp_block_cache_load_step(stp_block_cache *cache, stp_cache_load *load, bool *finished,
                                     stp_error *err);
/* Continues a load and waits until it has ended. Errors: as stp_block_cache_load_step, and those of
 * the idle work; then what is on its way still arrives. */
stp_status stp_block_cache_load(stp_block_cache *cache, stp_cache_load *load, stp_error *err);

/* Marks a block as used at `stamp`, if it is resident. */
void stp_block_cache_touch(stp_block_cache *cache, uint32_t block, uint64_t stamp);

/* Bytes of payloads read so far. */
uint64_t stp_block_cache_bytes_read(const stp_block_cache *cache);
/* Bytes of the Object Texture in use. */
uint64_t stp_block_cache_gpu_used(const stp_block_cache *cache);
/* How many of these bytes the picture drawn at `stamp` pins: of blocks used then, the levels that
 * its view asks for, and roots. The rest is cache, and is given back as soon as there is no room
 * for something else. */
uint64_t stp_block_cache_gpu_pinned(stp_block_cache *cache, uint64_t stamp);
/* A sentence about the first damage found, and how many more blocks are damaged; empty if none. */
const char *stp_block_cache_damage(const stp_block_cache *cache);
/* A sentence about why nothing arrives (the file cannot be read); empty if blocks arrive. */
const char *stp_block_cache_trouble(const stp_block_cache *cache);

#endif
