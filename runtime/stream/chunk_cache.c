/* Keeps chunks in the Object Texture. */
#include "runtime/stream/chunk_cache.h"

#include "base/clock.h"
#include "base/memory.h"
#include "runtime/cut/level_rule.h"
#include "runtime/gl/gl_context.h"
#include "runtime/stream/damage_log.h"
#include "runtime/stream/upload_ring.h"

#include <stdlib.h>
#include <string.h>

#define NO_SLOT UINT32_MAX
/* After so many frames without use, the need of a chunk counts half. */
#define AGE_FRAMES 120.0f
/* After a failed read the stream rests so long; after each further failure twice as long. */
#define REST_LEAST_S 1.0
#define REST_MOST_S 8.0

struct stp_chunk_cache {
    const stp_scene *scene;
    stp_budget budget;
    stp_stream *stream;
    stp_upload_ring ring;
    stp_object_texture texture;
    stp_resident *slots;
    uint32_t *free_slots; /* stack */
    uint32_t free_count;
    uint32_t *slot_of; /* by chunk */
    stp_damage_log damage;
    stp_gpu_frame frame; /* need is measured from this view */
    stp_dvec3 eye;
    stp_want *wants;
    size_t want_count, want_capacity, ahead;
    bool refused;       /* a want found no room; wants are not asked for again */
    bool ahead_refused; /* the same for chunks that will be wanted soon */
    double rest_until, rest_s;
    char trouble[512];
};

const stp_object_texture *stp_chunk_cache_texture(const stp_chunk_cache *cache)
{
    return &cache->texture;
}

const stp_budget *stp_chunk_cache_budget(const stp_chunk_cache *cache)
{
    return &cache->budget;
}

int stp_chunk_cache_finest(const stp_chunk_cache *cache, uint32_t chunk)
{
    uint32_t slot = cache->slot_of[chunk];
    return slot == NO_SLOT ? STP_NOT_RESIDENT : cache->slots[slot].finest;
}

bool stp_chunk_cache_damaged(const stp_chunk_cache *cache, uint32_t chunk)
{
    return cache->damage.damaged[chunk];
}

bool stp_chunk_cache_used(const stp_chunk_cache *cache, uint32_t chunk, uint64_t stamp)
{
    uint32_t slot = cache->slot_of[chunk];
    return slot != NO_SLOT && cache->slots[slot].last_used == stamp;
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
    return stp_stream_bytes_read(cache->stream);
}

uint64_t stp_chunk_cache_gpu_used(const stp_chunk_cache *cache)
{
    uint64_t bytes = 0;
    for (uint32_t s = 0; s < cache->texture.slot_capacity; s++) {
        const stp_resident *r = &cache->slots[s];
        if (r->chunk != STP_CHUNK_NONE)
            bytes += r->placement.samples.count * (uint64_t)STP_OBJECT_TEXTURE_SAMPLE_BYTES +
                     r->placement.patches.count * (uint64_t)STP_OBJECT_TEXTURE_PATCH_BYTES;
    }
    return bytes;
}

const char *stp_chunk_cache_damage(const stp_chunk_cache *cache)
{
    return cache->damage.words;
}

const char *stp_chunk_cache_trouble(const stp_chunk_cache *cache)
{
    return cache->trouble;
}

size_t stp_chunk_cache_pending(const stp_chunk_cache *cache)
{
    return stp_stream_pending(cache->stream);
}

bool stp_chunk_cache_rests(const stp_chunk_cache *cache)
{
    return stp_clock_seconds() < cache->rest_until;
}

bool stp_chunk_cache_has_news(const stp_chunk_cache *cache)
{
    return stp_stream_has_news(cache->stream);
}

void stp_chunk_cache_look(stp_chunk_cache *cache, const stp_gpu_frame *frame, stp_dvec3 eye)
{
    cache->frame = *frame;
    cache->eye = eye;
}

void stp_chunk_cache_touch(stp_chunk_cache *c, uint32_t chunk, uint64_t stamp)
{
    if (c->slot_of[chunk] != NO_SLOT)
        c->slots[c->slot_of[chunk]].last_used = stamp;
}

/* ---- making room ---- */

