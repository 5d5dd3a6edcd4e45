/* Makes leaf chunks from triangles. */
#include "preprocess/tree/triangle_leaves.h"

#include "base/memory.h"
#include "preprocess/cloud/morton.h"
#include "preprocess/patch/world_lattice.h"

#include <stdlib.h>
#include <string.h>

/* Greatest diagonal of a patch, in sizes of its triangles. The curve that orders the triangles
 * jumps. */
#define PART_SIZES 8.0

typedef struct maker {
    stp_triangle_leaves out;
    const stp_triangle_set *set;
    uint32_t (*corners)[3];
    int16_t *exponents;
    size_t part_capacity;
    double precision, side;
} maker;

static const stp_line_vertex *corner(const maker *m, uint32_t t, int k)
{
    return &m->set->vertices[m->corners[t][k]];
}

static bool is_valid(const stp_triangle_set *set, uint64_t t)
{
    for (int k = 0; k < 3; k++)
        if (set->triangles[t][k] >= set->vertex_count ||
            !stp_dvec3_finite(set->vertices[set->triangles[t][k]].position))
            return false;
    return true;
}

/* ---- order ---- */

/* Sorts the valid triangles along the Morton curve of their box, by their middles. */
static stp_status sort_triangles(maker *m, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_triangle_set *set = m->set;
    stp_morton_place *placed = NULL;
    uint32_t count = 0;
    m->out.box = stp_dbox_empty();
    STP_TRY(stp_alloc(&placed, set->triangle_count, sizeof *placed, "triangles", err));
    for (uint64_t t = 0; t < set->triangle_count; t++) {
        if (!is_valid(set, t)) {
            m->out.counts.rejected++;
            continue;
        }
        placed[count++].index = (uint32_t)t;
        for (int k = 0; k < 3; k++) {
            const stp_line_vertex *v = &set->vertices[set->triangles[t][k]];
            stp_dbox_add(&m->out.box, v->position);
            if (v->intensity > m->out.intensity_max)
                m->out.intensity_max = v->intensity;
        }
    }
    const stp_morton_grid grid = stp_morton_grid_of(&m->out.box);
    for (uint32_t i = 0; i < count; i++) {
        stp_dvec3 sum = {0.0, 0.0, 0.0};
        for (int k = 0; k < 3; k++) {
            const uint32_t v = set->triangles[placed[i].index][k];
            sum = stp_dvec3_add(sum, stp_dvec3_scale(set->vertices[v].position, 1.0 / 3.0));
        }
        placed[i].code = stp_morton_code(&grid, sum);
    }
    stp_morton_order(placed, count);
    STP_TRY(stp_alloc(&m->corners, count, sizeof *m->corners, "triangles", err));
    for (uint32_t i = 0; i < count; i++)
        memcpy(m->corners[i], set->triangles[placed[i].index], sizeof *m->corners);
    m->out.counts.triangles = count;
done:
    free(placed);
    return status;
}

/* ---- parts ---- */

static stp_dbox part_box(const maker *m, const stp_triangle_part *part)
{
    stp_dbox box = stp_dbox_empty();
    for (uint32_t t = 0; t < part->count; t++)
        for (int k = 0; k < 3; k++)
            stp_dbox_add(&box, corner(m, part->first + t, k)->position);
    return box;
}

/* The finest of the lattices on which the corners of the part lie; `free` is that of the others. */
static int corners_lattice(const maker *m, const stp_triangle_part *part, int free)
{
    int finest = STP_LATTICE_ANY;
    if (!m->set->lattices)
        return free;
    for (uint32_t t = 0; t < part->count; t++)
        for (int k = 0; k < 3; k++) {
            const int told = m->set->lattices[m->corners[part->first + t][k]];
            const int own = told == STP_LATTICE_ANY ? free : told;
            finest = own < finest ? own : finest;
        }
    return finest;
}

/* Chooses the part's lattice. Corners are kept to 1/1024 of the triangles' mean size and to the
 * precision asked for, unless they have lattices of their own; if the part is large, the lattice is
 * coarser. Returns whether the part is small enough for the finer lattice and its triangles are
 * near each other. */
