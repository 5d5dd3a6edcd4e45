/* Fills what is left between trimmed maps with triangles. */
#include "preprocess/gaps/map_fill.h"

#include "base/memory.h"
#include "preprocess/gaps/fill_front.h"
#include "preprocess/gaps/fill_loops.h"
#include "preprocess/maps/face_tree.h"

#include <stdlib.h>

/* Each pass takes wider triangles: radius of the circle through the corners, in sizes of the edge's
 * vertices; how far triangles may lie over each other, in the same sizes. */
#define PASSES 4
static const double pass_radius[PASSES] = {0.8, 1.2, 1.7, 2.4};
static const double pass_over[PASSES] = {0.01, 0.01, 0.03, 0.1};
/* Least cosine between the normals of a triangle and of its corners, and of two corners. */
#define ALIKE 0.2
/* A third corner is at least this far beside the edge, in lengths of it. */
#define BESIDE_LEAST 0.02
/* Triangles farther than this off the edge's plane, in sizes, lie on another sheet. */
#define SHEET 1.0

/* A triangle as it is seen along the edge's normal. */
typedef struct flat {
    double at[3][2];
} flat;

typedef struct candidate {
    uint32_t vertex;
    double cosine; /* of the angle at which it sees the edge */
} candidate;

typedef struct filling {
    stp_fill_front front;
    stp_face_tree tree; /* over the border's triangles */
    uint32_t *stamps;   /* by vertex: the last edge near which it was found */
    uint32_t stamp;
    candidate *candidates;
    size_t candidate_count, candidate_capacity;
    flat *flats; /* triangles near the edge */
    size_t flat_count, flat_capacity;
    /* The edge at hand: */
    uint32_t from, to;
    stp_dvec3 origin, axes[3]; /* along the edge, to its left, along the normal */
    double size, radius, over;
} filling;

static stp_dvec3 position(const filling *f, uint32_t v)
{
    return f->front.fill->border.mesh.positions[v];
}

static stp_dvec3 normal(const filling *f, uint32_t v)
{
    return stp_dvec3_from_float(f->front.fill->border.mesh.normals[v]);
}

static bool set_edge(filling *f, uint32_t from, uint32_t to)
{
    const stp_map_vertex *vertices = f->front.fill->border.vertices;
    const stp_dvec3 way = stp_dvec3_sub(position(f, to), position(f, from));
    const stp_dvec3 up = stp_dvec3_add(normal(f, from), normal(f, to));
    f->from = from;
    f->to = to;
    f->origin = stp_dvec3_add(position(f, from), stp_dvec3_scale(way, 0.5));
    f->size = stp_max(vertices[from].size, vertices[to].size);
    f->axes[0] = stp_dvec3_normalize(way);
    f->axes[1] = stp_dvec3_normalize(stp_dvec3_cross(up, f->axes[0]));
    f->axes[2] = stp_dvec3_cross(f->axes[0], f->axes[1]);
    return stp_dvec3_length(f->axes[1]) > 0.5;
}

static stp_dvec3 local(const filling *f, stp_dvec3 world)
{
    const stp_dvec3 d = stp_dvec3_sub(world, f->origin);
    return (stp_dvec3){stp_dvec3_dot(d, f->axes[0]), stp_dvec3_dot(d, f->axes[1]),
                       stp_dvec3_dot(d, f->axes[2])};
}

static stp_dvec3 normal_of(const stp_dvec3 at[3])
{
    return stp_dvec3_normalize(
        stp_dvec3_cross(stp_dvec3_sub(at[1], at[0]), stp_dvec3_sub(at[2], at[0])));
}

/* Notes a triangle near the edge, unless it is of another sheet. */
static stp_status note_triangle(filling *f, const uint32_t corners[3], stp_error *err)
{
    stp_status status = STP_OK;
    stp_dvec3 at[3];
    flat out;
    bool above = true, below = true;
    for (int k = 0; k < 3; k++) {
        at[k] = local(f, position(f, corners[k]));
        out.at[k][0] = at[k].x;
        out.at[k][1] = at[k].y;
        above = above && at[k].z > SHEET * f->size;
        below = below && at[k].z < -SHEET * f->size;
    }
    if (above || below || normal_of(at).z <= 0.0)
        return STP_OK;
    STP_TRY(stp_grow(&f->flats, &f->flat_capacity, f->flat_count + 1, sizeof *f->flats, "borders",
                     err));
    f->flats[f->flat_count++] = out;
done:
    return status;
}

/* Takes a vertex as third corner if the triangle is small and flat enough. */
static stp_status note_candidate(filling *f, uint32_t v, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_dvec3 at[3] = {position(f, f->from), position(f, f->to), position(f, v)};
    const stp_dvec3 a = stp_dvec3_sub(at[0], at[2]), b = stp_dvec3_sub(at[1], at[2]);
    const double length = stp_dvec3_length(stp_dvec3_sub(at[1], at[0]));
    if (v == f->from || v == f->to || f->front.wanted[v] == 0 ||
        local(f, at[2]).y < BESIDE_LEAST * length)
        return STP_OK;
    const double cosine = stp_dvec3_dot(a, b) / (stp_dvec3_length(a) * stp_dvec3_length(b));
    const double sine = sqrt(stp_max(1.0 - cosine * cosine, 1e-12));
    if (cosine > 0.0 && length > 2.0 * f->radius * sine)
        return STP_OK;
    const stp_dvec3 n = normal_of(at),
                    others[3] = {normal(f, f->from), normal(f, f->to), normal(f, v)};
    for (int k = 0; k < 3; k++)
        if (stp_dvec3_dot(n, others[k]) < ALIKE ||
            stp_dvec3_dot(others[k], others[(k + 1) % 3]) < ALIKE)
            return STP_OK;
    STP_TRY(stp_grow(&f->candidates, &f->candidate_capacity, f->candidate_count + 1,
                     sizeof *f->candidates, "borders", err));
    f->candidates[f->candidate_count++] = (candidate){v, cosine};
done:
    return status;
}

