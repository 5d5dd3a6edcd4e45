/* Residency of chunks in the Object Texture. */
#include "runtime/chunk_cache.h"

#include "base/clock.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

#define DEFAULT_GPU_BYTES (UINT64_C(1) << 30)
#define DEFAULT_CPU_BYTES (UINT64_C(1) << 30)
#define NO_SLOT UINT32_MAX
/* Chunks decoded at once. */
#define BATCH_LIMIT 64

struct stp_chunk_cache {
    const stp_model *model;
    stp_pool *pool;
    stp_object_texture texture;
    stp_resident *slots;
    uint32_t *slot_of; /* by chunk id */
    bool *damaged;     /* by chunk id */
    size_t batch;      /* chunks decoded at once */
    uint64_t bytes_read;
    char damage[512];
};

typedef struct decode_job {
    stp_chunk_cache *cache;
    stp_want wants[BATCH_LIMIT];
    stp_chunk *chunks[BATCH_LIMIT];
    stp_error errors[BATCH_LIMIT];
    size_t count;
} decode_job;

const stp_object_texture *stp_chunk_cache_texture(const stp_chunk_cache *cache)
{
    return &cache->texture;
}

int stp_chunk_cache_finest(const stp_chunk_cache *cache, uint32_t chunk)
{
    uint32_t slot = cache->slot_of[chunk];
    return slot == NO_SLOT ? STP_NOT_RESIDENT : cache->slots[slot].finest;
}

bool stp_chunk_cache_damaged(const stp_chunk_cache *cache, uint32_t chunk)
{
    return cache->damaged[chunk];
}

uint32_t stp_chunk_cache_slot(const stp_chunk_cache *cache, uint32_t chunk)
{
    return cache->slot_of[chunk];
}

const stp_resident *stp_chunk_cache_get(const stp_chunk_cache *cache, uint32_t slot)
{
    return &cache->slots[slot];
}

uint64_t stp_chunk_cache_bytes_read(const stp_chunk_cache *cache)
{
    return cache->bytes_read;
}

const char *stp_chunk_cache_damage(const stp_chunk_cache *cache)
{
    return cache->damage;
}

static void evict(stp_chunk_cache *c, uint32_t slot)
{
    stp_resident *r = &c->slots[slot];
    stp_object_texture_release(&c->texture, &r->placement);
    free(r->patches);
    free(r->bounds);
    c->slot_of[r->chunk] = NO_SLOT;
    *r = (stp_resident){.chunk = STP_CHUNK_NONE};
}

/* The slot least lately used before stamp, or NO_SLOT. Chunk 0, the root, stays. */
static uint32_t find_victim(const stp_chunk_cache *c, uint64_t stamp)
{
    uint32_t victim = NO_SLOT;
    for (uint32_t s = 0; s < c->texture.slot_capacity; s++) {
        const stp_resident *r = &c->slots[s];
        if (r->chunk == STP_CHUNK_NONE || r->chunk == 0 || r->last_used >= stamp)
            continue;
        if (victim == NO_SLOT || r->last_used < c->slots[victim].last_used)
            victim = s;
    }
    return victim;
}

static uint32_t find_free_slot(const stp_chunk_cache *c)
{
    for (uint32_t s = 0; s < c->texture.slot_capacity; s++)
        if (c->slots[s].chunk == STP_CHUNK_NONE)
            return s;
    return NO_SLOT;
}

/* Evicts until slot and placement are found; false if what may be evicted does not do. */
static bool make_room(stp_chunk_cache *c, const stp_want *want, uint64_t stamp, uint32_t *slot,
                      stp_placement *placement, stp_status *status, stp_error *err)
{
    const stp_chunk_entry *entry = &c->model->entries[want->chunk];
    for (;;) {
        *slot = find_free_slot(c);
        if (*slot != NO_SLOT &&
            stp_object_texture_place(&c->texture, entry, want->finest, placement, status, err))
            return true;
        uint32_t victim = find_victim(c, stamp);
        if (victim == NO_SLOT || *status != STP_OK)
            return false;
        evict(c, victim);
    }
}

/* *stored is false where there is no room. */
static stp_status store(stp_chunk_cache *c, const stp_want *want, const stp_chunk *chunk,
                        uint64_t stamp, bool *stored, stp_error *err)
{
    stp_status status = STP_OK;
    stp_resident r = {.chunk = want->chunk, .finest = want->finest, .last_used = stamp};
    uint32_t slot = NO_SLOT;
    if (c->slot_of[want->chunk] != NO_SLOT) /* there, but not fine enough */
        evict(c, c->slot_of[want->chunk]);
    *stored = make_room(c, want, stamp, &slot, &r.placement, &status, err);
    if (!*stored)
        return status;
    STP_TRY(stp_alloc(&r.patches, chunk->patch_count, sizeof *r.patches, "patches", err));
    STP_TRY(stp_alloc(&r.bounds, chunk->patch_count, sizeof *r.bounds, "patches", err));
    stp_gpu_patches_fill(r.patches, chunk, &r.placement, slot);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        r.bounds[p] = stp_patch_bound(&r.patches[p]);
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            r.radius[l] = fmaxf(r.radius[l], r.patches[p].radius[l]);
    }
    STP_TRY(stp_object_texture_upload(&c->texture, chunk, &r.placement, r.patches, err));
    c->slots[slot] = r;
    c->slot_of[want->chunk] = slot;
    r.patches = NULL;
    r.bounds = NULL;
