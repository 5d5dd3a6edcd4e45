/* In which order the numbers of a chunk's attributes are stored.
 *
 * A merged sample borrows the number of one of its children: the one of greatest radius, the first
 * of equals. So every level-0 sample's number is stored once, at the coarsest level that has it:
 * first those of level 3, then, level by level, those that the level above did not borrow. So level
 * l adds as many numbers as it has samples more than level l + 1. Threads: any. */
#ifndef STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_ORDER_H
#define STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_ORDER_H

#include "formats/chunk/chunk_file.h"

/* places[0, ends[0]) are the level-0 samples whose numbers are stored with level 3, and so on: part
 * k is for level 3 - k. of_vertex: by patch, its patch vertex's level-0 sample. */
typedef struct stp_attribute_order {
    uint32_t *places;  /* level-0 samples of the chunk, in the order stored */
    uint32_t *holders; /* by place: the sample of the part's level that has the number */
    uint32_t ends[STP_LEVEL_COUNT];
    uint32_t *of_vertex;
} stp_attribute_order;

/* The chunk has all levels. Errors: OUT_OF_MEMORY. Free with stp_attribute_order_clear. */
stp_status stp_attribute_order_make(stp_attribute_order *out, const stp_chunk *chunk,
                                    stp_error *err);
void stp_attribute_order_clear(stp_attribute_order *order);

/* The child that a merged sample borrows from, among its children [begin, end) of the next finer
 * level: at least one. */
static inline unsigned stp_attribute_borrowed(const stp_sample *children, unsigned begin,
                                              unsigned end)
{
    unsigned best = begin;
    for (unsigned k = begin + 1; k < end; k++)
        if (children[k].radius > children[best].radius)
            best = k;
    return best;
}

#define STP_NOT_BORROWED UINT8_MAX
/* For each sample of a level of a patch: the sample of the next coarser level, counted from the
 * patch's first, that borrows its number, or STP_NOT_BORROWED. samples: the patch's, of that level.
 */
void stp_attribute_borrowers(const stp_patch *patch, const stp_sample *samples, int level,
                             uint8_t out[STP_PATCH_SAMPLES]);

/* The level-0 sample that sample i of a level of the patch borrows from, counted from the patch's
 * first. samples: of the patch, by level. */
unsigned stp_attribute_lender(const stp_patch *patch, const stp_sample *const *samples, int level,
                              unsigned i);

#endif
