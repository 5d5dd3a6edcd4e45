/* Reads what OpenImageIO reads, held whole: heights of EXR, and colours of any format. */
#include "base/memory.h"
#include "formats/image/image.h"
#include "formats/scan/grid/raster.h"

#include <stdlib.h>
#include <string.h>

typedef struct image_raster {
    stp_image colours;
    float *heights;
    size_t width;
} image_raster;

static stp_status open_image(void *state, stp_raster_info *info, const char *path,
                             stp_raster_use use, stp_error *err)
{
    image_raster *r = state;
    stp_status status = STP_OK;
    int width = 0, height = 0;
    if (use == STP_RASTER_COLOURS) {
        STP_TRY(stp_image_load(&r->colours, path, err));
        width = r->colours.width;
        height = r->colours.height;
    } else {
        STP_TRY(stp_image_load_heights(path, &width, &height, &r->heights, err));
    }
    r->width = (size_t)width;
    *info = (stp_raster_info){.format = use == STP_RASTER_COLOURS ? "image" : "EXR",
                              .width = (uint32_t)width,
                              .height = (uint32_t)height,
                              .channels = use == STP_RASTER_COLOURS ? 4 : 1,
                              .alpha = use == STP_RASTER_COLOURS,
                              .floats = use == STP_RASTER_HEIGHTS,
                              .full = use == STP_RASTER_COLOURS ? 255.0 : 1.0};
done:
    return status;
}

static stp_status read_image(void *state, uint32_t row, double *values, stp_error *err)
{
    const image_raster *r = state;
    (void)err;
    for (size_t i = 0; r->heights != NULL && i < r->width; i++)
        values[i] = (double)r->heights[row * r->width + i];
    for (size_t i = 0; r->heights == NULL && i < 4 * r->width; i++)
        values[i] = r->colours.rgba[4 * row * r->width + i];
    return STP_OK;
}

static void close_image(void *state)
{
    image_raster *r = state;
    stp_image_destroy(&r->colours);
    free(r->heights);
}

const stp_raster_reader stp_raster_image = {.state_bytes = sizeof(image_raster),
                                            .open = open_image,
                                            .read = read_image,
                                            .close = close_image};
