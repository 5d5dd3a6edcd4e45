/* Puts discs into voxels, floods the outside, and classifies each point. */
#include "preprocess/closed/enclosure.h"

#include "base/memory.h"
#include "base/wide.h"
#include "preprocess/closed/openings.h"
#include "preprocess/closed/voxel_share.h"
#include "preprocess/cloud/cloud_blocks.h"

#include <stdatomic.h>
#include <stdlib.h>

/* Side of a voxel in median spacings: the wanted one and the largest. */
#define VOXEL_SPACINGS 1.5
#define VOXEL_SPACINGS_MOST 2.5
/* Growth of the side from one try to the next. */
#define VOXEL_GROWTH 1.2
/* Larger models are seen as scans of a quarter of the points, whose discs and voxels are twice as
 * large: a random scan of so many more points has more gaps than can be listed, though all are
 * small. Those of RETRY_SHARE times as many points, too, if their openings are too many. */
#define FINE_POINTS (UINT64_C(1) << 25)
#define RETRY_SHARE 0.125
/* Empty voxels around the box: discs reach beyond their centres. */
#define MARGIN 8
/* The blocks of voxels that a model may have: the least number, and one more for so many points. So
 * the voxels' size depends on the model alone, not on memory. Five sets of bits (occupied, outside,
 * and three while openings are sealed) take 40 bytes a point then; surfaces have a block for 700 to
 * 2000 points. */
#define VOXEL_BLOCKS_LEAST 4096u
#define VOXEL_BLOCK_POINTS 512u
/* Voxels. A disc with a greater radius closes nothing: it would cost too much. */
#define RADIUS_LIMIT 48.0
/* Voxels. How far from a point its open voxels are looked for. */
#define REACH 8.0
/* Voxels. The farthest open voxel beside a single layer of discs. */
#define LAYER 1.5
/* Voxels. How much farther the second layer must be than the first to decide a guessed sign. */
#define LAYER_EXCESS 1.0
/* Most cubes along the longest side of the coarse grid. */
#define COARSE_LIMIT 48
/* A smaller scan is fast to draw whole, and the gaps at its edges are many pixels wide. */
#define POINTS_LEAST 32768u
/* If a smaller share of the points is closed, the gain is not worth the cost. */
#define CLOSED_SHARE 0.05
/* A model is closed if more than this share of its points is. */
#define CLOSED_MODEL_SHARE 0.5
/* Voxels. If the model is not closed, openings up to 2 reach + 1 voxels wide are sealed, small
 * reaches first. A cube that is larger than needed does not fit into thin parts or narrow gaps
 * either, so more is taken for an opening. */
static const int seal_reaches[] = {1, STP_VOXEL_REACH_MOST};
#define BLOCK_POINTS 65536u
#define MEDIAN_POINTS 65536u
/* About how many points tell whether a model is closed. */
#define JUDGED_POINTS 65536u

typedef struct enclosing {
    stp_cloud *cloud;
    const stp_enclosure_params *params;
    stp_voxel_grid grid;
    stp_dvec3 origin;
    double scale;        /* of discs; a power of two */
    double voxel;        /* side, world units */
    bool too_many;       /* openings */
    double closed_share; /* of the points judged; 0 if openings are too many */
    bool known_closed;   /* most points are closed */
    atomic_uint_fast64_t closed_count;
    stp_rank_part own; /* points that this rank looks at */
} enclosing;

