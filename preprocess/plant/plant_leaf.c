/* Turns leaves of a plant's mesh into ribbons. */
#include "preprocess/plant/plant_leaf.h"

#include <math.h>
#include <string.h>

/* Greatest misfit of a reading: how far a pair's ends may lie from the ribbon's edge, over the
 * square root of the leaf's area; and the greatest relative difference of the areas. For scale: a
 * square's pair, tilted by half a right angle, has 0.38. */
static const double misfit_limit = 0.2;
/* In units of misfit: the cost of one more vertex, and the worth of a line e times as long. So a
 * leaf twice as long as wide is read along its length. A square is read as two vertices, not as
 * three across its corners. */
static const double vertex_cost = 0.01, length_worth = 0.02;
/* Least cosine at which a normal still says how the leaf lies. */
static const double normal_cosine = 0.5;

/* A row: a pair of the border's vertices, or a point, where both are the same. */
typedef struct row {
    uint32_t vertices[2];
    stp_dvec3 centre, half; /* half: from the centre to vertices[1] */
    double radius;
} row;

typedef struct reading {
    row rows[STP_PLANT_RIBBON_VERTICES];
    uint32_t count;
    double cost;
} reading;

typedef struct leaf {
    const stp_plant_piece *piece;
    uint32_t border[STP_PLANT_LEAF_VERTICES];
    uint32_t count;
    double area;
    stp_dvec3 normal; /* mean of the faces', turned to one side, by area; unit */
} leaf;

/* Finds the two neighbours of each vertex along open edges. False if a vertex does not have two. */
static bool find_neighbours(const stp_plant_piece *piece,
                            uint32_t neighbours[STP_PLANT_LEAF_VERTICES][2])
{
    uint32_t counts[STP_PLANT_LEAF_VERTICES] = {0};
    for (uint32_t i = 0; i < piece->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            if (!stp_plant_edge_is_open(piece, i, k))
                continue;
            const uint32_t ends[2] = {piece->corners[i][k], piece->corners[i][(k + 1) % 3]};
            for (int e = 0; e < 2; e++) {
                if (counts[ends[e]] == 2)
                    return false;
                neighbours[ends[e]][counts[ends[e]]++] = ends[1 - e];
            }
        }
    for (uint32_t v = 0; v < piece->vertex_count; v++)
        if (counts[v] != 2)
            return false;
    return true;
}

/* Lists the border from its first vertex. False if it is not one cycle through all vertices. */
static bool find_border(const stp_plant_piece *piece, leaf *out)
{
    uint32_t neighbours[STP_PLANT_LEAF_VERTICES][2];
    if (piece->vertex_count > STP_PLANT_LEAF_VERTICES ||
        piece->vertex_count != piece->triangle_count + 2 || piece->triangle_count < 2 ||
        !find_neighbours(piece, neighbours))
        return false;
    *out = (leaf){.piece = piece, .count = piece->vertex_count};
    uint32_t from = neighbours[0][1], at = 0;
    for (uint32_t i = 0; i < out->count; i++) {
        if (i > 0 && at == 0)
            return false;
        out->border[i] = at;
        const uint32_t next = neighbours[at][neighbours[at][0] == from];
        from = at;
        at = next;
    }
    return at == 0;
}

static bool is_small(const stp_plant_piece *piece, double size_limit)
{
    stp_dbox box = stp_dbox_empty();
    for (uint32_t v = 0; v < piece->vertex_count; v++)
        stp_dbox_add(&box, piece->vertices[v].position);
    return stp_dvec3_length(stp_dvec3_sub(box.max, box.min)) <= size_limit;
}

static void measure(leaf *l)
{
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t i = 0; i < l->piece->triangle_count; i++) {
        const stp_dvec3 area = stp_plant_triangle_area(l->piece, i);
        l->area += stp_dvec3_length(area);
        sum =
            stp_dvec3_add(sum, stp_dvec3_scale(area, stp_dvec3_dot(area, sum) < 0.0 ? -1.0 : 1.0));
    }
    l->normal = stp_dvec3_normalize(sum);
}

static row make_row(const leaf *l, uint32_t a, uint32_t b)
{
    row r = {.vertices = {l->border[a % l->count], l->border[b % l->count]}};
    const stp_dvec3 p = l->piece->vertices[r.vertices[0]].position;
    const stp_dvec3 q = l->piece->vertices[r.vertices[1]].position;
    r.centre = stp_dvec3_scale(stp_dvec3_add(p, q), 0.5);
    r.half = stp_dvec3_scale(stp_dvec3_sub(q, p), 0.5);
    r.radius = stp_dvec3_length(r.half);
    return r;
}

