/* Runs readers and decoders around one table of loads. */
#include "runtime/stream/stream.h"

#include "base/memory.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#ifdef __linux__
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

#define THREADS_LIMIT 64
/* Frames come first: decoders use the processors that the frame leaves free. */
#define DECODER_NICE 10

struct stp_stream {
    const stp_scene *scene;
    void (*wake)(void *);
    void *wake_context;
    pthread_t threads[THREADS_LIMIT];
    unsigned thread_count;
    pthread_mutex_t mutex; /* guards all members below; innermost, except for a file's own */
    pthread_cond_t work;   /* wakes readers and decoders */
    pthread_cond_t news;   /* wakes the render thread */
    bool quit;
    stp_payload_store store;
    stp_want wants[STP_STREAM_WANTS_LIMIT];
    size_t want_count, want_next;
    stp_load loads[STP_STREAM_LOADS_LIMIT];
    uint64_t bytes_read, news_count;
};

uint64_t stp_load_numbers_offset(const stp_placement *placement)
{
    return (uint64_t)placement->samples.count * sizeof(stp_sample);
}

uint64_t stp_load_patches_offset(const stp_placement *placement)
{
    return stp_load_numbers_offset(placement) +
           (uint64_t)placement->samples.count * sizeof(uint32_t);
}

uint64_t stp_load_bytes(const stp_placement *placement)
{
    return stp_load_patches_offset(placement) +
           (uint64_t)placement->patches.count * sizeof(stp_gpu_patch);
}

static bool state_has_news(stp_load_state state)
{
    return state == STP_LOAD_FETCHED || state == STP_LOAD_DONE || state == STP_LOAD_FAILED;
}

static void set_state(stp_stream *s, stp_load *load, stp_load_state state)
{
    load->state = state;
    if (state == STP_LOAD_PLACED || state == STP_LOAD_FREE)
        pthread_cond_broadcast(&s->work);
    if (!state_has_news(state))
        return;
    s->news_count++;
    pthread_cond_signal(&s->news);
    if (s->wake != NULL)
        s->wake(s->wake_context);
}

/* ---- reading ---- */

static stp_load *find_load(stp_stream *s, uint32_t chunk)
{
    for (size_t i = 0; i < STP_STREAM_LOADS_LIMIT; i++)
        if (s->loads[i].state != STP_LOAD_FREE && s->loads[i].want.chunk == chunk)
            return &s->loads[i];
    return NULL;
}

static stp_load *find_free(stp_stream *s)
{
    for (size_t i = 0; i < STP_STREAM_LOADS_LIMIT; i++)
        if (s->loads[i].state == STP_LOAD_FREE)
            return &s->loads[i];
    return NULL;
}

static uint32_t payload_bytes(const stp_stream *s, const stp_want *want)
{
    return stp_chunk_payload_bytes(&s->scene->entries[want->chunk], want->finest);
}

/* Begins the next wants. A want whose payload is in memory becomes FETCHED at once. The first other
 * one is returned for the caller to read; *known bytes of it are in memory. NULL: nothing to
 * begin. */
static stp_load *begin_next(stp_stream *s, uint32_t *known)
{
    while (s->want_next < s->want_count) {
        const stp_want *want = &s->wants[s->want_next];
        stp_load *load = find_free(s);
        stp_status status = STP_OK;
        uint32_t bytes = payload_bytes(s, want);
        if (load == NULL)
            return NULL;
        if (find_load(s, want->chunk) != NULL) {
            s->want_next++;
            continue;
        }
        *load = (stp_load){.want = *want, .rank = (unsigned)s->want_next};
        if (stp_payload_store_find(&s->store, want->chunk, bytes, &load->payload)) {
            s->want_next++;
            set_state(s, load, STP_LOAD_FETCHED);
            continue;
        }
        bool made = stp_payload_store_make(&s->store, want->chunk, bytes, &load->payload, known,
                                           &status, &load->error);
        if (!made && status == STP_OK)
            return NULL; /* until a payload is unpinned */
        s->want_next++;
        if (!made) {
            load->error.status = status;
            set_state(s, load, STP_LOAD_FAILED);
            continue;
        }
        load->state = STP_LOAD_FETCHING;
        return load;
    }
    return NULL;
}

