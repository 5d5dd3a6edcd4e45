/* What discs in place of triangles lose: a patch of up to 21 triangles, three corners each
 * (polygons of MKC08, section 4; the levels are ours).
 *
 * A disc of a coarser level stands for the triangles of all corners it covers, wholly. Its
 * perpendicular error is how far they lie over or under its plane: heights over a triangle change
 * evenly, so that corners suffice. Its tangential error is how far its centre and
 * 16 rim points lie, in its plane, from the nearest of these triangles. A disc without a normal
 * loses its diameter. Lengths: world units; positions relative to anything. Threads: any (pure). */
#ifndef STP_FORMATS_CHUNK_MEASURE_TRIANGLES_H
#define STP_FORMATS_CHUNK_MEASURE_TRIANGLES_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/measure/patch_bounds.h"

typedef struct stp_triangles_loss {
    double error, tangential_error, colour_error;
} stp_triangles_loss;

/* First and behind the last of the triangles that sample j of a level stands for. */
void stp_triangles_under(const uint8_t counts[STP_LEVEL_COUNT], int level, unsigned j,
                         unsigned *first, unsigned *end);

/* What a disc loses over triangles [first, end) of the corners. */
stp_triangles_loss stp_triangles_lost(const stp_disc *disc, const stp_disc *corners, unsigned first,
                                      unsigned end);

/* NULL if the coarser levels of a patch of triangles stand for them as SPEC.md says, else what does
 * not. */
const char *stp_triangles_fault(const stp_chunk *chunk, uint32_t patch);

#endif
