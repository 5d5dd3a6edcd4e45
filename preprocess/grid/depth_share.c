/* Gives the images that each rank has cut to all ranks. */
#include "preprocess/grid/depth_share.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"

#include <stdlib.h>
#include <string.h>

/* Replaces an array by those of all ranks, rank after rank. */
static stp_status join(void *array, size_t *count, size_t size, stp_ranks *ranks, stp_error *err)
{
    stp_status status = STP_OK;
    void *own = NULL, *all = NULL;
    stp_bytes bytes = {0};
    memcpy(&own, array, sizeof own);
    STP_TRY(stp_bytes_append(&bytes, own, *count * size, err));
    STP_TRY(stp_ranks_join(ranks, &bytes, err));
    stp_cursor from = {bytes.data, bytes.size};
    STP_TRY(stp_packet_take_array(&from, &all, bytes.size / size, size, err));
    free(own);
    memcpy(array, &all, sizeof all);
    *count = bytes.size / size;
done:
    free(bytes.data);
    return status;
}

/* What ranks before this one have, all of which come first. */
static stp_status count_before(const stp_depth_images *images, stp_ranks *ranks, uint32_t before[2],
                               stp_error *err)
{
    stp_status status = STP_OK;
    const uint32_t own[2] = {(uint32_t)images->pieces.count, (uint32_t)images->pieces.square_count};
    uint32_t(*all)[2] = NULL;
    before[0] = before[1] = 0;
    STP_TRY(stp_alloc(&all, ranks->count, sizeof *all, "ranks", err));
    STP_TRY(stp_ranks_gather(ranks, own, sizeof own, all, err));
    for (unsigned rank = 0; rank < ranks->self; rank++) {
        before[0] += all[rank][0];
        before[1] += all[rank][1];
    }
done:
    free(all);
    return status;
}

/* Numbers this rank's pieces as among those of all ranks. */
static stp_status number_pieces(stp_depth_images *images, stp_ranks *ranks, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t before[2];
    STP_TRY(count_before(images, ranks, before, err));
    for (size_t i = 0; i < images->pieces.square_count; i++)
        if (images->pieces.of_square[i] != STP_DEPTH_NO_RAYS)
            images->pieces.of_square[i] += before[0];
    for (uint32_t i = 0; i < images->square_count; i++)
        images->squares[i].rays += before[0];
    for (size_t i = 0; i < images->pixels.count; i++)
        images->cameras[i].first_square += before[1];
done:
    return status;
}

/* Gives each rank's images' pixels to all, as places in the whole cloud. */
static stp_status share_pixels(stp_pixel_images *pixels, const stp_pixel_share *share,
                               const stp_cloud *cloud, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = cloud->blocks->ranks;
    stp_pixel_images own = *pixels;
    own.list = NULL;
    pixels->points = NULL;
    pixels->high = NULL;
    STP_TRY(stp_alloc(&own.list, own.count, sizeof *own.list, "images", err));
    memcpy(own.list, pixels->list, own.count * sizeof *own.list);
    STP_TRY(stp_pixel_images_room(pixels, cloud, err));
    for (size_t i = 0; i < pixels->count; i++) {
        const stp_pixel_image *image = &pixels->list[i];
        const unsigned rank = stp_pixel_image_rank(pixels, image, ranks);
        const uint64_t count = stp_pixel_count(image);
        for (uint64_t k = 0; rank == ranks->self && k < count; k++) {
            const uint64_t point = stp_pixel_point(&own.list[i], k);
            if (point != STP_PIXEL_NONE)
                stp_pixel_set(image, k, stp_pixel_share_place(share, point));
        }
        STP_TRY(
            stp_ranks_broadcast(ranks, rank, image->points, count * sizeof *image->points, err));
        if (image->high)
            STP_TRY(stp_ranks_broadcast(ranks, rank, image->high, count, err));
        stp_spill_relieve(cloud->spill);
    }
done:
    stp_spill_free(cloud->spill, own.points);
    stp_spill_free(cloud->spill, own.high);
    free(own.list);
    return status;
}

stp_status stp_depth_images_share(stp_depth_images *images, stp_leaf_extent **extents,
                                  const stp_pixel_share *share, const stp_cloud *cloud,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = cloud->blocks->ranks;
    stp_pixel_images *pixels = &images->pixels;
    stp_depth_pieces *pieces = &images->pieces;
    size_t squares = images->square_count, measured = squares;
    STP_TRY(number_pieces(images, ranks, err));
    for (size_t i = 0; i < pixels->count; i++) {
        const unsigned rank = stp_pixel_image_rank(pixels, &pixels->list[i], ranks);
        const stp_pixel_image before = pixels->list[i];
        STP_TRY(stp_ranks_broadcast(ranks, rank, &pixels->list[i], sizeof *pixels->list, err));
        STP_TRY(
            stp_ranks_broadcast(ranks, rank, &images->cameras[i], sizeof *images->cameras, err));
        pixels->list[i].points = before.points;
        pixels->list[i].high = before.high;
    }
    STP_TRY(share_pixels(pixels, share, cloud, err));
    STP_TRY(join(&pieces->rays, &pieces->count, sizeof *pieces->rays, ranks, err));
    STP_TRY(join(&pieces->of_square, &pieces->square_count, sizeof *pieces->of_square, ranks, err));
    STP_TRY(join(&images->squares, &squares, sizeof *images->squares, ranks, err));
    STP_TRY(join(extents, &measured, sizeof **extents, ranks, err));
    STP_TRY(stp_depth_squares_check(squares, err));
    images->square_count = (uint32_t)squares;
done:
    return status;
}
