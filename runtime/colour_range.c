/* Chooses the palette, and the values at its two ends. */
#include "runtime/colour_range.h"

#include "base/memory.h"
#include "base/sort.h"
#include "runtime/cut/model.h"

#include <stdlib.h>

/* The share left out at either end; outliers would otherwise take most of the palette. */
#define TAIL 0.02

stp_palette stp_colour_palette(const stp_draw_params *params)
{
    if (params->palette != STP_PALETTE_OWN)
        return params->palette;
    return params->colour == STP_COLOUR_ELEVATION ? STP_PALETTE_VIRIDIS : STP_PALETTE_GREY;
}

void stp_palette_colour(stp_palette palette, double value, float rgb[3])
{
    static const double viridis[5][3] = {{0.267, 0.005, 0.329},
                                         {0.229, 0.322, 0.546},
                                         {0.128, 0.567, 0.551},
                                         {0.369, 0.789, 0.383},
                                         {0.993, 0.906, 0.144}};
    const double x = fmin(fmax(value, 0.0), 1.0), third = 3.0 * x;
    const double heat[3] = {third - 1.0, third < 1.0 ? third : 3.0 - third, 1.0 - third};
    const int part = (int)fmin(4.0 * x, 3.0);
    for (int c = 0; c < 3; c++) {
        const double from = viridis[part][c], to = viridis[part + 1][c];
        rgb[c] = (float)x;
        if (palette == STP_PALETTE_VIRIDIS)
            rgb[c] = (float)(from + (to - from) * (4.0 * x - part));
        if (palette == STP_PALETTE_HEAT)
            rgb[c] = (float)(fmin(fmax(heat[c], 0.0), 1.0) * 0.9 + 0.05);
    }
}

void stp_colour_range_place(float out[4], const stp_draw_params *params, const stp_dvec3 *eye)
{
    double low = params->colour_range[0], extent = params->colour_range[1] - low;
    if (params->colour == STP_COLOUR_ELEVATION)
        low -= eye->z;
    out[0] = (float)low;
    out[1] = extent > 0.0 ? (float)(1.0 / extent) : 0.0f;
    out[2] = out[3] = 0.0f;
}

/* The range of values without a share at either end. */
static void range_without(double *values, uint32_t count, double share, double range[2])
{
    range[0] = range[1] = 0.0;
    if (count == 0)
        return;
    stp_sort_doubles(values, count);
    range[0] = values[(uint32_t)(share * (count - 1))];
    range[1] = values[count - 1 - (uint32_t)(share * (count - 1))];
}

void stp_colour_range_of(double *values, uint32_t count, double range[2])
{
    range_without(values, count, TAIL, range);
}

stp_status stp_model_colour_range(const stp_model *model, stp_colour colour, double range[2],
                                  stp_error *err)
{
    return stp_model_colour_part(model, colour, TAIL, range, err);
}

stp_status stp_model_colour_part(const stp_model *model, stp_colour colour, double share,
                                 double range[2], stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *root = NULL;
    double *values = NULL;
    STP_TRY(stp_chunk_file_read(model->file, 0, 0, &root, err));
    uint32_t count = root->level_begin[0][root->patch_count];
    STP_TRY(stp_alloc(&values, count, sizeof *values, "values", err));
    for (uint32_t p = 0; p < root->patch_count; p++)
        for (uint32_t i = root->level_begin[0][p]; i < root->level_begin[0][p + 1]; i++) {
            const stp_sample *sample = &root->samples[0][i];
            values[i] =
                colour == STP_COLOUR_ELEVATION
                    ? model->entries[0].origin.z + stp_sample_position(sample, &root->patches[p]).z
                    : sample->intensity / 255.0;
        }
    range_without(values, count, share, range);
done:
    free(values);
    stp_chunk_destroy(&root);
    return status;
}
