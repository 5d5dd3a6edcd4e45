/* Runs readers and decoders around one table of loads. */
#include "runtime/stream/stream.h"

#include "base/memory.h"
#include "runtime/stream/cache/patch_levels.h"
#include "runtime/stream/chosen.h"
#include "runtime/stream/gather.h"
#include "runtime/stream/shown.h"

#include <pthread.h>
#include <stdatomic.h>
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
    size_t wants_left; /* not begun */
    uint32_t *want_of; /* by block: its place among the wants not begun, plus 1; else 0 */
    stp_load loads[STP_STREAM_LOADS_LIMIT];
    size_t count_of[STP_LOAD_FAILED + 1];         /* of loads, by state */
    uint32_t *load_of;                            /* by block: its load's place, plus 1; else 0 */
    atomic_bool unwanted[STP_STREAM_LOADS_LIMIT]; /* by load; the reader looks without the mutex */
    uint64_t bytes_read, news_count;
    bool stuck; /* the next want has no room, and only what was read ahead of it can make some */
};

static bool state_has_news(stp_load_state state)
{
    return state == STP_LOAD_FETCHED || state == STP_LOAD_DONE || state == STP_LOAD_FAILED;
}

static void tell_news(stp_stream *s)
{
    s->news_count++;
    pthread_cond_signal(&s->news);
    if (s->wake != NULL)
        s->wake(s->wake_context);
}

static void set_state(stp_stream *s, stp_load *load, stp_load_state state)
{
    s->count_of[load->state]--;
    s->count_of[state]++;
    load->state = state;
    if (state == STP_LOAD_PLACED || state == STP_LOAD_FREE)
        pthread_cond_broadcast(&s->work);
    if (state_has_news(state))
        tell_news(s);
}

/* ---- reading ---- */

static stp_load *find_load(stp_stream *s, uint32_t block)
{
    return s->load_of[block] != 0 ? &s->loads[s->load_of[block] - 1] : NULL;
}

static stp_load *find_free(stp_stream *s)
{
    size_t i = 0;
    if (s->count_of[STP_LOAD_FREE] == 0)
        return NULL;
    while (s->loads[i].state != STP_LOAD_FREE)
        i++;
    return &s->loads[i];
}

static uint32_t payload_bytes(const stp_stream *s, const stp_want *want)
{
    return stp_block_payload_bytes(&s->scene->blocks[want->block], want->finest);
}

/* A block that a reader reads. */
typedef struct reading {
    stp_load *load;
    stp_gather_item item;
} reading;

typedef enum begun { NO_ROOM, NOTHING_TO_READ, MUST_READ } begun;

/* The bytes to read of a want, if `known` bytes are in memory. */
static stp_gather_item item_of(const stp_stream *s, const stp_want *want, uint32_t known)
{
    stp_gather_item item = {.begin = known, .end = payload_bytes(s, want)};
    stp_scene_find_block(s->scene, want->block, &item.block);
    return item;
}

/* Begins a want. If its payload is in memory, the load becomes FETCHED at once; otherwise the
 * caller must read *out. */
static begun begin_want(stp_stream *s, size_t index, reading *out)
{
    const stp_want *want = &s->wants[index];
    stp_load *load = find_free(s);
    stp_status status = STP_OK;
    uint32_t bytes = payload_bytes(s, want), known = 0;
    if (load == NULL)
        return NO_ROOM;
    if (find_load(s, want->block) == NULL) {
        *load = (stp_load){.want = *want, .rank = (unsigned)index};
        bool found = stp_payload_store_find(&s->store, want->block, bytes, &load->payload);
        bool made = !found && stp_payload_store_make(&s->store, want->block, bytes, &load->payload,
                                                     &known, &status, &load->error);
        if (!found && !made && status == STP_OK)
            return NO_ROOM; /* until a payload is unpinned */
        atomic_store(&s->unwanted[load - s->loads], false);
        load->error.status = status;
        s->load_of[want->block] = (uint32_t)(load - s->loads) + 1;
        set_state(s, load, found ? STP_LOAD_FETCHED : made ? STP_LOAD_FETCHING : STP_LOAD_FAILED);
    }
    s->want_of[want->block] = 0;
    s->wants_left--;
    if (load->state != STP_LOAD_FETCHING)
        return NOTHING_TO_READ;
    *out = (reading){load, item_of(s, want, known)};
    out->item.out = stp_payload_memory(&s->store, load->payload) + known;
    out->item.unwanted = &s->unwanted[load - s->loads];
    return MUST_READ;
}

