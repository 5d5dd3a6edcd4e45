/* Overhang of merged discs over all level-0 discs of their chunk. */
#include "formats/chunk/overhang.h"

#include "base/memory.h"
#include "formats/chunk/disc_lanes.h"
#include "formats/chunk/nearest_disc.h"
#include "formats/chunk/patch_bounds.h"

#include <stdlib.h>

/* A cell is so many mean radii wide. */
#define CELL_RADII 1.0
/* A disc that reaches farther than so many cells from its centre's is large: every search tries it.
 * With more than these few of them there is no search. */
#define REACH_CELLS 4
#define LARGE_MAX 32
/* A point looks no farther than so many cells, and at no more discs than this. */
#define RING_MAX 3
#define TRIES_MAX 512
#define CELLS_MAX 4e15

typedef struct flat_disc {
    stp_dvec3 centre, normal;
    double radius;
} flat_disc;

/* The chunk's level-0 discs, each entered in every cell its box touches; cells are hashed. The
 * entries of bucket b are entries[begin[b]] to entries[begin[b + 1]]. */
typedef struct disc_grid {
    const stp_overhang_carry *carry;
    flat_disc *discs;
    uint32_t *begin, *entries;
    uint32_t large[LARGE_MAX], large_count;
    uint32_t count, mask;
    double width;
} disc_grid;

typedef struct cell {
    int64_t at[3];
} cell;

/* Blocks of 4 x 4 x 4 cells are hashed; the cells of a block lie together. */
static uint32_t bucket_of(const disc_grid *g, int64_t i, int64_t j, int64_t k)
{
    uint64_t h = (uint64_t)(i >> 2) * 0x9e3779b97f4a7c15u ^
                 (uint64_t)(j >> 2) * 0xc2b2ae3d27d4eb4fu ^
                 (uint64_t)(k >> 2) * 0x165667b19e3779f9u;
    uint32_t block = (uint32_t)(h >> 32 ^ h) & g->mask;
    return block << 6 | (uint32_t)((i & 3) << 4 | (j & 3) << 2 | (k & 3));
}

/* Farther out than doubles count whole cells, all is one cell. */
static int64_t step_of(double cells)
{
    return (int64_t)stp_max(-CELLS_MAX, stp_min(CELLS_MAX, floor(cells)));
}

static cell cell_of(const disc_grid *g, stp_dvec3 p)
{
    return (cell){{step_of(p.x / g->width), step_of(p.y / g->width), step_of(p.z / g->width)}};
}

/* The geometric mean keeps a few large discs from making the cells of many small ones wide. */
static void fill_discs(disc_grid *g, const stp_chunk *chunk)
{
    double sum = 0.0;
    uint32_t wide = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            stp_disc disc = stp_disc_from_sample(&chunk->samples[0][i], &chunk->patches[p]);
            g->discs[i] = (flat_disc){disc.centre, disc.normal, disc.radius};
            if (disc.radius > 0.0) {
                sum += log(disc.radius);
                wide++;
            }
        }
    g->width = wide ? CELL_RADII * exp(sum / wide) : 1.0;
}

/* Half the box of a disc; of a ball its radius. */
static stp_dvec3 half_box(const flat_disc *d)
{
    stp_dvec3 n = d->normal;
    return (stp_dvec3){d->radius * sqrt(stp_max(0.0, 1.0 - n.x * n.x)),
                       d->radius * sqrt(stp_max(0.0, 1.0 - n.y * n.y)),
                       d->radius * sqrt(stp_max(0.0, 1.0 - n.z * n.z))};
}

/* The cells that the disc's box touches; false if it is large. */
static bool cells_of_disc(const disc_grid *g, const flat_disc *d, cell *low, cell *high)
{
    stp_dvec3 half = half_box(d);
    double reach = REACH_CELLS * g->width;
    *low = cell_of(g, stp_dvec3_sub(d->centre, half));
    *high = cell_of(g, stp_dvec3_add(d->centre, half));
    return half.x <= reach && half.y <= reach && half.z <= reach;
}

