/* Cuts a cell into parts. */
#include "preprocess/maps/parts/part_cut.h"

#include "base/memory.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/cloud/neighbours.h"
#include "preprocess/maps/halve.h"
#include "preprocess/orient/forest.h"

#include <stdlib.h>

/* Neighbours by which points hang together. */
#define NEIGHBOURS 8u
/* A neighbour this many spacings away is beyond a gap. */
#define GAP 3.5
/* A neighbour is beyond a step if the way to it leads out of a tangent plane by more than this sine
 * (53 degrees). At a crease of 90 degrees it is 0.7. */
#define STEP 0.8

typedef struct cutter {
    const stp_cloud *cloud;
    const stp_cell *cell;
    double cosine;
    uint32_t *order, *scratch; /* places: those with a normal, set after set */
    vec3s *normals;            /* of a set */
    uint32_t *sets;            /* by place in the cell: its set, or STP_PART_NONE */
    uint32_t set_count;
    uint64_t *lists;   /* NEIGHBOURS places by place in the cell */
    stp_forest pieces; /* of places in the cell */
} cutter;

static uint32_t point_count(const cutter *c)
{
    return (uint32_t)(c->cell->end - c->cell->begin);
}

static void take_normals(const cutter *c, const uint32_t *places, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        c->normals[i] = stp_cloud_normal(c->cloud, places[i]);
}

/* Halves order[begin, end) until the cone holds. */
static void cut_set(cutter *c, uint32_t begin, uint32_t end)
{
    uint32_t *places = c->order + begin;
    const uint32_t count = end - begin;
    if (count == 0)
        return;
    take_normals(c, places, count);
    const stp_normal_cone cone = stp_normal_cone_of(c->normals, count);
    if (cone.cosine >= c->cosine) {
        for (uint32_t i = 0; i < count; i++)
            c->sets[places[i] - c->cell->begin] = c->set_count;
        c->set_count++;
        return;
    }
    const uint32_t first = stp_places_halve(c->cloud, places, count, c->scratch);
    cut_set(c, begin, begin + first);
    cut_set(c, begin + first, end);
}

static bool has_missed(const stp_cloud *cloud)
{
    return cloud->missed && *cloud->missed;
}

static stp_status find_neighbours(cutter *c, uint32_t index, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = point_count(c);
    stp_locale locale = {0};
    stp_cloud_point *points = NULL; /* gets spacings, which are known */
    uint64_t *places = NULL;
    STP_TRY(stp_locale_create(&locale, c->cloud, index, index + 1, NEIGHBOURS, 1.0, err));
    if (has_missed(c->cloud))
        goto done;
    STP_TRY(stp_alloc(&points, count, sizeof *points, "points", err));
    STP_TRY(stp_alloc(&places, count, sizeof *places, "points", err));
    for (uint32_t i = 0; i < count; i++)
        places[i] = c->cell->begin + i;
    STP_TRY(stp_neighbours_find(&locale, NEIGHBOURS, places, count, c->lists, points, err));
done:
    free(places);
    free(points);
    stp_locale_clear(&locale);
    return status;
}

/* Whether no gap or step lies between two points with normals. */
static bool hang_together(const stp_cloud *cloud, uint64_t a, uint64_t b)
{
    const stp_cloud_point *p = &cloud->points[a], *q = &cloud->points[b];
    if (!stp_has_normal(q))
        return false;
    const stp_dvec3 d = stp_dvec3_sub(q->position, p->position);
    const stp_dvec3 n = stp_dvec3_from_float(stp_cloud_normal(cloud, a));
    const stp_dvec3 m = stp_dvec3_from_float(stp_cloud_normal(cloud, b));
    const double length = stp_dvec3_length(d);
    return length <= GAP * (double)p->spacing && stp_dvec3_dot(n, m) >= 0.0 &&
           fabs(stp_dvec3_dot(d, n)) <= STEP * length && fabs(stp_dvec3_dot(d, m)) <= STEP * length;
}

/* Joins each point with those of its neighbours in its set that it hangs together with, and with
 * equal points before it. */
static void join_pieces(cutter *c)
{
    const uint32_t begin = (uint32_t)c->cell->begin, count = point_count(c);
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t *list = c->lists + (size_t)i * NEIGHBOURS;
        if (c->sets[i] == STP_PART_NONE)
            continue;
        for (unsigned k = 0; k < NEIGHBOURS && list[k] != STP_PLACE_NONE; k++) {
            const uint64_t j = list[k] - begin;
            if (j < count && c->sets[j] == c->sets[i] &&
                hang_together(c->cloud, begin + i, list[k]))
                stp_forest_join(&c->pieces, i, (uint32_t)j, false);
        }
        if (i > 0 && stp_cloud_repeats(c->cloud, begin + i) && c->sets[i - 1] == c->sets[i])
            stp_forest_join(&c->pieces, i, i - 1, false);
    }
}

/* Numbers the pieces in the order of their first points, which are their roots. */
static stp_status number_pieces(cutter *c, stp_cell_parts *out, uint32_t *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t count = point_count(c);
    uint32_t *number = numbers + c->cell->begin;
    uint8_t parity = 0;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t root = stp_forest_find(&c->pieces, i, &parity);
        number[i] = c->sets[i] == STP_PART_NONE ? STP_PART_NONE
                    : root == i                 ? out->part_count++
                                                : number[root];
    }
    STP_TRY(stp_alloc(&out->parts, out->part_count, sizeof *out->parts, "maps", err));
    for (uint32_t i = 0; i < count; i++)
        if (number[i] != STP_PART_NONE)
            out->parts[number[i]].points++;
