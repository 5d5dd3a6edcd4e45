/* Finds rings to begin a chain with. */
#include "preprocess/plant/plant_seed.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX
enum { REGULAR_STAR = 6, WAYS = 3 };

/* A step of a walk, from one vertex to the next. triangle: on the left of that edge. */
typedef struct edge_way {
    uint32_t from, at, triangle;
} edge_way;

typedef struct loop {
    uint32_t count, left_count;
    uint32_t vertices[STP_PLANT_RING_LIMIT];
    uint32_t left[2 * STP_PLANT_RING_LIMIT]; /* triangles */
} loop;

stp_status stp_plant_seeds_create(stp_plant_seeds *out, uint32_t most_triangles, stp_error *err)
{
    stp_status status = STP_OK;
    stp_plant_seeds s = {0};
    STP_TRY(stp_alloc(&s.tried, 3 * (size_t)most_triangles, sizeof *s.tried, "rings", err));
    STP_TRY(stp_alloc(&s.set_aside, most_triangles, sizeof *s.set_aside, "rings", err));
    *out = s;
    s = (stp_plant_seeds){0};
done:
    stp_plant_seeds_clear(&s);
    return status;
}

void stp_plant_seeds_clear(stp_plant_seeds *seeds)
{
    free(seeds->tried);
    free(seeds->set_aside);
    *seeds = (stp_plant_seeds){0};
}

void stp_plant_seeds_begin(stp_plant_seeds *seeds, const stp_plant_piece *piece)
{
    memset(seeds->tried, 0xff, piece->vertex_count * sizeof *seeds->tried);
}

static bool is_regular(const stp_plant_rings *r, uint32_t vertex)
{
    const stp_plant_piece *p = r->piece;
    const uint32_t begin = p->star_begins[vertex];
    if (p->star_begins[vertex + 1] - begin != REGULAR_STAR)
        return false;
    for (uint32_t i = begin; i < begin + REGULAR_STAR; i++)
        if (r->taken[p->stars[i]])
            return false;
    return true;
}

static bool has_corner(const stp_plant_piece *p, uint32_t triangle, uint32_t vertex)
{
    const uint32_t *c = p->corners[triangle];
    return c[0] == vertex || c[1] == vertex || c[2] == vertex;
}

static uint32_t third_corner(const stp_plant_piece *p, uint32_t triangle, uint32_t a, uint32_t b)
{
    const uint32_t *c = p->corners[triangle];
    for (int k = 0; k < 2; k++)
        if (c[k] != a && c[k] != b)
            return c[k];
    return c[2];
}

/* The other triangle at an edge of a vertex, or NONE. */
static uint32_t across(const stp_plant_piece *p, uint32_t vertex, uint32_t other, uint32_t triangle)
{
    for (uint32_t i = p->star_begins[vertex]; i < p->star_begins[vertex + 1]; i++)
        if (p->stars[i] != triangle && has_corner(p, p->stars[i], other))
            return p->stars[i];
    return NONE;
}

/* Goes straight on at a walk's vertex. *left gets the two triangles that the turn adds. */
static bool go_on(const stp_plant_rings *r, edge_way *way, uint32_t left[2])
{
    const stp_plant_piece *p = r->piece;
    if (!is_regular(r, way->at))
        return false;
    uint32_t edge = way->from, triangle = way->triangle;
    for (int k = 0; k < 2; k++) {
        edge = third_corner(p, triangle, edge, way->at);
        triangle = across(p, way->at, edge, triangle);
        if (triangle == NONE)
            return false;
        left[k] = triangle;
    }
    const uint32_t next = third_corner(p, triangle, edge, way->at);
    *way = (edge_way){.from = way->at, .at = next, .triangle = triangle};
    return true;
}

/* Notes the walk through a vertex between two neighbours. False if it was noted before. */
static bool note(stp_plant_seeds *s, uint32_t vertex, uint32_t before, uint32_t after)
{
    const uint32_t lesser = before < after ? before : after;
    for (int k = 0; k < WAYS; k++) {
        if (s->tried[vertex][k] == lesser)
            return false;
        if (s->tried[vertex][k] == NONE) {
            s->tried[vertex][k] = lesser;
            return true;
        }
    }
    return false;
}

