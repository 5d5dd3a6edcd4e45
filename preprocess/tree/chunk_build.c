/* Builds a chunk from items. */
#include "preprocess/tree/chunk_build.h"

#include "base/memory.h"
#include "formats/chunk/measure/overhang.h"
#include "formats/chunk/sample/normal_grid.h"
#include "formats/chunk/sample/patch.h"
#include "preprocess/patch/middle.h"
#include "preprocess/tree/vertex_item.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

typedef struct assembly {
    stp_dvec3 origin;
    stp_patch *patches;
    stp_item *vertices;
    uint32_t patch_count;
    size_t patch_capacity, vertex_capacity;
    stp_sample *samples[STP_LEVEL_COUNT];
    size_t sample_capacity[STP_LEVEL_COUNT];
    uint32_t sample_count[STP_LEVEL_COUNT];
    stp_carry *carry; /* by level-0 sample; none for a leaf */
    size_t carry_capacity;
    uint64_t *sources; /* by level-0 sample; none if patches are made, not built */
    size_t source_capacity;
    uint32_t *order;    /* of the patches: a run of them becomes one patch of the parent */
    uint32_t *together; /* ends of these runs; NULL: not known yet */
    uint32_t together_count;
    size_t together_capacity;
    int vertex_least;
    unsigned normal_bits;
    const stp_resolution *resolution; /* for points; else NULL */
    stp_displacement displacement;
    bool leaf, linked, even, regular;
    const stp_holes *holes; /* borrowed; NULL: none */
} assembly;

stp_chunk_extent stp_chunk_extent_none(int vertex_least)
{
    return (stp_chunk_extent){.box = stp_dbox_empty(), .finest = INT_MAX, .coarsest = vertex_least};
}

void stp_chunk_extent_add(stp_chunk_extent *e, stp_dvec3 centre, double area, double bound,
                          int exponent)
{
    stp_dbox_add(&e->box, centre);
    e->area = stp_max(e->area, area);
    e->bound = stp_max(e->bound, bound);
    e->finest = exponent < e->finest ? exponent : e->finest;
    e->coarsest = exponent > e->coarsest ? exponent : e->coarsest;
}

/* The chunk's origin is a multiple of 2^(this exponent), which is no finer than any lattice of the
 * items and of the patch vertices. So the lattices of the chunk, its children and its parent
 * coincide. */
static int unit_exponent(const stp_chunk_extent *e)
{
    const double side = stp_dbox_side(&e->box), reach = sqrt(3.0) * side + 2.0 * e->bound;
    const int lattice = stp_vertex_exponent(STP_PATCH_SAMPLES * e->area, reach, e->coarsest);
    const int exponent = side > 0.0 && isfinite(side) ? (int)ceil(log2(side)) : lattice;
    return (exponent > lattice ? exponent : lattice) + 1;
}

bool stp_chunk_extent_fits(const stp_chunk_extent *e)
{
    const double far = 0.5 * (ldexp(1.0, unit_exponent(e)) + stp_dbox_side(&e->box));
    return far <= (STP_ORIGIN_STEPS - STP_POSITION_STEPS) * ldexp(1.0, e->finest);
}

/* Patches [0, patch_count) of a chunk that refer to the child. */
static bool is_kept(const stp_kept_patches *kept, uint32_t p)
{
    return kept->above.chunk->patches[p].child == kept->child;
}

/* Kept patches: their lattices, and those of their vertices. */
static void add_kept(stp_chunk_extent *e, const stp_kept_patches *kept)
{
    const stp_chunk *above = kept->above.chunk;
    for (uint32_t p = 0; p < above->patch_count; p++) {
        if (!is_kept(kept, p))
            continue;
        const stp_item vertex = stp_vertex_item(&kept->above, p, INT_MIN);
        stp_chunk_extent_add(e, vertex.disc.centre, vertex.area / STP_PATCH_SAMPLES,
                             vertex.disc.bound, above->patches[p].exponent);
        e->coarsest = vertex.exponent > e->coarsest ? vertex.exponent : e->coarsest;
    }
}