done:
    return status;
}

/* Sums up each part, and finds its cone. */
static stp_status describe_parts(const cutter *c, const stp_cell_parts *out,
                                 const uint32_t *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t begin = (uint32_t)c->cell->begin, count = point_count(c);
    uint32_t *ends = c->scratch, at = 0; /* by part */
    for (uint32_t p = 0; p < out->part_count; p++) {
        ends[p] = at;
        at += out->parts[p].points;
    }
    for (uint32_t i = 0; i < count; i++) {
        if (numbers[begin + i] == STP_PART_NONE)
            continue;
        stp_part *part = &out->parts[numbers[begin + i]];
        const double spacing = (double)c->cloud->points[begin + i].spacing;
        const vec3s normal = stp_cloud_normal(c->cloud, begin + i);
        c->normals[ends[numbers[begin + i]]++] = normal;
        part->area += spacing * spacing;
        part->facing = stp_dvec3_add(
            part->facing, stp_dvec3_scale(stp_dvec3_from_float(normal), spacing * spacing));
    }
    for (uint32_t p = 0; p < out->part_count; p++) {
        stp_part *part = &out->parts[p];
        const vec3s *normals = c->normals + ends[p] - part->points;
        part->cone = stp_normal_cone_of(normals, part->points);
        STP_TRY(stp_normal_cone_corners(normals, part->points, &part->cone, &part->corners,
                                        &part->corner_count, err));
    }
done:
    return status;
}

/* Lists which parts touch. */
static stp_status find_pairs(const cutter *c, stp_cell_parts *out, const uint32_t *numbers,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t begin = (uint32_t)c->cell->begin, count = point_count(c);
    size_t pair_capacity = 0, border_capacity = 0;
    for (size_t at = 0; at < (size_t)count * NEIGHBOURS; at++) {
        const uint32_t i = begin + (uint32_t)(at / NEIGHBOURS);
        const uint32_t other = (uint32_t)c->lists[at];
        if (numbers[i] == STP_PART_NONE || other == STP_NEIGHBOUR_NONE)
            continue;
        const bool inside = other - begin < count;
        if (inside && (numbers[other] == STP_PART_NONE || numbers[other] == numbers[i]))
            continue;
        if (!hang_together(c->cloud, i, other))
            continue;
        if (inside) {
            STP_TRY(stp_grow(&out->pairs, &pair_capacity, out->pair_count + 1, sizeof *out->pairs,
                             "maps", err));
            out->pairs[out->pair_count++] = stp_part_pair_of(numbers[i], numbers[other]);
        } else {
            STP_TRY(stp_grow(&out->borders, &border_capacity, out->border_count + 1,
                             sizeof *out->borders, "maps", err));
            out->borders[out->border_count++] = (stp_part_border){numbers[i], other};
        }
    }
    out->pair_count = stp_part_pairs_sort(out->pairs, out->pair_count);
done:
    return status;
}

/* Whether a point can be in a part. */
static bool may_be_surface(const stp_cloud *cloud, uint32_t place)
{
    const stp_cloud_point *p = &cloud->points[place];
    return stp_has_normal(p) && p->spacing > 0.0f && !(cloud->marks[place] & STP_MARK_OUTLIER);
}

stp_status stp_cell_parts_cut(stp_cell_parts *out, const stp_cloud *cloud, uint32_t index,
                              double cosine, uint32_t *numbers, stp_error *err)
{
    stp_status status = STP_OK;
    cutter c = {.cloud = cloud, .cell = &cloud->cells[index], .cosine = cosine};
    stp_cell_parts made = {0};
    const uint32_t begin = (uint32_t)c.cell->begin, count = point_count(&c);
    uint32_t with_normal = 0;
    STP_TRY(stp_alloc(&c.order, count, sizeof *c.order, "points", err));
    STP_TRY(stp_alloc(&c.scratch, count, sizeof *c.scratch, "points", err));
    STP_TRY(stp_alloc(&c.normals, count, sizeof *c.normals, "normals", err));
    STP_TRY(stp_alloc(&c.sets, count, sizeof *c.sets, "points", err));
    STP_TRY(stp_alloc(&c.lists, (size_t)count * NEIGHBOURS, sizeof *c.lists, "neighbours", err));
    STP_TRY(stp_forest_create(&c.pieces, count, NULL, err));
    STP_TRY(find_neighbours(&c, index, err));
    if (has_missed(cloud))
        goto done;
    for (uint32_t i = 0; i < count; i++) {
        c.sets[i] = STP_PART_NONE;
        if (may_be_surface(cloud, begin + i))
            c.order[with_normal++] = begin + i;
    }
    cut_set(&c, 0, with_normal);
    join_pieces(&c);
    STP_TRY(number_pieces(&c, &made, numbers, err));
    STP_TRY(describe_parts(&c, &made, numbers, err));
    STP_TRY(find_pairs(&c, &made, numbers, err));
    *out = made;
    made = (stp_cell_parts){0};
done:
    stp_cell_parts_clear(&made);
    free(c.order);
    free(c.scratch);
    free(c.normals);
    free(c.sets);
    free(c.lists);
    stp_forest_clear(&c.pieces);
    return status;
}

void stp_cell_parts_clear(stp_cell_parts *parts)
{
    for (uint32_t p = 0; parts->parts && p < parts->part_count; p++)
        free(parts->parts[p].corners);
    free(parts->parts);
    free(parts->pairs);
    free(parts->borders);
    *parts = (stp_cell_parts){0};
}
