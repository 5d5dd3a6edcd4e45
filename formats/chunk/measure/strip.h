/* Errors of a strip's coarser levels. A strip is a polyline of up to 64 vertices; a coarser level
 * draws a polyline through some of them, or one disc (MKC08, section 4, gives the kinds; the levels
 * are ours).
 *
 * The polyline is taken as a tube of its half-width. A segment joins two kept vertices; its
 * half-width, normal and colour change evenly. Each dropped vertex between the two is compared with
 * the point of the segment that is nearest to it. Distances and differences are convex along the
 * edges between. So no point of the polyline is farther from the segment than the worst vertex, nor
 * any point of the segment from the polyline. Lengths: world units; positions relative to anything.
 * Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_MEASURE_STRIP_H
#define STP_FORMATS_CHUNK_MEASURE_STRIP_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/measure/patch_bounds.h"

/* Level-0 vertices under one vertex of level 2, at most. */
#define STP_STRIP_CANDIDATES 16

/* error: distance plus difference of half-widths; for ribbons plus how far turning the normal moves
 * an edge. colour_error: greatest difference of a channel. */
typedef struct stp_strip_loss {
    double error, colour_error;
} stp_strip_loss;

/* Candidates for one vertex of a coarser level, as vertex numbers of level 0. */
typedef struct stp_strip_choice {
    uint8_t count;
    uint8_t vertex[STP_STRIP_CANDIDATES];
} stp_strip_choice;

/* Chooses one vertex of each choice (2 to 16 choices, in rising order) so that the greatest error
 * between two neighbours is least. Ties: the first of each. Returns the greatest loss. */
stp_strip_loss stp_strip_choose(const stp_disc *vertices, const stp_strip_choice *choices,
                                unsigned count, uint8_t *chosen);

/* Radius around `centre` that holds all vertices with their half-widths. */
double stp_strip_reach(const stp_disc *vertices, unsigned count, stp_dvec3 centre);

/* What a disc around all vertices loses: two points in it may be a diameter apart. */
stp_strip_loss stp_strip_disc_lost(const stp_disc *vertices, unsigned count, const stp_disc *disc);

/* Checks a strip with all its samples: its levels as SPEC.md says, and the stored errors. Returns
 * NULL, or what is wrong. */
const char *stp_strip_fault(const stp_chunk *chunk, uint32_t patch);

#endif
