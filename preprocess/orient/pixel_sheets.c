/* Joins the sheets of a depth camera's image. */
#include "preprocess/orient/pixel_sheets.h"

#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/orient/forest.h"
#include "preprocess/orient/pixel_share.h"

#include <stdlib.h>

/* A number above those of all sheets. */
static stp_status find_sheet_end(uint32_t *out, const stp_cloud *cloud, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_rank_part own = stp_cloud_own(cloud);
    stp_ranks *ranks = cloud->blocks ? cloud->blocks->ranks : NULL;
    uint32_t here = 0;
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->sheets[i] != STP_SHEET_NONE && cloud->sheets[i] >= here)
            here = cloud->sheets[i] + 1;
    *out = here;
    for (unsigned rank = 0; rank < stp_ranks_count(ranks); rank++) {
        uint32_t end = here;
        STP_TRY(stp_ranks_broadcast(ranks, rank, &end, sizeof end, err));
        *out = end > *out ? end : *out;
    }
done:
    return status;
}

/* Joins what other ranks have joined in their images, too: pairs of a sheet and its root. */
static stp_status join_ranks(stp_forest *forest, uint32_t sheet_end, stp_ranks *ranks,
                             stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t parity = 0;
    stp_bytes pairs = {0};
    for (uint32_t i = 0; i < sheet_end; i++) {
        const uint32_t pair[2] = {i, stp_forest_find(forest, i, &parity)};
        if (pair[1] != i)
            STP_TRY(stp_bytes_append(&pairs, pair, sizeof pair, err));
    }
    STP_TRY(stp_ranks_join(ranks, &pairs, err));
    stp_cursor from = {pairs.data, pairs.size};
    while (from.left > 0) {
        uint32_t pair[2];
        STP_TRY(stp_packet_take(&from, pair, sizeof pair, err));
        stp_forest_join(forest, pair[0], pair[1], false);
    }
done:
    free(pairs.data);
    return status;
}

static bool is_seen(const stp_cloud *cloud, uint64_t point)
{
    return cloud->sheets[point] != STP_SHEET_NONE && cloud->points[point].given == STP_GIVEN_IMAGE;
}

static void join_image(const stp_cloud *cloud, const stp_pixel_image *image, double limit,
                       stp_forest *forest)
{
    for (uint64_t i = 0; i < 2 * stp_pixel_count(image); i++) {
        uint64_t a;
        const uint64_t b = stp_pixel_pair(image, i, 1, &a);
        if (b != STP_PIXEL_NONE && is_seen(cloud, a) && is_seen(cloud, b) &&
            stp_pixel_step(cloud, image, a, b) <= limit)
            stp_forest_join(forest, cloud->sheets[a], cloud->sheets[b], false);
    }
}

stp_status stp_pixel_sheets_join(stp_cloud *cloud, const stp_prep_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    stp_pixel_share share = {0};
    stp_pixel_images images = {0};
    stp_forest forest = {0};
    const stp_rank_part own = stp_cloud_own(cloud);
    uint32_t end = 0;
    uint8_t parity = 0;
    STP_TRY(stp_pixel_share_create(&share, cloud, source, err));
    STP_TRY(stp_pixel_images_create(&images, share.seen, source, err));
    STP_TRY(find_sheet_end(&end, cloud, err));
    STP_TRY(stp_forest_create(&forest, end, cloud->spill, err));
    for (size_t i = 0; i < images.count; i++) {
        double limit = 0.0;
        STP_TRY(stp_pixel_step_most(&limit, share.seen, &images.list[i], err));
        join_image(share.seen, &images.list[i], limit, &forest);
    }
    if (cloud->blocks)
        STP_TRY(join_ranks(&forest, end, cloud->blocks->ranks, err));
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->sheets[i] != STP_SHEET_NONE)
            cloud->sheets[i] = stp_forest_find(&forest, cloud->sheets[i], &parity);
done:
    stp_forest_clear(&forest);
    stp_pixel_images_clear(&images, cloud);
    stp_pixel_share_clear(&share);
    return status;
}
