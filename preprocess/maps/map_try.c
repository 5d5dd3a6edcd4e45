/* Makes the maps of a merged part. */
#include "preprocess/maps/map_try.h"

#include "base/memory.h"
#include "preprocess/cloud/box_tree.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/maps/halve.h"
#include "preprocess/maps/map_around.h"
#include "preprocess/maps/map_distance.h"
#include "preprocess/maps/map_make.h"

#include <stdlib.h>

/* A point farther off its map than this many spacings stays a point: by noise, two thirds of the
 * reach of the weights (map_points.c). */
#define QUIET_OFF 1.4
#define WIDE_OFF 1.9
#define WIDEST_OFF 2.8

/* Points this near to a map, in spacings of its grid, should be on it, or on another. */
#define CROWD_SPACINGS 4.0

typedef struct trial {
    const stp_cloud *cloud;
    const stp_maps_params *params;
    const stp_face_tree *faces;
    const uint32_t *parts;
    uint32_t *all; /* places of the merged part, those of a half together */
    bool *taken;   /* by these: a map stands for the point */
    uint32_t *scratch;
    vec3s *normals;
    double *distances;
    stp_map_list *list;
} trial;

double stp_map_limit(const stp_cloud *cloud, const stp_maps_params *params, uint32_t place)
{
    const uint8_t marks = cloud->marks[place];
    const double spacing = (double)cloud->points[place].spacing;
    const double by_noise = spacing * (marks & STP_MARK_WIDEST ? WIDEST_OFF
                                       : marks & STP_MARK_WIDE ? WIDE_OFF
                                                               : QUIET_OFF);
    return params->error > 0.0 ? fmin(params->error, by_noise) : by_noise;
}

static double limit_of(const trial *t, uint32_t place)
{
    return stp_map_limit(t->cloud, t->params, place);
}

/* Measures all own points. Returns how many lie off the map. */
static uint32_t measure(const trial *t, const stp_map *map, const stp_map_places *places)
{
    uint32_t off = 0;
    for (uint32_t i = 0; i < places->own_count; i++) {
        t->distances[i] = stp_map_distance(map, t->cloud->points[places->own[i]].position);
        off += t->distances[i] > limit_of(t, places->own[i]);
    }
    return off;
}

/* Notes the points of no part that the map can stand for. *crowd: how many others of no part
 * are near. */
static stp_status find_guests(trial *t, const stp_map *map, const stp_map_places *places,
                              uint32_t *crowd, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_list *list = t->list;
    *crowd = 0;
    for (uint32_t i = 0; i < places->around_count; i++) {
        const uint32_t place = places->around[i];
        if (t->parts[place] != STP_PART_NONE || t->cloud->marks[place] & STP_MARK_OUTLIER)
            continue;
        const double distance = stp_map_distance(map, t->cloud->points[place].position);
        if (distance > limit_of(t, place)) {
            *crowd += distance <= CROWD_SPACINGS * map->frame.spacing;
            continue;
        }
        STP_TRY(stp_grow(&list->guests, &list->guest_capacity, list->guest_count + 1,
                         sizeof *list->guests, "points", err));
        list->guests[list->guest_count++] = (stp_map_guest){.place = place, .distance = distance};
    }
done:
    return status;
}

/* Takes the map, and marks the points that it stands for. But if more points of no part are near
 * and off the map than it has itself, it lies in a volume of points, such as a crown of leaves, and
 * all of them stay points. */
static stp_status take(trial *t, stp_map *map, const stp_map_places *places, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_list *list = t->list;
    bool *taken = t->taken + (places->own - t->all);
    const size_t guests = list->guest_count;
    uint32_t crowd = 0;
    STP_TRY(find_guests(t, map, places, &crowd, err));
    if (crowd > places->own_count) {
        list->guest_count = guests;
        return STP_OK;
    }
    STP_TRY(
        stp_grow(&list->maps, &list->capacity, list->count + 1, sizeof *list->maps, "maps", err));
    STP_TRY(stp_spill_move(t->cloud->spill, &map->samples, (size_t)map->columns * map->rows,
                           sizeof *map->samples, "maps", err));
    for (uint32_t row = 0; row < map->rows; row++)
        for (uint32_t column = 0; column < map->columns; column++)
            if (stp_map_at(map, column, row)->flags & STP_MAP_SUPPORTED)
                stp_dbox_add(&list->box, stp_map_world(map, column, row));
    for (uint32_t i = 0; i < places->own_count; i++) {
        if (t->distances[i] > limit_of(t, places->own[i]))
            continue;
        taken[i] = true;
        stp_maps_counts_add(&list->counts, t->distances[i]);
    }
    list->counts.samples += map->count;
    list->maps[list->count++] = *map;
    *map = (stp_map){0};
done:
    return status;
}

