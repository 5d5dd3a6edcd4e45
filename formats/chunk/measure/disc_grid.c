/* Discs in hashed cells, and the search for the one of least value. */
#include "formats/chunk/measure/disc_grid.h"

#include "base/memory.h"
#include "formats/chunk/measure/disc_cells.h"

#include <stdlib.h>
#include <string.h>

/* Width of a cell, and how far discs may reach out of their cells, in mean radii. */
#define CELL_RADII 2.0
#define MARGIN_RADII 1.25
/* A disc is large if it reaches farther than this many cells from its centre's cell. */
#define REACH_CELLS 4.0f
/* A search visits at most this many rings of cells around its point, and this many discs. */
#define RING_MAX 3
#define TRIES_MAX 1024
/* Discs a block of 64 cells. */
#define DISCS_A_BLOCK 32
/* Smaller radii count as this: a float can then still tell the cell. */
#define RADIUS_MIN 0x1p-18
/* Errors of floats: in coordinates, grid units, and the factor in squared distances. */
#define FLOAT_SLACK 0x1p-21f
#define REACH_SLACK 1.0001f
#define FAR 1e18f /* its square is a float, too */

typedef struct cell {
    int at[3];
} cell;

static stp_flat_disc scaled(const stp_disc_grid *g, const stp_flat_disc *d)
{
    return (stp_flat_disc){stp_dvec3_scale(d->centre, g->scale), d->normal, d->radius * g->scale};
}

static stp_flat_disc disc_of(const stp_disc_grid *g, uint32_t disc)
{
    if (disc >= g->own_count)
        return scaled(g, &g->around[disc - g->own_count]);
    stp_flat_disc own = stp_flat_disc_from_sample(&g->chunk->samples[0][disc],
                                                  &g->chunk->patches[g->patch_of[disc]]);
    return scaled(g, &own);
}

/* World units. */
static stp_carry carry_of(const stp_disc_grid *g, uint32_t disc)
{
    const stp_carry none = {0.0, 0.0};
    if (disc < g->own_count)
        return g->carry ? g->carry[disc] : none;
    return g->carry_around ? g->carry_around[disc - g->own_count] : none;
}

/* At least the greatest coordinate of a rim of the patch's level-0 discs. */
static double extent_of_patch(const stp_patch *patch, const stp_sample *samples)
{
    uint16_t low[3] = {UINT16_MAX, UINT16_MAX, UINT16_MAX}, high[3] = {0, 0, 0};
    int64_t greatest = 0;
    uint8_t radius = 0;
    for (unsigned i = 0; i < patch->counts[0]; i++) {
        radius = samples[i].radius > radius ? samples[i].radius : radius;
        for (int a = 0; a < 3; a++) {
            const uint16_t at = samples[i].position[a];
            low[a] = at < low[a] ? at : low[a];
            high[a] = at > high[a] ? at : high[a];
        }
    }
    for (int a = 0; a < 3; a++) {
        const int64_t from = llabs((int64_t)patch->origin[a] + low[a]);
        const int64_t to = llabs((int64_t)patch->origin[a] + high[a]);
        greatest = from > greatest ? from : greatest;
        greatest = to > greatest ? to : greatest;
    }
    return ldexp((double)greatest, patch->exponent) + stp_radius_decode(radius, patch->exponent);
}

static double extent_of_disc(const stp_flat_disc *d)
{
    stp_dvec3 c = d->centre;
    return stp_max(fabs(c.x), stp_max(fabs(c.y), fabs(c.z))) + d->radius;
}

/* Chooses the unit and the width of cells. The width follows from the geometric mean of the chunk's
 * own radii, so that a few large discs do not widen the cells of many small ones. */
static void choose_scale(stp_disc_grid *g)
{
    const stp_chunk *chunk = g->chunk;
    double extent = 0.0;
    int64_t sum = 0; /* of logarithms of radii, in radius codes */
    uint32_t wide = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        const stp_sample *samples = chunk->samples[0] + chunk->level_begin[0][p];
        extent = stp_max(extent, extent_of_patch(patch, samples));
        for (unsigned i = 0; i < patch->counts[0]; i++)
            if (samples[i].radius > 0) {
                sum += samples[i].radius - 1 + patch->exponent * STP_RADIUS_CODES_PER_OCTAVE;
                wide++;
            }
    }
    for (uint32_t d = 0; d < g->count - g->own_count; d++)
        extent = stp_max(extent, extent_of_disc(&g->around[d]));
    g->scale = extent > 0.0 ? ldexp(1.0, -ilogb(extent) - 1) : 1.0;
    g->radius = RADIUS_MIN;
    if (wide) {
        double mean = exp2((double)sum / (STP_RADIUS_CODES_PER_OCTAVE * (double)wide));
        g->radius = stp_max(RADIUS_MIN, g->scale * mean);
    }
    g->width = (float)(CELL_RADII * g->radius);
    g->margin = (float)(MARGIN_RADII * g->radius) + FLOAT_SLACK;
}

