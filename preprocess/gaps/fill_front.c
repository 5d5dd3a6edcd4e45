/* Keeps the edges between filled and unfilled surface. */
#include "preprocess/gaps/fill_front.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

#define TRIANGLES_LIMIT (1u << 30)

static uint64_t key_of(uint32_t from, uint32_t to)
{
    return ((uint64_t)from << 32 | to) + 1;
}

/* The place of a key in the table, or the free place where it belongs. */
static size_t find(const stp_fill_front *f, uint64_t key)
{
    size_t at = (size_t)(key * UINT64_C(0x9e3779b97f4a7c15) >> 20) & f->edge_mask;
    while (f->edges[at] != 0 && f->edges[at] != key)
        at = (at + 1) & f->edge_mask;
    return at;
}

bool stp_fill_has_edge(const stp_fill_front *front, uint32_t from, uint32_t to)
{
    return front->edges[find(front, key_of(from, to))] != 0;
}

bool stp_fill_wants(const stp_fill_front *front, uint32_t from, uint32_t to)
{
    return !stp_fill_has_edge(front, from, to) && stp_fill_has_edge(front, to, from);
}

static stp_status grow_edges(stp_fill_front *f, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t *old = f->edges, *made = NULL;
    const size_t old_places = old ? f->edge_mask + 1 : 0, places = old ? 2 * old_places : 1024;
    if (2 * (f->edge_count + 3) < old_places)
        return STP_OK;
    STP_TRY(stp_alloc(&made, places, sizeof *made, "borders", err));
    f->edges = made;
    f->edge_mask = places - 1;
    for (size_t i = 0; i < old_places; i++)
        if (old[i] != 0)
            made[find(f, old[i])] = old[i];
    free(old);
done:
    return status;
}

/* Only edges between vertices on the border matter: triangles join no others. */
static stp_status add_edge(stp_fill_front *f, uint32_t from, uint32_t to, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_map_vertex *vertices = f->fill->border.vertices;
    if (!vertices[from].on_border || !vertices[to].on_border)
        return STP_OK;
    STP_TRY(grow_edges(f, err));
    const uint64_t key = key_of(from, to);
    f->edges[find(f, key)] = key;
    f->edge_count++;
    if (stp_fill_has_edge(f, to, from)) {
        f->wanted[from]--;
        return STP_OK;
    }
    STP_TRY(
        stp_grow(&f->queue, &f->queue_capacity, f->queued + 1, sizeof *f->queue, "borders", err));
    f->queue[f->queued++] = (stp_fill_edge){to, from};
    f->wanted[to]++;
done:
    return status;
}

bool stp_fill_may_add(const stp_fill_front *front, uint32_t a, uint32_t b, uint32_t c)
{
    return a != b && b != c && c != a && !stp_fill_has_edge(front, a, b) &&
           !stp_fill_has_edge(front, b, c) && !stp_fill_has_edge(front, c, a);
}

stp_status stp_fill_add(stp_fill_front *front, uint32_t a, uint32_t b, uint32_t c, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_fill *fill = front->fill;
    const uint32_t corners[3] = {a, b, c};
    if (fill->count >= TRIANGLES_LIMIT)
        return stp_error_set(err, STP_LIMIT,
                             "more than 2^30 triangles between maps: give --gaps "
                             "overlap, or split the input into several models");
    STP_TRY(stp_grow(&fill->triangles, &front->capacity, (size_t)fill->count + 1,
                     sizeof *fill->triangles, "triangles", err));
    STP_TRY(stp_grow(&front->next, &front->next_capacity, 3 * ((size_t)fill->count + 1),
                     sizeof *front->next, "triangles", err));
    memcpy(fill->triangles[fill->count], corners, sizeof corners);
    for (uint32_t k = 0; k < 3; k++) {
        front->next[3 * fill->count + k] = front->first[corners[k]];
        front->first[corners[k]] = 3 * fill->count + k;
    }
    fill->count++;
    for (int k = 0; k < 3; k++)
        STP_TRY(add_edge(front, corners[k], corners[(k + 1) % 3], err));
done:
    return status;
}

stp_status stp_fill_front_create(stp_fill_front *out, stp_map_fill *fill, stp_error *err)
{
    stp_status status = STP_OK;
    stp_fill_front made = {.fill = fill};
    const stp_mesh *mesh = &fill->border.mesh;
    STP_TRY(grow_edges(&made, err));
    STP_TRY(stp_alloc(&made.first, mesh->vertex_count, sizeof *made.first, "borders", err));
    STP_TRY(stp_alloc(&made.wanted, mesh->vertex_count, sizeof *made.wanted, "borders", err));
    for (uint64_t v = 0; v < mesh->vertex_count; v++)
        made.first[v] = STP_FILL_NONE;
    for (uint64_t t = 0; t < mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            STP_TRY(add_edge(&made, mesh->triangles[t][k], mesh->triangles[t][(k + 1) % 3], err));
    *out = made;
    made = (stp_fill_front){0};
done:
    stp_fill_front_clear(&made);
    return status;
}

void stp_fill_front_clear(stp_fill_front *front)
{
    free(front->edges);
    free(front->first);
    free(front->next);
    free(front->wanted);
    free(front->queue);
    *front = (stp_fill_front){0};
}
