/* Normals from neighbourhoods. */
#include "preprocess/surface/normals.h"

#include "base/ahead.h"
#include "base/memory.h"
#include "base/wide.h"
#include "preprocess/cloud/nearest_list.h"
#include "preprocess/surface/layer.h"
#include "preprocess/surface/neighbour_columns.h"
#include "preprocess/surface/spacing.h"

#include <stdlib.h>
#include <string.h>

/* A second sheet has at least this many neighbours. */
#define LAYER_POINTS 4u
/* If the noise is less than this part of the spacing, the nearest neighbours are enough. */
#define QUIET 0.04f
/* A plane is widened once if the noise is more than QUIET, and again if it is more than NOISY, as
 * where scans overlap. Each time it takes in about as many points again. */
#define NOISY 0.12f
#define ROUNDS 2u
/* A neighbour's plane joins if 1 - cosine of the angle is below `slack` and its height is at most
 * `reach`. With the deviation of the noise in spacings, s:
 *
 *     slack = max(min(LEAST_SLACK + SLACK s^2, MOST_SLACK), LEAST_SLACK + LOUD_SLACK s^2)
 *     reach = LEAST_REACH + REACH s, in spacings
 *
 * Noise turns planes, so slack grows with it. */
#define LEAST_SLACK 0.1f
#define SLACK 2.05f
/* Beyond MOST_SLACK the rim of a thin sheet would join its sides. LOUD_SLACK is for noise so strong
 * that it alone turns planes that far. */
#define MOST_SLACK 0.5f
#define LOUD_SLACK 0.7f
#define LEAST_REACH 0.5f
#define REACH 3.0f
/* r is the variance of heights over a wide plane, divided by that over narrow ones. If r <= EXCESS,
 * the wide plane is taken. If r >= MOST_EXCESS, it is not: there is a crease, or curvature. Between
 * them the two are mixed. */
#define EXCESS 1.4f
#define MOST_EXCESS 2.1f
/* The same above NOISY. Few points of overlapping scans lie on one layer, so a narrow plane sees
 * less of the distance between layers than a wide one. */
#define NOISY_EXCESS 3.0f
#define MOST_NOISY_EXCESS 4.0f
/* NOISY_EXCESS and MOST_NOISY_EXCESS hold only if 1 - cosine of the angle between wide and narrow
 * plane is at most this times the variance of the narrow plane's heights / spacing^2. Folds turn
 * planes more. */
#define MOST_TURN 0.3f
/* A point moves to its plane if its height is at most this many spacings plus REACH times the
 * noise. Noise is measured within layers, and overlapping layers lie farther apart. */
#define JOIN_REACH 2.0f

/* The plane near a point: a line of the cache. */
typedef struct plane {
    float sums[STP_MOMENT_SUMS]; /* of its own sheet's points; lengths times estimation.scale */
    vec3s normal;
    float variance; /* of the heights over the first plane */
    float noise;    /* variance of the noise, if wide */
    uint8_t wide;   /* STP_MARK_WIDE or STP_MARK_WIDEST: has more than the nearest neighbours */
} plane;

_Static_assert(sizeof(plane) == 64, "a line of the cache");

/* A point's plane after a round of growth. */
typedef struct grown_plane {
    plane plane;
    uint32_t point;
} grown_plane;

typedef struct estimation {
    const stp_unit *unit;
    const stp_cloud *cloud;
    const stp_neighbours *neighbours;
    double scale;              /* factor of lengths, so that floats hold their squares */
    plane *planes, *unaligned; /* unaligned: their memory */
    grown_plane *grown;        /* of this round: few, if there is little noise */
    size_t grown_count, grown_capacity;
    vec3s *normals; /* as fitted */
    float *roundness;
} estimation;

static stp_moments moments_of(const float s[STP_MOMENT_SUMS])
{
    return (stp_moments){{{s[0], s[1], s[2], s[6]},
                          {s[1], s[3], s[4], s[7]},
                          {s[2], s[4], s[5], s[8]},
                          {s[6], s[7], s[8], s[9]}}};
}