static void take_disc(stp_disc_grid *g, uint32_t disc, const stp_flat_disc *world)
{
    const stp_flat_disc d = scaled(g, world);
    const stp_carry carry = carry_of(g, disc);
    const stp_dvec3 c = d.centre, n = d.normal;
    g->numbers[disc] = (stp_lane_disc){
        {(float)c.x, (float)c.y, (float)c.z, (float)n.x, (float)n.y, (float)n.z, (float)d.radius,
         (float)(carry.tangential_error * g->scale), (float)(carry.error * g->scale)}};
}

/* Adds a patch's discs to the box around all. */
static void add_to_box(const stp_sample_lanes *lanes, uint32_t count, stp_dbox *box)
{
    for (uint32_t i = 0; i < count; i++)
        stp_dbox_add(box,
                     (stp_dvec3){lanes->centre[0][i], lanes->centre[1][i], lanes->centre[2][i]});
}

static void set_box(stp_disc_grid *g, const stp_dbox *box)
{
    const stp_dvec3 low = box->min, high = box->max;
    const double from[3] = {low.x, low.y, low.z}, to[3] = {high.x, high.y, high.z};
    for (int a = 0; a < 3; a++) {
        g->low[a] = (float)(from[a] * g->scale);
        g->high[a] = (float)(to[a] * g->scale);
    }
}

static void take_discs(stp_disc_grid *g)
{
    const stp_chunk *chunk = g->chunk;
    stp_sample_lanes lanes;
    stp_dbox box = stp_dbox_empty();
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const uint32_t first = chunk->level_begin[0][p], count = chunk->patches[p].counts[0];
        stp_samples_decode(&chunk->samples[0][first], count, &chunk->patches[p], &lanes);
        add_to_box(&lanes, count, &box);
        for (uint32_t i = 0; i < count; i++) {
            stp_flat_disc own = stp_flat_disc_from_lanes(&lanes, i);
            take_disc(g, first + i, &own);
            g->patch_of[first + i] = (uint16_t)p;
        }
    }
    set_box(g, &box);
    for (uint32_t d = g->own_count; d < g->count; d++)
        take_disc(g, d, &g->around[d - g->own_count]);
}

/* The cells that a disc's box touches after the margin is taken off. False if the disc is large. */
static bool cells_of_disc(const stp_disc_grid *g, const stp_lane_disc *d, cell *low, cell *high)
{
    const float radius = d->numbers[STP_LANE_RADIUS], inverse = 1.0f / g->width;
    bool large = false;
    for (int a = 0; a < 3; a++) {
        float c = d->numbers[STP_LANE_CENTRE + a], n = d->numbers[STP_LANE_NORMAL + a], half = 0.0f;
        if (radius > g->margin)
            half = fmaxf(radius * sqrtf(fmaxf(0.0f, 1.0f - n * n)) - g->margin, 0.0f);
        low->at[a] = stp_cell_floor((c - half) * inverse);
        high->at[a] = half > 0.0f ? stp_cell_floor((c + half) * inverse) : low->at[a];
        large |= half > REACH_CELLS * g->width;
    }
    return !large;
}

static void note_large(stp_disc_grid *g, uint32_t disc)
{
    if (g->large_count < STP_DISC_LARGE_MAX)
        g->large[g->large_count] = disc;
    g->large_count++;
}

/* First round: counts an entry in begin[]. Second round, once columns.disc exists: writes the entry
 * before begin[]. */
static void enter(stp_disc_grid *g, uint32_t bucket, uint32_t disc)
{
    if (g->columns.disc)
        g->columns.disc[--g->begin[bucket]] = disc;
    else
        g->begin[bucket]++;
}

#define SEVERAL UINT32_MAX

/* Enters all discs but the large ones. bucket: by disc, its one bucket, or SEVERAL; the first round
 * fills it. */