static bool is_simple(const loop *l)
{
    for (uint32_t i = 0; i < l->count; i++)
        for (uint32_t k = 0; k < i; k++)
            if (l->vertices[i] == l->vertices[k])
                return false;
    return l->count >= 3;
}

/* Walks until the walk is back at its begin. */
static bool walk(stp_plant_seeds *s, const stp_plant_rings *r, edge_way way, loop *out)
{
    const edge_way begin = way;
    out->count = out->left_count = 0;
    do {
        const edge_way before = way;
        if (out->count == STP_PLANT_RING_LIMIT || !go_on(r, &way, out->left + out->left_count))
            return false;
        if (!note(s, before.at, before.from, way.at))
            return false;
        out->vertices[out->count++] = before.at;
        out->left_count += 2;
    } while (way.at != begin.at || way.from != begin.from);
    return is_simple(out);
}

/* Sets out on one of the three walks through a regular vertex. */
static bool set_out(const stp_plant_rings *r, uint32_t vertex, int way, edge_way *out)
{
    const stp_plant_piece *p = r->piece;
    uint32_t triangle = p->stars[p->star_begins[vertex]];
    const uint32_t *c = p->corners[triangle];
    uint32_t from = c[0] == vertex ? c[1] : c[0];
    for (int k = 0; k < way; k++) {
        from = third_corner(p, triangle, from, vertex);
        triangle = across(p, vertex, from, triangle);
        if (triangle == NONE)
            return false;
    }
    *out = (edge_way){.from = from, .at = vertex, .triangle = triangle};
    return true;
}

static void set_taken(stp_plant_rings *r, const uint32_t *triangles, uint32_t count, uint8_t taken)
{
    for (uint32_t i = 0; i < count; i++)
        r->taken[triangles[i]] = taken;
}

/* Sets aside the free triangles around the last ring, beyond the chain's end. Returns their number.
 */
static uint32_t set_beyond_aside(stp_plant_seeds *s, stp_plant_rings *r)
{
    const stp_plant_piece *p = r->piece;
    uint32_t count = 0;
    for (uint32_t i = r->begins[r->ring_count - 1]; i < r->begins[r->ring_count]; i++) {
        const uint32_t v = r->vertices[i];
        for (uint32_t k = p->star_begins[v]; k < p->star_begins[v + 1]; k++)
            if (!r->taken[p->stars[k]]) {
                s->set_aside[count++] = p->stars[k];
                r->taken[p->stars[k]] = 1;
            }
    }
    return count;
}

/* Follows the chain to its end on the loop's right. */
static void follow_right(stp_plant_rings *r, const loop *l)
{
    set_taken(r, l->left, l->left_count, 1);
    stp_plant_rings_follow(r, l->vertices, l->count);
    set_taken(r, l->left, l->left_count, 0);
}

/* Follows the chain to one end, then back from there to the other end. If no chain can begin at
 * that end, the first way is the whole chain, so that it is not looked for again. */
static bool follow_both(stp_plant_seeds *s, stp_plant_rings *r, const loop *l)
{
    uint32_t ring[STP_PLANT_RING_LIMIT];
    follow_right(r, l);
    if (r->ring_count < 2)
        return false;
    const uint32_t begin = r->begins[r->ring_count - 1];
    const uint32_t count = r->begins[r->ring_count] - begin;
    const uint32_t aside = set_beyond_aside(s, r);
    memcpy(ring, r->vertices + begin, count * sizeof *ring);
    stp_plant_rings_undo(r);
    stp_plant_rings_follow(r, ring, count);
    set_taken(r, s->set_aside, aside, 0);
    if (r->ring_count < 2)
        follow_right(r, l);
    return true;
}

bool stp_plant_seeds_follow(stp_plant_seeds *s, stp_plant_rings *r, uint32_t vertex)
{
    loop l;
    for (int way = 0; way < WAYS && is_regular(r, vertex); way++) {
        edge_way begin;
        if (set_out(r, vertex, way, &begin) && walk(s, r, begin, &l) && follow_both(s, r, &l))
            return true;
    }
    return false;
}
