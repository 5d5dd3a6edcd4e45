/* Rings of vertices, one after the other along a branch. */
#include "preprocess/plant/plant_rings.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX

/* The surroundings of the last ring. Triangles and vertices from first_* on are not yet proven to
 * be a section. */
typedef struct layer {
    uint32_t first_triangle, first_vertex;
    uint32_t inner;   /* vertices of the ring */
    uint32_t lids;    /* triangles with three corners of the ring */
    uint32_t bases;   /* triangles with two corners of the ring */
    uint32_t singles; /* triangles with one corner of the ring */
} layer;

stp_status stp_plant_rings_create(stp_plant_rings *out, uint32_t most_triangles, stp_error *err)
{
    stp_status status = STP_OK;
    stp_plant_rings r = {0};
    const size_t triangles = most_triangles, vertices = 3 * triangles;
    STP_TRY(stp_alloc(&r.begins, vertices + 2, sizeof *r.begins, "rings", err));
    STP_TRY(stp_alloc(&r.vertices, vertices, sizeof *r.vertices, "rings", err));
    STP_TRY(stp_alloc(&r.sections, vertices + 2, sizeof *r.sections, "rings", err));
    STP_TRY(stp_alloc(&r.triangles, triangles, sizeof *r.triangles, "rings", err));
    STP_TRY(stp_alloc(&r.taken, triangles, sizeof *r.taken, "rings", err));
    STP_TRY(stp_alloc(&r.ring_of, vertices, sizeof *r.ring_of, "rings", err));
    STP_TRY(stp_alloc(&r.links, vertices, sizeof *r.links, "rings", err));
    STP_TRY(stp_alloc(&r.link_counts, vertices, sizeof *r.link_counts, "rings", err));
    *out = r;
    r = (stp_plant_rings){0};
done:
    stp_plant_rings_clear(&r);
    return status;
}

void stp_plant_rings_clear(stp_plant_rings *rings)
{
    free(rings->begins);
    free(rings->vertices);
    free(rings->sections);
    free(rings->triangles);
    free(rings->taken);
    free(rings->ring_of);
    free(rings->links);
    free(rings->link_counts);
    *rings = (stp_plant_rings){0};
}

void stp_plant_rings_begin(stp_plant_rings *r, const stp_plant_piece *piece)
{
    r->piece = piece;
    r->ring_count = r->vertex_count = r->triangle_count = 0;
    memset(r->taken, 0, piece->triangle_count * sizeof *r->taken);
    memset(r->ring_of, 0xff, piece->vertex_count * sizeof *r->ring_of);
}

/* Takes the free triangles around the last ring. False if there are too many. */
static bool take(stp_plant_rings *r)
{
    const uint32_t *star_begins = r->piece->star_begins;
    for (uint32_t i = r->begins[r->ring_count - 1]; i < r->begins[r->ring_count]; i++) {
        const uint32_t v = r->vertices[i];
        if (star_begins[v + 1] - star_begins[v] > STP_PLANT_STAR_LIMIT)
            return false;
        for (uint32_t s = star_begins[v]; s < star_begins[v + 1]; s++) {
            const uint32_t triangle = r->piece->stars[s];
            if (!r->taken[triangle])
                r->triangles[r->triangle_count++] = triangle;
            r->taken[triangle] = 1;
        }
    }
    return true;
}

static void link(stp_plant_rings *r, uint32_t from, uint32_t to)
{
    if (r->link_counts[from] < 2)
        r->links[from][r->link_counts[from]] = to;
    r->link_counts[from]++;
}

/* Counts a triangle of the layer and notes its new vertices. False if the triangle touches an older
 * ring. */
static bool look_at(stp_plant_rings *r, layer *l, uint32_t triangle)
{
    uint32_t others[3], other_count = 0;
    for (int k = 0; k < 3; k++) {
        const uint32_t v = r->piece->corners[triangle][k];
        if (r->ring_of[v] == r->ring_count - 1)
            continue;
        others[other_count++] = v;
        if (r->ring_of[v] == NONE) {
            r->ring_of[v] = r->ring_count;
            r->link_counts[v] = 0;
            r->vertices[r->vertex_count++] = v;
        }
        if (r->ring_of[v] != r->ring_count)
            return false;
    }
    if (other_count == 2) {
        link(r, others[0], others[1]);
        link(r, others[1], others[0]);
    }
    l->lids += other_count == 0;
    l->bases += other_count == 1;
    l->singles += other_count == 2;
    return true;
}