static void enter_discs(stp_disc_grid *g, uint32_t *bucket)
{
    const bool first_round = !g->columns.disc;
    for (uint32_t d = g->count; d-- > 0;) {
        cell low, high;
        if (!first_round && bucket[d] != SEVERAL) {
            enter(g, bucket[d], d);
            continue;
        }
        bool large = !cells_of_disc(g, &g->numbers[d], &low, &high);
        if (large && first_round)
            note_large(g, d);
        bucket[d] = SEVERAL;
        for (int i = low.at[0]; i <= high.at[0] && !large; i++)
            for (int j = low.at[1]; j <= high.at[1]; j++)
                for (int k = low.at[2]; k <= high.at[2]; k++) {
                    bucket[d] = stp_cell_bucket(g->mask, stp_cell_part_of(0, i),
                                                stp_cell_part_of(1, j), stp_cell_part_of(2, k));
                    enter(g, bucket[d], d);
                }
        if (memcmp(&low, &high, sizeof low) != 0)
            bucket[d] = SEVERAL;
    }
}

stp_status stp_disc_grid_create(stp_disc_grid *out, const stp_chunk *chunk, const stp_carry *carry,
                                const stp_surroundings *around, stp_error *err)
{
    stp_disc_grid g = {.chunk = chunk,
                       .own_count = chunk->level_begin[0][chunk->patch_count],
                       .around = around ? around->discs : NULL,
                       .carry = carry,
                       .carry_around = around ? around->carry : NULL};
    g.count = g.own_count + (around ? around->count : 0);
    stp_status status =
        stp_alloc_unset(&g.numbers, (size_t)g.count + 1, sizeof *g.numbers, "discs", err);
    if (status == STP_OK)
        status = stp_alloc_unset(&g.patch_of, g.own_count, sizeof *g.patch_of, "discs", err);
    if (status == STP_OK) {
        choose_scale(&g);
        take_discs(&g);
        g.numbers[g.count] = (stp_lane_disc){{FAR, FAR, FAR}};
    }
    *out = g;
    return status;
}

stp_status stp_disc_grid_fill(stp_disc_grid *g, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t size = 1, sum = 0, *bucket = NULL;
    while (DISCS_A_BLOCK * size < g->count)
        size *= 2;
    g->mask = size - 1;
    size *= 64;
    STP_TRY(stp_alloc(&g->begin, (size_t)size + 1, sizeof *g->begin, "discs", err));
    STP_TRY(stp_alloc_unset(&bucket, g->count, sizeof *bucket, "discs", err));
    enter_discs(g, bucket);
    for (uint32_t b = 0; b <= size; b++)
        g->begin[b] = sum += g->begin[b];
    g->entries = sum;
    STP_TRY(stp_alloc(&g->columns.disc, (size_t)sum + STP_LANE_STEP, sizeof *g->columns.disc,
                      "discs", err));
    enter_discs(g, bucket);
    STP_TRY(stp_disc_columns_fill(&g->columns, g->numbers, sum, g->carry || g->carry_around, err));
done:
    free(bucket);
    return status;
}

void stp_disc_grid_clear(stp_disc_grid *g)
{
    stp_disc_columns_clear(&g->columns);
    free(g->numbers);
    free(g->patch_of);
    free(g->begin);
    *g = (stp_disc_grid){0};
}

double stp_disc_grid_value(const stp_disc_grid *grid, uint32_t disc, stp_dvec3 x,
                           const stp_merged_disc *merged)
{
    stp_flat_disc d = disc_of(grid, disc);
    stp_carry carry = carry_of(grid, disc);
    stp_dvec3 v = stp_dvec3_sub(x, d.centre);
    double height = stp_dvec3_dot(v, d.normal);
    v = stp_dvec3_sub(v, stp_dvec3_scale(d.normal, height));
    double overhang = stp_max(0.0, stp_dvec3_length(v) - d.radius);
    double cost = overhang + carry.tangential_error * grid->scale;
    height = fabs(height);
    double high = height + carry.error * grid->scale;
    double open = sqrt(stp_max((high - merged->error) * (high + merged->error), 0.0));
    if (disc - merged->begin >= merged->end - merged->begin) {
        double cosine = stp_dvec3_dot(merged->normal, d.normal);
        stp_dvec3 aside = stp_dvec3_sub(d.normal, stp_dvec3_scale(merged->normal, cosine));
        open += height * stp_dvec3_length(aside);
    }
    return cost + stp_min(open, height);
}

