/* Chains the edges of a mesh to polylines. */
#include "formats/scan/mesh/line_chain.h"

#include "base/memory.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The edges that become lines, without those that are left out. The edges at vertex v are
 * ends[begin[v]] to ends[begin[v + 1]]. */
typedef struct chainer {
    const stp_point_mesh *mesh;
    uint32_t (*edges)[2]; /* the lower vertex number first; sorted */
    size_t edge_count;
    size_t *begin;
    size_t *at; /* edge numbers, grouped by vertex */
    bool *used; /* per edge */
    stp_line_set set;
    size_t vertex_capacity, strip_capacity;
    double radius;
} chainer;

static bool exists(const stp_point_mesh *mesh, uint32_t vertex)
{
    return vertex < mesh->point_count;
}

static int compare_edges(const void *a, const void *b)
{
    const uint32_t *x = a, *y = b;
    for (int i = 0; i < 2; i++)
        if (x[i] != y[i])
            return x[i] < y[i] ? -1 : 1;
    return 0;
}

/* Marks the edge between two vertices, if there is one. */
static void mark_side(const chainer *c, uint32_t a, uint32_t b, bool *marks)
{
    const uint32_t side[2] = {a < b ? a : b, a < b ? b : a};
    const uint32_t(*found)[2] =
        bsearch(side, c->edges, c->edge_count, sizeof *c->edges, compare_edges);
    if (found)
        marks[found - (const uint32_t(*)[2])c->edges] = true;
}

/* Leaves out the sides of faces. */
static stp_status drop_sides(chainer *c, stp_edge_counts *counts, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_point_mesh *mesh = c->mesh;
    bool *marks = NULL;
    const size_t count = c->edge_count;
    STP_TRY(stp_alloc(&marks, count, sizeof *marks, "edges", err));
    for (size_t t = 0; count > 0 && t < mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            mark_side(c, mesh->triangles[t][k], mesh->triangles[t][(k + 1) % 3], marks);
    c->edge_count = 0;
    for (size_t i = 0; i < count; i++) {
        if (marks[i])
            counts->of_faces++;
        else
            memmove(c->edges[c->edge_count++], c->edges[i], sizeof *c->edges);
    }
done:
    free(marks);
    return status;
}

/* Keeps the edges that can be lines, each once. */
static stp_status take_edges(chainer *c, stp_edge_counts *counts, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_point_mesh *mesh = c->mesh;
    size_t count = 0;
    counts->read = mesh->edge_count;
    STP_TRY(stp_alloc(&c->edges, mesh->edge_count, sizeof *c->edges, "edges", err));
    for (size_t i = 0; i < mesh->edge_count; i++) {
        const uint32_t a = mesh->edges[i].vertices[0], b = mesh->edges[i].vertices[1];
        if (!exists(mesh, a) || !exists(mesh, b)) {
            counts->no_vertex++;
        } else if (a == b) {
            counts->no_length++;
        } else if (!stp_dvec3_finite(mesh->points[a].position) ||
                   !stp_dvec3_finite(mesh->points[b].position)) {
            counts->not_finite++;
        } else {
            c->edges[count][0] = a < b ? a : b;
            c->edges[count++][1] = a < b ? b : a;
        }
    }
    if (count > 0)
        qsort(c->edges, count, sizeof *c->edges, compare_edges);
    for (size_t i = 0; i < count; i++) {
        if (i > 0 && compare_edges(c->edges[i], c->edges[c->edge_count - 1]) == 0)
            counts->repeated++;
        else
            memmove(c->edges[c->edge_count++], c->edges[i], sizeof *c->edges);
    }
    STP_TRY(drop_sides(c, counts, err));
done:
    return status;
}

/* Lists each vertex's edges. */
static stp_status list_edges(chainer *c, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t points = c->mesh->point_count;
    STP_TRY(stp_alloc(&c->begin, points + 2, sizeof *c->begin, "edges", err));
    STP_TRY(stp_alloc(&c->at, 2 * c->edge_count, sizeof *c->at, "edges", err));
    STP_TRY(stp_alloc(&c->used, c->edge_count, sizeof *c->used, "edges", err));
    for (size_t e = 0; e < c->edge_count; e++)
        for (int k = 0; k < 2; k++)
            c->begin[c->edges[e][k] + 2]++;
    for (size_t v = 2; v < points + 2; v++)
        c->begin[v] += c->begin[v - 1];
    for (size_t e = 0; e < c->edge_count; e++)
        for (int k = 0; k < 2; k++)
            c->at[c->begin[c->edges[e][k] + 1]++] = e;
done:
    return status;
}

static size_t degree(const chainer *c, uint32_t vertex)
{
    return c->begin[vertex + 1] - c->begin[vertex];
}

/* The half-width at a vertex. If the box is too large for a float, the greatest float stands for
 * it. */
static float radius_at(const chainer *c, uint32_t vertex)
{
    const double own = c->mesh->radii ? (double)c->mesh->radii[vertex] : 0.0;
    return (float)fmin(isfinite(own) && own > 0.0 ? own : c->radius, (double)FLT_MAX);
}

static stp_status add_vertex(chainer *c, uint32_t vertex, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_point *p = &c->mesh->points[vertex];
    const bool coloured = c->mesh->attributes & STP_POINT_HAS_COLOUR;
    STP_TRY(stp_grow(&c->set.vertices, &c->vertex_capacity, c->set.vertex_count + 1,
                     sizeof *c->set.vertices, "lines", err));
    stp_line_vertex *out = &c->set.vertices[c->set.vertex_count++];
    *out = (stp_line_vertex){.position = p->position,
                             .radius = radius_at(c, vertex),
                             .intensity = p->intensity,
                             .class_id = p->class_id};
    if (c->mesh->attributes & STP_POINT_HAS_NORMAL)
        out->direction = p->normal;
    for (int k = 0; k < 3; k++)
        out->rgb[k] = coloured ? p->rgb[k] : STP_POINT_GREY;
done:
    return status;
}

/* Makes the strip a ribbon if all its vertices have normals, else a tube. Tangents of tubes are
 * found later. */
static void decide_kind(stp_line_set *set, stp_line_strip *strip)
{
    stp_line_vertex *v = set->vertices + strip->begin;
    bool normals = true;
    for (uint64_t i = 0; i < strip->count; i++)
        normals &= glms_vec3_norm2(v[i].direction) > 0.0f;
    strip->kind = normals ? STP_LINE_RIBBON : STP_LINE_TUBE;
    for (uint64_t i = 0; i < strip->count && !normals; i++)
        v[i].direction = (vec3s){{0.0f, 0.0f, 0.0f}};
}

/* Walks from a vertex along an edge, and on as long as exactly one unused edge continues. */
static stp_status walk(chainer *c, uint32_t vertex, size_t edge, stp_error *err)
{
    stp_status status = STP_OK;
    stp_line_strip strip = {.begin = c->set.vertex_count};
    const uint32_t start = vertex;
    STP_TRY(add_vertex(c, vertex, err));
    for (;;) {
        c->used[edge] = true;
        vertex = c->edges[edge][c->edges[edge][0] == vertex];
        STP_TRY(add_vertex(c, vertex, err));
        if (degree(c, vertex) != 2 || vertex == start)
            break;
        const size_t *at = c->at + c->begin[vertex];
        edge = at[at[0] == edge];
    }
    strip.count = c->set.vertex_count - strip.begin;
    decide_kind(&c->set, &strip);
    STP_TRY(stp_grow(&c->set.strips, &c->strip_capacity, c->set.strip_count + 1,
                     sizeof *c->set.strips, "lines", err));
    c->set.strips[c->set.strip_count++] = strip;
done:
    return status;
}

/* Walks from the ends first; the remaining edges are rings. */
static stp_status walk_all(chainer *c, bool rings, stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t v = 0; v < c->mesh->point_count; v++) {
        if ((degree(c, (uint32_t)v) == 2) != rings)
            continue;
        for (size_t i = c->begin[v]; i < c->begin[v + 1]; i++)
            if (!c->used[c->at[i]])
                STP_TRY(walk(c, (uint32_t)v, c->at[i], err));
    }
done:
    return status;
}