static void note_large(disc_grid *g, uint32_t disc)
{
    if (g->large_count < LARGE_MAX)
        g->large[g->large_count] = disc;
    g->large_count++;
}

/* Counts each disc's entries in begin and notes the large ones, or, once entries are there, writes
 * them before begin. */
static void enter_discs(disc_grid *g)
{
    for (uint32_t d = g->count; d-- > 0;) {
        cell low, high;
        if (!cells_of_disc(g, &g->discs[d], &low, &high)) {
            if (!g->entries)
                note_large(g, d);
            continue;
        }
        for (int64_t i = low.at[0]; i <= high.at[0]; i++)
            for (int64_t j = low.at[1]; j <= high.at[1]; j++)
                for (int64_t k = low.at[2]; k <= high.at[2]; k++) {
                    uint32_t *begin = &g->begin[bucket_of(g, i, j, k)];
                    if (g->entries)
                        g->entries[--*begin] = d;
                    else
                        ++*begin;
                }
    }
}

static stp_status grid_create(disc_grid *g, const stp_chunk *chunk, const stp_overhang_carry *carry,
                              stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t size = 1, sum = 0;
    g->carry = carry;
    g->count = chunk->level_begin[0][chunk->patch_count];
    while (8 * size < g->count)
        size *= 2;
    g->mask = size - 1;
    size *= 64;
    STP_TRY(stp_alloc(&g->discs, g->count, sizeof *g->discs, "discs", err));
    STP_TRY(stp_alloc(&g->begin, (size_t)size + 1, sizeof *g->begin, "discs", err));
    fill_discs(g, chunk);
    enter_discs(g);
    for (uint32_t b = 0; b <= size; b++)
        g->begin[b] = sum += g->begin[b];
    STP_TRY(stp_alloc(&g->entries, (size_t)sum + 1, sizeof *g->entries, "discs", err));
    enter_discs(g);
done:
    return status;
}

static void grid_clear(disc_grid *g)
{
    free(g->discs);
    free(g->begin);
    free(g->entries);
}

/* ---- the nearest disc ---- */

static void try_disc(const disc_grid *g, stp_dvec3 x, uint32_t index, stp_nearest_disc *best)
{
    const flat_disc *d = &g->discs[index];
    stp_nearest_disc_try(best, x, d->centre, d->normal, d->radius, index);
}

/* A point's search, which ends where the squared distance is no more than `enough`. */
typedef struct search {
    const disc_grid *grid;
    stp_dvec3 x;
    double enough;
    uint32_t tries; /* left */
    stp_nearest_disc best;
} search;

static bool has_ended(const search *s)
{
    return s->tries == 0 || s->best.squared <= s->enough;
}

static void try_cell(search *s, cell c)
{
    const disc_grid *g = s->grid;
    uint32_t b = bucket_of(g, c.at[0], c.at[1], c.at[2]);
    uint32_t e = g->begin[b], end = g->begin[b + 1];
    stp_nearest_disc best = s->best;
    stp_dvec3 x = s->x;
    double enough = s->enough;
    end = end - e < s->tries ? end : e + s->tries;
    s->tries -= end - e;
    for (; e < end && best.squared > enough; e++)
        try_disc(g, x, g->entries[e], &best);
    s->best = best;
}

/* From a place in its cell to the cell `steps` beside it, along one axis. */
static double axis_distance(double in, int steps, double width)
{
    return steps < 0 ? in - (steps + 1) * width : steps > 0 ? steps * width - in : 0.0;
}

