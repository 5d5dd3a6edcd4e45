/* Reads what OpenImageIO reads: heights of EXR row by row, and colours of any format, held whole.
 */
#include "base/memory.h"
#include "formats/image/image.h"
#include "formats/scan/grid/raster.h"

typedef struct image_raster {
    bool is_heights;
    stp_image colours;
    stp_height_image heights;
} image_raster;

static stp_status open_image(void *state, stp_raster_info *info, const char *path,
                             stp_raster_use use, uint32_t step, stp_error *err)
{
    image_raster *r = state;
    stp_status status = STP_OK;
    (void)step;
    r->is_heights = use == STP_RASTER_HEIGHTS;
    if (r->is_heights)
        STP_TRY(stp_height_image_open(&r->heights, path, err));
    else
        STP_TRY(stp_image_load(&r->colours, path, err));
    *info = (stp_raster_info){
        .format = r->is_heights ? "EXR" : "image",
        .width = (uint32_t)(r->is_heights ? r->heights.width : r->colours.width),
        .height = (uint32_t)(r->is_heights ? r->heights.height : r->colours.height),
        .channels = r->is_heights ? 1 : 4,
        .alpha = !r->is_heights,
        .floats = r->is_heights,
        .full = r->is_heights ? 1.0 : 255.0};
done:
    return status;
}

static stp_status read_image(void *state, uint32_t row, double *values, stp_error *err)
{
    image_raster *r = state;
    stp_status status = STP_OK;
    const size_t count = 4 * (size_t)r->colours.width;
    if (r->is_heights) {
        const float *heights = NULL;
        STP_TRY(stp_height_image_read(&r->heights, (int)row, &heights, err));
        for (int i = 0; i < r->heights.width; i++)
            values[i] = (double)heights[i];
    } else {
        for (size_t i = 0; i < count; i++)
            values[i] = r->colours.rgba[row * count + i];
    }
done:
    return status;
}

static void close_image(void *state)
{
    image_raster *r = state;
    stp_image_destroy(&r->colours);
    stp_height_image_close(&r->heights);
}

const stp_raster_reader stp_raster_image = {.state_bytes = sizeof(image_raster),
                                            .open = open_image,
                                            .read = read_image,
                                            .close = close_image};
