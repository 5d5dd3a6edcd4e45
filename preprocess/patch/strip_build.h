/* Builds one patch from a part of a polyline: quantised vertices, coarser levels through some of
 * them, and the disc that stands for all.
 *
 * Vertices lie on the world's own lattices in every chunk. So the last vertex of one part and the
 * first of the next, which are the same vertex, stay the same. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_PATCH_STRIP_BUILD_H
#define STP_PREPROCESS_PATCH_STRIP_BUILD_H

#include "formats/scan/mesh/line_set.h"
#include "preprocess/patch/patch_build.h"

/* Vertices [first, first + count) of a polyline, 1 to 64. */
typedef struct stp_strip_part {
    const stp_line_vertex *line; /* all vertices of the polyline, finite */
    uint64_t line_count, first;
    unsigned count;
    stp_line_kind kind;
    int exponent;              /* of the patch's lattice */
    int first_exponent;        /* of the first vertex's lattice, which is no finer */
    int last_exponent;         /* of the last vertex's lattice, likewise */
    int vertex_exponent;       /* of the lattice of the disc's centre */
    bool continues, continued; /* the first, or last, vertex is also another part's */
} stp_strip_part;

/* Half the width; 0 if the vertex has none. */
static inline double stp_line_radius(const stp_line_vertex *v)
{
    return isfinite(v->radius) && v->radius > 0.0f ? (double)v->radius : 0.0;
}

/* Sets the part's exponents. Positions are kept to a quarter of the least half-width (ribbons:
 * 1/32; lines without a width: 1/32 of the mean distance of vertices), and to `precision` if that
 * is positive. If the part is more than 2^15 steps long, the lattice is coarser. Returns by how
 * many octaves. side: the longest of the model's box. */
int stp_strip_choose_lattice(stp_strip_part *part, double precision, double side);

/* Builds the patch. chunk_origin: a multiple of twice each of the part's lattices. greatest: the
 * intensity that 255 stands for. Returns false if the part is too far from the origin. */
bool stp_strip_build(const stp_strip_part *part, uint16_t greatest, stp_dvec3 chunk_origin,
                     stp_patch *patch, stp_patch_samples *samples, stp_item *vertex);

#endif
