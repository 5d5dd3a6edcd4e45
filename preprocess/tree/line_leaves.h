/* Makes leaf chunks from polylines: parts of up to 64 vertices, and parts near each other in one
 * leaf.
 *
 * All polylines are held in memory, plus 96 bytes per part; points are not. Vertices that are not
 * finite are dropped, and the polyline is cut there. Consecutive parts share the vertex where they
 * meet. Threads: one maker; leaves may be built on any. */
#ifndef STP_PREPROCESS_TREE_LINE_LEAVES_H
#define STP_PREPROCESS_TREE_LINE_LEAVES_H

#include "preprocess/patch/strip_build.h"
#include "preprocess/tree/chunk_build.h"
#include "preprocess/tree/leaf_cut.h"

/* vertices: those of the polylines, each once. samples: those of level 0; a vertex where parts meet
 * counts twice. */
typedef struct stp_line_counts {
    uint64_t strips, vertices, segments, samples;
    uint64_t rejected; /* vertices that are not finite */
} stp_line_counts;

typedef struct stp_line_leaves {
    stp_strip_part *parts; /* leaf by leaf */
    uint32_t part_count;
    stp_leaf_run *leaves; /* of parts */
    uint32_t leaf_count;
    uint16_t intensity_max; /* of all vertices */
    stp_line_counts counts;
    stp_dbox box; /* of all vertices */
} stp_line_leaves;

/* Cuts the lines into leaves. lines: borrowed as long as the leaves are used. side: the longest of
 * the model's box. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status stp_line_leaves_create(stp_line_leaves *out, const stp_line_set *lines, double precision,
                                  double side, stp_error *err);
/* Builds one leaf. intensity_max: what 255 stands for. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status stp_line_leaf_build(const stp_line_leaves *leaves, uint32_t leaf, uint16_t intensity_max,
                               stp_built_chunk *out, stp_error *err);
void stp_line_leaves_clear(stp_line_leaves *leaves);

#endif