/* Blocks of one model that a reader reads at once. */
typedef struct group {
    const stp_scene_model *model;
    reading of[STP_GATHER_BLOCKS];
    size_t count;
    uint64_t bytes;
} group;

/* One request brings blocks that lie apart until it has so many bytes: sixteen in flight fill 100
 * Mbit/s with answers after 40 ms. More would delay what is most wanted. */
#define GROUP_BYTES (32u << 10)
/* A neighbour may have so many blocks between that are not wanted. */
#define NEIGHBOURS_APART 4u

/* Begins wants whose payloads lie near that of the group's block number `first`: of the blocks that
 * follow it (step 1) or come before it (step -1). */
static void begin_neighbours(stp_stream *s, group *g, size_t first, uint32_t step)
{
    reading last = g->of[first];
    const stp_scene_model *m = g->model;
    const uint32_t block_count = m->model->first_block[m->model->info->chunk_count];
    uint32_t block = last.load->want.block + step;
    for (uint32_t apart = 0; apart <= NEIGHBOURS_APART && block - m->first_block < block_count &&
                             g->count < STP_GATHER_BLOCKS;
         block += step) {
        size_t index = s->want_of[block];
        if (index-- == 0) {
            apart++;
            continue;
        }
        stp_gather_item item =
            item_of(s, &s->wants[index], stp_payload_store_known(&s->store, block));
        if (item.begin >= item.end || g->bytes + item.end - item.begin > STP_SOURCE_REQUEST_BYTES ||
            !stp_gather_joins(m->model->file, &last.item, &item) ||
            begin_want(s, index, &g->of[g->count]) != MUST_READ)
            break;
        last = g->of[g->count++];
        g->bytes += item.end - item.begin;
        apart = 0;
    }
}

/* Whether a group takes one more of the wants, wherever its bytes lie. If few wants are left, they
 * are for all readers. */
static bool takes_more(const stp_stream *s, const group *g)
{
    if (g->count == 0)
        return true;
    const unsigned ranges = stp_byte_source_ranges(stp_chunk_file_source(g->model->model->file));
    const size_t share = 1 + s->wants_left / STP_STREAM_READERS_LIMIT;
    return g->count < ranges && g->count < share && g->count < STP_GATHER_BLOCKS &&
           g->bytes < GROUP_BYTES &&
           stp_scene_find(s->scene, s->scene->blocks[s->wants[s->want_next].block].chunk) ==
               g->model;
}

/* The next want has no room in one piece. If all loads are FETCHED, none makes room by itself: the
 * render thread may place them after that want. Then it is told, and lets go of them as it wants
 * blocks again. */
static void note_stuck(stp_stream *s)
{
    const size_t idle = s->count_of[STP_LOAD_FREE] + s->count_of[STP_LOAD_FETCHED];
    if (s->stuck || idle < STP_STREAM_LOADS_LIMIT || s->count_of[STP_LOAD_FETCHED] == 0)
        return;
    s->stuck = true;
    tell_news(s);
}

/* Begins the next wants until some must be read: one and its neighbours, and more if one request
 * can bring them. The group is empty if there is nothing to read. */
static void begin_next(stp_stream *s, group *g)
{
    g->count = 0;
    g->bytes = 0;
    while (s->want_next < s->want_count && takes_more(s, g)) {
        const size_t index = s->want_next, first = g->count;
        begun state = NOTHING_TO_READ;
        if (s->want_of[s->wants[index].block] == index + 1)
            state = begin_want(s, index, &g->of[first]);
        if (state == NO_ROOM) {
            note_stuck(s);
            return;
        }
        s->want_next++;
        if (state != MUST_READ)
            continue;
        const reading *r = &g->of[g->count++];
        g->model = stp_scene_find(s->scene, s->scene->blocks[r->load->want.block].chunk);
        g->bytes += r->item.end - r->item.begin;
        begin_neighbours(s, g, first, 1);
        begin_neighbours(s, g, first, UINT32_MAX);
    }
}

