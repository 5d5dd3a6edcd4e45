/* Cells with rings of neighbours. */
#include "preprocess/cloud/unit.h"

#include "base/memory.h"
#include "base/sort.h"
#include "preprocess/cloud/nearest_list.h"

#include <stdlib.h>
#include <string.h>

/* Room for the rings, as a part of the own points, is taken at once: arrays that move leave holes.
 */
#define RINGS_PART 2u
/* Spare reach beyond the rings and the last ring's own search, in k-th neighbour distances. */
#define REACH_SPARE 0.25

/* Points that are searched at a time: few enough that their lists, of places, stay in the cache
 * until they are numbered. */
#define BATCH_POINTS 2048u

/* Numbers of ring points, found by their places: open addressing with a power of two of slots. */
typedef struct place_map {
    uint32_t *numbers; /* STP_NEIGHBOUR_NONE: free */
    uint32_t mask, count;
} place_map;

typedef struct maker {
    stp_unit *unit;
    stp_locale locale;
    uint64_t begin, end; /* of the own points in the whole cloud */
    place_map map;
    uint64_t *fresh; /* places of the next ring, numbered as they are found until all are */
    uint32_t fresh_count;
    size_t fresh_capacity, point_capacity, place_capacity, list_capacity;
} maker;

static uint64_t place_of(const maker *m, uint32_t number)
{
    const uint32_t count = (uint32_t)m->unit->cloud.count;
    return number < count ? m->unit->places[number] : m->fresh[number - count];
}

static uint32_t *map_slot(const maker *m, const place_map *map, uint64_t place)
{
    uint32_t at = (uint32_t)(place * UINT64_C(0x9e3779b97f4a7c15) >> 32) & map->mask;
    while (map->numbers[at] != STP_NEIGHBOUR_NONE && place_of(m, map->numbers[at]) != place)
        at = (at + 1) & map->mask;
    return &map->numbers[at];
}

/* Makes room for one more entry. */
static stp_status map_grow(maker *m, stp_error *err)
{
    place_map *map = &m->map;
    place_map wider = {.mask = map->mask ? map->mask : 1023, .count = map->count};
    while (wider.mask < 2 * ((uint64_t)map->count + 1))
        wider.mask = 2 * wider.mask + 1;
    if (map->numbers && wider.mask == map->mask)
        return STP_OK;
    const size_t slots = (size_t)wider.mask + 1;
    const stp_status status =
        stp_alloc_unset(&wider.numbers, slots, sizeof *wider.numbers, "neighbours", err);
    if (status != STP_OK)
        return status;
    memset(wider.numbers, 0xff, slots * sizeof *wider.numbers);
    for (size_t i = 0; map->numbers && i <= map->mask; i++)
        if (map->numbers[i] != STP_NEIGHBOUR_NONE)
            *map_slot(m, &wider, place_of(m, map->numbers[i])) = map->numbers[i];
    free(map->numbers);
    *map = wider;
    return STP_OK;
}

/* Sets *number to that of a place. A place without one is of the next ring, and gets one. */
static stp_status number_place(maker *m, uint64_t place, uint32_t *number, stp_error *err)
{
    stp_status status = STP_OK;
    if (place - m->begin < m->unit->ring_end[0]) {
        *number = (uint32_t)(place - m->begin);
        return STP_OK;
    }
    STP_TRY(map_grow(m, err));
    uint32_t *slot = map_slot(m, &m->map, place);
    if (*slot == STP_NEIGHBOUR_NONE) {
        STP_TRY(stp_grow(&m->fresh, &m->fresh_capacity, (size_t)m->fresh_count + 1,
                         sizeof *m->fresh, "neighbours", err));
        *slot = (uint32_t)m->unit->cloud.count + m->fresh_count;
        m->fresh[m->fresh_count++] = place;
        m->map.count++;
    }
    *number = *slot;
done:
    return status;
}

/* Copies the fields that no other unit writes. */
static void copy_point(stp_cloud_point *out, const stp_cloud_point *from)
{
    out->position = from->position;
    out->source = from->source;
    out->station = from->station;
    out->given = from->given;
    out->normal = from->given ? from->normal : (vec3s){{0.0f, 0.0f, 0.0f}};
}

/* Makes room for `needed` points, and for their lists. */
static stp_status reserve(maker *m, size_t needed, stp_error *err)
{
    stp_status status = STP_OK;
    stp_unit *u = m->unit;
    STP_TRY(stp_grow(&u->cloud.points, &m->point_capacity, needed, sizeof *u->cloud.points,
                     "points", err));
    STP_TRY(stp_grow(&u->places, &m->place_capacity, needed, sizeof *u->places, "points", err));
    STP_TRY(stp_grow(&u->neighbours.indices, &m->list_capacity, needed * u->neighbours.k,
                     sizeof *u->neighbours.indices, "neighbours", err));
done:
    return status;
}

/* Appends the points at `count` places, ascending, as a ring. */
static stp_status add_ring(maker *m, const uint64_t *places, uint32_t count, unsigned ring,
                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_unit *u = m->unit;
    uint32_t first = (uint32_t)u->cloud.count;
    size_t needed = (size_t)first + count;
    STP_TRY(reserve(m, needed, err));
    for (uint32_t i = 0; i < count; i++) {
        copy_point(&u->cloud.points[first + i], &u->whole->points[places[i]]);
        u->places[first + i] = places[i];
    }
    u->cloud.count = needed;
    u->ring_end[ring] = (uint32_t)needed;
    u->cloud.capacity = u->cloud.count;
done:
    return status;
}

