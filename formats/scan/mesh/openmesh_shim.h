/* OpenMesh's readers of OBJ, OFF and STL behind C callbacks.
 *
 * The shim only translates: it passes everything straight to the sink, so non-manifold faces are
 * not dropped (OpenMesh's own mesh would refuse them). OpenMesh reads coordinates through float.
 * OpenMesh's readers keep state, so a mutex lets in one call at a time. */
#ifndef STP_FORMATS_SCAN_MESH_OPENMESH_SHIM_H
#define STP_FORMATS_SCAN_MESH_OPENMESH_SHIM_H

#include "base/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* If a callback returns a status other than STP_OK, it has set err and reading ends with that
 * status. Vertex numbers count from 0 in the order of the vertex calls. A face or normal may name a
 * vertex that does not exist: the callback checks. */
typedef struct stp_openmesh_sink {
    void *context;
    stp_status (*vertex)(void *context, const float position[3], stp_error *err);
    /* May be called several times for a vertex, once per corner. */
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
