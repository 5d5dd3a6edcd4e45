/* Makes leaf chunks from polylines. */
#include "preprocess/tree/line_leaves.h"

#include "base/memory.h"
#include "preprocess/cloud/morton.h"

#include <stdlib.h>
#include <string.h>

/* To get a finer lattice, a part is halved down to this many vertices; if a precision is asked for,
 * down to 2. */
#define PART_LEAST 9u
/* The lattices of parts that meet differ by at most this many octaves. */
#define MEETING_OCTAVES 12

typedef struct maker {
    stp_line_leaves out;
    size_t part_capacity;
    double precision, side;
} maker;

/* ---- parts ---- */

static void raise_to(stp_strip_part *part, int exponent)
{
    if (part->exponent < exponent)
        part->exponent = part->first_exponent = part->last_exponent = exponent;
    if (part->vertex_exponent < exponent)
        part->vertex_exponent = exponent;
}

/* Joins two parts: the vertex where they meet lies on the coarser of their lattices. */
static void join(stp_strip_part *a, stp_strip_part *b)
{
    int coarser = a->exponent > b->exponent ? a->exponent : b->exponent;
    a->continued = b->continues = true;
    a->last_exponent = b->first_exponent = coarser;
}

/* Gives the part as many vertices as a fine enough lattice allows. */
static void cut_part(const maker *m, stp_strip_part *part)
{
    const unsigned least = m->precision > 0.0 ? 2 : PART_LEAST;
    uint64_t left = part->line_count - part->first;
    part->count = left < STP_PATCH_SAMPLES ? (unsigned)left : STP_PATCH_SAMPLES;
    while (stp_strip_choose_lattice(part, m->precision, m->side) > 0 && part->count > least) {
        unsigned half = (part->count + 1) / 2;
        part->count = half > least ? half : least;
    }
}

/* Adds a polyline whose vertices are all finite. */
static stp_status add_line(maker *m, const stp_line_vertex *line, uint64_t count,
                           stp_line_kind kind, stp_error *err)
{
    stp_status status = STP_OK;
    stp_line_leaves *out = &m->out;
    const size_t begin = out->part_count;
    for (uint64_t first = 0;;) {
        stp_strip_part part = {.line = line, .line_count = count, .first = first, .kind = kind};
        cut_part(m, &part);
        if (out->part_count == UINT32_MAX - 1)
            return stp_error_set(err, STP_LIMIT,
                                 "the lines are cut into more than 2^32 parts: split the model");
        STP_TRY(stp_grow(&out->parts, &m->part_capacity, (size_t)out->part_count + 1,
                         sizeof *out->parts, "lines", err));
        out->parts[out->part_count++] = part;
        out->counts.samples += part.count;
        first += part.count - 1;
        if (first + 1 >= count)
            break;
    }
    stp_strip_part *parts = out->parts;
    for (size_t i = begin + 1; i < out->part_count; i++)
        raise_to(&parts[i], parts[i - 1].exponent - MEETING_OCTAVES);
    for (size_t i = out->part_count - 1; i > begin; i--)
        raise_to(&parts[i - 1], parts[i].exponent - MEETING_OCTAVES);
    for (size_t i = begin + 1; i < out->part_count; i++)
        join(&parts[i - 1], &parts[i]);
    out->counts.strips++;
    out->counts.vertices += count;
    out->counts.segments += count - 1;
done:
    return status;
}

static stp_status add_strip(maker *m, const stp_line_set *lines, const stp_line_strip *strip,
                            stp_error *err)
{
    const stp_line_vertex *v = lines->vertices + strip->begin;
    stp_status status = STP_OK;
    for (uint64_t begin = 0, i = 0; i <= strip->count && status == STP_OK; i++) {
        if (i < strip->count && stp_dvec3_finite(v[i].position)) {
            if (v[i].intensity > m->out.intensity_max)
                m->out.intensity_max = v[i].intensity;
            continue;
        }
        if (i > begin)
            status = add_line(m, v + begin, i - begin, strip->kind, err);
        m->out.counts.rejected += i < strip->count;
        begin = i + 1;
    }
    return status;
}