/* The cells whose greatest step from the middle is `ring`, where they come nearer than the best. */
static void try_ring(search *s, const cell *middle, const double in[3], int ring)
{
    double width = s->grid->width, x[3];
    for (int i = -ring; i <= ring; i++) {
        x[0] = axis_distance(in[0], i, width);
        for (int j = -ring; j <= ring; j++) {
            bool side = abs(i) == ring || abs(j) == ring;
            x[1] = axis_distance(in[1], j, width);
            for (int k = -ring; k <= ring; k += side || ring == 0 ? 1 : 2 * ring) {
                x[2] = axis_distance(in[2], k, width);
                if (has_ended(s))
                    return;
                if (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] < s->best.squared)
                    try_cell(s, (cell){{middle->at[0] + i, middle->at[1] + j, middle->at[2] + k}});
            }
        }
    }
}

/* The large discs, then the cells around x. True if the best is the nearest of all, or near enough.
 */
static bool find_nearest(search *s)
{
    const disc_grid *g = s->grid;
    cell middle = cell_of(g, s->x);
    double in[3] = {s->x.x - (double)middle.at[0] * g->width,
                    s->x.y - (double)middle.at[1] * g->width,
                    s->x.z - (double)middle.at[2] * g->width};
    double room = INFINITY; /* to the nearest face of the cell */
    for (int a = 0; a < 3; a++)
        room = stp_min(room, stp_min(in[a], g->width - in[a]));
    if (g->large_count > LARGE_MAX)
        return false;
    for (uint32_t i = 0; i < g->large_count; i++)
        try_disc(g, s->x, g->large[i], &s->best);
    for (int ring = 0; ring <= RING_MAX && !has_ended(s); ring++) {
        try_ring(s, &middle, in, ring);
        if (s->best.distance <= room + ring * g->width)
            return true;
    }
    return s->best.squared <= s->enough;
}

/* ---- merged discs ---- */

/* A merged disc over the discs [first, last), and the greatest error of its level so far. */
typedef struct measure {
    const disc_grid *grid;
    stp_dvec3 normal;
    double error;    /* the perpendicular error that is stored */
    uint32_t latest; /* the disc nearest to an earlier point */
    double greatest;
} measure;

/* What of the height over a disc the stored perpendicular error does not cover. */
static double uncovered(const measure *m, const stp_nearest_disc *nearest)
{
    const disc_grid *g = m->grid;
    double carried = g->carry ? g->carry[nearest->index].error : 0.0;
    double cosine = stp_dvec3_dot(m->normal, g->discs[nearest->index].normal);
    if (nearest->height + carried > m->error)
        return nearest->height;
    return nearest->height * sqrt(stp_max(0.0, 1.0 - cosine * cosine));
}

static double carried_overhang(const disc_grid *g, uint32_t index)
{
    return g->carry ? g->carry[index].tangential_error : 0.0;
}

/* Both overhang and height are at most the distance, so their sum is at most 1.42 times that: no
 * more than the greatest where the distance is small enough. own: the nearest disc under the
 * point's merged disc. */
static void measure_point(measure *m, stp_dvec3 x, uint32_t own)
{
    const disc_grid *g = m->grid;
    double enough = g->carry ? 0.0 : m->greatest * m->greatest / 2.02;
    search s = {g, x, enough, TRIES_MAX, stp_nearest_disc_none()};
    try_disc(g, x, own, &s.best);
    double over_own = s.best.overhang + carried_overhang(g, own);
    if (over_own <= m->greatest || has_ended(&s))
        return;
    try_disc(g, x, m->latest, &s.best);
    if (has_ended(&s))
        return;
    double over_all = INFINITY;
    if (find_nearest(&s))
        over_all = s.best.overhang + carried_overhang(g, s.best.index) + uncovered(m, &s.best);
    m->latest = s.best.index;
    m->greatest = stp_max(m->greatest, stp_min(over_own, over_all));
}

