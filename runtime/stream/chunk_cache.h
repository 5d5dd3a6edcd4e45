/* Which chunks are in the Object Texture: takes in what the stream brings, evicts what is needed
 * least.
 *
 * Reading and decoding run on the stream's threads (runtime/stream/stream.h), straight into the
 * upload ring; the render thread says where a chunk goes and issues its copy. Memory: all of it is
 * allotted at creation (runtime/stream/budget.h). Roots are loaded at creation and never leave.
 * Threads: the render thread. */
#ifndef STP_RUNTIME_STREAM_CHUNK_CACHE_H
#define STP_RUNTIME_STREAM_CHUNK_CACHE_H

#include "runtime/cut/level_choice.h"
#include "runtime/stream/budget.h"
#include "runtime/stream/object_texture.h"
#include "runtime/stream/stream.h"

#define STP_NOT_RESIDENT STP_LEVEL_COUNT
/* Copied to the GPU in one frame at most, unless somebody waits. */
#define STP_CACHE_FRAME_BYTES (UINT64_C(8) << 20)

typedef struct stp_resident {
    uint32_t chunk; /* STP_CHUNK_NONE: the slot is free, or its chunk is on its way */
    int finest;     /* levels >= finest are there */
    uint64_t last_used;
    stp_placement placement;
    stp_gpu_patch *patches;  /* the GPU's, for choosing on the CPU */
    stp_patch_brief *briefs; /* the patches': what looking at them reads */
} stp_resident;

typedef struct stp_chunk_cache stp_chunk_cache;

typedef struct stp_chunk_cache_params {
    const stp_scene *scene; /* borrowed; outlives the cache */
    uint64_t gpu_bytes;     /* 0: 1 GiB */
    uint64_t cpu_bytes;     /* 0: 1 GiB */
    unsigned thread_count;  /* for decoding, at least 1 */
    void (*wake)(void *);   /* see stp_stream_params */
    void *wake_context;
} stp_chunk_cache_params;

/* Loads the roots. Errors: LIMIT (a budget is too small), GL, OUT_OF_MEMORY, and those of reading
 * the roots. */
stp_status stp_chunk_cache_create(stp_chunk_cache **out, const stp_chunk_cache_params *params,
                                  stp_error *err);
void stp_chunk_cache_destroy(stp_chunk_cache **cache);

const stp_object_texture *stp_chunk_cache_texture(const stp_chunk_cache *cache);
const stp_budget *stp_chunk_cache_budget(const stp_chunk_cache *cache);
/* Finest resident level of a chunk, STP_NOT_RESIDENT if none. */
int stp_chunk_cache_finest(const stp_chunk_cache *cache, uint32_t chunk);
/* True if the chunk is damaged: its parent stands for it. */
bool stp_chunk_cache_damaged(const stp_chunk_cache *cache, uint32_t chunk);
/* Whether it is resident and was used at `stamp`. */
bool stp_chunk_cache_used(const stp_chunk_cache *cache, uint32_t chunk, uint64_t stamp);
/* The chunk's slot, and what is in it; the chunk must be resident. */
uint32_t stp_chunk_cache_slot(const stp_chunk_cache *cache, uint32_t chunk);
const stp_resident *stp_chunk_cache_get(const stp_chunk_cache *cache, uint32_t slot);

/* From where the scene is seen now: what lies near is needed more than what does not. */
void stp_chunk_cache_look(stp_chunk_cache *cache, const stp_gpu_frame *frame, stp_dvec3 eye);

/* ---- beside the frame ---- */

/* Takes in what has come since the last call, without waiting, and sends on what was read, evicting
 * what was last used before `stamp`. A failure to read is no error: see stp_chunk_cache_trouble.
 * Errors: OUT_OF_MEMORY, GL. */
stp_status stp_chunk_cache_update(stp_chunk_cache *cache, uint64_t stamp, stp_error *err);
/* What is wanted now, most wanted first; from wants[ahead] on what will be wanted soon. Replaces
 * what was wanted before. */
void stp_chunk_cache_want(stp_chunk_cache *cache, const stp_want *wants, size_t count,
                          size_t ahead);
/* Chunks on their way. */
size_t stp_chunk_cache_pending(const stp_chunk_cache *cache);
/* Whether, after a failure to read, nothing is asked for, for some seconds. */
bool stp_chunk_cache_rests(const stp_chunk_cache *cache);
/* Whether update would take something in. */
bool stp_chunk_cache_has_news(const stp_chunk_cache *cache);

/* ---- waiting ---- */

/* The loading of wants in order, until room ends. wants, count and stamp are the caller's, the rest
 * begins as zero. Only what was last used before `stamp` (frames count up) is evicted; what is
 * loaded or was there is marked used at `stamp`. */
typedef struct stp_cache_load {
    const stp_want *wants; /* borrowed until the load ends */
    size_t count;
    uint64_t stamp;
    bool started; /* what was wanted before no longer is */
    size_t there; /* wants[0..there) are resident; a damaged chunk counts as resident */
    size_t begun; /* wants[there..begun) are being decoded */
    bool damaged; /* a chunk was found damaged */
    bool full;    /* wants[begun] found no room */
    bool ring_full;
} stp_cache_load;

/* Goes on with a load without waiting; *finished: it has ended. Errors: IO, OUT_OF_MEMORY, GL; they
 * end it. */
stp_status stp_chunk_cache_load_step(stp_chunk_cache *cache, stp_cache_load *load, bool *finished,
                                     stp_error *err);
/* Goes on until it has ended. Errors: the same. */
stp_status stp_chunk_cache_load(stp_chunk_cache *cache, stp_cache_load *load, stp_error *err);

/* Marks a chunk, if it is resident, used at `stamp`. */
void stp_chunk_cache_touch(stp_chunk_cache *cache, uint32_t chunk, uint64_t stamp);

/* Bytes read of payloads so far. */
uint64_t stp_chunk_cache_bytes_read(const stp_chunk_cache *cache);
/* Bytes of the Object Texture in use. */
uint64_t stp_chunk_cache_gpu_used(const stp_chunk_cache *cache);
/* The first damage found, as a sentence, and of how many chunks besides; empty if none. */
const char *stp_chunk_cache_damage(const stp_chunk_cache *cache);
/* Why nothing comes at the moment (the file cannot be read), as a sentence; empty if it does. */
const char *stp_chunk_cache_trouble(const stp_chunk_cache *cache);

#endif