static stp_dvec3 choose_origin(const stp_item_group *groups, uint32_t group_count, int vertex_least)
{
    stp_chunk_extent extent =
        groups[0].make ? *groups[0].extent : stp_chunk_extent_none(vertex_least);
    for (uint32_t g = 0; g < group_count; g++)
        if (groups[g].kept)
            add_kept(&extent, groups[g].kept);
    for (uint32_t g = 0; g < group_count; g++)
        for (uint32_t i = 0; i < groups[g].count && !groups[g].make; i++) {
            const stp_item *item = &groups[g].items[i];
            stp_chunk_extent_add(&extent, item->disc.centre, item->area, item->disc.bound,
                                 item->exponent);
        }
    const double unit = ldexp(1.0, unit_exponent(&extent));
    const stp_dvec3 middle = stp_dbox_middle(&extent.box);
    return (stp_dvec3){nearbyint(middle.x / unit) * unit, nearbyint(middle.y / unit) * unit,
                       nearbyint(middle.z / unit) * unit};
}

static stp_status append(assembly *a, const stp_patch *patch, const stp_patch_samples *samples,
                         const stp_item *vertex, stp_error *err)
{
    stp_status status = STP_OK;
    size_t needed = (size_t)a->patch_count + 1;
    STP_TRY(stp_grow(&a->patches, &a->patch_capacity, needed, sizeof *a->patches, "patches", err));
    STP_TRY(
        stp_grow(&a->vertices, &a->vertex_capacity, needed, sizeof *a->vertices, "patches", err));
    for (int level = 0; level < STP_LEVEL_COUNT; level++) {
        size_t count = patch->counts[level];
        STP_TRY(stp_grow(&a->samples[level], &a->sample_capacity[level],
                         a->sample_count[level] + count, sizeof(stp_sample), "samples", err));
        memcpy(a->samples[level] + a->sample_count[level], samples->level[level],
               count * sizeof(stp_sample));
        a->sample_count[level] += (uint32_t)count;
    }
    a->patches[a->patch_count] = *patch;
    a->vertices[a->patch_count++] = *vertex;
done:
    return status;
}

/* Keeps the errors that the patch's level-0 samples, in their order, bring from their own chunks.
 */
static stp_status append_carry(assembly *a, const stp_item *items, const uint32_t *order,
                               uint32_t count, stp_error *err)
{
    size_t begin = a->sample_count[0] - count;
    stp_status status = stp_grow(&a->carry, &a->carry_capacity, a->sample_count[0],
                                 sizeof *a->carry, "errors", err);
    for (uint32_t i = 0; status == STP_OK && i < count; i++) {
        const stp_disc *disc = &items[order[i]].disc;
        a->carry[begin + i] = (stp_carry){disc->error, disc->tangential_error};
    }
    return status;
}

/* Keeps where the patch's level-0 samples come from. */
static stp_status append_sources(assembly *a, const stp_item *items, const uint32_t *order,
                                 uint32_t count, stp_error *err)
{
    const size_t begin = a->sample_count[0] - count;
    stp_status status = stp_grow(&a->sources, &a->source_capacity, a->sample_count[0],
                                 sizeof *a->sources, "samples", err);
    for (uint32_t i = 0; status == STP_OK && i < count; i++)
        a->sources[begin + i] = items[order[i]].source;
    return status;
}

static stp_status too_far(const stp_item *item, bool leaf, stp_error *err)
{
    const stp_dvec3 p = item->disc.centre;
    return stp_error_set(
        err, STP_LIMIT,
        "%s at (%g, %g, %g) is too far from the others to be stored with its precision: drop such "
        "points (--outliers drop) or give a coarser --precision",
        leaf ? "a point" : "a patch", p.x, p.y, p.z);
}