static stp_float4 place_of(const estimation *e, uint32_t other, uint32_t self)
{
    const stp_cloud_point *points = e->cloud->points;
    stp_dvec3 d =
        stp_dvec3_scale(stp_dvec3_sub(points[other].position, points[self].position), e->scale);
    return stp_moments_place((float)d.x, (float)d.y, (float)d.z);
}

/* Collects moments relative to the point itself. with_self: the point is one of them. */
static stp_moments collect(const estimation *e, uint32_t self, const uint32_t *list, unsigned count,
                           bool with_self)
{
    stp_moments m = {{{0}}};
    m.row[3][3] = with_self ? 1.0f : 0.0f;
    for (unsigned i = 0; i < count; i++)
        stp_moments_add_point(&m, place_of(e, list[i], self));
    return m;
}

/* The least variance of heights of `count` points and the point itself if enough of them for a
 * second sheet lie beyond a gap. It is least if those are all on one side, and are LAYER_POINTS or
 * all but LAYER_POINTS. */
static float two_sheet_variance(unsigned count, float gap)
{
    float n = (float)count + 1.0f, beyond = LAYER_POINTS;
    return 0.999f * gap * gap * beyond * (n - beyond) / (n * n);
}

/* A point's neighbours, and a lane of columns with their places. */
typedef struct neighbourhood {
    const uint32_t *list;
    unsigned count, lane;
    const float (*places)[3][STP_MOMENTS_LANES];
} neighbourhood;

/* If the neighbours lie on two sheets, fits one direction to both, each about its own mean, so that
 * the sheets' distance does not tilt it. Keeps only the own sheet's moments. */
static void part_sheets(plane *f, const estimation *e, uint32_t self, const neighbourhood *n,
                        float gap)
{
    uint32_t same[STP_NEIGHBOURS_LIMIT], others[STP_NEIGHBOURS_LIMIT];
    float heights[STP_NEIGHBOURS_LIMIT];
    unsigned same_count = 0, other_count = 0;
    for (unsigned i = 0; i < n->count; i++) {
        const float(*place)[STP_MOMENTS_LANES] = n->places[i];
        heights[i] = f->normal.x * place[0][n->lane] + f->normal.y * place[1][n->lane] +
                     f->normal.z * place[2][n->lane];
    }
    const stp_layer layer = stp_layer_of(heights, n->count, gap);
    for (unsigned i = 0; i < n->count; i++) { /* no branch: it goes either way */
        const bool holds = stp_layer_holds(layer, heights[i]);
        same[same_count] = others[other_count] = n->list[i];
        same_count += holds;
        other_count += !holds;
    }
    if (same_count < LAYER_POINTS || other_count < LAYER_POINTS)
        return;
    stp_moments own = collect(e, self, same, same_count, true);
    stp_moments other = collect(e, self, others, other_count, false), both = own;
    stp_float4 apart = own.row[3] / own.row[3][3] - other.row[3] / other.row[3][3];
    stp_moments_add(&both, &other, apart + (stp_float4){0.0f, 0.0f, 0.0f, 1.0f}, 1.0f);
    f->normal = stp_moments_normal(&both);
    stp_moments_get(&own, f->sums);
}

/* The plane of the nearest neighbours. */
static plane plane_of(const estimation *e, uint32_t self, const neighbourhood *n,
                      const stp_moment_columns *sums, const stp_moments_plane *fitted)
{
    plane f = {.wide = 0};
    if (n->count < 3)
        return f;
    for (int i = 0; i < STP_MOMENT_SUMS; i++)
        f.sums[i] = sums->of[i][n->lane];
    f.normal = fitted->normal;
    f.variance = fitted->variance;
    stp_float4 last = place_of(e, n->list[n->count - 1], self);
    float squared = last[0] * last[0] + last[1] * last[1] + last[2] * last[2];
    float gap = STP_LAYER_GAP * sqrtf(squared * (float)M_PI / (float)n->count);
    if (f.variance >= two_sheet_variance(n->count, gap))
        part_sheets(&f, e, self, n, gap);
    return f;
}

