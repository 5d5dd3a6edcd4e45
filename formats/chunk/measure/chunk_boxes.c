/* Boxes of chunks, and boxes around them. */
#include "formats/chunk/measure/chunk_boxes.h"

#include "base/memory.h"

#include <stdlib.h>

#define ABOVE STP_CHUNK_BOXES_ABOVE

stp_status stp_chunk_boxes_create(stp_chunk_boxes *out, uint32_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk_boxes b = {.count = count};
    for (size_t in_tier = count; in_tier > 0;
         in_tier = in_tier > 1 ? (in_tier + ABOVE - 1) / ABOVE : 0) {
        unsigned tier = b.tier_count++;
        b.begin[tier + 1] = b.begin[tier] + in_tier;
    }
    const size_t all = b.begin[b.tier_count];
    STP_TRY(stp_alloc(&b.boxes, all, sizeof *b.boxes, "chunks", err));
    for (size_t i = 0; i < all; i++)
        b.boxes[i] = stp_dbox_empty();
    *out = b;
done:
    return status;
}

void stp_chunk_boxes_clear(stp_chunk_boxes *b)
{
    free(b->boxes);
    *b = (stp_chunk_boxes){0};
}

/* Makes the box at `at` of a tier from those below it. */
static void join_below(stp_chunk_boxes *b, unsigned tier, size_t at)
{
    const size_t first = b->begin[tier - 1] + at * ABOVE, end = b->begin[tier];
    stp_dbox *sum = &b->boxes[b->begin[tier] + at];
    *sum = stp_dbox_empty();
    for (size_t i = first; i < end && i < first + ABOVE; i++)
        stp_dbox_join(sum, &b->boxes[i]);
}

void stp_chunk_boxes_set(stp_chunk_boxes *b, uint32_t index, const stp_dbox *box)
{
    b->boxes[index] = *box;
    size_t at = index;
    for (unsigned tier = 1; tier < b->tier_count; tier++)
        join_below(b, tier, at /= ABOVE);
}

void stp_chunk_boxes_join(stp_chunk_boxes *b)
{
    for (unsigned tier = 1; tier < b->tier_count; tier++)
        for (size_t at = 0; at < b->begin[tier + 1] - b->begin[tier]; at++)
            join_below(b, tier, at);
}

uint32_t stp_chunk_boxes_next(const stp_chunk_boxes *b, const stp_dbox *box, uint32_t from)
{
    for (uint64_t i = from, width = 1; i < b->count; i += width) {
        if (stp_dbox_meet(&b->boxes[i], box))
            return (uint32_t)i;
        /* skips all chunks under the widest box that begins here and does not meet */
        size_t at = i;
        width = 1;
        for (unsigned tier = 1; tier < b->tier_count && at % ABOVE == 0; tier++) {
            at /= ABOVE;
            if (stp_dbox_meet(&b->boxes[b->begin[tier] + at], box))
                break;
            width *= ABOVE;
        }
    }
    return STP_CHUNK_NONE;
}
