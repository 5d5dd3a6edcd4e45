/* Triangles of a model that are drawn as triangles (polygons of MKC08, section 4). Threads: any
 * once filled. */
#ifndef STP_FORMATS_SCAN_MESH_TRIANGLE_SET_H
#define STP_FORMATS_SCAN_MESH_TRIANGLE_SET_H

#include "formats/scan/mesh/line_set.h"

#define STP_LATTICE_ANY INT16_MAX

/* A vertex's direction is the surface's normal, zero if unknown. Its radius is 0, or at a border
 * the radius of the points that continue the surface. */
typedef struct stp_triangle_set {
    stp_line_vertex *vertices;
    uint64_t vertex_count;
    uint32_t (*triangles)[3]; /* three vertex numbers each */
    uint64_t triangle_count;
    int16_t *lattices; /* by vertex: it lies on multiples of 2^this and stays there. NULL, or
                          STP_LATTICE_ANY: a vertex may be moved a little */
} stp_triangle_set;

/* Frees what the set owns. */
void stp_triangle_set_clear(stp_triangle_set *set);

#endif
