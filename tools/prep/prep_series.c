/* Makes images that are given together depths or heights. */
#include "tools/prep/prep_series.h"

#include "base/memory.h"
#include "formats/scan/detect.h"
#include "formats/scan/grid/depth_guess.h"

#include <stdlib.h>

/* Floats are metres, whole numbers are not. */
static bool is_alike(const stp_depth_look *a, const stp_depth_look *b)
{
    return a->width == b->width && a->height == b->height && a->floats == b->floats;
}

/* Decides for all images of the kind of look i. */
static void decide(stp_grid_params *out, const stp_depth_look *looks, size_t count, size_t i)
{
    size_t images = 0, depths = 0;
    double scale = 0.0;
    for (size_t k = 0; k < count; k++) {
        if (!is_alike(&looks[k], &looks[i]))
            continue;
        images++;
        depths += looks[k].scale > 0.0;
        if (looks[k].scale > 0.0 && (scale == 0.0 || looks[k].scale < scale))
            scale = looks[k].scale;
    }
    out->series = 2 * depths >= images ? STP_SERIES_DEPTHS : STP_SERIES_HEIGHTS;
    if (out->series == STP_SERIES_DEPTHS && out->scale == 0.0)
        out->scale = scale;
}

stp_status prep_series_decide(prep_inputs *in, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_grid_params *given = in->params.grid;
    stp_depth_look *looks = NULL;
    if (in->count < 2 || (given && (given->fx > 0.0 || given->dx > 0.0)))
        return STP_OK;
    STP_TRY(stp_alloc(&looks, in->count, sizeof *looks, "inputs", err));
    STP_TRY(stp_alloc(&in->grids, in->count, sizeof *in->grids, "inputs", err));
    for (size_t i = 0; i < in->count; i++) {
        stp_scan_format format;
        if (stp_scan_detect(&format, in->paths[i], NULL) != STP_OK || format != STP_SCAN_GRID ||
            stp_depth_look_at(&looks[i], in->paths[i], NULL) != STP_OK)
            looks[i] = (stp_depth_look){0};
    }
    for (size_t i = 0; i < in->count; i++) {
        in->grids[i] = given ? *given : (stp_grid_params){0};
        if (looks[i].focal > 0.0)
            decide(&in->grids[i], looks, in->count, i);
    }
done:
    free(looks);
    return status;
}

const stp_grid_params *prep_series_grid(const prep_inputs *in, size_t i)
{
    return in->grids && in->grids[i].series != STP_SERIES_NONE ? &in->grids[i] : in->params.grid;
}