done:
    if (status != STP_OK)
        stp_object_texture_release(&c->texture, &r.placement);
    free(r.patches);
    free(r.bounds);
    return status;
}

static stp_status decode_task(void *context, size_t index, unsigned worker, stp_error *err)
{
    decode_job *job = context;
    (void)worker;
    (void)err;
    const stp_want *want = &job->wants[index];
    job->errors[index].status =
        stp_chunk_file_read(job->cache->model->file, want->chunk, want->finest, &job->chunks[index],
                            &job->errors[index]);
    return STP_OK; /* one damaged chunk does not stop the others */
}

/* Notes damage; any other failure is the caller's. */
static stp_status take_failure(stp_chunk_cache *c, uint32_t chunk, const stp_error *failure,
                               stp_error *err)
{
    if (failure->status != STP_CORRUPT && failure->status != STP_UNSUPPORTED)
        return stp_error_set(err, failure->status, "%s", failure->message);
    if (!c->damaged[chunk] && c->damage[0] == '\0')
        snprintf(c->damage, sizeof c->damage, "%.500s", failure->message);
    c->damaged[chunk] = true;
    return STP_OK;
}

/* The next wants that are not there, at most a batch of them; *end: how far it looked. */
static void fill_batch(decode_job *job, const stp_want *wants, size_t count, size_t begin,
                       size_t limit, uint64_t stamp, size_t *end)
{
    stp_chunk_cache *c = job->cache;
    size_t i = begin;
    job->count = 0;
    for (; i < count && job->count < limit; i++) {
        uint32_t chunk = wants[i].chunk;
        if (c->damaged[chunk])
            continue;
        if (stp_chunk_cache_finest(c, chunk) <= wants[i].finest)
            stp_chunk_cache_touch(c, chunk, stamp);
        else
            job->wants[job->count++] = wants[i];
    }
    *end = i;
}

static stp_status load_batch(decode_job *job, uint64_t stamp, size_t *stored_count, bool *damaged,
                             stp_error *err)
{
    stp_chunk_cache *c = job->cache;
    stp_status status = stp_pool_run(c->pool, job->count, decode_task, job, err);
    bool stored = true;
    *stored_count = 0;
    for (size_t i = 0; i < job->count; i++) {
        const stp_want *want = &job->wants[i];
        const stp_chunk_entry *entry = &c->model->entries[want->chunk];
        if (status == STP_OK && stored && job->chunks[i] != NULL) {
            c->bytes_read += entry->segment_end[STP_SEGMENT_COUNT - 1 - want->finest];
            status = store(c, want, job->chunks[i], stamp, &stored, err);
        } else if (status == STP_OK && job->errors[i].status != STP_OK) {
            status = take_failure(c, want->chunk, &job->errors[i], err);
            *damaged = true;
        }
        *stored_count += status == STP_OK && stored;
        stp_chunk_destroy(&job->chunks[i]);
    }
    return status;
}

stp_status stp_chunk_cache_load(stp_chunk_cache *c, const stp_want *wants, size_t count,
                                uint64_t stamp, double deadline, size_t *loaded, bool *damaged,
                                stp_error *err)
{
    stp_status status = STP_OK;
    size_t begin = 0;
    *loaded = 0;
    *damaged = false;
    while (begin < count) {
        decode_job job = {.cache = c};
        size_t end = 0, stored = 0;
        fill_batch(&job, wants, count, begin, c->batch, stamp, &end);
        if (job.count > 0 && deadline > 0.0 && stp_clock_seconds() >= deadline)
            break;
        status = load_batch(&job, stamp, &stored, damaged, err);
        if (status != STP_OK)
            return status;
        if (stored < job.count) { /* full: count up to the first that has no room */
            while (begin < end &&
                   (c->damaged[wants[begin].chunk] ||
                    stp_chunk_cache_finest(c, wants[begin].chunk) <= wants[begin].finest))
                begin++;
            break;
        }
        begin = end;
    }
    *loaded = begin;
    return STP_OK;
}

void stp_chunk_cache_touch(stp_chunk_cache *c, uint32_t chunk, uint64_t stamp)
{
    if (c->slot_of[chunk] != NO_SLOT)
        c->slots[c->slot_of[chunk]].last_used = stamp;
}