/* Limits the spacings of the first `count` points, and finds how round their neighbourhoods are
 * and, if wanted, their planes: several at a time. */
static void fit(estimation *e, stp_spacings *spacings, uint32_t count)
{
    stp_neighbour_columns columns;
    const float(*places)[3][STP_MOMENTS_LANES] =
        (const float(*)[3][STP_MOMENTS_LANES])columns.places;
    const unsigned k = e->neighbours->k;
    for (uint32_t first = 0; first < count; first += STP_MOMENTS_LANES) {
        stp_moment_columns sums;
        stp_moments_plane fitted[STP_MOMENTS_LANES];
        const uint32_t left = count - first < STP_MOMENTS_LANES ? count - first : STP_MOMENTS_LANES;
        for (uint32_t i = 0; i < left; i++)
            stp_ask_ahead(e->cloud->points, sizeof *e->cloud->points, first + i);
        stp_neighbour_columns_take(&columns, e->unit, first, first + left, e->scale);
        stp_spacings_limit(spacings, e->unit, &columns, left);
        for (uint32_t i = 0; i < STP_MOMENTS_LANES; i++)
            sums.of[STP_MOMENT_SUMS - 1][i] = (float)columns.counts[i] + 1.0f;
        stp_moments_sum(&sums, places, k);
        stp_moments_fit(&sums, fitted);
        for (uint32_t i = 0; i < left; i++) {
            const neighbourhood n = {e->neighbours->indices + (size_t)(first + i) * k,
                                     columns.counts[i], i, places};
            e->roundness[first + i] = fitted[i].roundness;
            if (e->planes)
                e->planes[first + i] = plane_of(e, first + i, &n, &sums, &fitted[i]);
        }
    }
}

/* Variance of the noise around a point: the harmonic mean of the variances that its neighbours' own
 * planes leave. At creases a plane leaves more, never less, so small ones must count most. The
 * farther half of the neighbours is as good as all. */
static float noise_near(const estimation *e, const uint32_t *list, unsigned count)
{
    const unsigned begin = count / 2;
    float inverse = 0.0f;
    for (unsigned i = begin; i < count; i++)
        inverse += 1.0f / e->planes[list[i]].variance;
    return (float)(count - begin) / inverse;
}

/* Sums as vectors: xx xy xz yy, yz zz and two unused, x y z weight. */
typedef struct sum_vectors {
    stp_float4 of[3];
} sum_vectors;

static inline sum_vectors vectors_of(const float sums[STP_MOMENT_SUMS])
{
    sum_vectors v;
    memcpy(&v.of[0], sums, sizeof v.of[0]);
    memcpy(&v.of[1], sums + 4, sizeof v.of[1]);
    memcpy(&v.of[2], sums + 6, sizeof v.of[2]);
    return v;
}

static stp_moments moments_of_vectors(const sum_vectors *v)
{
    float sums[STP_MOMENT_SUMS];
    memcpy(sums, &v->of[0], sizeof v->of[0]);
    memcpy(sums + 4, &v->of[1], 2 * sizeof *sums);
    memcpy(sums + 6, &v->of[2], sizeof v->of[2]);
    return moments_of(sums);
}

/* Adds, with a weight, sums that were collected at the place d: stp_moments_add without what
 * symmetry repeats. d[3]: 0. */
