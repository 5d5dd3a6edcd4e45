/* Measures and checks tangential errors: the least cost of each point of a merged disc over the
 * level-0 discs near it. */
#include "formats/chunk/measure/overhang.h"

#include "formats/chunk/measure/disc_grid.h"
#include "formats/chunk/measure/disc_hints.h"
#include "formats/chunk/measure/disc_rows.h"
#include "formats/chunk/measure/patch_bounds.h"

#include <string.h>

/* Costs in floats may be off by this part of a point's coordinates: 128 roundings. */
#define FLOAT_SLACK 0x1p-17

/* A point whose hinted disc does not show that its cost is small enough. */
typedef struct suspect {
    stp_dvec3 x, normal;  /* the point; the normal of its merged disc */
    double slack;         /* possible error of float results */
    double cost;          /* upper bound of what it needs; TOO_FAR or more: unknown */
    bool looked;          /* the discs about it have been asked, too */
    uint32_t disc;        /* of a check: the hinted disc */
    uint32_t first, last; /* the level-0 discs under the merged disc: [first, last) */
} suspect;

#define TOO_FAR 1e30

/* If the grid gives up, a check tries all discs of the chunk, but at most this often. */
#define WHOLE_SEARCHES 64

/* Most suspects: the points of a quarter's level-1 discs, and one in a hole under each. */
#define SUSPECTS (4 * (STP_DISC_POINTS + 1))

/* Patches that a thread measures at a time. */
#define SHARE_PATCHES 32u

/* The state of measuring or checking one patch. greatest: the greatest error of the quarter or
 * patch so far, grid units; of a check, the stored error. */
typedef struct measure {
    const stp_disc_grid *grid;
    const stp_disc_hints *hints;
    const stp_disc_rows *rows; /* of a check: none */
    stp_disc_steps steps;      /* of the patch, if there are rows */
    const stp_patch *patch;
    double sine; /* of the patch's cone angle gamma: the rule never takes sin(alpha) for less */
    bool check;
    stp_merged_disc merged;
    double greatest;
    bool exceeded; /* a check: some point's least cost exceeds the stored error */
    unsigned whole_searches;
    unsigned suspect_count;
    suspect suspects[SUSPECTS];
} measure;

/* Raises the greatest error to one that can be stored. Every point whose cost is no greater is
 * answered. */
static void raise_to(measure *m, double units)
{
    const stp_patch *patch = m->patch;
    double error = units / m->grid->scale;
    uint8_t code = stp_error_encode(error, patch->exponent);
    m->greatest = stp_max(error, stp_error_decode(code, patch->exponent)) * m->grid->scale;
}

/* A check: sets m->exceeded if the point's least cost over all discs exceeds what is stored. */
static void check_point(measure *m, const suspect *s)
{
    stp_merged_disc merged = m->merged;
    const double stop = m->greatest - s->slack;
    stp_disc_best best = {(float)stp_min(s->cost, m->greatest + 3.0 * s->slack), STP_LANE_FAR,
                          STP_LANE_FAR};
    merged.normal = s->normal;
    merged.error += s->slack;
    merged.begin = s->first;
    merged.end = s->last;
    if (stp_disc_grid_value(m->grid, s->disc, s->x, &merged) <= m->greatest)
        return;
    bool found = stp_disc_grid_least(m->grid, s->x, &merged, stop, false, &best);
    if (!found && m->whole_searches < WHOLE_SEARCHES) {
        m->whole_searches++;
        found = stp_disc_grid_least(m->grid, s->x, &merged, stop, true, &best);
    }
    m->exceeded |= found && (double)best.value - 2.0 * s->slack > m->greatest;
}

/* e sin(gamma): the part of any distance that the rule always allows for the perpendicular error,
 * wherever the eye is. */
static double forgiven(const measure *m, double slack)
{
    return stp_max(0.0, m->merged.error - slack) * m->sine;
}

/* What a point is asked over a disc that need not be the nearest: what it needs, in a check and in
 * rows its cost. There no disc counts as one under the merged disc, so values are upper bounds. In
 * rows no disc lies over another one, and any answers. */
static stp_over over_near(const measure *m, stp_dvec3 n, double slack)
{
    const bool any = m->check || m->rows->columns > 0;
    return (stp_over){any ? STP_OVER_COST : STP_OVER_NEED,
                      {(float)n.x, (float)n.y, (float)n.z},
                      (float)stp_max(0.0, m->merged.error - slack),
                      (float)(forgiven(m, slack) - slack),
                      0,
                      0};
}

