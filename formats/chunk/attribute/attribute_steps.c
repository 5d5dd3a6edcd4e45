/* Finds the steps of a clock's numbers; parts differences by them. */
#include "formats/chunk/attribute/attribute_steps.h"

#include "base/memory.h"
#include "base/sort.h"

#include <math.h>
#include <stdlib.h>

/* Fewer numbers tell no step. */
#define NUMBERS_LEAST 64u
/* A gap of one pulse: one in so many gaps is no greater. Half as many must be near it, within a
 * part of it. Fewer gaps of another tick are chance. */
#define FEW 16u
#define NEAR (1.0 / 64.0)
/* Gaps that differ by no more are equal, but for rounding. */
#define ROUNDING 2
/* A step is fitted to gaps of so many steps first, then to those of three times as many, ... */
#define WINDOW_FIRST 24.0
#define WINDOW_GROWTH 3.0
/* Greater ones are not parted: doubles hold them no longer. */
#define PARTED_MOST ((int64_t)1 << 52)

/* Sorts, and drops equal ones and those farther than PARTED_MOST from the least; counts from the
 * least. */
static uint32_t sort_distinct(int64_t *numbers, uint32_t count)
{
    uint32_t kept = 0;
    stp_sort_i64(numbers, count);
    const uint64_t least = count > 0 ? (uint64_t)numbers[0] : 0;
    int64_t before = -1;
    for (uint32_t i = 0; i < count; i++) {
        const uint64_t far = (uint64_t)numbers[i] - least;
        if (far < (uint64_t)PARTED_MOST && (int64_t)far != before)
            numbers[kept++] = before = (int64_t)far;
    }
    return kept;
}

/* The step of which the gaps are multiples, nearly: least squares over gaps of up to so many steps,
 * and more as the step becomes known. The gaps are sorted. */
static double fit_gaps(const int64_t *gaps, uint32_t count, double step)
{
    const double end = (double)gaps[count - 1];
    for (double window = WINDOW_FIRST * step;; window *= WINDOW_GROWTH) {
        double sum_kk = 0, sum_kx = 0;
        for (uint32_t i = 0; i < count && (double)gaps[i] <= window; i++) {
            const double x = (double)gaps[i], k = nearbyint(x / step);
            sum_kk += k * k;
            sum_kx += k * x;
        }
        step = sum_kk > 0 ? sum_kx / sum_kk : step;
        if (window >= end || !stp_step_is_valid(step))
            return step;
    }
}

/* The gaps of sorted numbers, sorted. */
static void make_gaps(const int64_t *numbers, uint32_t count, int64_t *gaps)
{
    for (uint32_t i = 0; i + 1 < count; i++)
        gaps[i] = numbers[i + 1] - numbers[i];
    stp_sort_i64(gaps, count - 1);
}

/* Where among sorted gaps those of one pulse are. */
typedef struct range {
    uint32_t begin, end;
} range;

static range find_pulse(const int64_t *gaps, uint32_t count)
{
    const uint32_t few = count / FEW;
    const double gap = (double)gaps[few], off = fmax(gap * NEAR, ROUNDING);
    range r = {0, 0};
    while ((double)gaps[r.begin] < gap - off)
        r.begin++;
    for (r.end = r.begin; r.end < count && (double)gaps[r.end] <= gap + off;)
        r.end++;
    return r;
}

static double mean_of(const int64_t *sorted, range r)
{
    double sum = 0;
    for (uint32_t i = r.begin; i < r.end; i++)
        sum += (double)sorted[i];
    return sum / (r.end - r.begin);
}

/* How far the two greatest groups of equal gaps are apart: a tick of the clock. 0 if there is one
 * group. */
static double find_tick(const int64_t *gaps, range r)
{
    range greatest = {0, 0}, second = {0, 0}, own = r;
    for (uint32_t i = r.begin + 1; i <= r.end; i++) {
        if (i < r.end && gaps[i] - gaps[i - 1] <= ROUNDING)
            continue;
        own.end = i;
        if (own.end - own.begin > greatest.end - greatest.begin) {
            second = greatest;
            greatest = own;
        } else if (own.end - own.begin > second.end - second.begin) {
            second = own;
        }
        own.begin = i;
    }
    if (second.end - second.begin <= (r.end - r.begin) / FEW)
        return 0.0;
    return fabs(mean_of(gaps, greatest) - mean_of(gaps, second));
}

static void to_steps(int64_t *numbers, uint32_t count, double step)
{
    for (uint32_t i = 0; i < count; i++)
        numbers[i] = (int64_t)nearbyint((double)numbers[i] / step);
}

stp_status stp_steps_find(int64_t *numbers, uint32_t count, stp_steps *out, stp_error *err)
{
    stp_status status = STP_OK;
    int64_t *gaps = NULL;
    const uint32_t distinct = sort_distinct(numbers, count);
    out->count = 0;
    if (distinct < NUMBERS_LEAST)
        return STP_OK;
    const uint32_t gap_count = distinct - 1;
    STP_TRY(stp_alloc(&gaps, gap_count, sizeof *gaps, "steps of an attribute", err));
    make_gaps(numbers, distinct, gaps);
    const range one = find_pulse(gaps, gap_count);
    if (one.end - one.begin < gap_count / (2 * FEW))
        goto done;
    double pulse = mean_of(gaps, one), tick = find_tick(gaps, one);
    if (tick > 2 * ROUNDING) {
        tick = fit_gaps(gaps + one.begin, gap_count - one.begin, tick);
        to_steps(gaps, gap_count, tick);
        pulse /= tick;
        out->of[out->count++] = tick;
    }
    out->of[out->count++] = fit_gaps(gaps + one.begin, gap_count - one.begin, pulse);
    for (unsigned k = 0; k < out->count; k++)
        if (!stp_step_is_valid(out->of[k]))
            out->count = 0;
done:
    free(gaps);
    return status;
}

void stp_steps_part(const stp_steps *steps, int64_t difference, int64_t *out)
{
    for (unsigned k = 0; k < steps->count; k++) {
        const double step = steps->of[k];
        const bool parted = difference > -PARTED_MOST && difference < PARTED_MOST;
        const double whole = parted ? nearbyint((double)difference / step) : 0.0;
        out[k] = difference - (int64_t)nearbyint(whole * step);
        difference = (int64_t)whole;
    }
    out[steps->count] = difference;
}

bool stp_steps_join(const stp_steps *steps, const int64_t *parts, int64_t *out)
{
    int64_t sum = parts[steps->count];
    for (unsigned k = steps->count; k-- > 0;) {
        const double multiple = nearbyint((double)sum * steps->of[k]);
        if (!(fabs(multiple) < 0x1p62))
            return false;
        sum = (int64_t)((uint64_t)(int64_t)multiple + (uint64_t)parts[k]);
    }
    *out = sum;
    return true;
}
