/* Turns branches of a plant's mesh into tubes. */
#include "preprocess/plant/plant_tube.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double two_pi = 6.28318530717958647692;
/* Least roundness, 4 pi area / length^2: 1 for a circle, 0.6 for an equilateral triangle. */
static const double least_roundness = 0.4;
/* Greatest growth of an end's radius over that of the ring before, relative to the distance between
 * them. */
static const double greatest_flare = 0.25;
/* Least length of a tube, in its greatest radius. */
static const double least_length = 4.0;

stp_status stp_plant_tubes_create(stp_plant_tubes *out, uint32_t most_triangles, stp_error *err)
{
    stp_status status = STP_OK;
    stp_plant_tubes t = {0};
    const size_t vertices = 3 * (size_t)most_triangles;
    STP_TRY(stp_plant_rings_create(&t.rings, most_triangles, err));
    STP_TRY(stp_plant_seeds_create(&t.seeds, most_triangles, err));
    STP_TRY(stp_alloc(&t.is_seen, vertices, sizeof *t.is_seen, "borders", err));
    STP_TRY(stp_alloc(&t.borders, vertices, sizeof *t.borders, "borders", err));
    STP_TRY(stp_alloc(&t.border_counts, vertices, sizeof *t.border_counts, "borders", err));
    STP_TRY(stp_alloc(&t.vertices, vertices, sizeof *t.vertices, "tubes", err));
    STP_TRY(stp_alloc(&t.is_thin, vertices, sizeof *t.is_thin, "tubes", err));
    *out = t;
    t = (stp_plant_tubes){0};
done:
    stp_plant_tubes_clear(&t);
    return status;
}

void stp_plant_tubes_clear(stp_plant_tubes *tubes)
{
    stp_plant_rings_clear(&tubes->rings);
    stp_plant_seeds_clear(&tubes->seeds);
    free(tubes->is_seen);
    free(tubes->borders);
    free(tubes->border_counts);
    free(tubes->vertices);
    free(tubes->is_thin);
    *tubes = (stp_plant_tubes){0};
}

static uint32_t ring_size(const stp_plant_rings *r, uint32_t ring)
{
    return r->begins[ring + 1] - r->begins[ring];
}

static stp_dvec3 ring_position(const stp_plant_rings *r, uint32_t ring, uint32_t i)
{
    const uint32_t size = ring_size(r, ring);
    return r->piece->vertices[r->vertices[r->begins[ring] + i % size]].position;
}

static stp_dvec3 ring_centre(const stp_plant_rings *r, uint32_t ring)
{
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = 0; i < ring_size(r, ring); i++)
        sum = stp_dvec3_add(sum, ring_position(r, ring, i));
    return stp_dvec3_scale(sum, 1.0 / (double)ring_size(r, ring));
}

static stp_dvec3 segment(const stp_line_vertex *vertices, uint32_t i)
{
    return stp_dvec3_sub(vertices[i + 1].position, vertices[i].position);
}

static stp_dvec3 tangent(const stp_line_vertex *vertices, uint32_t count, uint32_t i)
{
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    if (i > 0)
        sum = stp_dvec3_normalize(segment(vertices, i - 1));
    if (i + 1 < count)
        sum = stp_dvec3_add(sum, stp_dvec3_normalize(segment(vertices, i)));
    return stp_dvec3_normalize(sum);
}

/* Cauchy: the mean width of a convex outline is its length over pi. */
static double ring_radius(const stp_plant_rings *r, uint32_t ring, stp_dvec3 along)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < ring_size(r, ring); i++) {
        const stp_dvec3 edge =
            stp_dvec3_sub(ring_position(r, ring, i + 1), ring_position(r, ring, i));
        const stp_dvec3 seen =
            stp_dvec3_sub(edge, stp_dvec3_scale(along, stp_dvec3_dot(edge, along)));
        sum += stp_dvec3_length(seen);
    }
    return sum / two_pi;
}

static bool is_round(const stp_plant_rings *r, uint32_t ring, stp_dvec3 along, double radius)
{
    stp_dvec3 area = {0.0, 0.0, 0.0};
    const stp_dvec3 origin = ring_position(r, ring, 0);
    for (uint32_t i = 1; i + 1 < ring_size(r, ring); i++)
        area = stp_dvec3_add(area,
                             stp_dvec3_cross(stp_dvec3_sub(ring_position(r, ring, i), origin),
                                             stp_dvec3_sub(ring_position(r, ring, i + 1), origin)));
    const double seen = 0.5 * fabs(stp_dvec3_dot(area, along));
    /* The length is 2 pi radius. */
    return ring_size(r, ring) == 1 || seen >= least_roundness * 0.5 * two_pi * radius * radius;
}

/* Turns the rings into vertices of a line. A tip is at an end; its radius follows its neighbour's.
 */
static void measure(stp_plant_tubes *t, double greatest_radius)
{
    const stp_plant_rings *r = &t->rings;
    const uint32_t count = r->ring_count;
    stp_line_vertex *v = t->vertices;
    for (uint32_t i = 0; i < count; i++) {
        v[i] = stp_plant_line_vertex(r->piece, r->vertices + r->begins[i], ring_size(r, i));
        v[i].position = ring_centre(r, i);
    }
    for (uint32_t i = 0; i < count; i++) {
        const stp_dvec3 along = tangent(v, count, i);
        const double radius = ring_radius(r, i, along);
        v[i].direction = stp_dvec3_to_float(along);
        v[i].radius = (float)radius;
        t->is_thin[i] = radius <= greatest_radius && is_round(r, i, along, radius);
    }
    if (ring_size(r, 0) == 1)
        v[0].radius = (float)STP_PLANT_TIP_SHARE * v[1].radius;
    if (ring_size(r, count - 1) == 1)
        v[count - 1].radius = (float)STP_PLANT_TIP_SHARE * v[count - 2].radius;
}

