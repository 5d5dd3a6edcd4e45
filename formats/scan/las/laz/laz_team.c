/* Unpacks chunks of a LAZ file side by side. */
#include "formats/scan/las/laz/laz_team.h"

#include "base/memory.h"
#include "formats/scan/las/laz/laz_chunks.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

/* Chunks have many sizes: readers that are done early take another one. */
#define PARTS_PER_READER 4u
#define PARTS_LIMIT (STP_LAZ_TEAM_READERS * PARTS_PER_READER)

/* A chunk that one reader unpacked. */
typedef struct part {
    uint64_t first; /* point */
    size_t count, capacity;
    unsigned char *records;
    bool well;
} part;

struct stp_laz_team {
    stp_pool *pool;
    stp_laz *readers[STP_LAZ_TEAM_READERS];
    unsigned reader_count;
    size_t record_bytes;
    bool alone;    /* the first reader reads what is left */
    uint64_t next; /* point */
    part parts[PARTS_LIMIT];
    unsigned part_count, at; /* at: the part that is handed out */
    atomic_uint begun;       /* parts that a reader took */
};

static unsigned readers_of(const stp_laz_params *params, stp_pool *pool)
{
    unsigned count = pool ? stp_pool_thread_count(pool) : 1;
    if (params->chosen && params->source->mirror)
        count = 1; /* each chunk is fetched when it is opened */
    return count < STP_LAZ_TEAM_READERS ? count : STP_LAZ_TEAM_READERS;
}

/* Opens one reader more. The chosen chunks stay the caller's. */
static stp_status add_reader(stp_laz_team *team, const stp_laz_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    stp_laz_chunks chosen = {0};
    stp_laz_params own = *params;
    if (params->chosen) {
        chosen = *params->chosen;
        chosen.list = NULL;
        chosen.capacity = chosen.count;
        STP_TRY(stp_alloc(&chosen.list, chosen.count, sizeof *chosen.list, "LAZ chunks", err));
        memcpy(chosen.list, params->chosen->list, chosen.count * sizeof *chosen.list);
        own.chosen = &chosen;
    }
    STP_TRY(stp_laz_open(&team->readers[team->reader_count], &own, err));
    team->reader_count++;
done:
    stp_laz_chunks_free(&chosen);
    return status;
}

stp_status stp_laz_team_open(stp_laz_team **out, const stp_laz_params *params, stp_pool *pool,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_laz_team *team = NULL;
    STP_TRY(stp_alloc(&team, 1, sizeof *team, "LAZ readers", err));
    team->pool = pool;
    team->record_bytes = params->header->record_bytes;
    for (unsigned wanted = readers_of(params, pool); team->reader_count < wanted;)
        STP_TRY(add_reader(team, params, err));
    team->alone = true;
    *out = team;
    team = NULL;
done:
    stp_laz_team_close(&team);
    return status;
}

void stp_laz_team_close(stp_laz_team **team)
{
    stp_laz_team *t = *team;
    if (!t)
        return;
    for (unsigned i = 0; i < t->reader_count; i++)
        stp_laz_close(&t->readers[i]);
    for (unsigned i = 0; i < PARTS_LIMIT; i++)
        free(t->parts[i].records);
    free(t);
    *team = NULL;
}

uint64_t stp_laz_team_chunk_points(const stp_laz_team *team)
{
    return stp_laz_chunk_points(team->readers[0]);
}

uint64_t stp_laz_team_chunk_begin(const stp_laz_team *team, uint64_t point)
{
    return stp_laz_chunk_begin(team->readers[0], point);
}

void stp_laz_team_together(stp_laz_team *team)
{
    team->alone = team->reader_count < 2;
}

stp_status stp_laz_team_seek(stp_laz_team *team, uint64_t point, stp_error *err)
{
    team->alone = true;
    team->part_count = 0;
    team->next = point;
    return stp_laz_seek(team->readers[0], point, err);
}

/* Unpacks parts until all are taken. What goes wrong is said later, when the first reader comes to
 * it. */
static stp_status unpack_parts(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_laz_team *team = context;
    stp_laz *reader = team->readers[index];
    (void)worker;
    (void)err;
    for (unsigned i; (i = atomic_fetch_add(&team->begun, 1)) < team->part_count;) {
        part *p = &team->parts[i];
        p->well = stp_laz_seek(reader, p->first, NULL) == STP_OK &&
                  stp_laz_read(reader, p->records, p->count, NULL) == STP_OK;
    }
    return STP_OK;
}

/* Unpacks the next chunks, if the next point begins one. */
static void fill(stp_laz_team *team)
{
    uint64_t first = team->next;
    size_t room = STP_LAZ_TEAM_BYTES / team->record_bytes; /* points */
    team->part_count = team->at = 0;
    atomic_store(&team->begun, 0);
    while (team->part_count < PARTS_PER_READER * team->reader_count) {
        part *p = &team->parts[team->part_count];
        const uint64_t count = stp_laz_chunk_at(team->readers[0], first);
        if (count == 0 || count > room ||
            stp_grow(&p->records, &p->capacity, (size_t)count * team->record_bytes, 1, "records",
                     NULL) != STP_OK)
            break;
        p->first = first;
        p->count = (size_t)count;
        room -= p->count;
        first += count;
        team->part_count++;
    }
    if (team->part_count < 2 ||
        stp_pool_run(team->pool, team->reader_count, unpack_parts, team, NULL) != STP_OK)
        team->part_count = 0;
}

/* Hands out points of the parts; 0: there are none. */
static size_t take(stp_laz_team *team, unsigned char *records, size_t count)
{
    if (team->at == team->part_count)
        return 0;
    const part *p = &team->parts[team->at];
    if (!p->well) {
        team->alone = true;
        team->part_count = team->at = 0;
        return 0;
    }
    const size_t done = (size_t)(team->next - p->first), left = p->count - done;
    const size_t taken = left < count ? left : count;
    memcpy(records, p->records + done * team->record_bytes, taken * team->record_bytes);
    team->at += taken == left;
    return taken;
}

/* Reads by the first reader: all, or up to where a chunk may begin. */
static stp_status read_alone(stp_laz_team *team, unsigned char *records, size_t *count,
                             stp_error *err)
{
    stp_status status = stp_laz_seek(team->readers[0], team->next, err);
    if (status != STP_OK)
        return status;
    const uint64_t left = stp_laz_chunk_left(team->readers[0]);
    if (!team->alone && left > 0 && left < *count)
        *count = (size_t)left;
    return stp_laz_read(team->readers[0], records, *count, err);
}

stp_status stp_laz_team_read(stp_laz_team *team, unsigned char *records, size_t count,
                             stp_error *err)
{
    stp_status status = STP_OK;
    while (count > 0) {
        if (!team->alone && team->at == team->part_count)
            fill(team);
        size_t done_count = take(team, records, count);
        if (done_count == 0) {
            done_count = count;
            STP_TRY(read_alone(team, records, &done_count, err));
        }
        team->next += done_count;
        records += done_count * team->record_bytes;
        count -= done_count;
    }
done:
    return status;
}
