/* Which chunks are in the Object Texture: loads what a frame wants, evicts what was not used
 * lately.
 *
 * Reading and decoding run on the pool's threads, uploading on the render thread; a call returns
 * when its batch is done. Memory: the Object Texture never grows; at most two decoded chunks a
 * thread exist at once. The root is loaded at creation and never leaves. */
#ifndef STP_RUNTIME_CHUNK_CACHE_H
#define STP_RUNTIME_CHUNK_CACHE_H

#include "base/pool.h"
#include "runtime/level_choice.h"
#include "runtime/model.h"
#include "runtime/object_texture.h"

#define STP_NOT_RESIDENT STP_LEVEL_COUNT

typedef struct stp_resident {
    uint32_t chunk; /* STP_CHUNK_NONE: the slot is free */
    int finest;     /* levels >= finest are there */
    uint64_t last_used;
    stp_placement placement;
    stp_gpu_patch *patches;        /* the GPU's, for choosing on the CPU */
    stp_rule_bound *bounds;        /* the patches': what culling them reads */
    float radius[STP_LEVEL_COUNT]; /* greatest of each level */
} stp_resident;

/* One chunk, needed down to a level. */
typedef struct stp_want {
    uint32_t chunk;
    int finest;
} stp_want;

typedef struct stp_chunk_cache stp_chunk_cache;

typedef struct stp_chunk_cache_params {
    const stp_model *model; /* borrowed; outlives the cache */
    stp_pool *pool;         /* borrowed */
    uint64_t gpu_bytes;     /* budget of the Object Texture; 0: 1 GiB */
    uint64_t cpu_bytes;     /* budget of chunks being decoded, at least one; 0: 1 GiB */
} stp_chunk_cache_params;

/* Loads the root. Errors: LIMIT (the budget holds not even the root and one chunk), GL,
 * OUT_OF_MEMORY, and those of reading the root. */
stp_status stp_chunk_cache_create(stp_chunk_cache **out, const stp_chunk_cache_params *params,
                                  stp_error *err);
void stp_chunk_cache_destroy(stp_chunk_cache **cache);

const stp_object_texture *stp_chunk_cache_texture(const stp_chunk_cache *cache);
/* Finest resident level of a chunk, STP_NOT_RESIDENT if none. */
int stp_chunk_cache_finest(const stp_chunk_cache *cache, uint32_t chunk);
/* True if the chunk could not be read: its parent stands for it. */
bool stp_chunk_cache_damaged(const stp_chunk_cache *cache, uint32_t chunk);
/* The chunk's slot, and what is in it; the chunk must be resident. */
uint32_t stp_chunk_cache_slot(const stp_chunk_cache *cache, uint32_t chunk);
const stp_resident *stp_chunk_cache_get(const stp_chunk_cache *cache, uint32_t slot);

/* Loads wants[0..count) in order until room or time ends, evicting only what was last used before
 * `stamp` (frames count up); what is loaded or was there is marked used at `stamp`. *loaded: so
 * many of the wants, from the first, are resident. A damaged chunk is skipped (it counts as loaded,
 * and *damaged is set). deadline: stp_clock_seconds() after which no further batch starts, 0 none.
 * Errors: IO, OUT_OF_MEMORY, GL. */
stp_status stp_chunk_cache_load(stp_chunk_cache *cache, const stp_want *wants, size_t count,
                                uint64_t stamp, double deadline, size_t *loaded, bool *damaged,
                                stp_error *err);

/* Marks a chunk, if it is resident, used at `stamp`. */
void stp_chunk_cache_touch(stp_chunk_cache *cache, uint32_t chunk, uint64_t stamp);

/* Bytes read from the file so far. */
uint64_t stp_chunk_cache_bytes_read(const stp_chunk_cache *cache);
/* The first damage found, as a sentence; empty if none. */
const char *stp_chunk_cache_damage(const stp_chunk_cache *cache);

#endif
