/* Errors of discs that replace triangles: a patch of up to 21 triangles, three corners each
 * (polygons of MKC08, section 4; the levels are ours).
 *
 * If a disc of a coarser level covers a corner of a triangle, the disc stands for the whole
 * triangle. Its perpendicular error is how far these triangles lie over or under its plane; heights
 * change evenly over a triangle, so the corners suffice. Its tangential error is how far its centre
 * and 16 rim points lie, in its plane, from the nearest of these triangles. A disc without a normal
 * loses its diameter. Lengths: world units; positions relative to anything. Threads: any (pure). */
#ifndef STP_FORMATS_CHUNK_MEASURE_TRIANGLES_H
#define STP_FORMATS_CHUNK_MEASURE_TRIANGLES_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/measure/patch_bounds.h"

typedef struct stp_triangles_loss {
    double error, tangential_error, colour_error;
} stp_triangles_loss;

/* The triangles [first, end) that sample j of a level stands for. */
void stp_triangles_under(const uint8_t counts[STP_LEVEL_COUNT], int level, unsigned j,
                         unsigned *first, unsigned *end);

/* The errors of a disc over the triangles [first, end) of the corners. */
stp_triangles_loss stp_triangles_lost(const stp_disc *disc, const stp_disc *corners, unsigned first,
                                      unsigned end);

/* Checks the coarser levels of a patch of triangles against SPEC.md. Returns NULL, or what is
 * wrong. */
const char *stp_triangles_fault(const stp_chunk *chunk, uint32_t patch);

#endif