static void evict(stp_chunk_cache *c, uint32_t slot)
{
    stp_resident *r = &c->slots[slot];
    stp_object_texture_release(&c->texture, &r->placement);
    free(r->patches);
    free(r->briefs);
    c->slot_of[r->chunk] = NO_SLOT;
    *r = (stp_resident){.chunk = STP_CHUNK_NONE};
    c->free_slots[c->free_count++] = slot;
}

/* Pixels of error that the parent would show, if the chunk faced the eye and lay in front of it. So
 * a chunk is never needed more than its parent. */
static float need_of(const stp_chunk_cache *c, uint32_t chunk)
{
    const stp_chunk_entry *e = &c->scene->entries[chunk];
    stp_ball ball = stp_entry_ball(e, c->eye);
    float f = c->frame.viewport[2], error = e->error[STP_LEVEL_COUNT - 1];
    float distance = (float)(stp_dvec3_length(ball.centre) - ball.radius);
    return c->frame.modes[0] != 0
               ? error * f
               : error * f / fmaxf(distance, fmaxf(c->frame.viewport[3], 1e-30f));
}

/* The slot that is needed least among those last used before stamp, or NO_SLOT. A chunk needed
 * `limit` or more stays. */
static uint32_t find_victim(const stp_chunk_cache *c, uint64_t stamp, float limit)
{
    uint32_t victim = NO_SLOT;
    float least = limit;
    for (uint32_t s = 0; s < c->texture.slot_capacity; s++) {
        const stp_resident *r = &c->slots[s];
        if (r->chunk == STP_CHUNK_NONE || r->last_used >= stamp ||
            c->scene->entries[r->chunk].parent == STP_CHUNK_NONE)
            continue;
        float need = need_of(c, r->chunk) / (1.0f + (float)(stamp - r->last_used) / AGE_FRAMES);
        if (need < least) {
            victim = s;
            least = need;
        }
    }
    return victim;
}

/* Evicts until there are a slot and a place; false if evicting all that may go is not enough. */
static bool make_room(stp_chunk_cache *c, const stp_want *want, uint64_t stamp, float limit,
                      stp_load_place *place, stp_status *status, stp_error *err)
{
    const stp_chunk_entry *entry = &c->scene->entries[want->chunk];
    for (;;) {
        if (c->free_count > 0 && stp_object_texture_place(&c->texture, entry, want->finest,
                                                          &place->placement, status, err)) {
            place->slot = c->free_slots[--c->free_count];
            return true;
        }
        uint32_t victim = *status == STP_OK ? find_victim(c, stamp, limit) : NO_SLOT;
        if (victim == NO_SLOT)
            return false;
        evict(c, victim);
    }
}

static void give_place(stp_chunk_cache *c, const stp_load_place *place)
{
    stp_object_texture_release(&c->texture, &place->placement);
    c->free_slots[c->free_count++] = place->slot;
}

/* Sends a FETCHED load to the decoders. *room is false if there is no room: in the ring at the
 * moment, or in the Object Texture. */
static stp_status place(stp_chunk_cache *c, stp_load *load, uint64_t stamp, float limit, bool *room,
                        bool *ring_full, stp_error *err)
{
    stp_status status = STP_OK;
    stp_load_place p = {0};
    *ring_full = false;
    *room = make_room(c, &load->want, stamp, limit, &p, &status, err);
    if (!*room)
        return status;
    if (!stp_upload_ring_take(&c->ring, stp_load_bytes(&p.placement), &p.piece, &status, err)) {
        give_place(c, &p);
        *room = false;
        *ring_full = true;
        return status;
    }
    p.memory = stp_upload_ring_memory(&c->ring, p.piece);
    stp_stream_decode(c->stream, load, &p);
    return STP_OK;
}

/* ---- taking in what has arrived ---- */

static void copy(const stp_chunk_cache *c, GLuint buffer, uint64_t from, uint64_t to,
                 uint64_t bytes)
{
    if (bytes > 0)
        glCopyNamedBufferSubData(c->ring.buffer, buffer, (GLintptr)from, (GLintptr)to,
                                 (GLsizeiptr)bytes);
}

