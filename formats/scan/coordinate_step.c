/* Finds the step of coordinates that were written in decimals and are stored as binary floats. */
#include "formats/scan/coordinate_step.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

#define LOOK_POINTS 65536u
#define BATCH_POINTS 1024u
/* The largest extent of points, in steps, for which a model can keep the step: see the header. */
#define REACH_STEPS 1e9
/* A double that was computed as scale times integer lies this near to its decimals. */
#define COMPUTED 0x1p-50

static const double steps[] = {1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};
static const double parts[] = {1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};

#define STEP_COUNT (sizeof steps / sizeof *steps)
/* The first steps are those of surveys. Finer steps are tried only if `fine` is set. */
#define SURVEY_STEPS 4u

/* True if the value can be a multiple of steps[i] after rounding. */
static bool is_multiple(double value, size_t i)
{
    const double nearest = round(value * parts[i]) / parts[i];
    if (fabs(value - nearest) <= fabs(value) * COMPUTED)
        return true;
    /* If the double is exactly a float, it was most likely a float. */
    return (double)(float)value == value && (float)nearest == (float)value;
}

/* What all points so far have in common. */
typedef struct common {
    size_t step; /* index of the first step that fits; count: none */
    size_t count;
    bool heights; /* x and y are those of a grid: z alone was measured */
    bool doubles; /* some coordinates are no floats, so a fine step is not the rounding of floats */
    stp_dbox box;
} common;

static void look_at(common *all, const stp_point *point)
{
    const double at[3] = {point->position.x, point->position.y, point->position.z};
    if (point->reject != STP_REJECT_NONE || stp_scan_is_nowhere(point->position))
        return;
    stp_dbox_add(&all->box, point->position);
    for (int axis = all->heights ? 2 : 0; axis < 3; axis++)
        while (all->step < all->count && !is_multiple(at[axis], all->step))
            all->step++;
    for (int axis = all->heights ? 2 : 0; axis < 3; axis++)
        all->doubles = all->doubles || (double)(float)at[axis] != at[axis];
}

/* Returns the step; 0: none. */
static double decide(const common *all)
{
    const double reach = stp_dvec3_length(stp_dvec3_sub(all->box.max, all->box.min));
    if (all->step == all->count || (all->step >= SURVEY_STEPS && !all->doubles) ||
        !(reach <= REACH_STEPS * steps[all->step]))
        return 0.0;
    return steps[all->step];
}

stp_status stp_scan_find_step(stp_scan *scan, bool fine, double *step, stp_error *err)
{
    stp_status status = STP_OK;
    stp_point *points = NULL;
    common all = {.count = fine ? STEP_COUNT : SURVEY_STEPS, .box = stp_dbox_empty()};
    size_t count = 1;
    all.heights = !fine && stp_scan_get_info(scan)->raster.columns > 0;
    if (stp_scan_get_info(scan)->coordinate_step > 0.0) {
        *step = stp_scan_get_info(scan)->coordinate_step;
        return STP_OK;
    }
    STP_TRY(stp_alloc(&points, BATCH_POINTS, sizeof *points, "points", err));
    for (size_t seen = 0; seen < LOOK_POINTS && all.step < all.count && count > 0; seen += count) {
        STP_TRY(stp_scan_read(scan, points, BATCH_POINTS, &count, err));
        for (size_t i = 0; i < count; i++)
            look_at(&all, &points[i]);
    }
    *step = decide(&all);
done:
    free(points);
    return status;
}
