/* Points spread over the faces of a mesh, as many as wanted, one after the other.
 *
 * Stratified by area: the total area is cut into sample_count equal shares and each gets one point,
 * placed by the seed; within its triangle the point is uniform (Osada et al. 2002, eq. 1). So a
 * face gets its share of the points to within two, and the points come in the order of the faces.
 * Memory: none beside the mesh. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_MESH_MESH_SAMPLE_H
#define STP_FORMATS_SCAN_MESH_MESH_SAMPLE_H

#include "base/error.h"
#include "formats/scan/mesh/point_mesh.h"

#include <stddef.h>
#include <stdint.h>

typedef struct stp_mesh_sampler {
    const stp_point_mesh *mesh; /* borrowed */
    uint64_t sample_count, seed;
    uint64_t next;        /* sample */
    size_t triangle;      /* the one that holds the next share's begin, or one before it */
    double area_before;   /* of the triangles before it */
    double triangle_area; /* its own */
    double total_area;
} stp_mesh_sampler;

/* Errors: EMPTY (no face with a positive, finite area). */
stp_status stp_mesh_sampler_init(stp_mesh_sampler *sampler, const stp_point_mesh *mesh,
                                 uint64_t sample_count, uint64_t seed, const char *path,
                                 stp_error *err);
/* Up to capacity samples with the corners' attributes interpolated (class: the nearest corner's);
 * returns how many, 0 only at the end. */
size_t stp_mesh_sampler_next(stp_mesh_sampler *sampler, stp_point *points, size_t capacity);

#endif
