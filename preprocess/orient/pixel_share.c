/* Gives the points of images to the ranks that the images belong to. */
#include "preprocess/orient/pixel_share.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/prep.h"

#include <stdlib.h>
#include <string.h>

/* Points that all ranks together give at once, and each at least and most. Limits memory. */
#define GIVEN_POINTS (UINT32_C(1) << 20)
#define GIVEN_POINTS_LEAST 4096u
#define GIVEN_POINTS_MOST (UINT32_C(1) << 16)

/* What is sent of a point. */
typedef struct pixel_item {
    stp_cloud_point point;
    uint64_t place : STP_PLACE_BITS;
    uint64_t mark : 8;
    uint32_t sheet;
} pixel_item;

/* What ranks give at once. */
typedef struct giver {
    const stp_cloud *cloud;
    stp_ranks *ranks;
    const stp_prep_source *source;
    stp_pixel_images images;
    stp_pixel_share *share;
    size_t *sent, *received, *ends; /* by rank, in bytes */
    stp_bytes out, in;
} giver;

unsigned stp_pixel_image_rank(const stp_pixel_images *images, const stp_pixel_image *image,
                              const stp_ranks *ranks)
{
    const stp_pixel_image *first = &images->list[0], *last = &images->list[images->count - 1];
    const uint64_t records = last->first + last->count - first->first;
    return (unsigned)((image->first - first->first) * ranks->count / records);
}

/* The rank that gets a point, or the number of ranks if it is in no image. */
static unsigned taker_of(const giver *g, uint64_t i)
{
    const stp_pixel_image *m = stp_pixel_image_of(&g->images, &g->cloud->points[i]);
    return m ? stp_pixel_image_rank(&g->images, m, g->ranks) : g->ranks->count;
}

/* Adds what each rank gets of points [begin, end), in bytes, to sent. */
static void count_some(const giver *g, uint64_t begin, uint64_t end)
{
    for (uint64_t i = begin; i < end; i++, stp_cloud_step(g->cloud->spill, i)) {
        const unsigned taker = taker_of(g, i);
        if (taker < g->ranks->count)
            g->sent[taker] += sizeof(pixel_item);
    }
}

static void pack_some(const giver *g, uint64_t begin, uint64_t end)
{
    const stp_cloud *c = g->cloud;
    for (uint64_t i = begin; i < end; i++) {
        const unsigned taker = taker_of(g, i);
        if (taker == g->ranks->count)
            continue;
        const pixel_item item = {.point = c->points[i],
                                 .place = i & STP_PLACE_MASK,
                                 .mark = c->marks ? c->marks[i] : 0u,
                                 .sheet = c->sheets ? c->sheets[i] : STP_SHEET_NONE};
        memcpy(g->out.data + g->ends[taker], &item, sizeof item);
        g->ends[taker] += sizeof item;
    }
}

/* Gives points [begin, end), and takes what comes. */
static stp_status give_some(giver *g, uint64_t begin, uint64_t end, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *own = &g->share->own;
    size_t sum = 0;
    memset(g->sent, 0, g->ranks->count * sizeof *g->sent);
    count_some(g, begin, end);
    for (unsigned rank = 0; rank < g->ranks->count; rank++) {
        g->ends[rank] = sum;
        sum += g->sent[rank];
    }
    g->out.size = 0;
    STP_TRY(stp_bytes_append(&g->out, NULL, sum, err));
    pack_some(g, begin, end);
    STP_TRY(stp_ranks_exchange_bytes(g->ranks, g->out.data, g->sent, &g->in, g->received, err));
    stp_cursor from = {g->in.data, g->in.size};
    while (from.left > 0) {
        pixel_item item;
        STP_TRY(stp_packet_take(&from, &item, sizeof item, err));
        if (own->count == own->capacity)
            return stp_error_set(err, STP_INTERNAL, "more pixels come than were announced");
        own->points[own->count] = item.point;
        own->sheets[own->count] = item.sheet;
        own->marks[own->count] = item.mark;
        g->share->places[own->count] = (uint32_t)item.place;
        if (g->share->high)
            g->share->high[own->count] = (uint8_t)(item.place >> 32);
        own->count++;
    }
    stp_spill_relieve(own->spill);
done:
    return status;
}