/* Puts the new ring's vertices in order around it. False if they are not one closed row. */
static bool put_in_order(stp_plant_rings *r, uint32_t first, uint32_t count)
{
    for (uint32_t i = first; i < first + count; i++)
        if (r->link_counts[r->vertices[i]] != 2)
            return false;
    const uint32_t begin = r->vertices[first];
    uint32_t from = r->links[begin][1], at = begin;
    for (uint32_t i = 0; i < count; i++) {
        if (i > 0 && at == begin)
            return false;
        r->vertices[first + i] = at;
        const uint32_t next = r->links[at][r->links[at][0] == from];
        from = at;
        at = next;
    }
    return at == begin;
}

/* The edges of a ring. A tip has none. */
static uint32_t edges_of(uint32_t vertices)
{
    return vertices == 1 ? 0 : vertices;
}

/* Whether the layer is exactly a section. Only at the first ring, a lid may be there, too. */
static bool is_section(stp_plant_rings *r, const layer *l)
{
    const uint32_t outer = r->vertex_count - l->first_vertex;
    const bool lid_fits = l->lids == 0 || (r->ring_count == 1 && l->lids + 2 == l->inner);
    if (!lid_fits || outer == 0 || outer == 2 || outer > STP_PLANT_RING_LIMIT)
        return false;
    if (l->bases != edges_of(l->inner) || l->singles != edges_of(outer))
        return false;
    return outer == 1 ? l->inner > 1 : put_in_order(r, l->first_vertex, outer);
}

static void give_back(stp_plant_rings *r, uint32_t first_triangle, uint32_t first_vertex)
{
    while (r->triangle_count > first_triangle)
        r->taken[r->triangles[--r->triangle_count]] = 0;
    while (r->vertex_count > first_vertex)
        r->ring_of[r->vertices[--r->vertex_count]] = NONE;
}

/* Adds the next ring. False at the chain's end; a lid there belongs to the last section. */
static bool step(stp_plant_rings *r)
{
    layer l = {.first_triangle = r->triangle_count,
               .first_vertex = r->vertex_count,
               .inner = r->begins[r->ring_count] - r->begins[r->ring_count - 1]};
    bool known = take(r);
    for (uint32_t i = l.first_triangle; known && i < r->triangle_count; i++)
        known = look_at(r, &l, r->triangles[i]);
    if (known && is_section(r, &l)) {
        r->sections[r->ring_count] = r->triangle_count;
        r->begins[++r->ring_count] = r->vertex_count;
        return true;
    }
    const uint32_t count = r->triangle_count - l.first_triangle;
    if (known && r->ring_count > 1 && l.lids == count && count > 0 && count + 2 == l.inner)
        r->sections[r->ring_count - 1] = r->triangle_count;
    else
        give_back(r, l.first_triangle, l.first_vertex);
    return false;
}

void stp_plant_rings_follow(stp_plant_rings *r, const uint32_t *ring, uint32_t count)
{
    memcpy(r->vertices, ring, count * sizeof *ring);
    r->triangle_count = 0;
    r->vertex_count = count;
    r->ring_count = 1;
    r->begins[0] = 0;
    r->begins[1] = count;
    r->sections[0] = 0;
    for (uint32_t i = 0; i < count; i++)
        r->ring_of[ring[i]] = 0;
    while (step(r))
        ;
    /* Clear the ring numbers: a later chain may begin where this one ended. */
    for (uint32_t i = 0; i < r->vertex_count; i++)
        r->ring_of[r->vertices[i]] = NONE;
}

void stp_plant_rings_undo(stp_plant_rings *r)
{
    give_back(r, 0, r->vertex_count);
    r->ring_count = r->vertex_count = 0;
}