/* The box around a part in which points matter: as far as weights reach, and a square more. */
static stp_dbox box_of(const trial *t, const uint32_t *places, uint32_t count)
{
    stp_dbox box = stp_dbox_empty();
    double sum = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        const stp_cloud_point *p = &t->cloud->points[places[i]];
        sum += (double)p->spacing;
        stp_dbox_add(&box, p->position);
    }
    return stp_dbox_grown(&box, STP_MAP_MARGIN * sum / count);
}

static stp_status try_places(trial *t, uint32_t *own, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map map = {0};
    uint32_t *around = NULL;
    stp_map_places places = {.own = own, .own_count = count, .faces = t->faces};
    bool fits = false;
    if (count < STP_MAP_POINTS_LEAST)
        return STP_OK;
    for (uint32_t i = 0; i < count; i++)
        t->normals[i] = stp_cloud_normal(t->cloud, own[i]);
    const stp_normal_cone cone = stp_normal_cone_of(t->normals, count);
    places.box = box_of(t, own, count);
    STP_TRY(
        stp_places_around(t->cloud, own, count, &places.box, &around, &places.around_count, err));
    places.around = around;
    STP_TRY(stp_map_make(&map, &fits, t->cloud, &places, &cone, t->params->cone_deg * M_PI / 180.0,
                         err));
    if (fits && measure(t, &map, &places) <= STP_MAP_OFF_MOST * count) {
        STP_TRY(take(t, &map, &places, err));
    } else {
        const uint32_t first = stp_places_halve(t->cloud, own, count, t->scratch);
        STP_TRY(try_places(t, own, first, err));
        STP_TRY(try_places(t, own + first, count - first, err));
    }
done:
    free(around);
    free(map.samples);
    return status;
}

/* Takes the points that halving left without a map into the nearest map of their part, if that is
 * near enough. */
static void take_left(trial *t, uint32_t count)
{
    const uint32_t *own = t->all;
    for (uint32_t i = 0; i < count; i++) {
        double distance = INFINITY;
        if (t->taken[i] || t->cloud->marks[own[i]] & STP_MARK_OUTLIER)
            continue;
        for (size_t m = 0; m < t->list->count; m++)
            distance = stp_min(
                distance, stp_map_distance(&t->list->maps[m], t->cloud->points[own[i]].position));
        if (distance > limit_of(t, own[i]))
            continue;
        t->taken[i] = true;
        stp_maps_counts_add(&t->list->counts, distance);
    }
}

static bool meets_box(void *context, const stp_dbox *box)
{
    return stp_dbox_meet(context, box);
}

static bool pass(void *context, uint64_t begin, uint64_t end)
{
    (void)context;
    (void)begin;
    (void)end;
    return true;
}

/* Whether all points are here that maps of a part may be made of: its own, and all in the boxes
 * around its halves (box_of). */
static bool has_all(const stp_cloud *cloud, const uint32_t *places, uint32_t count)
{
    stp_dbox box = stp_dbox_empty();
    double most = 0.0;
    for (uint32_t i = 0; i < count; i++)
        (void)stp_cloud_has(cloud, places[i]);
    for (uint32_t i = 0; i < count && !*cloud->missed; i++) {
        most = stp_max(most, (double)cloud->points[places[i]].spacing);
        stp_dbox_add(&box, cloud->points[places[i]].position);
    }
    box = stp_dbox_grown(&box, (STP_MAP_MARGIN + 0.01) * most); /* rounding */
    if (!*cloud->missed)
        (void)stp_box_tree_walk(cloud, meets_box, pass, &box);
    return !*cloud->missed;
}

stp_status stp_map_list_make(stp_map_list *out, const stp_cloud *cloud,
                             const stp_maps_params *params, const stp_face_tree *faces,
                             const uint32_t *parts, uint32_t *places, bool *taken, uint32_t count,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_list made = {.box = stp_dbox_empty()};
    trial t = {.cloud = cloud, .params = params, .faces = faces, .parts = parts, .list = &made};
    t.all = places;
    t.taken = taken;
    if (cloud->blocks && !has_all(cloud, places, count))
        return STP_OK;
    STP_TRY(stp_alloc(&t.scratch, count, sizeof *t.scratch, "points", err));
    STP_TRY(stp_alloc(&t.normals, count, sizeof *t.normals, "normals", err));
    STP_TRY(stp_alloc(&t.distances, count, sizeof *t.distances, "points", err));
    STP_TRY(try_places(&t, places, count, err));
    take_left(&t, count);
    *out = made;
    made = (stp_map_list){0};
done:
    stp_map_list_clear(&made, cloud->spill);
    free(t.scratch);
    free(t.normals);
    free(t.distances);
    return status;
}

void stp_map_list_clear(stp_map_list *list, stp_spill *spill)
{
    for (size_t i = 0; i < list->count; i++)
        stp_spill_free(spill, list->maps[i].samples);
    free(list->maps);
    free(list->guests);
    *list = (stp_map_list){0};
}