static stp_dbox find_box(const stp_line_set *lines)
{
    stp_dbox box = stp_dbox_empty();
    for (uint64_t s = 0; s < lines->strip_count; s++) {
        const stp_line_strip *strip = &lines->strips[s];
        for (uint64_t i = strip->begin; i < strip->begin + strip->count; i++)
            if (stp_dvec3_finite(lines->vertices[i].position))
                stp_dbox_add(&box, lines->vertices[i].position);
    }
    return box;
}

/* ---- leaves ---- */

static stp_dbox part_box(const stp_strip_part *part)
{
    stp_dbox box = stp_dbox_empty();
    for (unsigned i = 0; i < part->count; i++)
        stp_dbox_add(&box, part->line[part->first + i].position);
    return box;
}

/* Sorts the parts along the Morton curve of the lines' box. */
static stp_status sort_parts(stp_line_leaves *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_morton_place *order = NULL;
    stp_strip_part *sorted = NULL;
    const stp_morton_grid grid = stp_morton_grid_of(&out->box);
    STP_TRY(stp_alloc(&order, out->part_count, sizeof *order, "lines", err));
    STP_TRY(stp_alloc(&sorted, out->part_count, sizeof *sorted, "lines", err));
    for (uint32_t i = 0; i < out->part_count; i++) {
        const stp_dbox box = part_box(&out->parts[i]);
        order[i] = (stp_morton_place){stp_morton_code(&grid, stp_dbox_middle(&box)), i};
    }
    stp_morton_order(order, out->part_count);
    for (uint32_t i = 0; i < out->part_count; i++)
        sorted[i] = out->parts[order[i].index];
    free(out->parts);
    out->parts = sorted;
done:
    free(order);
    return status;
}

static stp_leaf_extent extent_of(const void *context, uint32_t index)
{
    const stp_strip_part *part = (const stp_strip_part *)context + index;
    stp_leaf_extent out = {part_box(part), part->exponent, part->vertex_exponent};
    out.coarsest = part->first_exponent > out.coarsest ? part->first_exponent : out.coarsest;
    out.coarsest = part->last_exponent > out.coarsest ? part->last_exponent : out.coarsest;
    return out;
}

stp_status stp_line_leaves_create(stp_line_leaves *out, const stp_line_set *lines, double precision,
                                  double side, stp_error *err)
{
    stp_status status = STP_OK;
    maker m = {.precision = precision, .side = side, .out = {.box = find_box(lines)}};
    for (uint64_t s = 0; s < lines->strip_count; s++)
        STP_TRY(add_strip(&m, lines, &lines->strips[s], err));
    STP_TRY(sort_parts(&m.out, err));
    STP_TRY(stp_leaf_cut(&m.out.leaves, &m.out.leaf_count, m.out.part_count, extent_of, m.out.parts,
                         err));
    *out = m.out;
    m.out = (stp_line_leaves){0};
done:
    stp_line_leaves_clear(&m.out);
    return status;
}

/* ---- chunks ---- */

typedef struct leaf_context {
    const stp_strip_part *parts; /* of the leaf */
    uint16_t intensity_max;
} leaf_context;

static stp_status make_patch(const void *context, uint32_t index, stp_dvec3 origin,
                             stp_patch *patch, stp_patch_samples *samples, stp_item *vertex,
                             stp_error *err)
{
    const leaf_context *c = context;
    const stp_strip_part *part = &c->parts[index];
    const stp_dvec3 p = part->line[part->first].position;
    if (stp_strip_build(part, c->intensity_max, origin, patch, samples, vertex))
        return STP_OK;
    return stp_error_set(err, STP_LIMIT,
                         "a line at (%g, %g, %g) is too long, or too far from the others, to be "
                         "stored: cut it, or drop what is far away",
                         p.x, p.y, p.z);
}

stp_status stp_line_leaf_build(const stp_line_leaves *leaves, uint32_t leaf, uint16_t intensity_max,
                               stp_built_chunk *out, stp_error *err)
{
    const stp_leaf_run *l = &leaves->leaves[leaf];
    const leaf_context context = {leaves->parts + l->begin, intensity_max};
    return stp_chunk_build_made(out, l->origin, l->end - l->begin, make_patch, &context, err);
}

void stp_line_leaves_clear(stp_line_leaves *leaves)
{
    free(leaves->parts);
    free(leaves->leaves);
    *leaves = (stp_line_leaves){0};
}
