/* OpenMesh's readers of OBJ, OFF and STL behind C callbacks.
 *
 * Translates and nothing else: what the reader finds goes straight to the sink, so that no face is
 * dropped for being non-manifold (OpenMesh's own mesh would refuse it). OpenMesh reads coordinates
 * through float. Its readers keep state, so a mutex lets one call in at a time. */
#ifndef STP_FORMATS_SCAN_MESH_OPENMESH_SHIM_H
#define STP_FORMATS_SCAN_MESH_OPENMESH_SHIM_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A status other than STP_OK ends the reading with it; the callee has set err then. Vertex numbers
 * count from 0 in order of the vertex calls, but a face or normal may name one that does not exist:
 * the callee checks. */
typedef struct stp_openmesh_sink {
    void *context;
    stp_status (*vertex)(void *context, const float position[3], stp_error *err);
    /* May come several times for a vertex: once for each corner. */
    stp_status (*normal)(void *context, int64_t vertex, const float normal[3], stp_error *err);
    stp_status (*face)(void *context, const int64_t *vertices, size_t count, stp_error *err);
} stp_openmesh_sink;

typedef struct stp_openmesh_input {
    const char *path; /* for messages only */
    const void *data; /* the whole file */
    size_t size;
    const char *extension; /* ".obj", ".off" (without normals and colours), ".stl" */
    bool binary;           /* STL */
} stp_openmesh_input;

/* Errors: CORRUPT, OUT_OF_MEMORY, and whatever the sink returns. */
stp_status stp_openmesh_read(const stp_openmesh_input *input, const stp_openmesh_sink *sink,
                             stp_error *err);

#endif
