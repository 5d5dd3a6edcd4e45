/* Joins the sheets of a depth camera's image. */
#include "preprocess/orient/pixel_sheets.h"

#include "preprocess/orient/forest.h"
#include "preprocess/orient/pixel_image.h"

/* A number above those of all sheets. */
static uint32_t sheet_end(const stp_cloud *cloud)
{
    uint32_t end = 0;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->sheets[i] != STP_SHEET_NONE && cloud->sheets[i] >= end)
            end = cloud->sheets[i] + 1;
    return end;
}

static bool is_seen(const stp_cloud *cloud, uint32_t point)
{
    return cloud->sheets[point] != STP_SHEET_NONE && cloud->points[point].given == STP_GIVEN_IMAGE;
}

static void join_image(const stp_cloud *cloud, const stp_pixel_image *image, double limit,
                       stp_forest *forest)
{
    for (uint64_t i = 0; i < 2 * stp_pixel_count(image); i++) {
        uint32_t a;
        const uint32_t b = stp_pixel_pair(image, i, 1, &a);
        if (b != STP_PIXEL_NONE && is_seen(cloud, a) && is_seen(cloud, b) &&
            stp_pixel_step(cloud, image, a, b) <= limit)
            stp_forest_join(forest, cloud->sheets[a], cloud->sheets[b], false);
    }
}

stp_status stp_pixel_sheets_join(stp_cloud *cloud, const stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    stp_pixel_images images = {0};
    stp_forest forest = {0};
    uint8_t parity = 0;
    STP_TRY(stp_pixel_images_create(&images, cloud, source, err));
    STP_TRY(stp_forest_create(&forest, sheet_end(cloud), cloud->spill, err));
    for (size_t i = 0; i < images.count; i++) {
        double limit = 0.0;
        STP_TRY(stp_pixel_step_most(&limit, cloud, &images.list[i], err));
        join_image(cloud, &images.list[i], limit, &forest);
    }
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->sheets[i] != STP_SHEET_NONE)
            cloud->sheets[i] = stp_forest_find(&forest, cloud->sheets[i], &parity);
done:
    stp_forest_clear(&forest);
    stp_pixel_images_clear(&images, cloud);
    return status;
}
