/* What the coarser levels of a strip lose: a polyline of up to 64 vertices, drawn as a polyline
 * through some of them, or as one disc (MKC08, section 4, gives the kinds; the levels are ours).
 *
 * The polyline is taken as a tube of its half-width. Its part between two vertices that are kept is
 * compared with the straight segment between these, whose half-width, normal and colour change
 * evenly: each vertex that was dropped with the point of the segment nearest to it. Distances and
 * differences are convex along the edges between, so that no point of the polyline is farther from
 * the segment, nor one of the segment from the polyline, than the worst vertex.
 * Lengths: world units; positions relative to anything. Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_MEASURE_STRIP_H
#define STP_FORMATS_CHUNK_MEASURE_STRIP_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/measure/patch_bounds.h"

/* Level-0 vertices under one of level 2, at most. */
#define STP_STRIP_CANDIDATES 16

/* error: distance, and difference of half-widths; of ribbons also what turning the normal moves an
 * edge. colour_error: greatest difference of a channel. */
typedef struct stp_strip_loss {
    double error, colour_error;
} stp_strip_loss;

/* Vertices, by their numbers in level 0, one of which is a vertex of a coarser level. */
typedef struct stp_strip_choice {
    uint8_t count;
    uint8_t vertex[STP_STRIP_CANDIDATES];
} stp_strip_choice;

/* Of the vertices between `from` and `to`, where a segment joins these. */
stp_strip_loss stp_strip_lost(const stp_disc *vertices, unsigned from, unsigned to);

/* Takes one vertex of each choice, 2 to 16 in rising order, so that the greatest error between two
 * that follow each other is least; ties: the first of each. Returns what is lost, at most. */
stp_strip_loss stp_strip_choose(const stp_disc *vertices, const stp_strip_choice *choices,
                                unsigned count, uint8_t *chosen);

/* Distance from `centre` within which all vertices lie with their half-widths. */
double stp_strip_reach(const stp_disc *vertices, unsigned count, stp_dvec3 centre);

/* What a disc around all vertices loses: as much as two points in it may be apart. */
stp_strip_loss stp_strip_disc_lost(const stp_disc *vertices, unsigned count, const stp_disc *disc);

/* NULL if the levels of a strip, with all its samples, are as SPEC.md says and the stored errors
 * hold, else what does not. */
const char *stp_strip_fault(const stp_chunk *chunk, uint32_t patch);

#endif
