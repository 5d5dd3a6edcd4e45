/* Implicit surfaces f = 0: makes closed triangle meshes of them and projects points onto them.
 *
 * The mesh comes from marching tetrahedra on a body-centred cubic lattice (Labelle and Shewchuk
 * 2007 for the lattice). There are no ambiguous cases, so the mesh of a closed surface is always a
 * closed manifold. Vertices are roots on lattice edges. Memory: only the blocks that the surface
 * passes through. */
#ifndef STP_TOOLS_GEN_IMPLICIT_H
#define STP_TOOLS_GEN_IMPLICIT_H

#include "tools/gen/dual.h"
#include "tools/gen/surface.h"

/* Negative inside. *part (may be NULL) is set to the number of the nearest part. */
typedef gen_dual gen_implicit(vec3s p, unsigned *part);

typedef struct gen_implicit_box {
    vec3s min, max;  /* box around the surface with a margin */
    float lipschitz; /* |f(a) - f(b)| <= lipschitz * |a - b| */
} gen_implicit_box;

/* cell: the side of the lattice's cubes. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status gen_implicit_mesh(gen_implicit *f, const gen_implicit_box *box, float cell,
                             stp_pool *pool, gen_mesh *out, stp_error *err);

/* Returns the point of the surface next to start, which is at most about reach away. Uses Newton's
 * method along the gradient, and bisection where Newton does not settle, as at creases. Writes the
 * unit normal to *normal. part as above. */
vec3s gen_implicit_project(gen_implicit *f, vec3s start, float reach, vec3s *normal,
                           unsigned *part);

#endif