static void measure_displacement(assembly *a, const stp_item *items, const uint32_t *order,
                                 const stp_patch *patch, const stp_patch_samples *samples)
{
    for (unsigned i = 0; i < patch->counts[0]; i++) {
        const stp_dvec3 own = stp_sample_position(&samples->level[0][i], patch);
        stp_displacement_add(&a->displacement, &items[order[i]], stp_dvec3_add(a->origin, own),
                             a->resolution);
    }
}

/* Builds the run as one patch. If its items do not fit one lattice, halves it. */
static stp_status build_run(assembly *a, const stp_item *items, const uint32_t *order,
                            uint32_t count, uint8_t child, const stp_patch_grid *grid,
                            stp_error *err)
{
    stp_patch patch;
    stp_patch_samples samples;
    stp_item vertex;
    const stp_patch_ground ground = {.origin = a->origin,
                                     .copied = !a->leaf,
                                     .vertex_least = a->vertex_least,
                                     .normal_bits = a->normal_bits,
                                     .even = a->even,
                                     .regular = a->regular,
                                     .grid = grid,
                                     .holes = a->holes};
    if (stp_patch_build(items, order, count, &ground, &patch, &samples, &vertex)) {
        stp_patch_centre(&patch, &samples);
        patch.child = child;
        patch.first_below = a->linked ? (uint16_t)order[0] : 0;
        if (a->resolution)
            measure_displacement(a, items, order, &patch, &samples);
        stp_status appended = append(a, &patch, &samples, &vertex, err);
        if (appended == STP_OK)
            appended = append_sources(a, items, order, count, err);
        return appended == STP_OK && !a->leaf ? append_carry(a, items, order, count, err)
                                              : appended;
    }
    if (count == 1)
        return too_far(&items[order[0]], a->leaf, err);
    stp_status status = build_run(a, items, order, count / 2, child, grid, err);
    if (status == STP_OK)
        status = build_run(a, items, order + count / 2, count - count / 2, child, grid, err);
    return status;
}

static void fill_places(const stp_item_group *group, stp_dvec3 origin, stp_place *places)
{
    if (group->places) {
        group->places(group->context, origin, places);
        return;
    }
    for (uint32_t i = 0; i < group->count; i++) {
        const stp_item *item = &group->items[i];
        vec3s p = stp_dvec3_to_float(stp_dvec3_sub(item->disc.centre, origin));
        vec3s n = stp_dvec3_to_float(item->disc.normal);
        places[i] = (stp_place){.key = {p.x, p.y, p.z, n.x, n.y, n.z},
                                .spacing = (float)sqrt(item->area),
                                .sheet = item->sheet};
    }
}

/* Orders items so that runs of at most `most` become patches. order and ends have room for all
 * items. */
static stp_status find_runs(const stp_item_group *group, stp_dvec3 origin, uint32_t most,
                            uint32_t *order, uint32_t *ends, uint32_t *run_count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_place *places = NULL;
    uint64_t *scratch = NULL;
    STP_TRY(stp_alloc(&places, group->count, sizeof *places, "samples", err));
    STP_TRY(stp_alloc(&scratch, group->count, sizeof *scratch, "samples", err));
    fill_places(group, origin, places);
    *run_count = stp_partition(places, group->count, most, order, scratch, ends);
done:
    free(scratch);
    free(places);
    return status;
}

/* Moves a patch from the chunk that had it to the new origin. False if it lies too far away. */
static bool move_patch(stp_patch *patch, stp_dvec3 from, stp_dvec3 to)
{
    const double in = ldexp(1.0, -patch->exponent);
    const double way[3] = {from.x - to.x, from.y - to.y, from.z - to.z};
    for (int axis = 0; axis < 3; axis++) {
        const double at = (double)patch->origin[axis] + way[axis] * in;
        if (!(fabs(at) <= STP_ORIGIN_STEPS) || at != nearbyint(at))
            return false;
        patch->origin[axis] = (int32_t)at;
    }
    return true;
}