static int compare_floats(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The median spacing of points spread over the cloud. */
static stp_status median_spacing(const stp_cloud *cloud, double *out, stp_error *err)
{
    uint32_t listed = 0, count = 0;
    float *spacings = NULL;
    stp_cloud_point *points = NULL;
    stp_status status = STP_OK;
    STP_TRY(stp_cloud_every(cloud, (cloud->count - 1) / MEDIAN_POINTS + 1, &points, &listed, err));
    STP_TRY(stp_alloc(&spacings, listed, sizeof *spacings, "spacings", err));
    for (uint32_t i = 0; i < listed; i++)
        if (points[i].spacing > 0.0f)
            spacings[count++] = points[i].spacing;
    qsort(spacings, count, sizeof *spacings, compare_floats);
    *out = count > 0 ? (double)spacings[count / 2] : 0.0;
done:
    free(points);
    free(spacings);
    return status;
}

/* A point's disc in voxels. */
typedef struct voxel_disc {
    double centre[3], normal[3], radius;
} voxel_disc;

static inline voxel_disc disc_of(const enclosing *e, uint64_t i)
{
    const stp_cloud_point *p = &e->cloud->points[i];
    stp_dvec3 c = stp_dvec3_scale(stp_dvec3_sub(p->position, e->origin), 1.0 / e->voxel);
    double radius = e->scale * e->params->lambda * (double)p->spacing / e->voxel;
    bool flat = stp_has_normal(p) && radius <= RADIUS_LIMIT;
    return (voxel_disc){{c.x, c.y, c.z},
                        {(double)p->normal.x, (double)p->normal.y, (double)p->normal.z},
                        flat ? radius : 0.0};
}

/* A pass over those of this rank's points that are a multiple of stride after the first one, in
 * tasks of BLOCK_POINTS points. */
typedef struct pass {
    enclosing *e;
    void (*look)(enclosing *, uint64_t point);
    uint64_t stride;
} pass;

static stp_status look_at_block(void *context, size_t index, unsigned worker, stp_error *err)
{
    const pass *p = context;
    const uint64_t begin = p->e->own.begin + (uint64_t)index * BLOCK_POINTS;
    const uint64_t left = p->e->own.end - begin, first = p->e->cloud->first;
    const uint64_t end = begin + (left < BLOCK_POINTS ? left : BLOCK_POINTS);
    (void)worker;
    (void)err;
    for (uint64_t i = first + (begin - first + p->stride - 1) / p->stride * p->stride; i < end;
         i += p->stride)
        p->look(p->e, i);
    return STP_OK;
}

static stp_status look_at_every(enclosing *e, uint64_t stride, void (*look)(enclosing *, uint64_t),
                                stp_pool *pool, stp_error *err)
{
    pass p = {e, look, stride};
    const size_t points = e->own.end - e->own.begin;
    return stp_cloud_run(e->cloud, pool, (points + BLOCK_POINTS - 1) / BLOCK_POINTS, look_at_block,
                         &p, err);
}

static stp_status look_at_own(enclosing *e, void (*look)(enclosing *, uint64_t), stp_pool *pool,
                              stp_error *err)
{
    return look_at_every(e, 1, look, pool, err);
}

STP_WIDE
static void claim(enclosing *e, uint64_t point)
{
    voxel_disc d = disc_of(e, point);
    int low[3], high[3];
    for (int i = 0; i < 3; i++) {
        double reach = d.radius * sqrt(stp_max(0.0, 1.0 - d.normal[i] * d.normal[i])) + 1.5;
        reach += STP_VOXEL_REACH_MOST;
        low[i] = (int)floor(d.centre[i] - reach);
        high[i] = (int)floor(d.centre[i] + reach);
    }
    stp_voxel_grid_claim(&e->grid, low, high);
}

/* Marks the voxels that the disc's plane meets and whose centres project into the disc. Goes column
 * by column along the axis that is nearest to the normal. */
STP_WIDE
static void rasterise(enclosing *e, uint64_t point)
{
    voxel_disc d = disc_of(e, point);
    const double *n = d.normal;
    int home[3];
    for (int i = 0; i < 3; i++)
        home[i] = (int)floor(d.centre[i]);
    stp_voxel_grid_mark(&e->grid, home[0], home[1], home[2]);
    if (d.radius == 0.0)
        return;
    int c = fabs(n[0]) > fabs(n[1]) ? (fabs(n[0]) > fabs(n[2]) ? 0 : 2)
                                    : (fabs(n[1]) > fabs(n[2]) ? 1 : 2);
    int a = (c + 1) % 3, b = (c + 2) % 3;
    double thick = 0.5 * (fabs(n[0]) + fabs(n[1]) + fabs(n[2])) / fabs(n[c]);
    double reach_a = d.radius * sqrt(stp_max(0.0, 1.0 - n[a] * n[a]));
    double reach_b = d.radius * sqrt(stp_max(0.0, 1.0 - n[b] * n[b]));
    for (int i = (int)floor(d.centre[a] - reach_a); i <= (int)floor(d.centre[a] + reach_a); i++)
        for (int j = (int)floor(d.centre[b] - reach_b); j <= (int)floor(d.centre[b] + reach_b);
             j++) {
            double u = i + 0.5 - d.centre[a], v = j + 0.5 - d.centre[b];
            double w = -(n[a] * u + n[b] * v) / n[c];
            if (u * u + v * v + w * w > d.radius * d.radius)
                continue;
            int low = (int)ceil(d.centre[c] + w - thick - 0.5);
            int high = (int)floor(d.centre[c] + w + thick - 0.5);
            for (int k = low; k <= high; k++) {
                int at[3];
                at[a] = i, at[b] = j, at[c] = k;
                stp_voxel_grid_mark(&e->grid, at[0], at[1], at[2]);
            }
        }
}

/* The nearest open voxel on one side of a point. OCCUPIED: none within REACH. */
typedef struct flank {
    stp_voxel voxel;
    double distance; /* voxels */
} flank;

static flank flank_of(const enclosing *e, const voxel_disc *d, double sign)
{
    for (double t = 1.0; t <= REACH; t += 0.5) {
        int at[3];
        for (int i = 0; i < 3; i++)
            at[i] = (int)floor(d->centre[i] + sign * t * d->normal[i]);
        stp_voxel v = stp_voxel_grid_at(&e->grid, at[0], at[1], at[2]);
        if (v != STP_VOXEL_OCCUPIED)
            return (flank){v, t};
    }
    return (flank){STP_VOXEL_OCCUPIED, REACH};
}

/* Whether a point is closed: its front is outside and its back inside. Thin parts have no voxel
 * inside. So if the model is known to be closed, a back that is inside is enough, or a second layer
 * of voxels at the back. If the sign is a guess, more is asked for: both sides must show it. */
static bool is_closed(const enclosing *e, flank front, flank back)
{
    bool beside = front.voxel == STP_VOXEL_OUTSIDE && back.voxel == STP_VOXEL_OUTSIDE;
    double excess = back.distance - front.distance;
    if (front.voxel == STP_VOXEL_OUTSIDE && back.voxel == STP_VOXEL_INSIDE)
        return true;
    if (!e->known_closed)
        return false;
    if (e->params->guessed)
        return beside && front.distance <= LAYER && excess >= LAYER_EXCESS;
    return back.voxel == STP_VOXEL_INSIDE ||
           (beside && front.distance <= LAYER && back.distance > LAYER);
}

typedef enum verdict { VERDICT_OPEN, VERDICT_CLOSED, VERDICT_CLOSED_TURNED } verdict;

STP_WIDE
static verdict verdict_on(const enclosing *e, uint64_t point)
{
    const voxel_disc d = disc_of(e, point);
    const double sign = e->cloud->marks[point] & STP_MARK_TURNED ? -1.0 : 1.0;
    if (d.radius == 0.0)
        return VERDICT_OPEN;
    const flank front = flank_of(e, &d, sign), back = flank_of(e, &d, -sign);
    if (is_closed(e, front, back))
        return VERDICT_CLOSED;
    return e->params->guessed && is_closed(e, back, front) ? VERDICT_CLOSED_TURNED : VERDICT_OPEN;
}

static void judge(enclosing *e, uint64_t point)
{
    if (verdict_on(e, point) != VERDICT_OPEN)
        atomic_fetch_add_explicit(&e->closed_count, 1, memory_order_relaxed);
}

static void unmark(enclosing *e, uint64_t point)
{
    uint8_t *mark = &e->cloud->marks[point];
    *mark &= (uint8_t) ~(STP_MARK_CLOSED | (e->params->guessed ? STP_MARK_ORIENTED : 0u));
}

static void classify(enclosing *e, uint64_t point)
{
    const verdict found = verdict_on(e, point);
    unmark(e, point);
    if (found == VERDICT_OPEN)
        return;
    e->cloud->marks[point] |= STP_MARK_CLOSED | STP_MARK_ORIENTED;
    e->cloud->marks[point] ^= found == VERDICT_CLOSED_TURNED ? STP_MARK_TURNED : 0u;
    atomic_fetch_add_explicit(&e->closed_count, 1, memory_order_relaxed);
}

/* Sets the blocks along each axis. False if there are too many. */
static bool measure(enclosing *e, int blocks[3])
{
    const stp_dbox *box = &e->cloud->box;
    const double sides[3] = {box->max.x - box->min.x, box->max.y - box->min.y,
                             box->max.z - box->min.z};
    double margin = MARGIN * e->voxel;
    e->origin = stp_dvec3_sub(box->min, (stp_dvec3){margin, margin, margin});
    for (int i = 0; i < 3; i++) {
        double count = ceil((sides[i] / e->voxel + 2 * MARGIN + 1) / STP_VOXEL_BLOCK);
        if (!(count <= STP_VOXEL_BLOCKS_LIMIT))
            return false;
        blocks[i] = (int)count;
    }
    return true;
}

/* As how many points the model is seen. */
static double points_seen(const enclosing *e)
{
    return (double)e->cloud->count / (e->scale * e->scale);
}

/* Makes a grid whose voxels fit the spacing and whose blocks are not too many. *found is false if
 * there is none. */
static stp_status fit_grid(enclosing *e, stp_pool *pool, bool *found, stp_error *err)
{
    stp_status status = STP_OK;
    double spacing = 0.0;
    const uint64_t most = VOXEL_BLOCKS_LEAST + (uint64_t)points_seen(e) / VOXEL_BLOCK_POINTS;
    *found = false;
    if (e->cloud->count < POINTS_LEAST)
        return STP_OK;
    STP_TRY(median_spacing(e->cloud, &spacing, err));
    if (!(spacing > 0.0))
        return STP_OK;
    for (double s = VOXEL_SPACINGS; s <= VOXEL_SPACINGS_MOST && !*found; s *= VOXEL_GROWTH) {
        int blocks[3];
        e->voxel = s * e->scale * spacing;
        if (!measure(e, blocks))
            continue;
        STP_TRY(stp_voxel_grid_create(&e->grid, blocks, e->cloud->spill, pool, err));
        STP_TRY(look_at_own(e, claim, pool, err));
        STP_TRY(stp_voxel_share_claims(&e->grid, e->params->ranks, err));
        *found = stp_voxel_grid_claimed(&e->grid) <= most;
        if (!*found)
            stp_voxel_grid_clear(&e->grid);
    }
    if (*found)
        STP_TRY(stp_voxel_grid_make(&e->grid, err));
done:
    return status;
}

/* Sets the cubes of 2^n voxels in which an eye is outside. */
static stp_status find_outside(const enclosing *e, stp_outside *out, stp_error *err)
{
    int side = 1, most = 0;
    for (int i = 0; i < 3; i++)
        most = e->grid.blocks[i] > most ? e->grid.blocks[i] : most;
    while (side < STP_VOXEL_BLOCK && most * STP_VOXEL_BLOCK / side > COARSE_LIMIT)
        side *= 2;
    for (int i = 0; i < 3; i++)
        out->cells[i] = e->grid.blocks[i] * STP_VOXEL_BLOCK / side;
    out->origin = e->origin;
    out->cell = side * e->voxel;
    size_t count = (size_t)out->cells[0] * (size_t)out->cells[1] * (size_t)out->cells[2];
    stp_status status = stp_alloc(&out->outside, count, 1, "a grid", err);
    for (size_t i = 0; status == STP_OK && i < count; i++) {
        int x = (int)(i % (size_t)out->cells[0]);
        int y = (int)(i / (size_t)out->cells[0] % (size_t)out->cells[1]);
        int z = (int)(i / (size_t)out->cells[0] / (size_t)out->cells[1]);
        out->outside[i] = stp_voxel_grid_clear_of(&e->grid, x * side, y * side, z * side, side);
    }
    return status;
}

/* Adds up what the ranks counted. */
static stp_status sum_closed(enclosing *e, stp_error *err)
{
    uint64_t count = atomic_load(&e->closed_count);
    const stp_status status = stp_ranks_sum(e->params->ranks, &count, 1, err);
    atomic_store(&e->closed_count, count);
    return status;
}

/* Judges by points spread over the cloud whether the model is closed. */
static stp_status judge_model(enclosing *e, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t stride = (e->cloud->count - 1) / JUDGED_POINTS + 1;
    const uint64_t judged = (e->cloud->count - 1) / stride + 1;
    atomic_store(&e->closed_count, 0);
    STP_TRY(look_at_every(e, stride, judge, pool, err));
    STP_TRY(sum_closed(e, err));
    e->closed_share = (double)atomic_load(&e->closed_count) / (double)judged;
done:
    return status;
}

/* Gives each rank's marks to all, if all have all points. */
static stp_status share_marks(const enclosing *e, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud *cloud = e->cloud;
    stp_ranks *ranks = e->params->ranks;
    const bool wanted = stp_ranks_count(ranks) > 1 && !cloud->blocks;
    for (unsigned rank = 0; wanted && rank < ranks->count; rank++) {
        const stp_rank_part part = stp_cloud_part(cloud, ranks, rank);
        for (uint64_t at = part.begin, size; at < part.end; at += size) {
            size = part.end - at < BLOCK_POINTS ? part.end - at : BLOCK_POINTS;
            stp_spill_relieve(cloud->spill);
            STP_TRY(stp_ranks_broadcast(ranks, rank, cloud->marks + at, size, err));
        }
    }
done:
    return status;
}

/* Seals openings, if they are few enough to be listed. */
static stp_status seal(enclosing *e, int reach, stp_outside *out, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    bool sealed = false;
    size_t count = 0;
    stp_opening openings[STP_OPENINGS_LIMIT];
    stp_outside_clear(out);
    e->closed_share = 0.0;
    STP_TRY(stp_voxel_grid_seal(&e->grid, reach, &sealed, err));
    if (sealed)
        STP_TRY(stp_openings_find(&e->grid, openings, &count, err));
    e->too_many = sealed && count > STP_OPENINGS_LIMIT;
    if (!sealed || e->too_many)
        goto done;
    STP_TRY(judge_model(e, pool, err));
    STP_TRY(stp_alloc(&out->openings, count, sizeof *out->openings, "openings", err));
    for (size_t i = 0; i < count; i++)
        out->openings[i] =
            (stp_opening){stp_dvec3_add(e->origin, stp_dvec3_scale(openings[i].centre, e->voxel)),
                          e->voxel * openings[i].radius};
    out->opening_count = (uint32_t)count;
done:
    return status;
}

/* Floods a grid, and seals openings until the model is closed. False if no grid fits. */
static stp_status enclose(enclosing *e, stp_outside *found, stp_pool *pool, bool *fits,
                          stp_error *err)
{
    stp_status status = STP_OK;
    e->too_many = false;
    STP_TRY(fit_grid(e, pool, fits, err));
    if (!*fits)
        goto done;
    STP_TRY(look_at_own(e, rasterise, pool, err));
    STP_TRY(stp_voxel_share_occupied(&e->grid, e->params->ranks, err));
    STP_TRY(stp_voxel_grid_flood(&e->grid, e->grid.occupied, err));
    STP_TRY(judge_model(e, pool, err));
    for (size_t i = 0;
         i < sizeof seal_reaches / sizeof *seal_reaches && e->closed_share < CLOSED_MODEL_SHARE;
         i++)
        STP_TRY(seal(e, seal_reaches[i], found, pool, err));
    e->known_closed = e->closed_share >= CLOSED_MODEL_SHARE;
done:
    return status;
}

/* The same with larger discs, as long as the openings are too many and the points enough. */
static stp_status enclose_any(enclosing *e, stp_outside *found, stp_pool *pool, bool *fits,
                              stp_error *err)
{
    const uint64_t given = e->params->fine_points;
    const double fine = given > 0 ? (double)given : (double)FINE_POINTS;
    for (e->scale = 1.0; points_seen(e) > fine;)
        e->scale *= 2.0;
    for (;;) {
        const stp_status status = enclose(e, found, pool, fits, err);
        if (status != STP_OK || !e->too_many || points_seen(e) < RETRY_SHARE * fine)
            return status;
        stp_voxel_grid_clear(&e->grid);
        e->scale *= 2.0;
    }
}

stp_status stp_enclosure_find(stp_outside *out, stp_cloud *cloud,
                              const stp_enclosure_params *params, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_outside found = {0};
    enclosing e = {.cloud = cloud,
                   .params = params,
                   .own = cloud->blocks ? stp_cloud_own(cloud)
                                        : stp_cloud_part(cloud, params->ranks,
                                                         params->ranks ? params->ranks->self : 0)};
    bool fits = false;
    STP_TRY(enclose_any(&e, &found, pool, &fits, err));
    if (fits) {
        atomic_store(&e.closed_count, 0);
        if (e.closed_share >= CLOSED_SHARE / 2.0) { /* else surely fewer than CLOSED_SHARE are */
            STP_TRY(look_at_own(&e, classify, pool, err));
            STP_TRY(sum_closed(&e, err));
        }
    }
    found.point_count = atomic_load(&e.closed_count);
    if ((double)found.point_count < CLOSED_SHARE * (double)cloud->count) {
        stp_outside_clear(&found);
        STP_TRY(look_at_own(&e, unmark, pool, err));
    }
    STP_TRY(share_marks(&e, err));
    if (found.point_count > 0)
        STP_TRY(find_outside(&e, &found, err));
    *out = found;
    found = (stp_outside){0};
done:
    stp_voxel_grid_clear(&e.grid);
    stp_outside_clear(&found);
    return status;
}