static void read_group(stp_stream *s, const group *g)
{
    stp_gather_item items[STP_GATHER_BLOCKS];
    for (size_t i = 0; i < g->count; i++)
        items[i] = g->of[i].item;
    pthread_mutex_unlock(&s->mutex);
    const uint64_t bytes = stp_gather_read(g->model->model->file, items, g->count);
    pthread_mutex_lock(&s->mutex);
    s->bytes_read += bytes;
    for (size_t i = 0; i < g->count; i++) {
        stp_load *load = g->of[i].load;
        bool there = items[i].status == STP_OK;
        stp_payload_store_filled(&s->store, load->want.block, items[i].got);
        load->error = items[i].error;
        load->error.status = items[i].status;
        set_state(s, load, there ? STP_LOAD_FETCHED : STP_LOAD_FAILED);
    }
}

static void *run_reader(void *context)
{
    stp_stream *s = context;
    group g;
    pthread_mutex_lock(&s->mutex);
    while (!s->quit) {
        begin_next(s, &g);
        if (g.count > 0)
            read_group(s, &g);
        else
            pthread_cond_wait(&s->work, &s->mutex);
    }
    pthread_mutex_unlock(&s->mutex);
    return NULL;
}

/* ---- decoding ---- */

/* Fills the CPU's copies of the patches. Leaves out samples that have no place, and takes the
 * squares of level 0 from the chunk. */
static stp_status mirror_patches(const stp_stream *s, stp_load *load, stp_chunk *chunk,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    stp_mirror *m = &load->mirror;
    *m = load->place.mirror;
    uint32_t block = load->want.block, of = s->scene->blocks[block].chunk;
    const stp_scene_model *model = stp_scene_find(s->scene, of);
    stp_mirror_patches_fill(m->patches, chunk, &load->place.placement, stp_scene_shapes(s->scene));
    STP_TRY(stp_patch_levels_leave(&load->place, m->patches, chunk, err));
    STP_TRY(stp_spots_list(&m->spots, m->patches, chunk, err));
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        m->briefs[p] = stp_patch_brief_of(s->scene, of, &m->patches[p], &chunk->patches[p]);
        m->briefs[p].empty = model->model->chosen ? (uint8_t)stp_chosen_empty(chunk, p) : 0;
    }
    if (chunk->finest_level == 0 && stp_chunk_is_squares(chunk)) {
        m->squares = chunk->squares;
        m->rasters = chunk->rasters;
        chunk->squares = NULL;
        chunk->rasters = NULL;
    }
done:
    return status;
}

static stp_status decode(const stp_stream *s, stp_load *load, stp_chunk_scratch *scratch,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    const stp_block *block = NULL;
    const stp_scene_model *m = stp_scene_find_block(s->scene, load->want.block, &block);
    STP_TRY(stp_block_decode(m->model->file, block, load->want.finest,
                             stp_payload_memory(&s->store, load->payload), scratch, &chunk, err));
    const uint32_t *first = &m->model->first_block[block->chunk];
    const stp_block *blocks = &m->model->blocks[first[0]];
    const stp_numbers_block own = {blocks, (uint32_t)(block - blocks), first[1] - first[0], chunk};
    if (m->model->chosen) /* before intensities are replaced */
        STP_TRY(stp_chosen_mark(m->model->chosen, &own, chunk, err));
    if (m->model->shown)
        STP_TRY(stp_shown_fill(m->model->shown, &own, chunk, err));
    STP_TRY(mirror_patches(s, load, chunk, err));
    load->place.texels =
        stp_placement_write(&load->place.placement, load->place.memory, load->mirror.records, chunk,
                            load->place.slot, stp_scene_shapes(s->scene));
done:
    stp_chunk_recycle(&chunk, scratch);
    return status;
}

/* The most wanted load in a state, or NULL. */
static stp_load *first_of(stp_stream *s, stp_load_state state)
{
    stp_load *first = NULL;
    for (size_t i = 0; s->count_of[state] > 0 && i < STP_STREAM_LOADS_LIMIT; i++)
        if (s->loads[i].state == state && (first == NULL || s->loads[i].rank < first->rank))
            first = &s->loads[i];
    return first;
}