/* Searches the neighbours of a ring's points, and numbers them. */
static stp_status search_ring(maker *m, unsigned ring, stp_error *err)
{
    stp_status status = STP_OK;
    stp_unit *u = m->unit;
    const unsigned k = u->neighbours.k;
    const uint32_t end = u->ring_end[ring];
    uint64_t *found = NULL;
    STP_TRY(stp_alloc_unset(&found, (size_t)BATCH_POINTS * k, sizeof *found, "neighbours", err));
    for (uint32_t at = ring > 0 ? u->ring_end[ring - 1] : 0, count; at < end; at += count) {
        uint32_t *lists = u->neighbours.indices + (size_t)at * k;
        count = end - at < BATCH_POINTS ? end - at : BATCH_POINTS;
        STP_TRY(stp_neighbours_find(&m->locale, k, u->places + at, count, found,
                                    u->cloud.points + at, err));
        for (size_t i = 0; i < (size_t)count * k; i++) {
            lists[i] = STP_NEIGHBOUR_NONE;
            if (found[i] != STP_PLACE_NONE)
                STP_TRY(number_place(m, found[i], &lists[i], err));
        }
    }
done:
    free(found);
    return status;
}

/* Searches the spacings of the last ring's points. */
static stp_status search_last(maker *m, stp_error *err)
{
    stp_unit *u = m->unit;
    const uint32_t first = u->ring_end[u->ring_count - 1], count = (uint32_t)u->cloud.count - first;
    return stp_neighbours_find(&m->locale, u->neighbours.k, u->places + first, count, NULL,
                               u->cloud.points + first, err);
}

/* Gives numbers found so far, of the ring that follows, the order of places. */
static void renumber(uint32_t *numbers, size_t count, uint32_t first, const uint32_t *ranks)
{
    for (size_t i = 0; i < count; i++)
        if (numbers[i] >= first && numbers[i] != STP_NEIGHBOUR_NONE)
            numbers[i] = first + ranks[numbers[i] - first];
}

/* Makes a ring of the places that the lists of the ring before name for the first time. */
static stp_status number_ring(maker *m, unsigned ring, stp_error *err)
{
    stp_status status = STP_OK;
    stp_unit *u = m->unit;
    const uint32_t count = m->fresh_count, first = (uint32_t)u->cloud.count;
    const size_t k = u->neighbours.k, begin = ring > 1 ? u->ring_end[ring - 2] : 0;
    uint64_t *sorted = NULL;
    uint32_t *ranks = NULL;
    STP_TRY(stp_alloc_unset(&sorted, count, sizeof *sorted, "neighbours", err));
    STP_TRY(stp_alloc_unset(&ranks, count, sizeof *ranks, "neighbours", err));
    if (count > 0)
        memcpy(sorted, m->fresh, count * sizeof *sorted);
    stp_sort_u64(sorted, count);
    for (uint32_t i = 0; i < count; i++)
        ranks[*map_slot(m, &m->map, sorted[i]) - first] = i;
    renumber(m->map.numbers, (size_t)m->map.mask + 1, first, ranks);
    renumber(u->neighbours.indices + begin * k, (u->ring_end[ring - 1] - begin) * k, first, ranks);
    m->fresh_count = 0;
    STP_TRY(add_ring(m, sorted, count, ring, err));
done:
    free(sorted);
    free(ranks);
    return status;
}

static bool has_missed(const stp_cloud *cloud)
{
    return cloud->missed && *cloud->missed;
}

/* Gathers the own points, then ring by ring what is around them. */
static stp_status gather(maker *m, stp_error *err)
{
    stp_status status = STP_OK;
    stp_unit *u = m->unit;
    const uint32_t count = (uint32_t)(m->end - m->begin);
    uint64_t *own = NULL;
    STP_TRY(stp_alloc_unset(&own, count, sizeof *own, "points", err));
    for (uint32_t i = 0; i < count; i++)
        own[i] = m->begin + i;
    STP_TRY(map_grow(m, err));
    STP_TRY(reserve(m, (size_t)count + count / RINGS_PART, err));
    STP_TRY(add_ring(m, own, count, 0, err));
    STP_TRY(search_ring(m, 0, err));
    for (unsigned ring = 1; ring <= u->ring_count && !has_missed(u->whole); ring++) {
        STP_TRY(number_ring(m, ring, err));
        STP_TRY(ring < u->ring_count ? search_ring(m, ring, err) : search_last(m, err));
    }
done:
    free(own);
    return status;
}

stp_status stp_unit_create(stp_unit *out, const stp_cloud *whole, uint32_t first, uint32_t end,
                           unsigned k, unsigned ring_count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_unit unit = {.whole = whole, .neighbours = {.k = k}, .ring_count = ring_count};
    maker m = {.unit = &unit, .begin = whole->cells[first].begin, .end = whole->cells[end - 1].end};
    if (k < 3 || k > STP_NEIGHBOURS_LIMIT)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "%u neighbours: give 3 to %d", k,
                             STP_NEIGHBOURS_LIMIT);
    STP_TRY(stp_locale_create(&m.locale, whole, first, end, k, ring_count + 1 + REACH_SPARE, err));
    if (!has_missed(whole))
        STP_TRY(gather(&m, err));
    *out = unit;
    unit = (stp_unit){0};
done:
    stp_locale_clear(&m.locale);
    free(m.map.numbers);
    free(m.fresh);
    stp_unit_clear(&unit);
    return status;
}

void stp_unit_clear(stp_unit *unit)
{
    free(unit->cloud.points);
    free(unit->neighbours.indices);
    free(unit->places);
    free(unit->wide);
    free(unit->roundness);
    *unit = (stp_unit){0};
}