/* Lowers the suspect's cost to what it needs going by the best of these discs. */
static void look_at(const measure *m, suspect *s, const stp_over *over,
                    const uint32_t discs[STP_LANE_STEP])
{
    const float point[3] = {(float)s->x.x, (float)s->x.y, (float)s->x.z};
    float need[STP_LANE_STEP], least = STP_LANE_FAR;
    stp_lane_discs_tell(m->grid->numbers, discs, over, point, need);
    for (unsigned i = 0; i < STP_LANE_STEP; i++)
        least = need[i] < least ? need[i] : least;
    s->cost = stp_min(s->cost, (double)least + s->slack);
}

/* Looks at the discs that the hint cells around a suspect name; if these do not answer it, at those
 * under its merged disc, if they are few. */
static void look_about(const measure *m, suspect *s)
{
    stp_over over = over_near(m, s->normal, s->slack);
    const float point[3] = {(float)s->x.x, (float)s->x.y, (float)s->x.z};
    uint32_t discs[STP_LANE_STEP];
    s->looked = true;
    over.begin = s->first;
    over.end = s->last;
    stp_disc_hints_about(m->hints, point, discs);
    look_at(m, s, &over, discs);
    for (uint32_t d = s->first; d < s->last && s->cost > m->greatest; d += STP_LANE_STEP) {
        for (uint32_t i = 0; i < STP_LANE_STEP; i++)
            discs[i] = d + i < s->last ? d + i : d;
        look_at(m, s, &over, discs);
    }
}

/* What the point needs if it goes by `own`, the nearest disc under its merged disc, which may not
 * be the nearest of all. It needs no less than the distance to `own`, plus slack, less what is
 * forgiven: a nearer disc may lie anywhere within that distance. Of two discs as near, e may cover
 * the height over one and not over the other. */
static double over_own(const measure *m, uint32_t own, stp_dvec3 x, double squared, double slack)
{
    stp_merged_disc merged = m->merged;
    merged.begin = own;
    merged.end = own + 1;
    return stp_max(stp_disc_grid_value(m->grid, own, x, &merged),
                   sqrt(squared) + slack - forgiven(m, slack));
}

/* Raises the greatest error to what the point needs: its cost over the nearest disc, or what it
 * needs going by another one, if that is less. */
static void measure_point(measure *m, const suspect *s)
{
    stp_merged_disc merged = m->merged;
    stp_disc_best best = {(float)(s->cost - s->slack), STP_LANE_FAR, STP_LANE_FAR};
    merged.what = STP_OVER_NEED;
    merged.normal = s->normal;
    merged.error = stp_max(0.0, merged.error - s->slack);
    merged.forgiven = forgiven(m, s->slack) - s->slack;
    merged.begin = s->first;
    merged.end = s->last;
    const bool found =
        stp_disc_grid_least(m->grid, s->x, &merged, m->greatest - s->slack, false, &best);
    if (found && best.cost < best.value)
        best.value = best.cost;
    double value = (double)best.value + s->slack, squared;
    if (!found && value > m->greatest) {
        const uint32_t own = stp_disc_grid_nearest(m->grid, s->first, s->last, s->x, &squared);
        value = stp_min(value, over_own(m, own, s->x, squared, s->slack));
    }
    if (value > m->greatest)
        raise_to(m, value);
}

/* The same in rows: its cost over that disc about it over which it is least, or over its nearest
 * own disc, which may lie farther off. */
static void measure_in_rows(measure *m, const suspect *s)
{
    const float point[3] = {(float)s->x.x, (float)s->x.y, (float)s->x.z};
    const float stop = (float)(m->greatest - s->slack);
    stp_over over = over_near(m, s->normal, s->slack);
    stp_merged_disc merged = m->merged;
    double squared, value = INFINITY;
    uint32_t disc;
    merged.normal = s->normal;
    merged.begin = over.begin = s->first;
    merged.end = over.end = s->last;
    const float least = stp_disc_rows_least(m->rows, point, &over, stop, &disc);
    if (least < STP_DISC_ROWS_NONE)
        value = least <= stop ? 0.0 : stp_disc_grid_value(m->grid, disc, s->x, &merged);
    if (value <= m->greatest)
        return;
    disc = stp_disc_grid_nearest(m->grid, s->first, s->last, s->x, &squared);
    value = stp_min(value, stp_disc_grid_value(m->grid, disc, s->x, &merged));
    if (value > m->greatest)
        raise_to(m, value);
}

/* The points of a merged disc that reaches farther out than the grid searches: each goes by its
 * nearest own disc. */
