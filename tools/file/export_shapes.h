/* Finds for export which vertices of a file's strips and triangles are written once, and which
 * edges and faces join them. */
#ifndef STP_TOOLS_FILE_EXPORT_SHAPES_H
#define STP_TOOLS_FILE_EXPORT_SHAPES_H

#include "base/progress.h"
#include "formats/chunk/chunk_file.h"
#include "formats/scan/ply/ply_write.h"

#include <stdbool.h>

/* A joint: one strip continues another at this vertex of the output. */
typedef struct export_joint {
    uint64_t number, vertex;
} export_joint;

/* A strip, in the order in which vertices are written. */
typedef struct export_strip {
    uint64_t first; /* number of the first vertex that is the strip's own */
    uint64_t joint; /* index of the joint where the strip continues; UINT64_MAX: none */
    unsigned count; /* number of vertices of its own */
} export_strip;

typedef struct export_shapes {
    export_joint *joints; /* by number */
    export_strip *strips;
    uint64_t *triangles; /* pairs: first vertex of a patch's triangles, and number of corners */
    size_t joint_count, strip_count, triangle_patch_count;
    size_t joint_capacity, strip_capacity, triangle_capacity;
    uint64_t repeated; /* vertices that belong to another strip, too */
    uint64_t edge_count, triangle_count;
    uint64_t vertex; /* number of the next vertex that is written */
} export_shapes;

/* Finds the joints in all leaves except those left out. Errors: those of stp_chunk_file_read. */
stp_status export_shapes_find(export_shapes *out, stp_chunk_file *file, const bool *left_out,
                              stp_error *err);
/* Call it before a patch's level-0 samples are written. Returns how many of the first samples are
 * written with another strip. Errors: OUT_OF_MEMORY. */
stp_status export_shapes_patch(export_shapes *shapes, const stp_patch *patch,
                               const stp_sample *samples, stp_dvec3 origin, unsigned *skipped,
                               stp_error *err);
/* Writes triangles and edges. Call it after all vertices. Errors: those of the writer. */
stp_status export_shapes_write(const export_shapes *shapes, stp_ply_writer *writer, stp_error *err);
void export_shapes_clear(export_shapes *shapes);

#endif