/* Makes a DONE load resident. It replaces a coarser version of the chunk. */
static void commit(stp_chunk_cache *c, stp_load *load, uint64_t stamp)
{
    const stp_load_place *p = &load->place;
    const stp_placement *at = &p->placement;
    uint64_t begin = stp_upload_ring_offset(p->piece);
    copy(c, c->texture.samples, begin, at->samples.begin * (uint64_t)sizeof(stp_sample),
         stp_load_numbers_offset(at));
    copy(c, c->texture.patch_of_sample, begin + stp_load_numbers_offset(at),
         at->samples.begin * (uint64_t)sizeof(uint32_t),
         stp_load_patches_offset(at) - stp_load_numbers_offset(at));
    copy(c, c->texture.patches, begin + stp_load_patches_offset(at),
         at->patches.begin * (uint64_t)sizeof(stp_gpu_patch),
         stp_load_bytes(at) - stp_load_patches_offset(at));
    stp_upload_ring_copied(&c->ring, p->piece);
    if (c->slot_of[load->want.chunk] != NO_SLOT)
        evict(c, c->slot_of[load->want.chunk]);
    stp_resident *r = &c->slots[p->slot];
    *r = (stp_resident){.chunk = load->want.chunk,
                        .finest = load->want.finest,
                        .last_used = stamp,
                        .placement = *at,
                        .patches = load->patches,
                        .briefs = load->briefs};
    c->slot_of[r->chunk] = p->slot;
    load->patches = NULL;
    load->briefs = NULL;
}

/* Gives back the place of a load that failed after it was placed. */
static void give_back(stp_chunk_cache *c, const stp_load *load)
{
    if (load->place.memory == NULL)
        return;
    give_place(c, &load->place);
    stp_upload_ring_give(&c->ring, load->place.piece);
}

/* Whether the chunk is damaged in the file, and not just held back by a server. */
static bool is_damage(const stp_load *load)
{
    bool placed = load->place.memory != NULL;
    return load->error.status == STP_CORRUPT || (placed && load->error.status == STP_UNSUPPORTED);
}

/* Records that the file cannot be read at the moment: the stream rests, longer each time. Reads
 * that were under way when the rest began count as the same failure, even if they fail after it. */
static void note_trouble(stp_chunk_cache *c, const stp_load *load)
{
    double now_s = stp_clock_seconds();
    if (now_s < c->rest_until || (load->dropped && c->trouble[0] != '\0'))
        return;
    snprintf(c->trouble, sizeof c->trouble, "%.500s", load->error.message);
    c->rest_s = c->rest_s > 0.0 ? fmin(2.0 * c->rest_s, REST_MOST_S) : REST_LEAST_S;
    c->rest_until = now_s + c->rest_s;
}

/* Takes in one load; adds the bytes copied to *bytes. */
static void take_in(stp_chunk_cache *c, stp_load *load, uint64_t stamp, uint64_t *bytes)
{
    if (load->state == STP_LOAD_DONE) {
        *bytes += stp_load_bytes(&load->place.placement);
        commit(c, load, stamp);
        c->trouble[0] = '\0';
        c->rest_s = c->rest_until = 0.0; /* the stream rests only while there is trouble */
    } else {
        give_back(c, load);
        if (is_damage(load))
            stp_damage_log_note(&c->damage, load->want.chunk, load->error.message);
        else
            note_trouble(c, load);
    }
    stp_stream_release(c->stream, load);
}

/* ---- beside the frame ---- */

static bool is_ahead(const stp_chunk_cache *c, uint32_t chunk)
{
    for (size_t i = 0; i < c->ahead; i++)
        if (c->wants[i].chunk == chunk)
            return false;
    return true;
}

stp_status stp_chunk_cache_update(stp_chunk_cache *c, uint64_t stamp, stp_error *err)
{
    stp_load *load = NULL;
    uint64_t bytes = 0;
    while (bytes < STP_CACHE_FRAME_BYTES && stp_upload_ring_may_copy(&c->ring) &&
           (load = stp_stream_next_done(c->stream)) != NULL)
        take_in(c, load, stamp, &bytes);
    stp_upload_ring_fence(&c->ring);
    while ((load = stp_stream_next_fetched(c->stream)) != NULL) {
        bool room = false, ring_full = false, ahead = is_ahead(c, load->want.chunk);
        float limit = ahead ? need_of(c, load->want.chunk) : INFINITY;
        stp_status status = place(c, load, stamp, limit, &room, &ring_full, err);
        if (status != STP_OK || ring_full)
            return status;
        if (room)
            continue;
        c->refused = c->refused || !ahead;
        c->ahead_refused = c->ahead_refused || ahead;
        stp_stream_release(c->stream, load);
    }
    return stp_gl_check("uploading chunks", err);
}