static bool is_long(const stp_line_vertex *vertices, uint32_t count)
{
    double length = 0.0, radius = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        radius = fmax(radius, (double)vertices[i].radius);
        if (i + 1 < count)
            length += stp_dvec3_length(segment(vertices, i));
    }
    return length > 0.0 && length >= least_length * radius;
}

/* Adds rings begin .. end - 1 as a tube, if they make one. */
static stp_status add_run(const stp_plant_tubes *t, uint32_t begin, uint32_t end,
                          stp_plant_lines *lines, uint8_t *fates, stp_error *err)
{
    const stp_plant_rings *r = &t->rings;
    if (end - begin < 2 || !is_long(t->vertices + begin, end - begin))
        return STP_OK;
    for (uint32_t i = r->sections[begin]; i < r->sections[end - 1]; i++)
        fates[r->piece->triangles[r->triangles[i]]] = STP_LINE_TUBE;
    return stp_plant_lines_add(lines, STP_LINE_TUBE, t->vertices + begin, end - begin, err);
}

static bool flares(const stp_line_vertex *end, const stp_line_vertex *inner)
{
    const double step = stp_dvec3_length(stp_dvec3_sub(end->position, inner->position));
    return (double)(end->radius - inner->radius) > greatest_flare * step;
}

/* Adds the thin runs of the last chain. */
static stp_status add_chain(stp_plant_tubes *t, double greatest_radius, stp_plant_lines *lines,
                            uint8_t *fates, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t begin = 0, count = t->rings.ring_count;
    if (count < 2)
        return STP_OK;
    measure(t, greatest_radius);
    begin += flares(&t->vertices[0], &t->vertices[1]);
    count -= flares(&t->vertices[count - 1], &t->vertices[count - 2]);
    for (uint32_t i = begin; i < count;) {
        uint32_t end = i;
        while (end < count && t->is_thin[end])
            end++;
        STP_TRY(add_run(t, i, end, lines, fates, err));
        i = end + 1;
    }
done:
    return status;
}

static void note_border(stp_plant_tubes *t, uint32_t from, uint32_t to)
{
    if (t->border_counts[from] < 2)
        t->borders[from][t->border_counts[from]] = to;
    if (t->border_counts[from] < UINT8_MAX)
        t->border_counts[from]++;
}

static void find_borders(stp_plant_tubes *t, const stp_plant_piece *piece)
{
    memset(t->border_counts, 0, piece->vertex_count);
    memset(t->is_seen, 0, piece->vertex_count);
    for (uint32_t i = 0; i < piece->triangle_count; i++)
        for (int k = 0; k < 3; k++)
            if (stp_plant_edge_is_open(piece, i, k)) {
                note_border(t, piece->corners[i][k], piece->corners[i][(k + 1) % 3]);
                note_border(t, piece->corners[i][(k + 1) % 3], piece->corners[i][k]);
            }
}

/* Walks the closed border through a vertex. Returns its number of vertices; 0: not closed, or too
 * long. */
static uint32_t walk_border(stp_plant_tubes *t, uint32_t begin, uint32_t ring[STP_PLANT_RING_LIMIT])
{
    uint32_t count = 0, from = t->borders[begin][1], at = begin;
    bool fits = true;
    do {
        t->is_seen[at] = 1;
        if (t->border_counts[at] != 2)
            return 0;
        if (count < STP_PLANT_RING_LIMIT)
            ring[count++] = at;
        else
            fits = false;
        const uint32_t next = t->borders[at][t->borders[at][0] == from];
        from = at;
        at = next;
    } while (at != begin && !t->is_seen[at]);
    return fits && at == begin && count > 2 ? count : 0;
}

/* Finds tubes that end in a border. */
static stp_status find_open(stp_plant_tubes *t, const stp_plant_piece *piece,
                            double greatest_radius, stp_plant_lines *lines, uint8_t *fates,
                            stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t ring[STP_PLANT_RING_LIMIT];
    find_borders(t, piece);
    for (uint32_t v = 0; v < piece->vertex_count; v++) {
        if (t->border_counts[v] == 0 || t->is_seen[v])
            continue;
        const uint32_t count = walk_border(t, v, ring);
        if (count == 0)
            continue;
        stp_plant_rings_follow(&t->rings, ring, count);
        STP_TRY(add_chain(t, greatest_radius, lines, fates, err));
    }
done:
    return status;
}

stp_status stp_plant_tubes_find(stp_plant_tubes *t, const stp_plant_piece *piece,
                                double greatest_radius, stp_plant_lines *lines, uint8_t *fates,
                                stp_error *err)
{
    stp_status status = STP_OK;
    stp_plant_rings_begin(&t->rings, piece);
    stp_plant_seeds_begin(&t->seeds, piece);
    STP_TRY(find_open(t, piece, greatest_radius, lines, fates, err));
    for (uint32_t v = 0; v < piece->vertex_count; v++)
        if (stp_plant_seeds_follow(&t->seeds, &t->rings, v))
            STP_TRY(add_chain(t, greatest_radius, lines, fates, err));
done:
    return status;
}