/* Makes room for what comes. *most: points of the longest run of a rank. */
static stp_status make_room(giver *g, uint64_t *most, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_rank_part run = stp_cloud_own(g->cloud);
    const uint64_t *begins = g->cloud->blocks->begins;
    stp_cloud *own = &g->share->own;
    uint64_t *counts = NULL;
    STP_TRY(stp_alloc(&counts, g->ranks->count, sizeof *counts, "ranks", err));
    count_some(g, run.begin, run.end);
    for (unsigned rank = 0; rank < g->ranks->count; rank++) {
        counts[rank] = g->sent[rank] / sizeof(pixel_item);
        *most = begins[rank + 1] - begins[rank] > *most ? begins[rank + 1] - begins[rank] : *most;
    }
    STP_TRY(stp_ranks_sum(g->ranks, counts, g->ranks->count, err));
    own->capacity = counts[g->ranks->self];
    STP_TRY(stp_spill_alloc(own->spill, &own->points, own->capacity, sizeof *own->points, "pixels",
                            err));
    STP_TRY(stp_spill_alloc(own->spill, &own->sheets, own->capacity, sizeof *own->sheets, "pixels",
                            err));
    STP_TRY(
        stp_spill_alloc(own->spill, &own->marks, own->capacity, sizeof *own->marks, "pixels", err));
    STP_TRY(stp_spill_alloc(own->spill, &g->share->places, own->capacity, sizeof *g->share->places,
                            "pixels", err));
    if (g->cloud->first + g->cloud->count > UINT32_MAX)
        STP_TRY(stp_spill_alloc(own->spill, &g->share->high, own->capacity, 1, "pixels", err));
done:
    free(counts);
    return status;
}

static stp_status give_all(giver *g, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t most = 0;
    const stp_rank_part run = stp_cloud_own(g->cloud);
    const uint32_t part = GIVEN_POINTS / g->ranks->count;
    const uint32_t step = part < GIVEN_POINTS_LEAST  ? GIVEN_POINTS_LEAST
                          : part > GIVEN_POINTS_MOST ? GIVEN_POINTS_MOST
                                                     : part;
    STP_TRY(stp_alloc(&g->sent, g->ranks->count, sizeof *g->sent, "ranks", err));
    STP_TRY(stp_alloc(&g->received, g->ranks->count, sizeof *g->received, "ranks", err));
    STP_TRY(stp_alloc(&g->ends, g->ranks->count, sizeof *g->ends, "ranks", err));
    STP_TRY(stp_pixel_images_list(&g->images, g->source, g->cloud->first_record, err));
    if (g->images.count == 0)
        goto done;
    STP_TRY(make_room(g, &most, err));
    for (uint64_t at = 0; at < most; at += step) {
        const uint64_t begin = at < run.end - run.begin ? run.begin + at : run.end;
        STP_TRY(give_some(g, begin, run.end - begin < step ? run.end : begin + step, err));
    }
done:
    return status;
}

stp_status stp_pixel_share_create(stp_pixel_share *out, const stp_cloud *cloud,
                                  const stp_prep_source *source, stp_error *err)
{
    *out = (stp_pixel_share){.seen = cloud};
    if (!cloud->blocks)
        return STP_OK;
    giver g = {.cloud = cloud, .ranks = cloud->blocks->ranks, .source = source, .share = out};
    out->own = (stp_cloud){
        .spill = cloud->spill, .pixels = cloud->pixels, .first_record = cloud->first_record};
    out->seen = &out->own;
    const stp_status status = give_all(&g, err);
    free(g.images.list);
    free(g.sent);
    free(g.received);
    free(g.ends);
    free(g.out.data);
    free(g.in.data);
    if (status != STP_OK)
        stp_pixel_share_clear(out);
    return status;
}

void stp_pixel_share_clear(stp_pixel_share *share)
{
    stp_spill *spill = share->own.spill;
    stp_spill_free(spill, share->own.points);
    stp_spill_free(spill, share->own.sheets);
    stp_spill_free(spill, share->own.marks);
    stp_spill_free(spill, share->places);
    stp_spill_free(spill, share->high);
    *share = (stp_pixel_share){0};
}
