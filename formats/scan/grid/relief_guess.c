/* Guesses how far the samples of heights are apart if their file does not tell. */
#include "formats/scan/grid/relief_guess.h"

#include "base/memory.h"
#include "formats/scan/grid/raster.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* Rows and columns that are looked at. */
#define SIDE 256u
#define END_SHARE 0.001 /* of the heights, at either end, may be anything */
#define FLAT 64.0
#define SIDE_LEAST 32u   /* fewer samples are no landscape */
#define RELIEF_PART 0.25 /* of the longer side */

typedef struct relief {
    double low, high, least, most; /* without and with the ends */
} relief;

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static bool is_sample(const stp_raster_info *info, const stp_grid_params *params,
                      const double *pixel)
{
    const double n = pixel[0];
    return fabs(n) < STP_SCAN_NONE_FROM && !stp_is_usual_none(n) &&
           !(info->has_none && n == info->none) && !(params->has_invalid && n == params->invalid) &&
           !(info->alpha && pixel[info->channels - 1] == 0.0);
}

/* all zero: there are no samples. */
static stp_status measure(relief *out, stp_raster_file *raster, const stp_grid_params *params,
                          stp_error *err)
{
    stp_status status = STP_OK;
    const stp_raster_info *info = stp_raster_get_info(raster);
    const uint32_t down = (info->height - 1) / SIDE + 1, across = (info->width - 1) / SIDE + 1;
    double *row = NULL, *heights = NULL;
    size_t count = 0;
    *out = (relief){0.0, 0.0, 0.0, 0.0};
    STP_TRY(stp_alloc(&row, info->width, info->channels * sizeof *row, "a row of heights", err));
    STP_TRY(stp_alloc(&heights, SIDE, SIDE * sizeof *heights, "heights", err));
    for (uint32_t r = 0; r < info->height; r += down) {
        STP_TRY(stp_raster_read(raster, r, row, err));
        for (uint32_t c = 0; c < info->width; c += across) {
            const double *pixel = row + (size_t)c * info->channels;
            if (is_sample(info, params, pixel))
                heights[count++] = pixel[0];
        }
    }
    if (count == 0)
        goto done;
    qsort(heights, count, sizeof *heights, compare);
    const size_t ends = (size_t)(END_SHARE * (double)count);
    *out = (relief){heights[ends], heights[count - 1 - ends], heights[0], heights[count - 1]};
done:
    free(row);
    free(heights);
    return status;
}

/* 0: nothing is guessed. */
static double spacing_of(const stp_raster_info *info, const relief *r)
{
    const double side = fmax(info->width, info->height) - 1.0, rise = r->high - r->low;
    const bool needle = rise > side;
    const bool flat = info->floats && r->least >= 0.0 && r->most <= 1.0 && FLAT * rise < side;
    if (!(rise > 0.0) || (!needle && !flat))
        return 0.0;
    return exp2(ceil(log2(rise / (RELIEF_PART * side))));
}

stp_status stp_relief_guess(stp_grid_params *params, char *note, size_t note_bytes,
                            const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_raster_file *raster = NULL;
    relief r;
    if (params->fx > 0.0 || params->dx > 0.0 || params->scale != 0.0)
        return STP_OK;
    STP_TRY(stp_raster_open(&raster, path, STP_RASTER_HEIGHTS, 1, err));
    const stp_raster_info *info = stp_raster_get_info(raster);
    if ((!info->floats && info->full <= 255.0) || info->spaced || info->placed ||
        info->scale != 0.0 || info->width < SIDE_LEAST || info->height < SIDE_LEAST)
        goto done;
    STP_TRY(measure(&r, raster, params, err));
    const double spacing = spacing_of(info, &r);
    if (spacing == 0.0)
        goto done;
    params->dx = params->dy = spacing;
    snprintf(note, note_bytes,
             "heights %.6g to %.6g, and the file does not tell how far samples are apart: %g is "
             "assumed, for a landscape. Say otherwise by --spacing and --height-scale, or give "
             "--pinhole fx,fy,cx,cy if these are depths",
             r.low, r.high, spacing);
done:
    stp_raster_close(&raster);
    return status;
}
