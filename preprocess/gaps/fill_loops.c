/* Closes small loops of wanted edges. */
#include "preprocess/gaps/fill_loops.h"

#include "base/memory.h"

#include <stdlib.h>

#define MOST STP_FILL_NARROW_EDGES
/* A triangle whose normal is this far off a corner's counts as larger. */
#define ALIKE 0.2
#define UNLIKE_COST 10.0
/* A slit has less area than this part of its length squared. */
#define SLIT 0.035
/* A narrow loop is less wide, on average, in sizes of its first vertex. */
#define NARROW 1.0

typedef struct loop {
    uint32_t vertices[MOST], count;
    double cost[MOST][MOST];   /* of the triangles between two corners; INFINITY: there are none */
    uint32_t apex[MOST][MOST]; /* if the cost is finite */
    bool may_turn;             /* triangles may look against the corners' normals */
} loop;

static stp_dvec3 position(const stp_fill_front *f, uint32_t v)
{
    return f->fill->border.mesh.positions[v];
}

static int compare_edges(const void *a, const void *b)
{
    const stp_fill_edge *p = a, *q = b;
    if (p->from != q->from)
        return p->from < q->from ? -1 : 1;
    return (p->to > q->to) - (p->to < q->to);
}

/* The first edge that leaves a vertex, of the first `count` of the queue, which are sorted. */
static size_t first_from(const stp_fill_front *f, size_t count, uint32_t vertex)
{
    size_t low = 0, high = count;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (f->queue[middle].from < vertex)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* The edge after another one around the gap on their left: the first one clockwise from it; `count`
 * if there is none. */
static size_t edge_after(const stp_fill_front *f, size_t count, size_t edge)
{
    const uint32_t at = f->queue[edge].to;
    const stp_dvec3 n = stp_dvec3_from_float(f->fill->border.mesh.normals[at]);
    const stp_dvec3 back = stp_dvec3_sub(position(f, f->queue[edge].from), position(f, at));
    const stp_dvec3 side = stp_dvec3_cross(n, back);
    size_t best = count;
    double least = INFINITY;
    for (size_t i = first_from(f, count, at); i < count && f->queue[i].from == at; i++) {
        if (!stp_fill_wants(f, at, f->queue[i].to))
            continue;
        const stp_dvec3 way = stp_dvec3_sub(position(f, f->queue[i].to), position(f, at));
        const stp_dvec3 flat = stp_dvec3_sub(back, stp_dvec3_scale(n, stp_dvec3_dot(n, back)));
        double angle = atan2(-stp_dvec3_dot(way, side), stp_dvec3_dot(way, flat));
        angle = angle <= 0.0 ? angle + 2.0 * M_PI : angle;
        if (angle < least) {
            least = angle;
            best = i;
        }
    }
    return best;
}

/* Whether a loop may be closed. Finds whether its triangles may turn against the normals of its
 * corners: only if it is no border around a map, which would be shut from behind. Such a border has
 * four edges or more, of one map or around more than a slit. */
static bool may_close(const stp_fill_front *f, loop *l)
{
    const stp_map_vertex *vertices = f->fill->border.vertices, *first = &vertices[l->vertices[0]];
    const stp_dvec3 origin = position(f, l->vertices[0]);
    stp_dvec3 twice = {0.0, 0.0, 0.0}, up = {0.0, 0.0, 0.0}; /* the area; the sum of normals */
    double length = 0.0;
    bool alone = true;
    for (uint32_t i = 0; i < l->count; i++) {
        const uint32_t at = l->vertices[i], next = l->vertices[(i + 1) % l->count];
        const stp_dvec3 a = stp_dvec3_sub(position(f, at), origin);
        const stp_dvec3 b = stp_dvec3_sub(position(f, next), origin);
        twice = stp_dvec3_add(twice, stp_dvec3_cross(a, b));
        up = stp_dvec3_add(up, stp_dvec3_from_float(f->fill->border.mesh.normals[at]));
        length += stp_dvec3_length(stp_dvec3_sub(b, a));
        alone = alone && vertices[at].map == first->map;
    }
    const double area = 0.5 * stp_dvec3_length(twice);
    l->may_turn = l->count == 3 || (!alone && area < SLIT * length * length);
    return l->count <= STP_FILL_LOOP_EDGES ||
           (stp_dvec3_dot(twice, up) > 0.0 && 2.0 * area < NARROW * first->size * length);
}

/* What the triangle of three of the loop's corners, in its order, adds to the cost. */
static double cost_of(const stp_fill_front *f, const uint32_t corners[3], bool may_turn)
{
    const stp_dvec3 a = position(f, corners[0]), b = position(f, corners[1]);
    const stp_dvec3 n =
        stp_dvec3_cross(stp_dvec3_sub(b, a), stp_dvec3_sub(position(f, corners[2]), a));
    const double area = 0.5 * stp_dvec3_length(n);
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    bool alike = true;
    if (!stp_fill_may_add(f, corners[0], corners[1], corners[2]))
        return INFINITY;
    for (int k = 0; k < 3; k++) {
        const stp_dvec3 own = stp_dvec3_from_float(f->fill->border.mesh.normals[corners[k]]);
        alike = alike && stp_dvec3_dot(n, own) >= 2.0 * area * ALIKE;
        sum = stp_dvec3_add(sum, own);
    }
    if (stp_dvec3_dot(n, sum) < 0.0 && !may_turn)
        return INFINITY;
    return alike ? area : UNLIKE_COST * area;
}

/* A chord may be new only if no triangle has it on either side. */
static bool is_chord_free(const stp_fill_front *f, const loop *l, uint32_t i, uint32_t k)
{
    const uint32_t a = l->vertices[i], b = l->vertices[k];
    return k == i + 1 || (i == 0 && k + 1 == l->count) ||
           (a != b && !stp_fill_has_edge(f, a, b) && !stp_fill_has_edge(f, b, a));
}

/* Finds the triangles of least cost between all pairs of corners. */
static void triangulate(const stp_fill_front *f, loop *l)
{
    for (uint32_t i = 0; i + 1 < l->count; i++)
        l->cost[i][i + 1] = 0.0;
    for (uint32_t wide = 2; wide < l->count; wide++)
        for (uint32_t i = 0; i + wide < l->count; i++) {
            const uint32_t j = i + wide;
            l->cost[i][j] = INFINITY;
            if (!is_chord_free(f, l, i, j))
                continue;
            for (uint32_t k = i + 1; k < j; k++) {
                const double below = l->cost[i][k] + l->cost[k][j];
                const uint32_t corners[3] = {l->vertices[i], l->vertices[k], l->vertices[j]};
                const double cost =
                    below < l->cost[i][j] ? below + cost_of(f, corners, l->may_turn) : INFINITY;
                if (cost < l->cost[i][j]) {
                    l->cost[i][j] = cost;
                    l->apex[i][j] = k;
                }
            }
        }
}

/* Adds the triangles between two corners of the loop. */
static stp_status add_between(stp_fill_front *f, const loop *l, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t stack[2 * MOST][2], count = 1;
    stack[0][0] = 0;
    stack[0][1] = l->count - 1;
    while (count > 0) {
        const uint32_t i = stack[--count][0], j = stack[count][1];
        if (j == i + 1)
            continue;
        const uint32_t k = l->apex[i][j];
        if (!stp_fill_may_add(f, l->vertices[i], l->vertices[k], l->vertices[j]))
            continue; /* the loop meets itself: a chord is there by now */
        STP_TRY(stp_fill_add(f, l->vertices[i], l->vertices[k], l->vertices[j], err));
        stack[count][0] = i;
        stack[count++][1] = k;
        stack[count][0] = k;
        stack[count++][1] = j;
    }
done:
    return status;
}

stp_status stp_fill_loops_close(stp_fill_front *front, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t count = front->queued;
    size_t kept = 0;
    loop *l = NULL;
    STP_TRY(stp_alloc(&l, 1, sizeof *l, "borders", err));
    if (count > 0)
        qsort(front->queue, count, sizeof *front->queue, compare_edges);
    for (size_t first = 0; first < count; first++) {
        size_t at = first;
        l->count = 0;
        if (!stp_fill_wants(front, front->queue[first].from, front->queue[first].to))
            continue;
        do {
            l->vertices[l->count++] = front->queue[at].from;
            at = edge_after(front, count, at);
        } while (at != first && at != count && l->count < MOST);
        if (at != first || l->count < 3 || !may_close(front, l))
            continue;
        triangulate(front, l);
        if (isfinite(l->cost[0][l->count - 1]))
            STP_TRY(add_between(front, l, err));
    }
    for (size_t i = 0; i < front->queued; i++)
        if (stp_fill_wants(front, front->queue[i].from, front->queue[i].to))
            front->queue[kept++] = front->queue[i];
    front->queued = kept;
done:
    free(l);
    return status;
}