static void decode_load(stp_stream *s, stp_load *load, stp_chunk_scratch *scratch)
{
    stp_error error = {0};
    set_state(s, load, STP_LOAD_DECODING);
    pthread_mutex_unlock(&s->mutex);
    stp_status status = decode(s, load, scratch, &error);
    pthread_mutex_lock(&s->mutex);
    load->error = error;
    load->error.status = status;
    if (status != STP_OK) /* the payload may be damaged: it is read anew */
        stp_payload_store_filled(&s->store, load->want.block, 0);
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
    STP_TRY(stp_alloc(&s, 1, sizeof *s, "a stream of blocks", err));
    s->scene = params->scene;
    s->count_of[STP_LOAD_FREE] = STP_STREAM_LOADS_LIMIT;
    s->wake = params->wake;
    s->wake_context = params->wake_context;
    pthread_mutex_init(&s->mutex, NULL);
    pthread_cond_init(&s->work, NULL);
    pthread_cond_init(&s->news, NULL);
    STP_TRY(stp_alloc(&s->want_of, s->scene->block_count, sizeof *s->want_of, "blocks", err));
    STP_TRY(stp_alloc(&s->load_of, s->scene->block_count, sizeof *s->load_of, "blocks", err));
    STP_TRY(stp_payload_store_create(&s->store, params->payload_bytes, s->scene->block_count, err));
    STP_TRY(start(s, run_reader, count_readers(s->scene), err));
    STP_TRY(start(s, run_decoder, params->decoder_count, err));
    *out = s;
    s = NULL;
done:
    stp_stream_destroy(&s);
    return status;
}

void stp_mirror_clear(stp_mirror *mirror)
{
    free(mirror->squares);
    free(mirror->rasters);
    free(mirror->spots);
    *mirror = (stp_mirror){0};
}

static void drop_results(stp_load *load)
{
    stp_mirror_clear(&load->mirror);
    stp_patch_levels_clear(&load->place);
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
    for (size_t i = 0; i < STP_STREAM_LOADS_LIMIT; i++)
        drop_results(&s->loads[i]);
    stp_payload_store_destroy(&s->store);
    pthread_cond_destroy(&s->news);
    pthread_cond_destroy(&s->work);
    pthread_mutex_destroy(&s->mutex);
    free(s->want_of);
    free(s->load_of);
    free(s);
    *stream = NULL;
}

static void end_load(stp_stream *s, stp_load *load)
{
    bool pinned = load->payload.count > 0;
    if (pinned && stp_payload_store_known(&s->store, load->want.block) == 0)
        stp_payload_store_discard(&s->store, load->want.block);
    else if (pinned)
        stp_payload_store_unpin(&s->store, load->want.block);
    drop_results(load);
    s->load_of[load->want.block] = 0;
    set_state(s, load, STP_LOAD_FREE);
}

/* Replaces the queue; a block that is wanted twice counts as its first want. */
static void set_wants(stp_stream *s, const stp_want *wants, size_t count)
{
    for (size_t i = 0; i < s->want_count; i++)
        s->want_of[s->wants[i].block] = 0;
    s->want_next = s->wants_left = 0;
    s->want_count = count < STP_STREAM_WANTS_LIMIT ? count : STP_STREAM_WANTS_LIMIT;
    if (s->want_count > 0)
        memcpy(s->wants, wants, s->want_count * sizeof *wants);
    for (size_t i = 0; i < s->want_count; i++) {
        uint32_t *want_of = &s->want_of[s->wants[i].block];
        s->wants_left += *want_of == 0;
        *want_of = *want_of == 0 ? (uint32_t)i + 1 : *want_of;
    }
}

void stp_stream_want(stp_stream *s, const stp_want *wants, size_t count)
{
    pthread_mutex_lock(&s->mutex);
    set_wants(s, wants, count);
    for (size_t i = 0; i < STP_STREAM_LOADS_LIMIT; i++) {
        stp_load *load = &s->loads[i];
        uint32_t want = load->state == STP_LOAD_FREE ? 0 : s->want_of[load->want.block];
        bool asked = want != 0 && load->want.finest <= s->wants[want - 1].finest;
        load->rank = asked ? want - 1 : STP_STREAM_WANTS_LIMIT;
        load->dropped = load->dropped || !asked;
        atomic_store(&s->unwanted[i], !asked);
        if ((!asked || s->stuck) && load->state == STP_LOAD_FETCHED)
            end_load(s, load);
    }
    s->stuck = false;
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

stp_load *stp_stream_find(stp_stream *s, uint32_t block)
{
    pthread_mutex_lock(&s->mutex);
    stp_load *load = find_load(s, block);
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
    return s->wants_left + STP_STREAM_LOADS_LIMIT - s->count_of[STP_LOAD_FREE];
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
    bool news = s->count_of[STP_LOAD_FETCHED] + s->count_of[STP_LOAD_DONE] > 0 ||
                s->count_of[STP_LOAD_FAILED] > 0;
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