static float squared_distance(const stp_disc_grid *g, uint32_t disc, const float p[3])
{
    float height, overhang = stp_lane_overhang(p, g->numbers[disc].numbers, &height);
    return height * height + overhang * overhang;
}

uint32_t stp_disc_grid_nearest(const stp_disc_grid *grid, uint32_t first, uint32_t last,
                               stp_dvec3 x, double *squared)
{
    const float p[3] = {(float)x.x, (float)x.y, (float)x.z};
    float least = squared_distance(grid, first, p);
    uint32_t nearest = first;
    for (uint32_t d = first + 1; d < last; d++) {
        float away = squared_distance(grid, d, p);
        nearest = away < least ? d : nearest;
        least = fminf(least, away);
    }
    *squared = (double)least;
    return nearest;
}

/* A point's search. */
typedef struct search {
    const stp_disc_grid *grid;
    stp_over over;
    float x[3];
    float stop;
    float reach;    /* squared: no disc farther away is better */
    float far;      /* the same, not squared */
    uint32_t tries; /* left */
    stp_disc_best best;
} search;

static bool has_ended(const search *s)
{
    return s->tries == 0 || s->best.value <= s->stop;
}

static float lesser(float a, float b)
{
    return a < b ? a : b;
}

/* Sets the squared distance beyond which o or b alone, or the distance, is as much as the least so
 * far. If that is the nearest disc's cost, no disc may be nearer; if it is small enough, nothing
 * else matters. */
static void set_reach(search *s)
{
    const stp_disc_best *best = &s->best;
    const bool nearest = best->cost < best->value;
    const float least = nearest ? best->cost : best->value;
    const float error = s->over.error, near = least + s->over.forgiven;
    s->reach = least * least + error * error;
    if (s->over.what == STP_OVER_NEED && near * near < s->reach)
        s->reach = near * near;
    if (nearest && (least <= s->stop || best->squared > s->reach))
        s->reach = best->squared;
    s->reach *= REACH_SLACK;
    s->far = lesser(sqrtf(s->reach) + FLOAT_SLACK, STP_LANE_ANYWHERE);
}

/* The cells about x along one axis, by their steps from the middle cell. */
typedef struct row {
    int middle;
    float in; /* x above the middle cell's lower face */
    stp_cell_part part[2 * RING_MAX + 1];
    float squared[2 * RING_MAX + 1]; /* distance from x to what their discs reach */
} row;

static void row_add(row *r, const stp_disc_grid *g, int axis, int steps)
{
    float near_face = (float)(abs(steps) - 1) * g->width;
    float away = steps < 0 ? r->in + near_face : near_face + g->width - r->in;
    away = steps != 0 && away > g->margin ? away - g->margin : 0.0f;
    r->part[RING_MAX + steps] = stp_cell_part_of(axis, r->middle + steps);
    r->squared[RING_MAX + steps] = away * away;
}

/* The nth of the steps from the middle cell, the nearer side first. */
static int nth_step(const row *r, const stp_disc_grid *g, int n)
{
    int far = (n + 1) / 2;
    return (n & 1) == (r->in < g->width / 2.0f) ? -far : far;
}

/* Tries the discs of buckets [first, last]. */
static void try_buckets(search *s, uint32_t first, uint32_t last)
{
    const stp_disc_grid *g = s->grid;
    uint32_t begin = g->begin[first], count = g->begin[last + 1] - begin;
    if (count == 0)
        return;
    count = count < s->tries ? count : s->tries;
    s->tries -= count;
    if (stp_disc_columns_least(&g->columns, begin, count, &s->over, s->x, s->far, &s->best))
        set_reach(s);
}

/* Tries one column of cells along the third axis, i and j steps away along the other two: those of
 * its cells [low, high] that come near enough. The cells of a block have consecutive buckets. */
static void try_column(search *s, const row rows[3], int i, int j, int low, int high)
{
    const row *z = &rows[2];
    const float squared = rows[0].squared[RING_MAX + i] + rows[1].squared[RING_MAX + j];
    if (squared >= s->reach)
        return;
    while (low <= high && squared + z->squared[RING_MAX + low] >= s->reach)
        low++;
    while (low <= high && squared + z->squared[RING_MAX + high] >= s->reach)
        high--;
    while (low <= high && !has_ended(s)) {
        int end = low + (3 - ((z->middle + low) & 3));
        end = end < high ? end : high;
        const stp_cell_part x = rows[0].part[RING_MAX + i], y = rows[1].part[RING_MAX + j];
        try_buckets(s, stp_cell_bucket(s->grid->mask, x, y, z->part[RING_MAX + low]),
                    stp_cell_bucket(s->grid->mask, x, y, z->part[RING_MAX + end]));
        low = end + 1;
    }
}