static void measure_far(measure *m, const stp_disc *disc, uint32_t first, uint32_t last)
{
    stp_dvec3 points[STP_DISC_POINTS];
    unsigned count = m->check ? 0 : stp_disc_points(disc, points);
    for (unsigned i = 0; i < count; i++) {
        double squared = 0.0;
        uint32_t own = stp_disc_grid_nearest(m->grid, first, last, points[i], &squared);
        double value =
            over_own(m, own, points[i], squared, FLOAT_SLACK * stp_dvec3_length(points[i]));
        if (value > m->greatest)
            raise_to(m, value);
    }
}

static stp_disc in_units(const stp_flat_disc *disc, double scale)
{
    return (stp_disc){.centre = stp_dvec3_scale(disc->centre, scale),
                      .normal = disc->normal,
                      .radius = disc->radius * scale};
}

/* Tests a merged disc's points against their hinted discs. A set bit means: the hint does not show
 * that the point's cost is at most the greatest. told: the cost over the hinted disc. */
static uint32_t unanswered(const measure *m, const stp_disc *disc, double slack,
                           stp_paired_lanes *lanes, float told[STP_DISC_LANES])
{
    const stp_dvec3 n = disc->normal, c = disc->centre;
    stp_dvec3 u = {0.0, 0.0, 0.0}, v = u;
    bool known = n.x != 0.0 || n.y != 0.0 || n.z != 0.0;
    if (known)
        stp_disc_axes(n, &u, &v);
    const float centre[3] = {(float)c.x, (float)c.y, (float)c.z};
    const float axes[2][3] = {{(float)u.x, (float)u.y, (float)u.z},
                              {(float)v.x, (float)v.y, (float)v.z}};
    const stp_over over = over_near(m, n, slack);
    const uint32_t points = known && disc->radius > 0.0 ? (1u << STP_DISC_POINTS) - 1 : 1;
    const float limit = (float)(m->greatest - slack);
    stp_paired_lanes_points(lanes, centre, axes, (float)disc->radius);
    if (m->rows->columns > 0)
        return points & stp_disc_rows_above(m->rows, &m->steps, &over, limit, lanes, told);
    stp_disc_hints_pair(m->hints, lanes);
    return points & stp_paired_lanes_above(lanes, &over, limit, told);
}

/* Adds to the suspects those points of a merged disc over the level-0 discs [first, last) that
 * their hints do not answer, and its point in the middle of a hole, between all the others. */
static void suspect_points(measure *m, const stp_disc *disc, uint32_t first, uint32_t last)
{
    stp_paired_lanes lanes;
    stp_dvec3 points[STP_DISC_POINTS], c = disc->centre;
    float told[STP_DISC_LANES];
    double extent = stp_max(fabs(c.x), stp_max(fabs(c.y), fabs(c.z))) + disc->radius;
    double slack = FLOAT_SLACK * stp_max(1.0, extent);
    if (!(extent < STP_DISC_GRID_REACH)) {
        measure_far(m, disc, first, last);
        return;
    }
    suspect hole = {.normal = disc->normal,
                    .slack = slack,
                    .cost = TOO_FAR,
                    .disc = first,
                    .first = first,
                    .last = last};
    if (stp_disc_rows_hole(m->rows, disc, &hole.x))
        m->suspects[m->suspect_count++] = hole;
    uint32_t above = unanswered(m, disc, slack, &lanes, told);
    if (above)
        stp_disc_points(disc, points);
    for (unsigned i = 0; above >> i; i++)
        if (above >> i & 1)
            m->suspects[m->suspect_count++] = (suspect){
                .x = points[i],
                .normal = disc->normal,
                .slack = slack,
                .cost = (double)told[i] + slack,
                .disc = lanes.index[i],
                .first = first,
                .last = last,
            };
}

/* Lets the suspect at a place of a heap sink to where its cost belongs. */
static void sink(const measure *m, uint8_t *heap, unsigned count, unsigned at)
{
    const suspect *suspects = m->suspects;
    const uint8_t own = heap[at];
    const double cost = suspects[own].cost;
    for (unsigned below = 2 * at + 1; below < count; below = 2 * at + 1) {
        below += below + 1 < count && suspects[heap[below + 1]].cost > suspects[heap[below]].cost;
        if (suspects[heap[below]].cost <= cost)
            break;
        heap[at] = heap[below];
        at = below;
    }
    heap[at] = own;
}

/* Makes a heap of the numbers of those suspects whose cost is above the greatest error, the
 * greatest cost first. Returns how many. */
static unsigned heap_above(const measure *m, uint8_t *heap)
{
    unsigned count = 0;
    for (unsigned i = 0; i < m->suspect_count; i++)
        if (m->suspects[i].cost > m->greatest)
            heap[count++] = (uint8_t)i;
    for (unsigned at = count / 2; at-- > 0;)
        sink(m, heap, count, at);
    return count;
}

