/* Measures how much given normals differ between near and between farther points; averages them. */
#include "preprocess/surface/given_normals.h"

#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/nearest_list.h"

#include <stdlib.h>

/* Runs of sorted points that are measured, evenly spread, and the points of each. */
#define RUNS 64u
#define RUN_POINTS 512u
/* A point's neighbours by distance: [0, NEAR_END) are near, [FAR_BEGIN, FAR_END) are farther. */
#define NEAR_END 4u
#define FAR_BEGIN 8u
#define FAR_END 16u
/* Cap of a squared difference: an edge is not noise. */
#define MOST_SQUARED 0.2f
/* Noisy if the sum of squared near differences is at least this part of that of farther ones. True
 * normals of the generated surfaces have 0.2 to 0.25, ten overlapping range scans 0.8. */
#define NOISY_RATIO 0.5f
/* The mean squared near difference, twice the square of the angle, must also be in this range: from
 * 2 degrees of noise (quantised normals) to 20 degrees (no normals of a surface). */
#define LEAST_NEAR 0.00244f
#define MOST_NEAR 0.244f
/* Normals are averaged if their cosine to the mean is at least this, */
#define LIKE 0.9f
/* and their points' height over the plane is at most BESIDE spacings. DECAY: weight falls with the
 * squared distance in spacings. */
#define BESIDE 1.0f
#define DECAY 0.25f
#define ROUNDS 2u

typedef struct run_sums {
    float near, far;
} run_sums;

static float squared_difference(const stp_cloud_point *a, const stp_cloud_point *b)
{
    return fminf(glms_vec3_norm2(glms_vec3_sub(a->normal, b->normal)), MOST_SQUARED);
}

/* Adds the differences between a point and its nearest points of the run. */
static void add_point(run_sums *sums, const stp_cloud_point *run, uint32_t count, uint32_t self)
{
    double distances[FAR_END];
    uint32_t nearest[FAR_END], found = 0;
    for (uint32_t i = 0; i < count; i++) {
        stp_dvec3 d = stp_dvec3_sub(run[i].position, run[self].position);
        double squared = stp_dvec3_dot(d, d);
        if (i == self || !stp_has_normal(&run[i]) ||
            (found == FAR_END && squared >= distances[FAR_END - 1]))
            continue;
        uint32_t at = found < FAR_END ? found++ : FAR_END - 1;
        for (; at > 0 && distances[at - 1] > squared; at--) {
            distances[at] = distances[at - 1];
            nearest[at] = nearest[at - 1];
        }
        distances[at] = squared;
        nearest[at] = i;
    }
    if (found < FAR_END)
        return;
    for (uint32_t i = 0; i < NEAR_END; i++)
        sums->near += squared_difference(&run[self], &run[nearest[i]]) / (float)NEAR_END;
    for (uint32_t i = FAR_BEGIN; i < FAR_END; i++)
        sums->far +=
            squared_difference(&run[self], &run[nearest[i]]) / (float)(FAR_END - FAR_BEGIN);
}

/* Whether the run's normals differ as noisy ones do. */
static bool run_noisy(const stp_cloud_point *run, uint32_t count)
{
    run_sums sums = {0.0f, 0.0f};
    for (uint32_t i = 0; i < count; i++) {
        if (run[i].given == STP_GIVEN_INPUT && stp_has_normal(&run[i]))
            add_point(&sums, run, count, i);
    }
    float mean = sums.near / (float)count;
    return mean >= LEAST_NEAR && mean <= MOST_NEAR && sums.near >= NOISY_RATIO * sums.far;
}

stp_status stp_given_noisy(stp_cloud *cloud, bool *out, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_rank_part own = stp_cloud_own(cloud);
    const uint64_t step = cloud->count / RUNS;
    const uint32_t length = step < RUN_POINTS ? (uint32_t)step : RUN_POINTS;
    uint64_t noisy = 0;
    *out = false;
    if (length <= 2 * FAR_END)
        return STP_OK;
    for (uint64_t i = cloud->first, r = 0; r < RUNS; r++, i += step)
        if (i >= own.begin && i < own.end) /* a run may end at another rank */
            (void)(stp_cloud_has(cloud, i) & stp_cloud_has(cloud, i + length - 1));
    STP_TRY(stp_cloud_fetch(cloud, err));
    for (uint64_t i = cloud->first, r = 0; r < RUNS; r++, i += step)
        if (i >= own.begin && i < own.end)
            noisy += run_noisy(cloud->points + i, length);
    STP_TRY(stp_cloud_sum(cloud, &noisy, 1, err));
    *out = 2 * noisy > RUNS;
done:
    return status;
}

/* The mean of those normals of the point and its neighbours that are near a direction; the
 * direction itself if there are none. */
static vec3s mean_near(const stp_unit *unit, uint32_t self, vec3s direction, unsigned count)
{
    const stp_cloud_point *points = unit->cloud.points;
    const uint32_t *list = unit->neighbours.indices + (size_t)self * unit->neighbours.k;
    const float scale = 1.0f / points[self].spacing;
    vec3s sum = {{0.0f, 0.0f, 0.0f}};
    for (unsigned i = 0; i <= count; i++) {
        const stp_cloud_point *other = &points[i < count ? list[i] : self];
        stp_dvec3 between = stp_dvec3_sub(other->position, points[self].position);
        vec3s d = glms_vec3_scale(stp_dvec3_to_float(between), scale);
        float weight = glms_vec3_dot(direction, other->normal) - LIKE;
        if (other->given && weight > 0.0f && fabsf(glms_vec3_dot(direction, d)) <= BESIDE)
            sum = glms_vec3_muladds(other->normal, weight * expf(-DECAY * glms_vec3_norm2(d)), sum);
    }
    return glms_vec3_norm2(sum) > 0.0f ? glms_vec3_normalize(sum) : direction;
}

/* Averages a normal. Begins with the mean of all normals on its side, so that a normal that is far
 * off does not choose others like itself. */
static vec3s average(const stp_unit *unit, uint32_t self)
{
    const stp_cloud_point *points = unit->cloud.points;
    const uint32_t *list = unit->neighbours.indices + (size_t)self * unit->neighbours.k;
    vec3s own = points[self].normal, sum = own;
    unsigned count = 0;
    for (; count < unit->neighbours.k && list[count] != STP_NEIGHBOUR_NONE; count++) {
        const stp_cloud_point *other = &points[list[count]];
        if (other->given && glms_vec3_dot(own, other->normal) > 0.0f)
            sum = glms_vec3_add(sum, other->normal);
    }
    sum = glms_vec3_normalize(sum);
    for (unsigned round = 0; round < ROUNDS; round++)
        sum = mean_near(unit, self, sum, count);
    return sum;
}

void stp_given_average(vec3s *out, const stp_unit *unit)
{
    const stp_cloud_point *points = unit->cloud.points;
    for (uint32_t i = 0; i < unit->ring_end[0]; i++) {
        bool averaged = points[i].given == STP_GIVEN_INPUT && stp_has_normal(&points[i]) &&
                        points[i].spacing > 0.0f;
        out[i] = averaged ? average(unit, i) : points[i].normal;
    }
}