void stp_chunk_cache_want(stp_chunk_cache *c, const stp_want *wants, size_t count, size_t ahead)
{
    bool same = count == c->want_count &&
                (count == 0 || memcmp(wants, c->wants, count * sizeof *wants) == 0);
    if (stp_grow(&c->wants, &c->want_capacity, count, sizeof *c->wants, "a list of chunks", NULL) !=
        STP_OK)
        count = 0;
    if (count > 0)
        memcpy(c->wants, wants, count * sizeof *wants);
    c->refused = c->refused && same;
    c->ahead_refused = c->ahead_refused && same;
    c->want_count = count;
    c->ahead = ahead < count ? ahead : count;
    bool rests = stp_chunk_cache_rests(c);
    if (count == 0 && !rests)
        c->trouble[0] = '\0';
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
        if (l->wants[i].chunk == load->want.chunk)
            return true;
    return false;
}

/* Takes in all loads that are DONE or FAILED. Puts a fence behind their copies, which later frees
 * their pieces of the ring. */
static stp_status take_news(stp_chunk_cache *c, stp_cache_load *l, stp_error *err)
{
    stp_load *load = NULL;
    uint64_t bytes = 0;
    while ((load = stp_stream_next_done(c->stream)) != NULL) {
        bool failed = load->state == STP_LOAD_FAILED, broken = failed && is_damage(load);
        bool own = is_own(l, load);
        stp_error error = load->error;
        if (!stp_upload_ring_may_copy(&c->ring))
            stp_upload_ring_fence(&c->ring);
        take_in(c, load, l->stamp, &bytes);
        if (failed && !broken && own)
            return stp_error_set(err, error.status, "%s", error.message);
        l->damaged = l->damaged || broken;
    }
    stp_upload_ring_fence(&c->ring);
    return STP_OK;
}

/* Whether a want needs nothing more. */
static bool settled(stp_chunk_cache *c, const stp_want *want, uint64_t stamp)
{
    if (c->damage.damaged[want->chunk])
        return true;
    if (stp_chunk_cache_finest(c, want->chunk) > want->finest)
        return false;
    stp_chunk_cache_touch(c, want->chunk, stamp);
    return true;
}

/* Evicts a coarser version, whose room the finer one needs. */
static void evict_coarser(stp_chunk_cache *c, const stp_want *want)
{
    uint32_t slot = c->slot_of[want->chunk];
    if (slot != NO_SLOT && c->slots[slot].finest > want->finest &&
        c->scene->entries[want->chunk].parent != STP_CHUNK_NONE)
        evict(c, slot);
}

/* Places the next want in order, if its payload has been read. */
static stp_status place_next(stp_chunk_cache *c, stp_cache_load *l, bool *placed, stp_error *err)
{
    const stp_want *want = &l->wants[l->begun];
    stp_load *load = stp_stream_find(c->stream, want->chunk);
    *placed = false;
    if (load == NULL || load->state != STP_LOAD_FETCHED)
        return STP_OK;
    if (load->want.finest > want->finest) { /* it was begun for another picture */
        stp_stream_release(c->stream, load);
        return STP_OK;
    }
    evict_coarser(c, want);
    stp_status status = place(c, load, l->stamp, INFINITY, placed, &l->ring_full, err);
    l->full = !*placed && !l->ring_full;
    return status;
}

/* Takes in loads that are done, and places loads that are read. */
static stp_status load_round(stp_chunk_cache *c, stp_cache_load *l, stp_error *err)
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

stp_status stp_chunk_cache_load_step(stp_chunk_cache *c, stp_cache_load *l, bool *finished,
                                     stp_error *err)
{
    stp_status status = STP_OK;
    bool more = false;
    if (!l->started)
        stp_stream_want(c->stream, NULL, 0);
    l->started = true;
    do {
        STP_TRY(load_round(c, l, err));
        more = l->begun < l->count && !l->full;
        *finished = l->there == l->begun && !more;
    } while (!*finished && l->ring_full && stp_upload_ring_wait(&c->ring));
    if (more && stp_stream_find(c->stream, l->wants[l->begun].chunk) == NULL)
        stp_stream_want(c->stream, l->wants + l->begun, l->count - l->begun);
    STP_TRY(stp_gl_check("uploading chunks", err));
done:
    if (status != STP_OK || *finished)
        stp_stream_want(c->stream, NULL, 0);
    return status;
}