static inline void add_vectors(sum_vectors *sums, const sum_vectors *other, stp_float4 d,
                               float weight)
{
    const stp_float4 t = other->of[2] + 0.5f * other->of[2][3] * d;
    const stp_float4 d0 = {d[0], d[0], d[0], d[1]};
    const stp_float4 t0 = {t[0], t[0], t[0], t[1]};
    const stp_float4 d1 = {d[0], d[1], d[2], d[1]};
    const stp_float4 t1 = {t[0], t[1], t[2], t[1]};
    const stp_float4 d2 = {d[1], d[2], d[3], d[3]};
    const stp_float4 t2 = {t[1], t[2], t[3], t[3]};
    const stp_float4 d3 = {d[2], d[2], d[3], d[3]};
    const stp_float4 t3 = {t[2], t[2], t[3], t[3]};
    sums->of[0] += weight * (other->of[0] + d0 * t1 + t0 * d1);
    sums->of[1] += weight * (other->of[1] + d2 * t3 + t2 * d3);
    sums->of[2] += weight * (other->of[2] + t[3] * d);
}

/* Adds to a plane the moments of those of the farther half of the neighbours that are on the same
 * piece of surface. */
static stp_moments widen(const estimation *e, uint32_t self, const uint32_t *list, unsigned count,
                         float noise, float spacing)
{
    const vec3s n = e->planes[self].normal;
    const float squared = noise / (spacing * spacing);
    const float slack =
        fmaxf(fminf(LEAST_SLACK + SLACK * squared, MOST_SLACK), LEAST_SLACK + LOUD_SLACK * squared);
    const float reach = LEAST_REACH * spacing + REACH * sqrtf(noise);
    sum_vectors sums = vectors_of(e->planes[self].sums);
    for (unsigned i = count / 2; i < count; i++) {
        const plane *other = &e->planes[list[i]];
        stp_float4 d = place_of(e, list[i], self);
        float cosine = fabsf(glms_vec3_dot(n, other->normal));
        float offset = fabsf(n.x * d[0] + n.y * d[1] + n.z * d[2]);
        float weight = 1.0f - (1.0f - cosine) / slack;
        if (weight > 0.0f && offset <= reach) {
            d[3] = 0.0f;
            const sum_vectors others = vectors_of(other->sums);
            add_vectors(&sums, &others, d, weight);
        }
    }
    return moments_of_vectors(&sums);
}

/* Widens a point's plane by its neighbours' planes if the noise is more than least_noise spacings
 * and the heights of all points over the wide plane are no more than noise. Returns whether it did.
 */
static bool grow(const estimation *e, uint32_t self, float least_noise, plane *out)
{
    const uint32_t *list = e->neighbours->indices + (size_t)self * e->neighbours->k;
    unsigned count = stp_neighbours_known(list, e->neighbours->k);
    float spacing = (float)e->scale * e->cloud->points[self].spacing;
    float quiet = least_noise * least_noise * spacing * spacing, wide = 0.0f;
    plane f = e->planes[self];
    if (!(f.variance > 0.25f * quiet)) /* usually saves asking the neighbours */
        return false;
    float noise = noise_near(e, list, count);
    if (!(noise > quiet))
        return false;
    stp_moments sums = widen(e, self, list, count, noise, spacing);
    vec3s normal = stp_moments_turn(&sums, f.normal, &wide);
    bool noisy = noise > NOISY * NOISY * spacing * spacing &&
                 (1.0f - fabsf(glms_vec3_dot(normal, f.normal))) * spacing * spacing <=
                     MOST_TURN * f.variance;
    float least = noisy ? NOISY_EXCESS : EXCESS, most = noisy ? MOST_NOISY_EXCESS : MOST_EXCESS;
    float share = (most - wide / noise) / (most - least);
    if (!(share > 0.0f))
        return false;
    if (share < 1.0f)
        normal = glms_vec3_normalize(glms_vec3_lerp(f.normal, normal, share));
    f.normal = normal;
    stp_moments_get(&sums, f.sums);
    f.noise = noise;
    f.wide = f.wide ? STP_MARK_WIDEST : STP_MARK_WIDE;
    *out = f;
    return true;
}