/* Tries the cells whose greatest step from the middle is `ring`. */
static void try_ring(search *s, row rows[3], int ring)
{
    for (int axis = 0; axis < 3; axis++) {
        row_add(&rows[axis], s->grid, axis, ring);
        row_add(&rows[axis], s->grid, axis, -ring);
    }
    for (int a = 0; a <= 2 * ring; a++) {
        int i = nth_step(&rows[0], s->grid, a);
        if (rows[0].squared[RING_MAX + i] >= s->reach)
            continue;
        for (int b = 0; b <= 2 * ring; b++) {
            int j = nth_step(&rows[1], s->grid, b);
            if (rows[1].squared[RING_MAX + j] >= s->reach)
                continue;
            if (abs(i) == ring || abs(j) == ring) {
                try_column(s, rows, i, j, -ring, ring);
                continue;
            }
            try_column(s, rows, i, j, -ring, -ring);
            try_column(s, rows, i, j, ring, ring);
        }
    }
}

/* Tries the cells around x, ring by ring. True if no disc has a lesser value, or the least is small
 * enough. */
static bool try_cells(search *s)
{
    const float width = s->grid->width;
    float room = width; /* to the nearest face of the cell */
    row rows[3];
    for (int a = 0; a < 3; a++) {
        rows[a].middle = stp_cell_floor(s->x[a] / width);
        rows[a].part[RING_MAX] = stp_cell_part_of(a, rows[a].middle);
        rows[a].squared[RING_MAX] = 0.0f;
    }
    const uint32_t first = stp_cell_bucket(s->grid->mask, rows[0].part[RING_MAX],
                                           rows[1].part[RING_MAX], rows[2].part[RING_MAX]);
    try_buckets(s, first, first);
    if (s->best.value <= s->stop)
        return true;
    for (int a = 0; a < 3; a++) {
        rows[a].in = s->x[a] - (float)rows[a].middle * width;
        room = lesser(room, lesser(rows[a].in, width - rows[a].in));
    }
    for (int ring = 0; ring <= RING_MAX && !has_ended(s); ring++) {
        float seen = room + (float)ring * width - s->grid->margin;
        if (ring > 0)
            try_ring(s, rows, ring);
        if (s->tries > 0 && seen > 0.0f && s->reach <= seen * seen)
            return true;
    }
    return s->best.value <= s->stop;
}

/* Tries a disc that is in no cell. */
static void try_large(search *s, uint32_t disc)
{
    const bool own = disc - s->over.begin < s->over.end - s->over.begin;
    float squared;
    const float cost =
        stp_lane_cost_squared(s->x, s->grid->numbers[disc].numbers, own, &s->over, &squared);
    const float value =
        s->over.what == STP_OVER_NEED ? stp_lane_need(cost, squared, &s->over) : cost;
    s->best.value = fminf(s->best.value, value);
    if (squared < s->best.squared) {
        s->best.squared = squared;
        s->best.cost = cost;
    }
}

bool stp_disc_grid_least(const stp_disc_grid *grid, stp_dvec3 x, const stp_merged_disc *merged,
                         double stop, bool whole, stp_disc_best *best)
{
    stp_dvec3 n = merged->normal;
    search s = {.grid = grid,
                .over = {merged->what,
                         {(float)n.x, (float)n.y, (float)n.z},
                         (float)merged->error,
                         (float)merged->forgiven,
                         merged->begin,
                         merged->end},
                .x = {(float)x.x, (float)x.y, (float)x.z},
                .stop = (float)stop,
                .tries = TRIES_MAX,
                .best = *best};
    if (grid->large_count > STP_DISC_LARGE_MAX)
        return false;
    for (uint32_t i = 0; i < grid->large_count; i++)
        try_large(&s, grid->large[i]);
    set_reach(&s);
    bool found = try_cells(&s);
    if (!found && whole && !has_ended(&s)) {
        stp_disc_columns_least(&grid->columns, 0, grid->entries, &s.over, s.x, STP_LANE_ANYWHERE,
                               &s.best);
        found = true;
    }
    *best = s.best;
    return found;
}
