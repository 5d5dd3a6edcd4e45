/* Corners of triangles that a block has told before.
 *
 * Each triangle stores its three corners, and triangles beside each other have equal ones. Only the
 * first of equal corners is coded in full. For any other, the file says how many different corners
 * ago its equal came. formats/SPEC.md, "Corners", has the layout. Reading treats every byte as
 * hostile. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_PREDICT_CORNERS_H
#define STP_FORMATS_CHUNK_CODEC_PREDICT_CORNERS_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/odds/symbols.h"

/* A level-0 sample of a block. */
typedef struct stp_corner {
    uint32_t ago;           /* its last equal came so many different corners ago; 0: it is told */
    uint32_t sample, patch; /* that equal, and the equal's patch; its own if it is told */
} stp_corner;

typedef struct stp_corners {
    stp_corner *of;       /* by level-0 sample; NULL: all are told */
    uint32_t recalled[2]; /* samples that are not told: elder children, last children */
} stp_corners;

/* Whether a block has triangles. */
bool stp_has_corners(const stp_chunk *block);
/* Finds equal corners; `of` stays NULL if there are none. Free with stp_corners_clear. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_corners_find(const stp_chunk *block, stp_corners *out, stp_error *err);
void stp_corners_clear(stp_corners *corners);

/* Takes which corners are equal, as symbols of a lane. Errors: OUT_OF_MEMORY. */
stp_status stp_corners_put(const stp_chunk *block, const stp_corners *corners, unsigned lane,
                           stp_symbol_writer *w, stp_error *err);
/* Errors: CORRUPT, OUT_OF_MEMORY. */
stp_status stp_corners_get(stp_symbol_reader *symbols, unsigned lane, const stp_chunk *block,
                           stp_corners *out, stp_error *err);

/* The sample that a corner equals, as its own patch stores it. What has no place there becomes any
 * other. */
stp_sample stp_corner_recall(const stp_chunk *block, stp_corner corner, const stp_patch *patch);

#endif