static void read_load(stp_stream *s, stp_load *load, uint32_t known)
{
    const stp_scene_model *m = stp_scene_find(s->scene, load->want.chunk);
    uint32_t bytes = payload_bytes(s, &load->want);
    uint8_t *memory = stp_payload_memory(&s->store, load->payload);
    pthread_mutex_unlock(&s->mutex);
    stp_error error = {0};
    stp_status status = stp_chunk_file_fetch(m->model->file, load->want.chunk - m->first, known,
                                             bytes, memory + known, &error);
    pthread_mutex_lock(&s->mutex);
    if (status == STP_OK) {
        s->bytes_read += bytes - known;
        stp_payload_store_filled(&s->store, load->payload, bytes);
    }
    load->error = error;
    load->error.status = status;
    set_state(s, load, status == STP_OK ? STP_LOAD_FETCHED : STP_LOAD_FAILED);
}

static void *run_reader(void *context)
{
    stp_stream *s = context;
    pthread_mutex_lock(&s->mutex);
    while (!s->quit) {
        uint32_t known = 0;
        stp_load *load = begin_next(s, &known);
        if (load != NULL)
            read_load(s, load, known);
        else
            pthread_cond_wait(&s->work, &s->mutex);
    }
    pthread_mutex_unlock(&s->mutex);
    return NULL;
}

/* ---- decoding ---- */

static void number_patches(const stp_chunk *chunk, const stp_placement *placement, uint32_t *out)
{
    for (int l = chunk->finest_level; l < STP_LEVEL_COUNT; l++) {
        const uint32_t *begin = chunk->level_begin[l];
        uint32_t *level = out + (placement->level_begin[l] - placement->samples.begin);
        for (uint32_t p = 0; p < chunk->patch_count; p++)
            for (uint32_t i = begin[p]; i < begin[p + 1]; i++)
                level[i] = placement->patches.begin + p;
    }
}

static void write_piece(const stp_load *load, const stp_chunk *chunk)
{
    const stp_placement *p = &load->place.placement;
    uint8_t *memory = load->place.memory;
    for (int l = chunk->finest_level; l < STP_LEVEL_COUNT; l++)
        memcpy(memory + (size_t)(p->level_begin[l] - p->samples.begin) * sizeof(stp_sample),
               chunk->samples[l],
               (size_t)chunk->level_begin[l][chunk->patch_count] * sizeof(stp_sample));
    number_patches(chunk, p, (uint32_t *)(void *)(memory + stp_load_numbers_offset(p)));
    memcpy(memory + stp_load_patches_offset(p), load->patches,
           (size_t)p->patches.count * sizeof *load->patches);
}

/* Fills the CPU's copies of the patches. shapes: as in stp_gpu_patches_fill. */
static stp_status mirror_patches(stp_load *load, const stp_chunk *chunk, unsigned shapes,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&load->patches, chunk->patch_count, sizeof *load->patches, "patches", err));
    STP_TRY(stp_alloc(&load->briefs, chunk->patch_count, sizeof *load->briefs, "patches", err));
    stp_gpu_patches_fill(load->patches, chunk, &load->place.placement, load->place.slot, shapes);
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        load->briefs[p] = stp_patch_brief_of(&load->patches[p], &chunk->patches[p]);
done:
    return status;
}

static stp_status decode(const stp_stream *s, stp_load *load, stp_chunk_scratch *scratch,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    const stp_scene_model *m = stp_scene_find(s->scene, load->want.chunk);
    STP_TRY(stp_chunk_file_decode(m->model->file, load->want.chunk - m->first, load->want.finest,
                                  stp_payload_memory(&s->store, load->payload), scratch, &chunk,
                                  err));
    STP_TRY(mirror_patches(load, chunk, stp_scene_shapes(s->scene), err));
    write_piece(load, chunk);
done:
    stp_chunk_recycle(&chunk, scratch);
    return status;
}

/* The most wanted load in a state, or NULL. */
static stp_load *first_of(stp_stream *s, stp_load_state state)
{
    stp_load *first = NULL;
    for (size_t i = 0; i < STP_STREAM_LOADS_LIMIT; i++)
        if (s->loads[i].state == state && (first == NULL || s->loads[i].rank < first->rank))
            first = &s->loads[i];
    return first;
}

static void decode_load(stp_stream *s, stp_load *load, stp_chunk_scratch *scratch)
{
    stp_error error = {0};
    load->state = STP_LOAD_DECODING;
    pthread_mutex_unlock(&s->mutex);
    stp_status status = decode(s, load, scratch, &error);
    pthread_mutex_lock(&s->mutex);
    load->error = error;
    load->error.status = status;
    set_state(s, load, status == STP_OK ? STP_LOAD_DONE : STP_LOAD_FAILED);
}

