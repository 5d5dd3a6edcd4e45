/* Finds nearest points leaf by leaf. Each point is searched first in the leaf whose box is nearest,
 * then in leaves that could hold a nearer point. So each leaf is read at most twice. */
#include "tools/tune/tune_nearest.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define PROBES_A_TASK 256

/* ---- one leaf's discs ---- */

typedef struct disc {
    stp_dvec3 centre, normal;
    double radius;
} disc;

/* The discs of a patch, and a ball around them. */
typedef struct group {
    uint32_t begin, end;
    stp_dvec3 centre;
    double radius;
} group;

typedef struct leaf {
    disc *discs;
    group *groups;
    size_t disc_capacity, group_capacity, group_count;
} leaf;

static double distance(stp_dvec3 a, stp_dvec3 b)
{
    return stp_dvec3_length(stp_dvec3_sub(a, b));
}

static stp_dvec3 nearest_on(const disc *d, stp_dvec3 x)
{
    stp_dvec3 v = stp_dvec3_sub(x, d->centre);
    v = stp_dvec3_sub(v, stp_dvec3_scale(d->normal, stp_dvec3_dot(v, d->normal)));
    double length = stp_dvec3_length(v);
    if (length > d->radius)
        v = stp_dvec3_scale(v, d->radius / length);
    return stp_dvec3_add(d->centre, v);
}

static disc disc_of(const stp_chunk_entry *entry, const stp_patch *patch, const stp_sample *sample)
{
    disc d = {.centre = stp_dvec3_add(entry->origin, stp_sample_position(sample, patch)),
              .radius = stp_sample_radius(sample, patch)};
    if (sample->flags & STP_SAMPLE_HAS_NORMAL)
        d.normal = stp_dvec3_normalize(stp_dvec3_from_float(stp_normal_decode(sample->normal)));
    return d;
}

static void bound_group(group *g, const disc *discs)
{
    stp_dbox box = stp_dbox_empty();
    for (uint32_t i = g->begin; i < g->end; i++)
        stp_dbox_add(&box, discs[i].centre);
    g->centre = stp_dbox_middle(&box);
    for (uint32_t i = g->begin; i < g->end; i++)
        g->radius = fmax(g->radius, distance(g->centre, discs[i].centre) + discs[i].radius);
}

static stp_status read_leaf(const tune_nearest_params *p, uint32_t id, leaf *l, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *entry = &p->entries[id];
    stp_chunk *chunk = NULL;
    uint32_t used = 0;
    STP_TRY(stp_chunk_file_read(p->file, id, 0, &chunk, err));
    STP_TRY(stp_grow(&l->discs, &l->disc_capacity, entry->sample_count[0], sizeof *l->discs,
                     "the discs of a chunk", err));
    STP_TRY(stp_grow(&l->groups, &l->group_capacity, chunk->patch_count, sizeof *l->groups,
                     "the discs of a chunk", err));
    l->group_count = 0;
    for (uint32_t k = 0; k < chunk->patch_count; k++) {
        const stp_patch *patch = &chunk->patches[k];
        group g = {.begin = used};
        if (patch->flags & STP_PATCH_SHAPES)
            continue;
        for (uint32_t i = chunk->level_begin[0][k]; i < chunk->level_begin[0][k + 1]; i++)
            l->discs[used++] = disc_of(entry, patch, &chunk->samples[0][i]);
        g.end = used;
        if (g.end == g.begin)
            continue;
        bound_group(&g, l->discs);
        l->groups[l->group_count++] = g;
    }
done:
    stp_chunk_destroy(&chunk);
    return status;
}

static void search_group(const leaf *l, const group *g, tune_probe *probe)
{
    for (uint32_t i = g->begin; i < g->end; i++) {
        const disc *d = &l->discs[i];
        if (distance(probe->at, d->centre) - d->radius >= probe->distance)
            continue;
        stp_dvec3 y = nearest_on(d, probe->at);
        double away = distance(probe->at, y);
        if (away < probe->distance) {
            probe->distance = away;
            probe->nearest = y;
        }
    }
}

static void search_leaf(const leaf *l, tune_probe *probe)
{
    size_t first = 0;
    double least = INFINITY;
    for (size_t k = 0; k < l->group_count; k++) {
        double away = distance(probe->at, l->groups[k].centre);
        if (away < least) {
            least = away;
            first = k;
        }
    }
    if (l->group_count > 0) /* search the nearest group first, so that few others are near enough */
        search_group(l, &l->groups[first], probe);
    for (size_t k = 0; k < l->group_count; k++)
        if (distance(probe->at, l->groups[k].centre) - l->groups[k].radius < probe->distance)
            search_group(l, &l->groups[k], probe);
}

/* ---- which leaves ---- */

/* A point to search for in a leaf. */
typedef struct visit {
    uint32_t leaf, probe;
} visit;