/* The line's direction at a row: the mean of the directions of the segments on its sides. */
static stp_dvec3 direction(const reading *r, uint32_t i)
{
    stp_dvec3 sum = {0.0, 0.0, 0.0};
    for (uint32_t k = i > 0 ? i - 1 : 0; k <= i && k + 1 < r->count; k++)
        sum = stp_dvec3_add(
            sum, stp_dvec3_normalize(stp_dvec3_sub(r->rows[k + 1].centre, r->rows[k].centre)));
    return stp_dvec3_normalize(sum);
}

/* How far a pair's ends lie from the ribbon's edge. The edge is at right angles to the line. */
static double row_misfit(const reading *r, uint32_t i)
{
    const stp_dvec3 along = direction(r, i), half = r->rows[i].half;
    const double slant = stp_dvec3_dot(half, along);
    const stp_dvec3 across =
        stp_dvec3_normalize(stp_dvec3_sub(half, stp_dvec3_scale(along, slant)));
    return stp_dvec3_length(stp_dvec3_sub(half, stp_dvec3_scale(across, r->rows[i].radius)));
}

/* Reads the border from place `start`: row i pairs border[start - i] with border[start + gap + i].
 * gap 0: the reading begins with a point; 1: with a pair. */
static reading read_border(const leaf *l, uint32_t start, uint32_t gap)
{
    reading r = {0};
    double area = 0.0, length = 0.0, misfit = 0.0;
    for (uint32_t i = 0; 2 * i < l->count + 1 - gap; i++)
        r.rows[r.count++] = make_row(l, start + l->count - i, start + gap + i);
    for (uint32_t i = 0; i < r.count; i++)
        misfit = fmax(misfit, row_misfit(&r, i) / sqrt(l->area));
    for (uint32_t i = 0; i + 1 < r.count; i++) {
        const double step = stp_dvec3_length(stp_dvec3_sub(r.rows[i + 1].centre, r.rows[i].centre));
        length += step;
        area += step * (r.rows[i].radius + r.rows[i + 1].radius);
    }
    misfit = fmax(misfit, fabs(area / l->area - 1.0));
    r.cost = misfit <= misfit_limit ? misfit + vertex_cost * (double)r.count -
                                          length_worth * log(length / sqrt(l->area))
                                    : INFINITY;
    return r;
}

/* Tries all readings. A reading and its reverse are the same, so if both ends are alike, half the
 * starts are enough. */
static reading best_reading(const leaf *l)
{
    reading best = {.cost = INFINITY};
    const bool even = l->count % 2 == 0;
    for (uint32_t gap = 0; gap < (even ? 2u : 1u); gap++)
        for (uint32_t start = 0; start < (even ? l->count / 2 : l->count); start++) {
            const reading r = read_border(l, start, gap);
            if (r.cost < best.cost)
                best = r;
        }
    return best;
}

static vec3s row_normal(const leaf *l, const row *r)
{
    const stp_dvec3 sum = stp_dvec3_normalize(stp_dvec3_add(
        l->piece->vertices[r->vertices[0]].normal, l->piece->vertices[r->vertices[1]].normal));
    const double cosine = stp_dvec3_dot(sum, l->normal);
    if (!(fabs(cosine) >= normal_cosine))
        return stp_dvec3_to_float(l->normal);
    return stp_dvec3_to_float(stp_dvec3_scale(sum, cosine < 0.0 ? -1.0 : 1.0));
}

static bool is_point(const row *r)
{
    return r->vertices[0] == r->vertices[1];
}

uint32_t stp_plant_leaf_read(const stp_plant_piece *piece, double size_limit,
                             stp_line_vertex out[STP_PLANT_RIBBON_VERTICES])
{
    leaf l;
    if (!find_border(piece, &l) || !is_small(piece, size_limit))
        return 0;
    measure(&l);
    if (!(l.area > 0.0))
        return 0;
    const reading r = best_reading(&l);
    if (!isfinite(r.cost))
        return 0;
    for (uint32_t i = 0; i < r.count; i++) {
        out[i] = stp_plant_line_vertex(piece, r.rows[i].vertices, 2);
        out[i].position = r.rows[i].centre;
        out[i].radius = (float)r.rows[i].radius;
        if (is_point(&r.rows[i]))
            out[i].radius = (float)(STP_PLANT_TIP_SHARE * r.rows[i > 0 ? i - 1 : 1].radius);
        out[i].direction = row_normal(&l, &r.rows[i]);
    }
    return r.count;
}
