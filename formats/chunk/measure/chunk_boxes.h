/* The boxes of many chunks, in the order of their indices: finds those that meet a box without
 * looking at all of them.
 *
 * A box above is around 8 boxes in a row below, up to one box around all. Chunks near each other
 * have indices near each other, so one box above often rules out many. Threads: any number may
 * search while nobody sets a box. */
#ifndef STP_FORMATS_CHUNK_MEASURE_CHUNK_BOXES_H
#define STP_FORMATS_CHUNK_MEASURE_CHUNK_BOXES_H

#include "formats/chunk/chunk_file.h"

#define STP_CHUNK_BOXES_ABOVE 8u
/* Enough for 2^32 chunks. */
#define STP_CHUNK_BOXES_TIERS 12

typedef struct stp_chunk_boxes {
    stp_dbox *boxes;                         /* tier by tier; first the chunks' own, by index */
    uint32_t count;                          /* chunks */
    size_t begin[STP_CHUNK_BOXES_TIERS + 1]; /* where each tier begins */
    unsigned tier_count;
} stp_chunk_boxes;

/* World box that a chunk's entry states. */
static inline stp_dbox stp_chunk_entry_box(const stp_chunk_entry *e)
{
    return (stp_dbox){stp_dvec3_add(e->origin, stp_dvec3_from_float(e->box_min)),
                      stp_dvec3_add(e->origin, stp_dvec3_from_float(e->box_max))};
}

/* All boxes are empty at first, and an empty box meets nothing. Errors: OUT_OF_MEMORY. */
stp_status stp_chunk_boxes_create(stp_chunk_boxes *out, uint32_t count, stp_error *err);
void stp_chunk_boxes_clear(stp_chunk_boxes *boxes);

void stp_chunk_boxes_set(stp_chunk_boxes *boxes, uint32_t index, const stp_dbox *box);
/* Call after writing many of the chunks' own boxes to boxes->boxes, from any thread each. */
void stp_chunk_boxes_join(stp_chunk_boxes *boxes);

/* The first index, `from` or greater, whose box meets `box`; STP_CHUNK_NONE if there is none. */
uint32_t stp_chunk_boxes_next(const stp_chunk_boxes *boxes, const stp_dbox *box, uint32_t from);

#endif