stp_status stp_chunk_cache_load(stp_chunk_cache *c, stp_cache_load *l, stp_error *err)
{
    bool finished = false;
    c->rest_until = 0.0;
    while (!finished) {
        uint64_t seen = stp_stream_news_count(c->stream);
        stp_status status = stp_chunk_cache_load_step(c, l, &finished, err);
        if (status != STP_OK)
            return status;
        if (!finished)
            stp_stream_wait(c->stream, seen);
    }
    return STP_OK;
}

/* ---- creation ---- */

/* Lists the root of each model. */
static void list_roots(const stp_chunk_cache *c, stp_want roots[STP_SCENE_MODELS_LIMIT])
{
    for (size_t i = 0; i < c->scene->model_count; i++)
        roots[i] = (stp_want){c->scene->models[i].first, 0};
}

static stp_status load_roots(stp_chunk_cache *c, stp_error *err)
{
    stp_want roots[STP_SCENE_MODELS_LIMIT];
    stp_cache_load load = {.wants = roots, .count = c->scene->model_count, .stamp = 1};
    list_roots(c, roots);
    stp_status status = stp_chunk_cache_load(c, &load, err);
    if (status == STP_OK && load.damaged)
        status = stp_error_set(err, STP_CORRUPT, "%s", c->damage.words);
    if (status == STP_OK && load.there < load.count)
        status = stp_error_set(err, STP_LIMIT,
                               "%zu models do not fit in the GPU memory given: give a larger "
                               "--gpu-memory",
                               load.count);
    return status;
}

static stp_status create_tables(stp_chunk_cache *c, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t count = c->scene->chunk_count, slots = c->budget.slot_capacity;
    STP_TRY(stp_alloc(&c->slot_of, count, sizeof *c->slot_of, "slots", err));
    memset(c->slot_of, 0xff, count * sizeof *c->slot_of);
    STP_TRY(stp_damage_log_create(&c->damage, count, err));
    STP_TRY(stp_alloc(&c->slots, slots, sizeof *c->slots, "slots", err));
    STP_TRY(stp_alloc(&c->free_slots, slots, sizeof *c->free_slots, "slots", err));
    for (uint32_t s = 0; s < slots; s++) {
        c->slots[s].chunk = STP_CHUNK_NONE;
        c->free_slots[slots - 1 - s] = s;
    }
    c->free_count = slots;
done:
    return status;
}

stp_status stp_chunk_cache_create(stp_chunk_cache **out, const stp_chunk_cache_params *params,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_cache *c = NULL;
    stp_want roots[STP_SCENE_MODELS_LIMIT];
    stp_budget b;
    STP_TRY(stp_budget_plan(&b, params->scene, params->gpu_bytes, params->cpu_bytes,
                            params->thread_count, err));
    STP_TRY(stp_alloc(&c, 1, sizeof *c, "a chunk cache", err));
    c->scene = params->scene;
    c->budget = b;
    STP_TRY(create_tables(c, err));
    STP_TRY(stp_stream_create(&c->stream,
                              &(stp_stream_params){.scene = params->scene,
                                                   .payload_bytes = b.payload_bytes,
                                                   .decoder_count = b.decoder_count,
                                                   .wake = params->wake,
                                                   .wake_context = params->wake_context},
                              err));
    /* Roots are read while GL makes its buffers, which some drivers fill with zeros. */
    list_roots(c, roots);
    stp_stream_want(c->stream, roots, params->scene->model_count);
    STP_TRY(stp_object_texture_create(&c->texture, b.sample_capacity, b.patch_capacity,
                                      b.slot_capacity, err));
    STP_TRY(stp_upload_ring_create(&c->ring, b.ring_bytes, err));
    STP_TRY(load_roots(c, err));
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
    stp_stream_destroy(&c->stream); /* first, since decoders write into the ring */
    for (uint32_t s = 0; c->slots != NULL && s < c->texture.slot_capacity; s++) {
        free(c->slots[s].patches);
        free(c->slots[s].briefs);
    }
    stp_upload_ring_destroy(&c->ring);
    stp_object_texture_destroy(&c->texture);
    free(c->slots);
    free(c->free_slots);
    free(c->slot_of);
    stp_damage_log_destroy(&c->damage);
    free(c->wants);
    free(c);
    *cache = NULL;
}
