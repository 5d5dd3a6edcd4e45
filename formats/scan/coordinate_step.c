/* Finds the step of coordinates that were written in decimals and are stored as binary floats. */
#include "formats/scan/coordinate_step.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>

#define LOOK_POINTS 65536u
#define BATCH_POINTS 1024u
/* The largest extent of points, in steps, for which a model can keep the step: see the header. */
#define REACH_STEPS 1e9
/* A grid's cell is at most so many steps wide: 8 x 8 cells then fit in the 16 bits of a patch. */
#define CELL_STEPS 1024.0
/* A double that was computed as scale times integer lies this near to its decimals. */
#define COMPUTED 0x1p-50

static const double steps[] = {1.0, 0.1, 0.01, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9};
static const double parts[] = {1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9};

#define STEP_COUNT (sizeof steps / sizeof *steps)
/* The first steps are those of surveys. Finer steps are tried only if `fine` is set. */
#define SURVEY_STEPS 4u

/* True if the value, known to +-off, can be a multiple of steps[i] after rounding. */
static bool is_multiple(double value, double off, size_t i)
{
    const double nearest = round(value * parts[i]) / parts[i];
    if (fabs(value - nearest) <= fabs(value) * COMPUTED + off)
        return true;
    /* If the double is exactly a float, it was most likely a float. */
    return fabs((double)(float)value - value) <= off && (float)nearest == (float)value;
}

/* What all points so far have in common. */
typedef struct common {
    size_t step; /* index of the first step that fits; count: none */
    size_t count;
    bool heights; /* x and y are those of a grid: z alone was measured */
    bool doubles; /* some coordinates are no floats, so a fine step is not the rounding of floats */
    double scale, offset; /* heights are scale * number + offset, and numbers are looked at */
    stp_dbox box;
} common;

/* Looks at a coordinate, or at the number that it was computed from, which is known to +-off. */
static void look_at_number(common *all, double value, double off)
{
    while (all->step < all->count && !is_multiple(value, off, all->step))
        all->step++;
    all->doubles = all->doubles || fabs((double)(float)value - value) > off;
}

static void look_at(common *all, const stp_point *point)
{
    const stp_dvec3 p = point->position;
    if (point->reject != STP_REJECT_NONE || stp_scan_is_nowhere(p))
        return;
    stp_dbox_add(&all->box, p);
    if (!all->heights) {
        look_at_number(all, p.x, 0.0);
        look_at_number(all, p.y, 0.0);
    }
    const bool computed = all->scale != 1.0 || all->offset != 0.0;
    const double off = computed ? (fabs(p.z) + fabs(all->offset)) / all->scale * COMPUTED : 0.0;
    look_at_number(all, (p.z - all->offset) / all->scale, off);
}

/* Returns the step; 0: none. cell: of a grid of heights, else 0. */
static double decide(const common *all, double cell)
{
    const double reach = stp_dvec3_length(stp_dvec3_sub(all->box.max, all->box.min));
    if (all->step == all->count || (all->step >= SURVEY_STEPS && !all->doubles))
        return 0.0;
    const double step = all->scale * steps[all->step];
    const bool fits = step >= steps[SURVEY_STEPS - 1] || CELL_STEPS * step >= cell;
    return fits && reach <= REACH_STEPS * step ? step : 0.0;
}

stp_status stp_scan_find_step(stp_scan *scan, bool fine, double *step, stp_error *err)
{
    stp_status status = STP_OK;
    stp_point *points = NULL;
    common all = {.count = fine ? STEP_COUNT : SURVEY_STEPS, .scale = 1.0, .box = stp_dbox_empty()};
    size_t count = 1;
    const stp_scan_raster *raster = &stp_scan_get_info(scan)->raster;
    all.heights = !fine && raster->columns > 0;
    if (all.heights && raster->scale != 0.0) {
        all.scale = fabs(raster->scale);
        all.offset = raster->offset;
    }
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
    *step = decide(&all, all.heights ? stp_min(raster->dx, raster->dy) : 0.0);
done:
    free(points);
    return status;
}