/* Keeps the errors that the patch's level-0 samples bring from the child. */
static stp_status carry_kept(assembly *a, const stp_patch *patch, const stp_chunk *below,
                             stp_error *err)
{
    const int level = STP_LEVEL_COUNT - 1;
    const size_t begin = a->sample_count[0] - patch->counts[0];
    stp_status status = stp_grow(&a->carry, &a->carry_capacity, a->sample_count[0],
                                 sizeof *a->carry, "errors", err);
    for (uint32_t i = 0; status == STP_OK && i < patch->counts[0]; i++) {
        const stp_patch *from = &below->patches[patch->first_below + i];
        a->carry[begin + i] =
            (stp_carry){stp_error_decode(from->error[level], from->exponent),
                        stp_error_decode(from->tangential_error[level], from->exponent)};
    }
    return status;
}

static stp_status keep_patch(assembly *a, const stp_kept_patches *kept, uint32_t p, uint8_t child,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk *above = kept->above.chunk;
    stp_patch patch = above->patches[p];
    stp_patch_samples samples = {0};
    const stp_item vertex = stp_vertex_item(&kept->above, p, INT_MIN);
    if (!move_patch(&patch, kept->above.origin, a->origin))
        return too_far(&vertex, false, err);
    patch.child = child;
    for (int level = 0; level < STP_LEVEL_COUNT; level++)
        memcpy(samples.level[level], above->samples[level] + above->level_begin[level][p],
               patch.counts[level] * sizeof(stp_sample));
    STP_TRY(append(a, &patch, &samples, &vertex, err));
    STP_TRY(stp_grow(&a->sources, &a->source_capacity, a->sample_count[0], sizeof *a->sources,
                     "samples", err));
    for (uint32_t i = a->sample_count[0] - patch.counts[0]; i < a->sample_count[0]; i++)
        a->sources[i] = STP_SOURCE_NONE;
    STP_TRY(carry_kept(a, &patch, kept->below, err));
done:
    return status;
}

/* Ends a run of patches that become one patch of the parent at each of the group's ends. */
static stp_status end_together(assembly *a, const stp_item_group *group, uint32_t run,
                               uint32_t *next, stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t before = a->together_count ? a->together[a->together_count - 1] : 0;
    uint32_t more = a->patch_count - before;
    if (!group->together_ends || *next == group->together_count ||
        group->together_ends[*next] != run + 1)
        return STP_OK;
    (*next)++;
    while (more > 0) { /* squares that did not fit one lattice have become several patches */
        const uint32_t count = more < STP_PATCH_SAMPLES ? more : STP_PATCH_SAMPLES;
        STP_TRY(stp_grow(&a->together, &a->together_capacity, (size_t)a->together_count + 1,
                         sizeof *a->together, "patches", err));
        more -= count;
        a->together[a->together_count++] = a->patch_count - more;
    }
done:
    return status;
}

static stp_status keep_group(assembly *a, const stp_kept_patches *kept, uint8_t child,
                             stp_error *err)
{
    stp_status status = STP_OK;
    for (uint32_t p = 0; status == STP_OK && p < kept->above.chunk->patch_count; p++)
        if (is_kept(kept, p))
            status = keep_patch(a, kept, p, child, err);
    return status;
}

