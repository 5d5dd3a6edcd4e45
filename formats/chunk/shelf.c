/* Reads, shares and drops decoded chunks. */
#include "formats/chunk/shelf.h"

#include "base/memory.h"

#include <pthread.h>
#include <stdlib.h>

typedef struct place {
    stp_chunk *chunk; /* NULL: not on the shelf */
    uint32_t takers;  /* threads that hold the chunk or wait for it */
    bool reading;
    uint64_t last_taken;
} place;

struct stp_shelf {
    stp_chunk_file *file;
    pthread_mutex_t mutex;
    pthread_cond_t read;
    place *places; /* by chunk */
    uint32_t count, kept, room;
    uint64_t clock;
};

stp_status stp_shelf_create(stp_shelf **out, stp_chunk_file *file, uint32_t room, stp_error *err)
{
    stp_status status = STP_OK;
    stp_shelf *s = NULL;
    STP_TRY(stp_alloc(&s, 1, sizeof *s, "chunks", err));
    s->file = file;
    s->room = room;
    s->count = stp_chunk_file_get_info(file)->chunk_count;
    pthread_mutex_init(&s->mutex, NULL);
    pthread_cond_init(&s->read, NULL);
    *out = s;
    status = stp_alloc(&s->places, s->count, sizeof *s->places, "chunks", err);
    if (status != STP_OK)
        stp_shelf_destroy(out);
done:
    return status;
}

void stp_shelf_destroy(stp_shelf **shelf)
{
    stp_shelf *s = *shelf;
    if (!s)
        return;
    for (uint32_t i = 0; s->places && i < s->count; i++)
        stp_chunk_destroy(&s->places[i].chunk);
    free(s->places);
    pthread_cond_destroy(&s->read);
    pthread_mutex_destroy(&s->mutex);
    free(s);
    *shelf = NULL;
}

/* Drops chunks that nobody holds, the longest unused first, until there is room for one more. */
static void make_room(stp_shelf *s)
{
    while (s->kept >= s->room) {
        place *oldest = NULL;
        for (uint32_t i = 0; i < s->count; i++) {
            place *p = &s->places[i];
            if (p->chunk && p->takers == 0 && (!oldest || p->last_taken < oldest->last_taken))
                oldest = p;
        }
        if (!oldest)
            return;
        stp_chunk_destroy(&oldest->chunk);
        s->kept--;
    }
}

/* Reads the chunk while other threads go on. The mutex is locked on entry and on return. */
static stp_status read_chunk(stp_shelf *s, uint32_t id, stp_error *err)
{
    place *p = &s->places[id];
    stp_chunk *chunk = NULL;
    make_room(s);
    p->reading = true;
    s->kept++;
    pthread_mutex_unlock(&s->mutex);
    stp_status status = stp_chunk_file_read(s->file, id, 0, &chunk, err);
    pthread_mutex_lock(&s->mutex);
    p->chunk = chunk;
    p->reading = false;
    if (!chunk)
        s->kept--;
    pthread_cond_broadcast(&s->read);
    return status;
}

stp_status stp_shelf_take(stp_shelf *s, uint32_t id, const stp_chunk **out, stp_error *err)
{
    stp_status status = STP_OK;
    place *p = &s->places[id];
    pthread_mutex_lock(&s->mutex);
    p->takers++;
    while (p->reading)
        pthread_cond_wait(&s->read, &s->mutex);
    if (!p->chunk) /* also if another thread's reading failed: then this one fails with the same
                      message */
        status = read_chunk(s, id, err);
    p->last_taken = ++s->clock;
    if (status != STP_OK)
        p->takers--;
    *out = p->chunk;
    pthread_mutex_unlock(&s->mutex);
    return status;
}

void stp_shelf_give(stp_shelf *s, uint32_t id)
{
    pthread_mutex_lock(&s->mutex);
    s->places[id].takers--;
    pthread_mutex_unlock(&s->mutex);
}