static void *run_decoder(void *context)
{
    stp_stream *s = context;
    stp_chunk_scratch scratch = {0};
#ifdef __linux__
    (void)setpriority(PRIO_PROCESS, (id_t)syscall(SYS_gettid), DECODER_NICE);
#endif
    pthread_mutex_lock(&s->mutex);
    while (!s->quit) {
        stp_load *load = first_of(s, STP_LOAD_PLACED);
        if (load != NULL)
            decode_load(s, load, &scratch);
        else
            pthread_cond_wait(&s->work, &s->mutex);
    }
    pthread_mutex_unlock(&s->mutex);
    stp_chunk_scratch_free(&scratch);
    return NULL;
}

/* ---- the render thread's side ---- */

static stp_status start(stp_stream *s, void *(*run)(void *), unsigned count, stp_error *err)
{
    for (unsigned i = 0; i < count && s->thread_count < THREADS_LIMIT; i++) {
        if (pthread_create(&s->threads[s->thread_count], NULL, run, s) != 0)
            return stp_error_set(err, STP_LIMIT, "a thread cannot be started: give --threads 1");
        s->thread_count++;
    }
    return STP_OK;
}

/* The number of reads in flight from which any of the models profits. */
static unsigned count_readers(const stp_scene *scene)
{
    unsigned count = 1;
    for (size_t i = 0; i < scene->model_count; i++) {
        stp_byte_source *source = stp_chunk_file_source(scene->models[i].model->file);
        unsigned parallel = stp_byte_source_parallel(source);
        count = parallel > count ? parallel : count;
    }
    return count < STP_STREAM_READERS_LIMIT ? count : STP_STREAM_READERS_LIMIT;
}

/* Interrupts requests at once, since a server may be silent for long. The models live on and may be
 * read again afterwards. */
static void interrupt_reads(const stp_scene *scene, void (*act)(stp_byte_source *source))
{
    for (size_t i = 0; i < scene->model_count; i++)
        act(stp_chunk_file_source(scene->models[i].model->file));
}

stp_status stp_stream_create(stp_stream **out, const stp_stream_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_stream *s = NULL;
    STP_TRY(stp_alloc(&s, 1, sizeof *s, "a stream of chunks", err));
    s->scene = params->scene;
    s->wake = params->wake;
    s->wake_context = params->wake_context;
    pthread_mutex_init(&s->mutex, NULL);
    pthread_cond_init(&s->work, NULL);
    pthread_cond_init(&s->news, NULL);
    STP_TRY(stp_payload_store_create(&s->store, params->payload_bytes, err));
    STP_TRY(start(s, run_reader, count_readers(s->scene), err));
    STP_TRY(start(s, run_decoder, params->decoder_count, err));
    *out = s;
    s = NULL;
done:
    stp_stream_destroy(&s);
    return status;
}

void stp_stream_destroy(stp_stream **stream)
{
    stp_stream *s = *stream;
    if (s == NULL)
        return;
    pthread_mutex_lock(&s->mutex);
    s->quit = true;
    pthread_cond_broadcast(&s->work);
    pthread_mutex_unlock(&s->mutex);
    interrupt_reads(s->scene, stp_byte_source_cancel);
    for (unsigned i = 0; i < s->thread_count; i++)
        pthread_join(s->threads[i], NULL);
    interrupt_reads(s->scene, stp_byte_source_resume);
    for (size_t i = 0; i < STP_STREAM_LOADS_LIMIT; i++) {
        free(s->loads[i].patches);
        free(s->loads[i].briefs);
    }
    stp_payload_store_destroy(&s->store);
    pthread_cond_destroy(&s->news);
    pthread_cond_destroy(&s->work);
    pthread_mutex_destroy(&s->mutex);
    free(s);
    *stream = NULL;
}

static void end_load(stp_stream *s, stp_load *load)
{
    bool pinned = load->payload.count > 0;
    if (pinned && load->state == STP_LOAD_FAILED)
        stp_payload_store_discard(&s->store, load->payload);
    else if (pinned)
        stp_payload_store_unpin(&s->store, load->payload);
    free(load->patches);
    free(load->briefs);
    load->patches = NULL;
    load->briefs = NULL;
    set_state(s, load, STP_LOAD_FREE);
}