static bool choose_lattice(const maker *m, stp_triangle_part *part)
{
    const stp_dbox box = part_box(m, part);
    double length = 0.0, wide = 0.0;
    for (uint32_t t = 0; t < part->count; t++)
        for (int k = 0; k < 3; k++) {
            const stp_line_vertex *a = corner(m, part->first + t, k);
            const stp_line_vertex *b = corner(m, part->first + t, (k + 1) % 3);
            length += stp_dvec3_length(stp_dvec3_sub(a->position, b->position));
            wide = isfinite(a->radius) ? fmax(wide, (double)a->radius) : wide;
        }
    const double reach = stp_dvec3_length(stp_dvec3_sub(box.max, box.min)) + wide;
    const double size = length / (3.0 * part->count), fine = size * STP_SPACING_PARTS / 1024.0;
    const int free = stp_lattice_exponent(fine, 0.0, m->precision, box.max);
    const int small = stp_lattice_exponent(fine, 2.0 * reach, m->precision, box.max);
    const int wanted = corners_lattice(m, part, free);
    const int exponent = small > free ? small : wanted;
    const stp_lattices lattices = stp_lattices_choose(exponent, &box, reach, m->side);
    part->exponent = part->coarsest = lattices.exponent;
    part->vertex_exponent = lattices.vertex_exponent;
    return part->exponent <= wanted && reach - wide <= PART_SIZES * size;
}

/* Which corner of a triangle another one lacks, if they have an edge in common; else 3. */
static unsigned corner_beside(const uint32_t a[3], const uint32_t other[3])
{
    unsigned lacking = 3, count = 0;
    for (unsigned k = 0; k < 3; k++) {
        const bool has = a[k] == other[0] || a[k] == other[1] || a[k] == other[2];
        lacking = has ? lacking : k;
        count += has;
    }
    return count == 2 ? lacking : 3;
}

/* Puts first what comes before, then the corner that the triangle before lacks. */
static void turn(uint32_t corners[3], unsigned last)
{
    const uint32_t old[3] = {corners[0], corners[1], corners[2]};
    for (unsigned k = 0; k < 3; k++)
        corners[k] = old[(last + 1 + k) % 3];
}

/* Orders the triangles of a part so that each has an edge in common with the one before, or with
 * one as late before it as may be; its other corner comes last. Equal corners then take few bytes
 * (formats/SPEC.md, "Corners"). */
static void arrange(uint32_t (*corners)[3], uint32_t count)
{
    for (uint32_t i = 1; i < count; i++) {
        uint32_t found = i;
        unsigned last = 3;
        for (uint32_t before = i; before-- > 0 && last == 3;)
            for (uint32_t j = i; j < count && last == 3; j++) {
                last = corner_beside(corners[j], corners[before]);
                found = last < 3 ? j : found;
            }
        uint32_t next[3] = {corners[found][0], corners[found][1], corners[found][2]};
        if (last < 3)
            turn(next, last);
        memmove(corners + i + 1, corners + i, (found - i) * sizeof *corners);
        memcpy(corners[i], next, sizeof next);
    }
}

static stp_status make_parts(maker *m, stp_error *err)
{
    stp_status status = STP_OK;
    stp_triangle_leaves *out = &m->out;
    const uint32_t count = (uint32_t)out->counts.triangles;
    for (uint32_t first = 0; first < count;) {
        const uint32_t left = count - first;
        const uint32_t most = left < STP_PATCH_TRIANGLE_COUNT ? left : STP_PATCH_TRIANGLE_COUNT;
        stp_triangle_part part = {.first = first, .count = 1}, more = part;
        STP_TRY(stp_grow(&out->parts, &m->part_capacity, (size_t)out->part_count + 1,
                         sizeof *out->parts, "triangles", err));
        for (bool fits = choose_lattice(m, &part); fits && part.count < most;) {
            more.count = part.count + 1;
            fits = choose_lattice(m, &more);
            part = fits ? more : part;
        }
        out->parts[out->part_count++] = part;
        arrange(m->corners + first, part.count);
        first += part.count;
    }
done:
    return status;
}

/* Puts each vertex on the coarsest lattice of the parts that have it. These parts' lattices are at
 * most STP_CORNER_OCTAVES finer. */
