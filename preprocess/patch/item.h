/* What a level-0 sample of a chunk is made from: a point of the scan, or the patch vertex of a
 * child chunk (of points or of lines). The item carries everything that the sample stands for.
 * Positions are world coordinates in double. */
#ifndef STP_PREPROCESS_PATCH_ITEM_H
#define STP_PREPROCESS_PATCH_ITEM_H

#include "formats/chunk/measure/patch_bounds.h"

/* The source of an item that is no point of the scan, nor borrows from one. */
#define STP_SOURCE_NONE UINT64_MAX

typedef struct stp_item {
    stp_disc disc;   /* centre in world coordinates */
    double spread;   /* of a vertex beside holes (holes.h): originals lie within this distance */
    double area;     /* spacing squared, summed over the originals */
    double loose;    /* how far off the centre may be stored, world units; 0: to its lattice */
    int exponent;    /* the centre may be rounded to multiples of 2^exponent; a vertex's is one */
    uint32_t sheet;  /* items of different sheets share no patch */
    uint64_t source; /* place in the input; a vertex borrows that of one of its points */
    uint8_t intensity, class_id;
    uint8_t flags;     /* STP_SAMPLE_* */
    uint8_t normal[3]; /* disc.normal as stored: quantised once, here */
} stp_item;

#endif