typedef struct finder {
    const tune_nearest_params *params;
    tune_probe *probes;
    visit *visits;
    size_t visit_count, visit_capacity;
    leaf leaf;
    size_t begin, end; /* range of the visits to the present leaf */
} finder;

/* The distance from a chunk's box. The box holds the discs below the chunk, up to the rounding of
 * its floats. */
static double box_distance(const stp_chunk_entry *e, stp_dvec3 x)
{
    stp_dvec3 p = stp_dvec3_sub(x, e->origin);
    stp_dbox box = {stp_dvec3_from_float(e->box_min), stp_dvec3_from_float(e->box_max)};
    double away = sqrt(stp_dbox_distance_squared(&box, p));
    return fmax(0.0, away - 1e-5 * stp_dbox_side(&box));
}

/* Finds the nearest leaf below a chunk, if its box is nearer than *best. */
static void nearest_leaf(const stp_chunk_entry *entries, uint32_t id, stp_dvec3 x, double *best,
                         uint32_t *found)
{
    const stp_chunk_entry *e = &entries[id];
    double away = box_distance(e, x);
    if (away >= *best)
        return;
    if (e->child_count == 0) {
        *best = away;
        *found = id;
    }
    for (uint32_t k = 0; k < e->child_count; k++)
        nearest_leaf(entries, e->first_child + k, x, best, found);
}

static stp_status add_visit(finder *f, uint32_t id, size_t probe, stp_error *err)
{
    stp_status status = stp_grow(&f->visits, &f->visit_capacity, f->visit_count + 1,
                                 sizeof *f->visits, "a list of chunks", err);
    if (status == STP_OK)
        f->visits[f->visit_count++] = (visit){id, (uint32_t)probe};
    return status;
}

/* Adds the leaves that could hold a nearer point, except the first leaf. */
static stp_status add_others(finder *f, uint32_t id, size_t probe, uint32_t first, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_entry *e = &f->params->entries[id];
    if (box_distance(e, f->probes[probe].at) >= f->probes[probe].distance)
        return STP_OK;
    if (e->child_count == 0 && id != first)
        STP_TRY(add_visit(f, id, probe, err));
    for (uint32_t k = 0; k < e->child_count; k++)
        STP_TRY(add_others(f, e->first_child + k, probe, first, err));
done:
    return status;
}

static int compare_visits(const void *a, const void *b)
{
    const visit *x = a, *y = b;
    if (x->leaf != y->leaf)
        return x->leaf < y->leaf ? -1 : 1;
    return (x->probe > y->probe) - (x->probe < y->probe);
}

static stp_status search_some(void *context, size_t index, unsigned worker, stp_error *err)
{
    finder *f = context;
    (void)worker;
    (void)err;
    size_t begin = f->begin + index * PROBES_A_TASK, end = begin + PROBES_A_TASK;
    for (size_t i = begin; i < end && i < f->end; i++)
        search_leaf(&f->leaf, &f->probes[f->visits[i].probe]);
    return STP_OK;
}

/* Searches all leaves to visit, one after the other. */
static stp_status visit_leaves(finder *f, const char *stage, stp_error *err)
{
    stp_status status = STP_OK;
    if (f->visit_count > 0)
        qsort(f->visits, f->visit_count, sizeof *f->visits, compare_visits);
    for (f->begin = 0; f->begin < f->visit_count; f->begin = f->end) {
        uint32_t id = f->visits[f->begin].leaf;
        for (f->end = f->begin; f->end < f->visit_count && f->visits[f->end].leaf == id;)
            f->end++;
        STP_TRY(stp_progress_update(f->params->progress, stage, f->begin, f->visit_count, err));
        STP_TRY(read_leaf(f->params, id, &f->leaf, err));
        size_t tasks = (f->end - f->begin + PROBES_A_TASK - 1) / PROBES_A_TASK;
        STP_TRY(stp_pool_run(f->params->pool, tasks, search_some, f, err));
    }
done:
    f->visit_count = 0;
    return status;
}

stp_status tune_nearest_find(const tune_nearest_params *params, tune_probe *probes, size_t count,
                             stp_error *err)
{
    stp_status status = STP_OK;
    finder f = {.params = params, .probes = probes};
    uint32_t *first = NULL;
    STP_TRY(stp_alloc(&first, count, sizeof *first, "a list of chunks", err));
    for (size_t i = 0; i < count; i++) {
        double best = INFINITY;
        probes[i].distance = INFINITY;
        probes[i].nearest = probes[i].at;
        nearest_leaf(params->entries, 0, probes[i].at, &best, &first[i]);
        STP_TRY(add_visit(&f, first[i], i, err));
    }
    STP_TRY(visit_leaves(&f, "discs", err));
    for (size_t i = 0; i < count; i++)
        STP_TRY(add_others(&f, 0, i, first[i], err));
    STP_TRY(visit_leaves(&f, "discs around", err));
done:
    free(first);
    free(f.visits);
    free(f.leaf.discs);
    free(f.leaf.groups);
    return status;
}