static stp_status build_group(assembly *a, const stp_item_group *group, uint8_t child,
                              stp_error *err)
{
    stp_status status = STP_OK;
    if (group->kept)
        return keep_group(a, group->kept, child, err);
    uint32_t *order = NULL, *own_ends = NULL;
    const uint32_t *ends = group->run_ends;
    uint32_t run_count = group->run_count, next = 0;
    stp_item made[STP_PATCH_SAMPLES];
    uint32_t in_order[STP_PATCH_SAMPLES]; /* made items are in the order of their run */
    for (uint32_t i = 0; i < STP_PATCH_SAMPLES; i++)
        in_order[i] = i;
    STP_TRY(stp_alloc(&order, group->count, sizeof *order, "samples", err));
    for (uint32_t i = 0; i < group->count; i++)
        order[i] = i;
    if (ends == NULL) {
        STP_TRY(stp_alloc(&own_ends, group->count, sizeof *own_ends, "patches", err));
        STP_TRY(find_runs(group, a->origin, STP_PATCH_SAMPLES, order, own_ends, &run_count, err));
        ends = own_ends;
    }
    for (uint32_t run = 0; run < run_count; run++) {
        const uint32_t begin = run ? ends[run - 1] : 0, count = ends[run] - begin;
        const stp_patch_grid *grid = group->run_grids ? &group->run_grids[run] : NULL;
        if (group->make)
            group->make(group->context, order + begin, count, made);
        STP_TRY(build_run(a, group->make ? made : group->items,
                          group->make ? in_order : order + begin, count, child, grid, err));
        STP_TRY(end_together(a, group, run, &next, err));
    }
done:
    free(own_ends);
    free(order);
    return status;
}

/* Orders the patches so that runs of them, which end at *run_ends, each become one patch of the
 * parent. Only their vertices decide. */
static stp_status order_patches(assembly *a, uint32_t **run_ends, uint32_t *run_count,
                                stp_error *err)
{
    stp_status status = STP_OK;
    stp_item_group vertices = {.items = a->vertices, .count = a->patch_count};
    uint32_t *ends = NULL;
    STP_TRY(stp_alloc(&a->order, a->patch_count, sizeof *a->order, "patches", err));
    if (a->together) {
        for (uint32_t p = 0; p < a->patch_count; p++)
            a->order[p] = p;
        *run_ends = a->together;
        *run_count = a->together_count;
        a->together = NULL;
        return STP_OK;
    }
    STP_TRY(stp_alloc(&ends, a->patch_count, sizeof *ends, "patches", err));
    STP_TRY(find_runs(&vertices, a->origin, STP_ABOVE_SAMPLES, a->order, ends, run_count, err));
    STP_TRY(stp_alloc(run_ends, *run_count, sizeof **run_ends, "patches", err)); /* kept: exact */
    memcpy(*run_ends, ends, *run_count * sizeof **run_ends);
done:
    free(ends);
    return status;
}

/* Copies each patch's part of an array, in the order of the patches. */
static void gather(void *out, const void *from, size_t item_bytes, const assembly *a,
                   const uint32_t *from_begin)
{
    size_t at = 0;
    for (uint32_t p = 0; p < a->patch_count; p++) {
        uint32_t begin = from_begin[a->order[p]];
        size_t bytes = (from_begin[a->order[p] + 1] - begin) * item_bytes;
        memcpy((char *)out + at, (const char *)from + begin * item_bytes, bytes);
        at += bytes;
    }
}

/* Finds where each patch's samples of a level begin, in the order in which the patches were built.
 */
static void find_begins(const assembly *a, int level, uint32_t *begin)
{
    begin[0] = 0;
    for (uint32_t p = 0; p < a->patch_count; p++)
        begin[p + 1] = begin[p] + a->patches[p].counts[level];
}