static void measure_disc(measure *m, const stp_disc *disc, uint32_t first, uint32_t last)
{
    stp_dvec3 points[STP_DISC_POINTS];
    stp_disc_lanes lanes;
    unsigned count = stp_disc_points(disc, points);
    stp_disc_lanes_begin(&lanes, points, count, disc->centre, disc->radius, first);
    for (uint32_t i = first; i < last; i++) {
        const flat_disc *own = &m->grid->discs[i];
        stp_disc_lanes_try(&lanes, own->centre, own->normal, own->radius, i);
    }
    m->normal = disc->normal;
    m->latest = first;
    for (unsigned i = 0; i < count; i++)
        measure_point(m, points[i], lanes.nearest[i]);
}

/* A patch while it is measured. */
typedef struct patch_place {
    const stp_chunk *chunk;
    const stp_patch *patch;
    uint32_t begin[STP_LEVEL_COUNT];                       /* its samples in the chunk */
    uint8_t first[STP_LEVEL_COUNT][STP_PATCH_SAMPLES + 1]; /* level-0 sample under each */
} patch_place;

static patch_place place_of(const stp_chunk *chunk, uint32_t p)
{
    patch_place at = {.chunk = chunk, .patch = &chunk->patches[p]};
    const uint8_t *counts = at.patch->counts;
    for (int level = 0; level < STP_LEVEL_COUNT; level++) {
        at.begin[level] = chunk->level_begin[level][p];
        for (unsigned i = 0; i <= counts[level]; i++)
            at.first[level][i] = (uint8_t)(level ? at.first[level - 1][stp_level_children_begin(
                                                       i, counts[level], counts[level - 1])]
                                                 : i);
    }
    return at;
}

/* The samples [begin, end) of a level; error: their stored perpendicular one. */
static void measure_level(measure *m, const patch_place *at, int level, uint8_t error,
                          unsigned begin, unsigned end)
{
    m->error = stp_error_decode(error, at->patch->exponent) * (1.0 + 1e-6);
    for (unsigned i = begin; i < end; i++) {
        const stp_sample *sample = &at->chunk->samples[level][at->begin[level] + i];
        stp_disc disc = stp_disc_from_sample(sample, at->patch);
        measure_disc(m, &disc, at->begin[0] + at->first[level][i],
                     at->begin[0] + at->first[level][i + 1]);
    }
}

static void measure_patch(stp_overhang *out, const disc_grid *g, const stp_chunk *chunk, uint32_t p)
{
    const stp_patch *patch = &chunk->patches[p];
    patch_place at = place_of(chunk, p);
    measure m = {.grid = g};
    double floor = patch->counts[0] > 1
                       ? stp_radius_decode(patch->radius[0], patch->exponent) / STP_OVERHANG_PARTS
                       : 0.0;
    *out = (stp_overhang){0};
    for (unsigned q = 0; q < patch->counts[2]; q++) {
        double carried = 0.0;
        for (uint32_t i = at.first[2][q]; i < at.first[2][q + 1]; i++)
            carried = stp_max(carried, carried_overhang(g, at.begin[0] + i));
        out->level[0] = stp_max(out->level[0], carried);
        m.greatest = stp_max(carried, floor);
        for (int level = 1; level <= 2; level++) {
            measure_level(&m, &at, level, patch->quarter_error[level - 1][q],
                          stp_quarter_begin(patch->counts, level, q),
                          stp_quarter_begin(patch->counts, level, q + 1));
            out->quarter[level - 1][q] = m.greatest;
            out->level[level] = stp_max(out->level[level], m.greatest);
        }
    }
    m.greatest = out->level[2];
    measure_level(&m, &at, 3, patch->error[3], 0, 1);
    out->level[3] = m.greatest;
}

stp_status stp_overhang_measure(stp_overhang *out, const stp_chunk *chunk,
                                const stp_overhang_carry *carry, stp_error *err)
{
    disc_grid g = {0};
    stp_status status = grid_create(&g, chunk, carry, err);
    for (uint32_t p = 0; status == STP_OK && p < chunk->patch_count; p++)
        measure_patch(&out[p], &g, chunk, p);
    grid_clear(&g);
    return status;
}