/* Takes the greatest cost first: what it raises the error to may answer the other points. A search
 * is dear, so the discs about a point are asked before it has its turn. */
static void measure_suspects(measure *m)
{
    const bool in_rows = m->rows->columns > 0;
    uint8_t heap[SUSPECTS];
    unsigned count = heap_above(m, heap);
    while (count > 0 && m->suspects[heap[0]].cost > m->greatest) {
        suspect *s = &m->suspects[heap[0]];
        if (m->check || in_rows || s->looked)
            heap[0] = heap[--count];
        if (m->check)
            check_point(m, s);
        else if (in_rows)
            measure_in_rows(m, s);
        else if (s->looked)
            measure_point(m, s);
        else
            look_about(m, s);
        sink(m, heap, count, 0);
    }
    m->suspect_count = 0;
}

/* Whether a sample is a copy of the one level-0 sample that it stands for. */
static bool is_its_own(const stp_sample *sample, const stp_sample *first, unsigned count)
{
    return count == 1 && memcmp(sample, first, sizeof *sample) == 0;
}

static void take_patch(measure *m, const stp_patch *patch)
{
    m->patch = patch;
    m->sine = sin(stp_min(M_PI_2, stp_cone_angle_decode(patch->cone_angle)));
    if (m->rows->columns > 0)
        stp_disc_rows_steps(m->rows, stp_normal_decode(patch->cone_axis).raw, &m->steps);
}

/* All samples of quarter q at a level. */
static void measure_level(measure *m, const stp_chunk *chunk, int level, unsigned q)
{
    const stp_patch *patch = m->patch;
    const uint32_t p = (uint32_t)(patch - chunk->patches), own = chunk->level_begin[0][p];
    const stp_sample *samples = chunk->samples[level] + chunk->level_begin[level][p];
    const unsigned begin = stp_quarter_begin(patch->counts, level, q);
    const unsigned end = stp_quarter_begin(patch->counts, level, q + 1);
    stp_sample_lanes lanes;
    stp_samples_decode(&samples[begin], end - begin, patch, &lanes);
    m->merged.error = stp_error_decode(stp_quarter_error(patch, level, q), patch->exponent) *
                      STP_STORED_SLACK * m->grid->scale;
    m->merged.what = STP_OVER_COST;
    for (unsigned i = begin; i < end; i++) {
        unsigned first = stp_covered_begin(patch->counts, level, i, 0);
        unsigned count = stp_covered_begin(patch->counts, level, i + 1, 0) - first;
        if (is_its_own(&samples[i], &chunk->samples[0][own + first], count))
            continue;
        const stp_flat_disc flat = stp_flat_disc_from_lanes(&lanes, i - begin);
        const stp_disc disc = in_units(&flat, m->grid->scale);
        suspect_points(m, &disc, own + first, own + first + count);
    }
    measure_suspects(m);
}

/* The greatest tangential error that the level-0 samples of a quarter carry. */
static double carried_by(const stp_chunk *chunk, const stp_carry *carry, uint32_t p, unsigned q)
{
    const stp_patch *patch = &chunk->patches[p];
    double carried = 0.0;
    unsigned end = stp_quarter_begin(patch->counts, 0, q + 1);
    for (unsigned i = stp_quarter_begin(patch->counts, 0, q); carry && i < end; i++)
        carried = stp_max(carried, carry[chunk->level_begin[0][p] + i].tangential_error);
    return carried;
}

static void measure_patch(stp_overhang *out, measure *m, const stp_chunk *chunk, uint32_t p)
{
    const stp_patch *patch = &chunk->patches[p];
    const double scale = m->grid->scale;
    double least = patch->counts[0] > 1
                       ? stp_radius_decode(patch->radius[0], patch->exponent) / STP_OVERHANG_PARTS
                       : 0.0;
    take_patch(m, patch);
    *out = (stp_overhang){0};
    for (unsigned q = 0; q < patch->counts[2]; q++) {
        double carried = carried_by(chunk, m->grid->carry, p, q);
        out->level[0] = stp_max(out->level[0], carried);
        raise_to(m, stp_max(carried, least) * scale);
        for (int level = 1; level <= 2; level++) {
            measure_level(m, chunk, level, q);
            out->quarter[level - 1][q] = m->greatest / scale;
            out->level[level] = stp_max(out->level[level], out->quarter[level - 1][q]);
        }
    }
    m->greatest = out->level[2] * scale;
    measure_level(m, chunk, 3, 0);
    out->level[3] = m->greatest / scale;
}

