/* What export must know of a file's strips and triangles: which vertices are there once, and which
 * edges and faces join them. */
#ifndef STP_TOOLS_FILE_EXPORT_SHAPES_H
#define STP_TOOLS_FILE_EXPORT_SHAPES_H

#include "base/progress.h"
#include "formats/chunk/chunk_file.h"
#include "formats/scan/ply/ply_write.h"

#include <stdbool.h>

/* Where one strip is continued by another, and which vertex of the output that is. */
typedef struct export_joint {
    uint64_t number, vertex;
} export_joint;

/* A strip as its vertices are written. */
typedef struct export_strip {
    uint64_t first; /* vertex: the strip's first that is its own */
    uint64_t joint; /* of the joints: where it continues; UINT64_MAX: nowhere */
    unsigned count; /* of its own */
} export_strip;

typedef struct export_shapes {
    export_joint *joints; /* by number */
    export_strip *strips;
    uint64_t *triangles; /* first vertex of each patch's, and how many corners: in pairs */
    size_t joint_count, strip_count, triangle_patch_count;
    size_t joint_capacity, strip_capacity, triangle_capacity;
    uint64_t repeated; /* vertices that are another strip's, too */
    uint64_t edge_count, triangle_count;
    uint64_t vertex; /* next to be written */
} export_shapes;

/* Looks for joints in all leaves but those left out. Errors: those of stp_chunk_file_read. */
stp_status export_shapes_find(export_shapes *out, stp_chunk_file *file, const bool *left_out,
                              stp_error *err);
/* Of a patch's level-0 samples, whose vertices are written next: how many of the first are written
 * with another strip. Errors: OUT_OF_MEMORY. */
stp_status export_shapes_patch(export_shapes *shapes, const stp_patch *patch,
                               const stp_sample *samples, stp_dvec3 origin, unsigned *skipped,
                               stp_error *err);
/* Triangles and edges, after all vertices. Errors: those of the writer. */
stp_status export_shapes_write(const export_shapes *shapes, stp_ply_writer *writer, stp_error *err);
void export_shapes_clear(export_shapes *shapes);

#endif