static stp_status share_lattices(maker *m, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(&m->exponents, m->set->vertex_count, sizeof *m->exponents, "triangles", err));
    m->out.source = (stp_triangle_source){m->set, m->corners, m->exponents};
    for (uint64_t v = 0; v < m->set->vertex_count; v++)
        m->exponents[v] = INT16_MIN;
    for (bool changed = true; changed;) {
        changed = false;
        for (uint32_t p = 0; p < m->out.part_count; p++) {
            stp_triangle_part *part = &m->out.parts[p];
            for (unsigned i = 0; i < 3 * part->count; i++) {
                int16_t *at = &m->exponents[stp_corner_vertex(&m->out.source, part, i)];
                if (*at < part->exponent) { /* parts before this one may have the vertex, too */
                    *at = (int16_t)part->exponent;
                    changed = true;
                }
                if (*at - STP_CORNER_OCTAVES > part->exponent) {
                    part->exponent = *at - STP_CORNER_OCTAVES;
                    changed = true;
                }
                part->coarsest = *at > part->coarsest ? *at : part->coarsest;
            }
            if (part->vertex_exponent < part->exponent)
                part->vertex_exponent = part->exponent;
        }
    }
    for (uint32_t p = 0; p < m->out.part_count; p++)
        for (unsigned i = 0; i < 3 * m->out.parts[p].count; i++) {
            const int at = m->exponents[stp_corner_vertex(&m->out.source, &m->out.parts[p], i)];
            if (at > m->out.parts[p].coarsest)
                m->out.parts[p].coarsest = at;
        }
done:
    return status;
}

/* ---- leaves ---- */

static stp_leaf_extent extent_of(const void *context, uint32_t index)
{
    const maker *m = context;
    const stp_triangle_part *part = &m->out.parts[index];
    const int vertex = part->vertex_exponent;
    return (stp_leaf_extent){part_box(m, part), part->exponent,
                             part->coarsest > vertex ? part->coarsest : vertex};
}

stp_status stp_triangle_leaves_create(stp_triangle_leaves *out, const stp_triangle_set *set,
                                      double precision, double side, stp_error *err)
{
    stp_status status = STP_OK;
    maker m = {.set = set, .precision = precision, .side = side};
    if (set->triangle_count >= UINT32_MAX)
        return stp_error_set(err, STP_LIMIT,
                             "%llu triangles are more than a model may have: split it",
                             (unsigned long long)set->triangle_count);
    STP_TRY(sort_triangles(&m, err));
    STP_TRY(make_parts(&m, err));
    STP_TRY(share_lattices(&m, err));
    STP_TRY(stp_leaf_cut(&m.out.leaves, &m.out.leaf_count, m.out.part_count, extent_of, &m, err));
    *out = m.out;
    m = (maker){0};
done:
    m.out.source = (stp_triangle_source){NULL, m.corners, m.exponents};
    stp_triangle_leaves_clear(&m.out);
    return status;
}

/* ---- chunks ---- */

typedef struct leaf_context {
    const stp_triangle_leaves *leaves;
    uint32_t begin;
    uint16_t intensity_max;
} leaf_context;

static stp_status make_patch(const void *context, uint32_t index, stp_dvec3 origin,
                             stp_patch *patch, stp_patch_samples *samples, stp_item *vertex,
                             stp_error *err)
{
    const leaf_context *c = context;
    const stp_triangle_source *source = &c->leaves->source;
    const stp_triangle_part *part = &c->leaves->parts[c->begin + index];
    const stp_dvec3 p = source->set->vertices[stp_corner_vertex(source, part, 0)].position;
    if (stp_triangles_build(source, part, c->intensity_max, origin, patch, samples, vertex))
        return STP_OK;
    return stp_error_set(err, STP_LIMIT,
                         "triangles at (%g, %g, %g) are too large, or too far from the others, to "
                         "be stored: drop what is far away",
                         p.x, p.y, p.z);
}

stp_status stp_triangle_leaf_build(const stp_triangle_leaves *leaves, uint32_t leaf,
                                   uint16_t intensity_max, stp_built_chunk *out, stp_error *err)
{
    const stp_leaf_run *l = &leaves->leaves[leaf];
    const leaf_context context = {leaves, l->begin, intensity_max};
    return stp_chunk_build_made(out, l->origin, l->end - l->begin, make_patch, &context, err);
}

void stp_triangle_leaves_clear(stp_triangle_leaves *leaves)
{
    free(leaves->source.corners);
    free(leaves->source.exponents);
    free(leaves->parts);
    free(leaves->leaves);
    *leaves = (stp_triangle_leaves){0};
}
