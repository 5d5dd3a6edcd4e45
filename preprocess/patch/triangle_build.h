/* One patch out of up to 21 triangles: quantised corners, and discs that stand for them.
 *
 * Corners lie on the world's own lattices, whatever the chunk: those of one vertex are at one place
 * in all patches. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_PATCH_TRIANGLE_BUILD_H
#define STP_PREPROCESS_PATCH_TRIANGLE_BUILD_H

#include "formats/scan/mesh/triangle_set.h"
#include "preprocess/patch/patch_build.h"

/* Triangles of a patch, at most. */
#define STP_PATCH_TRIANGLE_COUNT 21u
/* Lattices of a vertex and of a patch it is in differ by no more octaves. */
#define STP_CORNER_OCTAVES 12

typedef struct stp_triangle_part {
    uint32_t first; /* of the triangles in their order */
    uint32_t count;
    int exponent;        /* of the patch's lattice */
    int coarsest;        /* greatest of its corners' lattices and its own */
    int vertex_exponent; /* of the lattice of its last disc's centre */
} stp_triangle_part;

/* What parts are made from: triangles by their order, and each vertex's lattice. */
typedef struct stp_triangle_source {
    const stp_triangle_set *set;
    const uint32_t *order;
    const int16_t *exponents;
} stp_triangle_source;

/* A corner's vertex; corner of the part, from 0. */
static inline uint32_t stp_corner_vertex(const stp_triangle_source *source,
                                         const stp_triangle_part *part, unsigned corner)
{
    return source->set->triangles[source->order[part->first + corner / 3]][corner % 3];
}

/* chunk_origin is a multiple of twice each of the part's lattices; greatest: intensity that 255
 * stands for. Returns false if the part is too far from the origin, or too large. */
bool stp_triangles_build(const stp_triangle_source *source, const stp_triangle_part *part,
                         uint16_t greatest, stp_dvec3 chunk_origin, stp_patch *patch,
                         stp_patch_samples *samples, stp_item *vertex);

#endif