static int compare_candidates(const void *a, const void *b)
{
    const candidate *p = a, *q = b;
    if (p->cosine != q->cosine)
        return p->cosine < q->cosine ? -1 : 1;
    return (p->vertex > q->vertex) - (p->vertex < q->vertex);
}

/* Finds the vertices that may be third corners, and all triangles near the edge. */
static stp_status look_around(filling *f, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_map_fill *fill = f->front.fill;
    const stp_dbox at = {f->origin, f->origin}, box = stp_dbox_grown(&at, 2.0 * f->radius);
    uint32_t *found = NULL;
    size_t count = 0;
    f->stamp++;
    f->candidate_count = f->flat_count = 0;
    STP_TRY(stp_face_tree_find(&f->tree, &box, &found, &count, err));
    for (size_t i = 0; i < count; i++) {
        const uint32_t *corners = fill->border.mesh.triangles[found[i]];
        STP_TRY(note_triangle(f, corners, err));
        for (int k = 0; k < 3; k++) {
            const uint32_t v = corners[k];
            if (f->stamps[v] == f->stamp)
                continue;
            f->stamps[v] = f->stamp;
            STP_TRY(note_candidate(f, v, err));
            for (uint32_t c = f->front.first[v]; c != STP_FILL_NONE; c = f->front.next[c])
                STP_TRY(note_triangle(f, fill->triangles[c / 3], err));
        }
    }
    if (f->candidate_count > 0)
        qsort(f->candidates, f->candidate_count, sizeof *f->candidates, compare_candidates);
done:
    free(found);
    return status;
}

/* Whether a side of the first triangle parts it from the second, but for `over`. */
static bool is_parted(const flat *a, const flat *b, double over)
{
    for (int k = 0; k < 3; k++) {
        const double *p = a->at[k], *q = a->at[(k + 1) % 3];
        const double way[2] = {q[0] - p[0], q[1] - p[1]}, length = hypot(way[0], way[1]);
        double least = INFINITY;
        for (int i = 0; i < 3; i++)
            least = stp_min(least, way[1] * (b->at[i][0] - p[0]) - way[0] * (b->at[i][1] - p[1]));
        if (least >= -over * length)
            return true;
    }
    return false;
}

/* Whether the triangle over the edge lies over none that is there. */
static bool is_free(const filling *f, uint32_t v)
{
    const uint32_t corners[3] = {f->from, f->to, v};
    flat own;
    for (int k = 0; k < 3; k++) {
        const stp_dvec3 at = local(f, position(f, corners[k]));
        own.at[k][0] = at.x;
        own.at[k][1] = at.y;
    }
    for (size_t i = 0; i < f->flat_count; i++)
        if (!is_parted(&own, &f->flats[i], f->over) && !is_parted(&f->flats[i], &own, f->over))
            return false;
    return true;
}

/* Adds a triangle on the left of a wanted edge, if there is one. */
static stp_status fill_edge(filling *f, stp_fill_edge edge, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(look_around(f, err));
    for (size_t i = 0; i < f->candidate_count; i++) {
        const uint32_t v = f->candidates[i].vertex;
        if (!stp_fill_may_add(&f->front, edge.from, edge.to, v) || !is_free(f, v))
            continue;
        STP_TRY(stp_fill_add(&f->front, edge.from, edge.to, v, err));
        break;
    }
done:
    return status;
}

/* Goes through all wanted edges. Those that have no triangle stay in the queue. */
static stp_status run_pass(filling *f, int pass, stp_error *err)
{
    stp_status status = STP_OK;
    stp_fill_front *front = &f->front;
    size_t kept = 0;
    f->over = 0.0;
    for (size_t i = 0; i < front->queued; i++) {
        const stp_fill_edge edge = front->queue[i];
        if (!stp_fill_wants(front, edge.from, edge.to))
            continue;
        if (set_edge(f, edge.from, edge.to)) {
            f->radius = pass_radius[pass] * f->size;
            f->over = pass_over[pass] * f->size;
            STP_TRY(fill_edge(f, edge, err));
        }
        if (stp_fill_wants(front, edge.from, edge.to))
            front->queue[kept++] = edge;
    }
    front->queued = kept;
done:
    return status;
}

stp_status stp_map_fill_create(stp_map_fill *out, const stp_map *maps, uint32_t count,
                               stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_fill made = {0};
    filling f = {0};
    STP_TRY(stp_map_border_create(&made.border, maps, count, err));
    STP_TRY(stp_fill_front_create(&f.front, &made, err));
    STP_TRY(stp_face_tree_create(&f.tree, &made.border.mesh, err));
    STP_TRY(stp_alloc(&f.stamps, made.border.mesh.vertex_count, sizeof *f.stamps, "borders", err));
    for (int pass = 0; pass < PASSES; pass++)
        STP_TRY(run_pass(&f, pass, err));
    STP_TRY(stp_fill_loops_close(&f.front, err));
    made.open_edges = f.front.queued;
    *out = made;
    made = (stp_map_fill){0};
done:
    stp_fill_front_clear(&f.front);
    stp_face_tree_clear(&f.tree);
    free(f.stamps);
    free(f.candidates);
    free(f.flats);
    stp_map_fill_clear(&made);
    return status;
}

void stp_map_fill_clear(stp_map_fill *fill)
{
    stp_map_border_clear(&fill->border);
    free(fill->triangles);
    *fill = (stp_map_fill){0};
}