static stp_status pack(const assembly *a, stp_built_chunk *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = NULL;
    uint32_t *begin = NULL;
    STP_TRY(stp_chunk_create(&out->chunk, a->patch_count, a->sample_count, 0, err));
    chunk = out->chunk;
    chunk->linked = a->linked;
    STP_TRY(stp_alloc(&begin, (size_t)a->patch_count + 1, sizeof *begin, "patches", err));
    STP_TRY(stp_alloc(&out->vertices, a->patch_count, sizeof *out->vertices, "patches", err));
    for (uint32_t p = 0; p < a->patch_count; p++) {
        chunk->patches[p] = a->patches[a->order[p]];
        out->vertices[p] = a->vertices[a->order[p]];
    }
    stp_patches_place(chunk);
    for (int level = 0; level < STP_LEVEL_COUNT; level++) {
        find_begins(a, level, begin);
        gather(chunk->samples[level], a->samples[level], sizeof(stp_sample), a, begin);
    }
    find_begins(a, 0, begin);
    if (a->sources) {
        STP_TRY(stp_alloc(&out->sources, a->sample_count[0], sizeof *out->sources, "samples", err));
        gather(out->sources, a->sources, sizeof *a->sources, a, begin);
    }
    if (!a->leaf) {
        STP_TRY(stp_alloc(&out->carry, a->sample_count[0], sizeof *out->carry, "errors", err));
        gather(out->carry, a->carry, sizeof *a->carry, a, begin);
    }
done:
    free(begin);
    return status;
}

static void clear_assembly(assembly *a)
{
    free(a->order);
    free(a->together);
    free(a->carry);
    free(a->sources);
    free(a->patches);
    free(a->vertices);
    for (int level = 0; level < STP_LEVEL_COUNT; level++)
        free(a->samples[level]);
}

/* Orders the patches and packs them into a chunk. */
static stp_status finish(assembly *a, stp_built_chunk *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_built_chunk built = {
        .origin = a->origin, .displacement = a->displacement, .limited = a->holes != NULL};
    STP_TRY(order_patches(a, &built.run_ends, &built.run_count, err));
    STP_TRY(pack(a, &built, err));
    built.vertex_count = a->patch_count;
    *out = built;
    built = (stp_built_chunk){0};
done:
    stp_built_chunk_clear(&built);
    return status;
}

static stp_status build_groups(stp_built_chunk *out, assembly *a, const stp_item_group *groups,
                               uint32_t group_count, stp_error *err)
{
    stp_status status = STP_OK;
    a->origin = choose_origin(groups, group_count, a->vertex_least);
    for (uint32_t g = 0; g < group_count; g++)
        STP_TRY(build_group(a, &groups[g], a->leaf ? STP_PATCH_NO_CHILD : (uint8_t)g, err));
    STP_TRY(finish(a, out, err));
done:
    clear_assembly(a);
    return status;
}

stp_status stp_chunk_build_leaf(stp_built_chunk *out, const stp_item_group *points,
                                const stp_point_item_params *params, stp_error *err)
{
    assembly a = {.leaf = true,
                  .vertex_least = params->vertex_least,
                  .normal_bits = params->normal_bits,
                  .resolution = &params->resolution,
                  .even = points->together_ends != NULL,
                  .regular = points->regular,
                  .holes = points->holes};
    return build_groups(out, &a, points, 1, err);
}

stp_status stp_chunk_build_inner(stp_built_chunk *out, const stp_item_group *groups,
                                 uint32_t group_count, stp_error *err)
{
    assembly a = {.linked = groups[0].run_ends != NULL || groups[0].kept != NULL,
                  .vertex_least = INT_MIN,
                  .normal_bits = STP_NORMAL_BITS,
                  .regular = groups[0].regular,
                  .holes = groups[0].holes};
    return build_groups(out, &a, groups, group_count, err);
}

stp_status stp_chunk_build_made(stp_built_chunk *out, stp_dvec3 origin, uint32_t patch_count,
                                stp_patch_maker *make, const void *context, stp_error *err)
{
    stp_status status = STP_OK;
    assembly a = {.origin = origin, .leaf = true};
    for (uint32_t i = 0; i < patch_count; i++) {
        stp_patch patch;
        stp_patch_samples samples;
        stp_item vertex;
        STP_TRY(make(context, i, origin, &patch, &samples, &vertex, err));
        stp_patch_centre(&patch, &samples);
        STP_TRY(append(&a, &patch, &samples, &vertex, err));
    }
    STP_TRY(finish(&a, out, err));
done:
    clear_assembly(&a);
    return status;
}