/* Room for the whole model, or for as much of it as the budget holds. */
static stp_status choose_capacity(const stp_model *model, uint64_t budget, uint32_t out[3],
                                  stp_error *err)
{
    uint64_t samples = 0, patches = 0, most_samples = 0, most_patches = 0;
    for (uint32_t id = 0; id < model->info->chunk_count; id++) {
        const stp_chunk_entry *e = &model->entries[id];
        uint64_t own = 0;
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            own += e->sample_count[l];
        samples += own;
        patches += e->patch_count;
        most_samples = own > most_samples ? own : most_samples;
        most_patches = e->patch_count > most_patches ? e->patch_count : most_patches;
    }
    uint64_t total = stp_model_gpu_bytes(model);
    double share = total > budget ? (double)budget / (double)total : 1.0;
    uint64_t sample_capacity = (uint64_t)(share * (double)samples);
    uint64_t patch_capacity = (uint64_t)(share * (double)patches);
    if (share < 1.0 && (sample_capacity < 2 * most_samples || patch_capacity < 2 * most_patches)) {
        double most_share =
            fmax((double)most_samples / (double)samples, (double)most_patches / (double)patches);
        unsigned long long needed_mib =
            1 + ((1 + (uint64_t)(2.0 * (double)total * most_share)) >> 20);
        return stp_error_set(err, STP_LIMIT,
                             "%s: a GPU memory of %llu bytes holds not even two chunks: give "
                             "--gpu-memory %lluM or more",
                             stp_chunk_file_path(model->file), (unsigned long long)budget,
                             needed_mib);
    }
    out[0] = (uint32_t)(sample_capacity < UINT32_MAX ? sample_capacity : UINT32_MAX);
    out[1] = (uint32_t)(patch_capacity < UINT32_MAX ? patch_capacity : UINT32_MAX);
    out[2] = model->info->chunk_count;
    return STP_OK;
}

/* Two chunks a thread, as long as the CPU's budget holds them; at least one. */
static size_t choose_batch(const stp_model *model, const stp_pool *pool, uint64_t cpu_bytes)
{
    size_t most = 1, batch = 2 * (size_t)stp_pool_thread_count(pool);
    for (uint32_t id = 0; id < model->info->chunk_count; id++) {
        size_t bytes = stp_chunk_memory_bytes(&model->entries[id], 0);
        most = bytes > most ? bytes : most;
    }
    uint64_t fit = (cpu_bytes != 0 ? cpu_bytes : DEFAULT_CPU_BYTES) / most;
    batch = batch < BATCH_LIMIT ? batch : BATCH_LIMIT;
    return fit < 1 ? 1 : fit < batch ? (size_t)fit : batch;
}

stp_status stp_chunk_cache_create(stp_chunk_cache **out, const stp_chunk_cache_params *params,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_cache *c = NULL;
    const stp_model *model = params->model;
    uint64_t budget = params->gpu_bytes != 0 ? params->gpu_bytes : DEFAULT_GPU_BYTES;
    uint32_t capacity[3] = {0, 0, 0};
    size_t loaded = 0;
    bool damaged = false;
    STP_TRY(choose_capacity(model, budget, capacity, err));
    STP_TRY(stp_alloc(&c, 1, sizeof *c, "a chunk cache", err));
    c->model = model;
    c->pool = params->pool;
    c->batch = choose_batch(model, params->pool, params->cpu_bytes);
    STP_TRY(stp_alloc(&c->slot_of, model->info->chunk_count, sizeof *c->slot_of, "slots", err));
    memset(c->slot_of, 0xff, model->info->chunk_count * sizeof *c->slot_of);
    STP_TRY(stp_alloc(&c->damaged, model->info->chunk_count, sizeof *c->damaged, "slots", err));
    STP_TRY(stp_alloc(&c->slots, capacity[2], sizeof *c->slots, "slots", err));
    for (uint32_t s = 0; s < capacity[2]; s++)
        c->slots[s].chunk = STP_CHUNK_NONE;
    STP_TRY(stp_object_texture_create(&c->texture, capacity[0], capacity[1], capacity[2], err));
    STP_TRY(stp_chunk_cache_load(c, &(stp_want){0, 0}, 1, 1, 0.0, &loaded, &damaged, err));
    if (damaged || loaded < 1) {
        status = stp_error_set(err, STP_CORRUPT, "%s", c->damage);
        goto done;
    }
    *out = c;
    c = NULL;
done:
    stp_chunk_cache_destroy(&c);
    return status;
}

void stp_chunk_cache_destroy(stp_chunk_cache **cache)
{
    stp_chunk_cache *c = *cache;
    if (c == NULL)
        return;
    for (uint32_t s = 0; c->slots != NULL && s < c->texture.slot_capacity; s++) {
        free(c->slots[s].patches);
        free(c->slots[s].bounds);
    }
    stp_object_texture_destroy(&c->texture);
    free(c->slots);
    free(c->slot_of);
    free(c->damaged);
    free(c);
    *cache = NULL;
}