/* Grows the planes of the first `count` points, each from its neighbours' planes of before. */
static stp_status grow_all(estimation *e, uint32_t count, float least_noise, stp_error *err)
{
    stp_status status = STP_OK;
    plane wider;
    e->grown_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        stp_ask_ahead(e->planes, sizeof *e->planes, i);
        stp_ask_ahead(e->cloud->points, sizeof *e->cloud->points, i);
        if (!grow(e, i, least_noise, &wider))
            continue;
        STP_TRY(stp_grow(&e->grown, &e->grown_capacity, e->grown_count + 1, sizeof *e->grown,
                         "normals", err));
        e->grown[e->grown_count++] = (grown_plane){wider, i};
    }
    for (size_t i = 0; i < e->grown_count; i++)
        e->planes[e->grown[i].point] = e->grown[i].plane;
done:
    return status;
}

/* Weight of a neighbour's normal. Falls with the angle and with the squared distance in spacings;
 * zero if the offset from the tangent plane is more than one spacing. Negative if the signs
 * disagree. */
static float weight_of(float cosine, float offset, float distance)
{
    float closeness = fabsf(cosine) - 0.9f;
    float beside = fabsf(offset) <= 1.0f ? 10.0f : 0.0f;
    float x = 0.25f * distance; /* e^-x to a thousandth where neighbours lie */
    float decay = 1.0f + x * (1.0f + x * (0.5f + x * (1.0f / 6.0f + x / 24.0f)));
    closeness = closeness > 0.0f ? closeness : 0.0f;
    return copysignf(closeness, cosine) * beside / decay;
}

/* Averages a fitted normal with those of neighbours on the same piece of surface. This removes the
 * noise of a fit over k points without rounding edges. */
STP_WIDE
static vec3s smooth(const estimation *e, uint32_t self)
{
    const stp_cloud *cloud = e->cloud;
    const uint32_t *list = e->neighbours->indices + (size_t)self * e->neighbours->k;
    const stp_cloud_point *point = &cloud->points[self];
    float scale = 1.0f / point->spacing;
    float dx[STP_NEIGHBOURS_LIMIT], dy[STP_NEIGHBOURS_LIMIT], dz[STP_NEIGHBOURS_LIMIT];
    float mx[STP_NEIGHBOURS_LIMIT], my[STP_NEIGHBOURS_LIMIT], mz[STP_NEIGHBOURS_LIMIT];
    unsigned count = stp_neighbours_known(list, e->neighbours->k);
    for (unsigned i = 0; i < count; i++) {
        stp_dvec3 d = stp_dvec3_sub(cloud->points[list[i]].position, point->position);
        vec3s m = e->normals[list[i]];
        dx[i] = (float)d.x * scale, dy[i] = (float)d.y * scale, dz[i] = (float)d.z * scale;
        mx[i] = m.x, my[i] = m.y, mz[i] = m.z;
    }
    vec3s n = e->normals[self];
    for (unsigned i = 0; i < count; i++) { /* by columns, for vector instructions */
        float weight = weight_of(n.x * mx[i] + n.y * my[i] + n.z * mz[i],
                                 n.x * dx[i] + n.y * dy[i] + n.z * dz[i],
                                 dx[i] * dx[i] + dy[i] * dy[i] + dz[i] * dz[i]);
        mx[i] *= weight;
        my[i] *= weight;
        mz[i] *= weight;
    }
    for (unsigned i = 0; i < count; i++)
        n = (vec3s){{n.x + mx[i], n.y + my[i], n.z + mz[i]}};
    return glms_vec3_normalize(n);
}

/* A power of two that scales lengths so that floats hold the squares of all of the cloud's lengths.
 */
static double scale_of(const stp_cloud *whole)
{
    double side = stp_dbox_side(&whole->box);
    return side > 0.0 && isfinite(side) ? ldexp(1.0, -ilogb(side)) : 1.0;
}

static bool all_given(const stp_unit *unit)
{
    uint32_t given = 0;
    while (given < unit->cloud.count && unit->cloud.points[given].given)
        given++;
    return given == unit->cloud.count;
}