void stp_stream_want(stp_stream *s, const stp_want *wants, size_t count)
{
    pthread_mutex_lock(&s->mutex);
    s->want_next = 0;
    s->want_count = count < STP_STREAM_WANTS_LIMIT ? count : STP_STREAM_WANTS_LIMIT;
    if (s->want_count > 0)
        memcpy(s->wants, wants, s->want_count * sizeof *wants);
    for (size_t i = 0; i < STP_STREAM_LOADS_LIMIT; i++)
        s->loads[i].rank = STP_STREAM_WANTS_LIMIT;
    for (size_t i = 0; i < s->want_count; i++) {
        stp_load *load = find_load(s, wants[i].chunk);
        if (load != NULL && load->want.finest <= wants[i].finest)
            load->rank = (unsigned)i;
    }
    for (size_t i = 0; i < STP_STREAM_LOADS_LIMIT; i++) {
        if (s->loads[i].rank < STP_STREAM_WANTS_LIMIT)
            continue;
        s->loads[i].dropped = true;
        if (s->loads[i].state == STP_LOAD_FETCHED)
            end_load(s, &s->loads[i]);
    }
    pthread_cond_broadcast(&s->work);
    pthread_mutex_unlock(&s->mutex);
}

stp_load *stp_stream_next_fetched(stp_stream *s)
{
    pthread_mutex_lock(&s->mutex);
    stp_load *load = first_of(s, STP_LOAD_FETCHED);
    pthread_mutex_unlock(&s->mutex);
    return load;
}

stp_load *stp_stream_find(stp_stream *s, uint32_t chunk)
{
    pthread_mutex_lock(&s->mutex);
    stp_load *load = find_load(s, chunk);
    load = load != NULL && state_has_news(load->state) ? load : NULL;
    pthread_mutex_unlock(&s->mutex);
    return load;
}

void stp_stream_decode(stp_stream *s, stp_load *load, const stp_load_place *place)
{
    pthread_mutex_lock(&s->mutex);
    load->place = *place;
    set_state(s, load, STP_LOAD_PLACED);
    pthread_mutex_unlock(&s->mutex);
}

stp_load *stp_stream_next_done(stp_stream *s)
{
    pthread_mutex_lock(&s->mutex);
    stp_load *load = first_of(s, STP_LOAD_DONE);
    load = load != NULL ? load : first_of(s, STP_LOAD_FAILED);
    pthread_mutex_unlock(&s->mutex);
    return load;
}

void stp_stream_release(stp_stream *s, stp_load *load)
{
    pthread_mutex_lock(&s->mutex);
    end_load(s, load);
    pthread_mutex_unlock(&s->mutex);
}

static size_t count_pending(const stp_stream *s)
{
    size_t count = s->want_count - s->want_next;
    for (size_t i = 0; i < STP_STREAM_LOADS_LIMIT; i++)
        count += s->loads[i].state != STP_LOAD_FREE;
    return count;
}

static bool has_news(const stp_stream *s)
{
    for (size_t i = 0; i < STP_STREAM_LOADS_LIMIT; i++)
        if (state_has_news(s->loads[i].state))
            return true;
    return false;
}

uint64_t stp_stream_news_count(stp_stream *s)
{
    pthread_mutex_lock(&s->mutex);
    uint64_t count = s->news_count;
    pthread_mutex_unlock(&s->mutex);
    return count;
}

void stp_stream_wait(stp_stream *s, uint64_t seen)
{
    pthread_mutex_lock(&s->mutex);
    while (s->news_count == seen && count_pending(s) > 0)
        pthread_cond_wait(&s->news, &s->mutex);
    pthread_mutex_unlock(&s->mutex);
}

size_t stp_stream_pending(stp_stream *s)
{
    pthread_mutex_lock(&s->mutex);
    size_t count = count_pending(s);
    pthread_mutex_unlock(&s->mutex);
    return count;
}

bool stp_stream_has_news(stp_stream *s)
{
    pthread_mutex_lock(&s->mutex);
    bool news = has_news(s);
    pthread_mutex_unlock(&s->mutex);
    return news;
}

uint64_t stp_stream_bytes_read(stp_stream *s)
{
    pthread_mutex_lock(&s->mutex);
    uint64_t bytes = s->bytes_read;
    pthread_mutex_unlock(&s->mutex);
    return bytes;
}