/* Gives points on edges the mean of their edges' colours, other points grey. */
static stp_status take_colours(stp_point_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    double(*sums)[4] = NULL;
    STP_TRY(stp_alloc(&sums, mesh->point_count, sizeof *sums, "colours", err));
    for (size_t e = 0; e < mesh->edge_count; e++) {
        const stp_mesh_edge *edge = &mesh->edges[e];
        for (int k = 0; k < 2; k++) {
            if (!exists(mesh, edge->vertices[k]))
                continue;
            double *sum = sums[edge->vertices[k]];
            for (int i = 0; i < 3; i++)
                sum[i] += edge->rgb[i];
            sum[3] += 1.0;
        }
    }
    for (size_t v = 0; v < mesh->point_count; v++)
        for (int i = 0; i < 3; i++)
            mesh->points[v].rgb[i] =
                (uint16_t)(sums[v][3] > 0.0 ? sums[v][i] / sums[v][3] + 0.5 : STP_POINT_GREY);
    mesh->attributes |= STP_POINT_HAS_COLOUR;
done:
    free(sums);
    return status;
}

/* Marks points that a line uses and no face. Sets the half-width, from their box, of lines that
 * have none. */
static stp_status mark_taken(chainer *c, uint8_t **taken, stp_error *err)
{
    stp_status status = STP_OK;
    stp_dbox box = stp_dbox_empty();
    STP_TRY(stp_alloc(taken, c->mesh->point_count, 1, "points", err));
    for (size_t e = 0; e < c->edge_count; e++)
        for (int k = 0; k < 2; k++) {
            (*taken)[c->edges[e][k]] = 1;
            stp_dbox_add(&box, c->mesh->points[c->edges[e][k]].position);
        }
    for (size_t t = 0; t < c->mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            (*taken)[c->mesh->triangles[t][k]] = 0;
    if (!(c->radius > 0.0) && c->edge_count > 0)
        c->radius = STP_LINE_RADIUS_PART * stp_dvec3_length(stp_dvec3_sub(box.max, box.min));
done:
    return status;
}

stp_status stp_line_chain(stp_line_set *out, uint8_t **taken, stp_point_mesh *mesh, double radius,
                          stp_edge_counts *counts, stp_error *err)
{
    stp_status status = STP_OK;
    chainer c = {.mesh = mesh, .radius = radius};
    uint8_t *marks = NULL;
    *counts = (stp_edge_counts){0};
    if (mesh->edge_colours && !(mesh->attributes & STP_POINT_HAS_COLOUR))
        STP_TRY(take_colours(mesh, err));
    STP_TRY(take_edges(&c, counts, err));
    STP_TRY(mark_taken(&c, &marks, err));
    STP_TRY(list_edges(&c, err));
    STP_TRY(walk_all(&c, false, err));
    STP_TRY(walk_all(&c, true, err));
    *out = c.set;
    *taken = marks;
    c.set = (stp_line_set){0};
    marks = NULL;
done:
    stp_line_set_clear(&c.set);
    free(marks);
    free(c.edges);
    free(c.begin);
    free(c.at);
    free(c.used);
    return status;
}