/* The shift of a point to its plane. */
static vec3s shift_of(const estimation *e, uint32_t self)
{
    const plane *f = &e->planes[self];
    if (!f->wide || e->cloud->points[self].given == STP_GIVEN_IMAGE)
        return glms_vec3_zero();
    const float *s = f->sums;
    float height =
        f->normal.x * (s[6] / s[9]) + f->normal.y * (s[7] / s[9]) + f->normal.z * (s[8] / s[9]);
    float spacing = (float)e->scale * e->cloud->points[self].spacing;
    if (!(fabsf(height) <= JOIN_REACH * spacing + REACH * sqrtf(f->noise)))
        return glms_vec3_zero();
    return glms_vec3_scale(f->normal, height / (float)e->scale);
}

/* Adds the errors of own normals that are not given. */
static void add_errors(const estimation *e, uint32_t count, stp_normal_errors *errors)
{
    for (uint32_t i = 0; i < count; i++) {
        const plane *f = &e->planes[i];
        const stp_moments sums = moments_of(f->sums);
        if (!e->cloud->points[i].given && sums.row[3][3] > 0.0f)
            stp_normal_errors_add(errors, &sums, f->wide ? f->noise : f->variance);
    }
}

/* Makes room for planes that each lie in one line of the cache. */
static stp_status planes_alloc(estimation *e, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc_unset(&e->unaligned, (size_t)count + 1, sizeof *e->planes, "normals", err));
    const size_t over = (uintptr_t)e->unaligned % sizeof *e->planes;
    e->planes = (plane *)((char *)e->unaligned + (over > 0 ? sizeof *e->planes - over : 0));
done:
    return status;
}

stp_status stp_normals_estimate(stp_unit *unit, vec3s *shifts, stp_normal_errors *errors,
                                stp_error *err)
{
    stp_status status = STP_OK;
    estimation e = {.unit = unit,
                    .cloud = &unit->cloud,
                    .neighbours = &unit->neighbours,
                    .scale = scale_of(unit->whole)};
    stp_spacings spacings = {0};
    stp_cloud_point *points = unit->cloud.points;
    uint32_t count = stp_unit_inner(unit, 1);
    const bool wanted = shifts || !all_given(unit);
    STP_TRY(stp_alloc_unset(&unit->roundness, count, sizeof *unit->roundness, "normals", err));
    e.roundness = unit->roundness;
    if (wanted)
        STP_TRY(planes_alloc(&e, count, err));
    STP_TRY(stp_spacings_create(&spacings, count, err));
    fit(&e, &spacings, count);
    stp_spacings_smooth(&spacings, unit);
    if (!wanted)
        goto done;
    for (unsigned round = 1; round <= ROUNDS; round++) {
        count = stp_unit_inner(unit, 1 + round);
        STP_TRY(grow_all(&e, count, round == 1 ? QUIET : NOISY, err));
    }
    STP_TRY(stp_alloc_unset(&unit->wide, unit->ring_end[0], sizeof *unit->wide, "normals", err));
    for (uint32_t i = 0; i < unit->ring_end[0]; i++)
        unit->wide[i] = points[i].given ? 0 : e.planes[i].wide;
    add_errors(&e, unit->ring_end[0], errors);
    for (uint32_t i = 0; shifts && i < unit->ring_end[0]; i++)
        shifts[i] = shift_of(&e, i);
    STP_TRY(stp_alloc_unset(&e.normals, count, sizeof *e.normals, "normals", err));
    for (uint32_t i = 0; i < count; i++)
        e.normals[i] = points[i].given ? points[i].normal : e.planes[i].normal;
    count = stp_unit_inner(unit, 2 + ROUNDS);
    for (uint32_t i = 0; i < count; i++) {
        stp_ask_ahead(points, sizeof *points, i);
        stp_ask_ahead(e.normals, sizeof *e.normals, i);
        if (points[i].given || glms_vec3_norm2(e.normals[i]) == 0.0f)
            continue;
        points[i].normal = points[i].spacing > 0.0f ? smooth(&e, i) : e.normals[i];
    }
done:
    stp_spacings_clear(&spacings);
    free(e.unaligned);
    free(e.grown);
    free(e.normals);
    return status;
}