static bool exceeds_stored(measure *m, const stp_chunk *chunk, uint32_t p)
{
    const stp_patch *patch = &chunk->patches[p];
    take_patch(m, patch);
    for (int level = 1; level < STP_LEVEL_COUNT; level++)
        for (unsigned q = 0; q < (level == 3 ? 1 : patch->counts[2]) && !m->exceeded; q++) {
            m->greatest = stp_error_held(stp_quarter_tangential_error(patch, level, q), patch) *
                          m->grid->scale;
            measure_level(m, chunk, level, q);
        }
    return m->exceeded;
}

/* What all patches of a chunk are measured with: rows, or cells and hints. */
typedef struct ground {
    stp_disc_grid grid;
    stp_disc_hints hints;
    stp_disc_rows rows; /* never to check */
} ground;

static stp_status ground_create(ground *out, const stp_chunk *chunk, const stp_carry *carry,
                                const stp_surroundings *around, bool check, stp_error *err)
{
    stp_status status = STP_OK;
    *out = (ground){0};
    STP_TRY(stp_disc_grid_create(&out->grid, chunk, carry, around, err));
    if (!check)
        STP_TRY(stp_disc_rows_create(&out->rows, &out->grid, err));
    if (out->rows.columns > 0)
        return STP_OK;
    STP_TRY(stp_disc_grid_fill(&out->grid, err));
    STP_TRY(stp_disc_hints_create(&out->hints, out->grid.numbers, out->grid.count, out->grid.radius,
                                  err));
done:
    return status;
}

static void ground_clear(ground *g)
{
    stp_disc_rows_clear(&g->rows);
    stp_disc_hints_clear(&g->hints);
    stp_disc_grid_clear(&g->grid);
}

static stp_overhang stored_overhang(const stp_patch *patch)
{
    stp_overhang out = {0};
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        out.level[l] = stp_error_decode(patch->tangential_error[l], patch->exponent);
    for (int l = 0; l < 2; l++)
        for (int q = 0; q < STP_PATCH_QUARTERS; q++)
            out.quarter[l][q] =
                stp_error_decode(patch->quarter_tangential_error[l][q], patch->exponent);
    return out;
}

typedef struct measuring {
    stp_overhang *out;
    const stp_chunk *chunk;
    const ground *ground;
} measuring;

/* A stp_pool_task: measures the patches of a share. */
static stp_status measure_share(void *context, size_t share, unsigned worker, stp_error *err)
{
    const measuring *of = context;
    const ground *g = of->ground;
    const stp_chunk *chunk = of->chunk;
    measure m = {.grid = &g->grid, .hints = &g->hints, .rows = &g->rows};
    const size_t end = (share + 1) * SHARE_PATCHES;
    (void)worker;
    (void)err;
    for (size_t p = share * SHARE_PATCHES; p < end && p < chunk->patch_count; p++)
        if (chunk->patches[p].flags & STP_PATCH_SHAPES)
            of->out[p] = stored_overhang(&chunk->patches[p]);
        else
            measure_patch(&of->out[p], &m, chunk, (uint32_t)p);
    return STP_OK;
}

stp_status stp_overhang_measure(stp_overhang *out, const stp_chunk *chunk, const stp_carry *carry,
                                const stp_surroundings *around, stp_pool *pool, stp_error *err)
{
    ground g;
    measuring of = {out, chunk, &g};
    stp_status status = ground_create(&g, chunk, carry, around, false, err);
    const size_t shares = (chunk->patch_count + SHARE_PATCHES - 1) / SHARE_PATCHES;
    if (status == STP_OK && pool)
        status = stp_pool_run(pool, shares, measure_share, &of, err);
    for (size_t i = 0; status == STP_OK && !pool && i < shares; i++)
        (void)measure_share(&of, i, 0, NULL);
    ground_clear(&g);
    return status;
}

stp_status stp_overhang_check(uint32_t *patch, const stp_chunk *chunk,
                              const stp_surroundings *around, stp_error *err)
{
    ground g;
    stp_status status = ground_create(&g, chunk, NULL, around, true, err);
    measure m = {.grid = &g.grid, .hints = &g.hints, .rows = &g.rows, .check = true};
    uint32_t found = STP_CHUNK_NONE;
    for (uint32_t p = 0; status == STP_OK && p < chunk->patch_count && found == STP_CHUNK_NONE; p++)
        if (!(chunk->patches[p].flags & STP_PATCH_SHAPES) && exceeds_stored(&m, chunk, p))
            found = p;
    if (status == STP_OK)
        *patch = found;
    ground_clear(&g);
    return status;
}
