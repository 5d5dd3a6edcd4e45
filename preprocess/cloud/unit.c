/* Cells with rings of neighbours. */
#include "preprocess/cloud/unit.h"

#include "base/memory.h"
#include "preprocess/cloud/nearest_list.h"

#include <stdlib.h>
#include <string.h>

/* Room for the rings, as a part of the own points, is taken at once: arrays that move leave holes.
 */
#define RINGS_PART 2u
/* Spare reach beyond the rings and the last ring's own search, in k-th neighbour distances. */
#define REACH_SPARE 0.25

/* Maps places of ring points to numbers: open addressing with a power of two of slots. */
typedef struct place_map {
    uint32_t *places, *numbers; /* STP_NEIGHBOUR_NONE: free */
    uint32_t mask, count;
} place_map;

typedef struct maker {
    stp_unit *unit;
    stp_locale locale;
    uint32_t begin, end; /* of the own points in the whole cloud */
    place_map map;
    size_t point_capacity, place_capacity, list_capacity;
} maker;

static void map_clear(place_map *map)
{
    free(map->places);
    free(map->numbers);
    *map = (place_map){0};
}

static uint32_t *map_slot(const place_map *map, uint32_t place)
{
    uint32_t at = (place * 2654435761u >> 7) & map->mask;
    while (map->places[at] != STP_NEIGHBOUR_NONE && map->places[at] != place)
        at = (at + 1) & map->mask;
    return &map->places[at];
}

/* Makes room for `more` entries. */
static stp_status map_grow(place_map *map, uint32_t more, stp_error *err)
{
    stp_status status = STP_OK;
    place_map wider = {.mask = map->mask ? map->mask : 1023, .count = map->count};
    while (wider.mask < 2 * ((uint64_t)map->count + more))
        wider.mask = 2 * wider.mask + 1;
    if (map->places && wider.mask == map->mask)
        return STP_OK;
    size_t slots = (size_t)wider.mask + 1;
    STP_TRY(stp_alloc(&wider.places, slots, sizeof *wider.places, "neighbours", err));
    STP_TRY(stp_alloc(&wider.numbers, slots, sizeof *wider.numbers, "neighbours", err));
    memset(wider.places, 0xff, slots * sizeof *wider.places);
    for (size_t i = 0; map->places && i <= map->mask; i++) {
        if (map->places[i] == STP_NEIGHBOUR_NONE)
            continue;
        uint32_t *slot = map_slot(&wider, map->places[i]);
        *slot = map->places[i];
        wider.numbers[slot - wider.places] = map->numbers[i];
    }
    map_clear(map);
    *map = wider;
    wider = (place_map){0};
done:
    map_clear(&wider);
    return status;
}

/* The number of a place; STP_NEIGHBOUR_NONE if it has none yet. */
static uint32_t number_of(const maker *m, uint32_t place)
{
    if (place - m->begin < m->unit->ring_end[0])
        return place - m->begin;
    uint32_t *slot = map_slot(&m->map, place);
    return *slot == place ? m->map.numbers[slot - m->map.places] : STP_NEIGHBOUR_NONE;
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
static stp_status add_ring(maker *m, const uint32_t *places, uint32_t count, unsigned ring,
                           stp_error *err)
{
    stp_status status = STP_OK;
    stp_unit *u = m->unit;
    uint32_t first = u->cloud.count;
    size_t needed = (size_t)first + count;
    STP_TRY(reserve(m, needed, err));
    for (uint32_t i = 0; i < count; i++) {
        copy_point(&u->cloud.points[first + i], &u->whole->points[places[i]]);
        u->places[first + i] = places[i];
    }
    u->cloud.count = u->ring_end[ring] = (uint32_t)needed;
    u->cloud.capacity = u->cloud.count;
done:
    return status;
}

/* Searches the neighbours of a ring's points. The last ring's lists are not kept. */
static stp_status search_ring(maker *m, unsigned ring, stp_error *err)
{
    stp_unit *u = m->unit;
    unsigned k = u->neighbours.k;
    uint32_t first = ring > 0 ? u->ring_end[ring - 1] : 0, count = u->ring_end[ring] - first;
    const bool kept = ring < u->ring_count;
    uint32_t *lists = kept ? u->neighbours.indices + (size_t)first * k : NULL;
    return stp_neighbours_find(&m->locale, k, u->places + first, count, lists,
                               u->cloud.points + first, err);
}

static int compare_places(const void *a, const void *b)
{
    uint32_t p = *(const uint32_t *)a, q = *(const uint32_t *)b;
    return p < q ? -1 : p > q;
}

/* Numbers the places that a ring's lists name for the first time: they are the next ring. */
static stp_status number_ring(maker *m, unsigned ring, stp_error *err)
{
    stp_status status = STP_OK;
    stp_unit *u = m->unit;
    uint32_t *fresh = NULL;
    size_t capacity = 0;
    uint32_t count = 0;
    size_t begin = ring > 0 ? u->ring_end[ring - 1] : 0, end = u->ring_end[ring];
    for (size_t i = begin * u->neighbours.k; i < end * u->neighbours.k; i++) {
        uint32_t place = u->neighbours.indices[i];
        if (place == STP_NEIGHBOUR_NONE || place - m->begin < u->ring_end[0])
            continue;
        STP_TRY(map_grow(&m->map, 1, err));
        uint32_t *slot = map_slot(&m->map, place);
        if (*slot == place)
            continue;
        *slot = place;
        m->map.count++;
        STP_TRY(stp_grow(&fresh, &capacity, (size_t)count + 1, sizeof *fresh, "neighbours", err));
        fresh[count++] = place;
    }
    if (count > 0)
        qsort(fresh, count, sizeof *fresh, compare_places);
    for (uint32_t i = 0; i < count; i++)
        m->map.numbers[map_slot(&m->map, fresh[i]) - m->map.places] = u->cloud.count + i;
    STP_TRY(add_ring(m, fresh, count, ring + 1, err));
done:
    free(fresh);
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
    uint32_t count = m->end - m->begin;
    uint32_t *own = NULL;
    STP_TRY(stp_alloc_unset(&own, count, sizeof *own, "points", err));
    for (uint32_t i = 0; i < count; i++)
        own[i] = m->begin + i;
    STP_TRY(map_grow(&m->map, 1, err));
    STP_TRY(reserve(m, (size_t)count + count / RINGS_PART, err));
    STP_TRY(add_ring(m, own, count, 0, err));
    STP_TRY(search_ring(m, 0, err));
    for (unsigned ring = 1; ring <= u->ring_count && !has_missed(u->whole); ring++) {
        STP_TRY(number_ring(m, ring - 1, err));
        STP_TRY(search_ring(m, ring, err));
    }
    if (has_missed(u->whole))
        goto done;
    size_t listed = (size_t)u->ring_end[u->ring_count - 1] * u->neighbours.k;
    for (size_t i = 0; i < listed; i++)
        if (u->neighbours.indices[i] != STP_NEIGHBOUR_NONE)
            u->neighbours.indices[i] = number_of(m, u->neighbours.indices[i]);
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
    map_clear(&m.map);
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
