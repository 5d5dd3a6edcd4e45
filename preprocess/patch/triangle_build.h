/* Builds one patch from up to 21 triangles: quantised corners, and discs that stand for them.
 *
 * Corners lie on the world's own lattices in every chunk, so a vertex is at one position in all
 * patches. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_PATCH_TRIANGLE_BUILD_H
#define STP_PREPROCESS_PATCH_TRIANGLE_BUILD_H

#include "formats/scan/mesh/triangle_set.h"
#include "preprocess/patch/patch_build.h"

/* Most triangles of a patch. */
#define STP_PATCH_TRIANGLE_COUNT 21u
/* The lattices of a vertex and of a patch that has the vertex differ by at most this many octaves.
 */
#define STP_CORNER_OCTAVES 12

typedef struct stp_triangle_part {
    uint32_t first; /* first triangle, in their order */
    uint32_t count;
    int exponent;        /* of the patch's lattice */
    int coarsest;        /* coarsest of its corners' lattices and its own */
    int vertex_exponent; /* of the lattice of its last disc's centre */
} stp_triangle_part;

/* What parts are made from: triangles in an order, and each vertex's lattice. */
typedef struct stp_triangle_source {
    const stp_triangle_set *set;
    uint32_t (*corners)[3]; /* of each triangle: vertices, in an order that codes well */
    int16_t *exponents;
} stp_triangle_source;

/* The vertex of a corner. corner: its number in the part, from 0. */
static inline uint32_t stp_corner_vertex(const stp_triangle_source *source,
                                         const stp_triangle_part *part, unsigned corner)
{
    return source->corners[part->first + corner / 3][corner % 3];
}

/* Builds the patch. chunk_origin: a multiple of twice each of the part's lattices. greatest: the
 * intensity that 255 stands for. Returns false if the part is too far from the origin, or too
 * large. */
bool stp_triangles_build(const stp_triangle_source *source, const stp_triangle_part *part,
                         uint16_t greatest, stp_dvec3 chunk_origin, stp_patch *patch,
                         stp_patch_samples *samples, stp_item *vertex);

#endif
