/* Spreads sample_count points over the faces of a mesh, one after the other.
 *
 * Stratified by area: the total area is cut into sample_count equal shares. Each share gets one
 * point, placed by the seed, uniform within its triangle (Osada et al. 2002, eq. 1). So the number
 * of points of a face is its share to within two, and the points come in the order of the faces.
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
    size_t next_loose;    /* of the mesh's loose points, which come after the samples */
    size_t triangle;      /* the triangle where the next share begins, or one before it */
    double area_before;   /* of the triangles before it */
    double triangle_area; /* its own */
    double total_area;
    double texels; /* of the triangle's image, by sample */
} stp_mesh_sampler;

/* Errors: EMPTY (no face with a positive, finite area). */
stp_status stp_mesh_sampler_init(stp_mesh_sampler *sampler, const stp_point_mesh *mesh,
                                 uint64_t sample_count, uint64_t seed, const char *path,
                                 stp_error *err);
/* Writes up to capacity samples, and behind them the mesh's loose points. Returns how many, 0 only
 * at the end. Attributes are interpolated between the corners; the class is the nearest corner's,
 * and the colour is the material's, if the face has one. */
size_t stp_mesh_sampler_next(stp_mesh_sampler *sampler, stp_point *points, size_t capacity);

#endif
