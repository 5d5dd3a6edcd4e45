/* Implicit surfaces: closed triangle meshes of f = 0 and projection onto it.
 *
 * The mesh comes from marching tetrahedra on a body-centred cubic lattice: no ambiguous case, so
 * the mesh of a closed surface is always a closed manifold (Labelle and Shewchuk 2007 for the
 * lattice). Vertices are roots on lattice edges. Memory: blocks the surface passes through, nothing
 * else. */
#ifndef STP_TOOLS_GEN_IMPLICIT_H
#define STP_TOOLS_GEN_IMPLICIT_H

#include "tools/gen/dual.h"
#include "tools/gen/surface.h"

/* Negative inside; *part (may be NULL) is set to a number of whatever is nearest. */
typedef gen_dual gen_implicit(vec3s p, unsigned *part);

typedef struct gen_implicit_box {
    vec3s min, max;  /* holds the surface with a margin */
    float lipschitz; /* no |f(a) - f(b)| above this times |a - b| */
} gen_implicit_box;

/* cell: the side of the lattice's cubes. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status gen_implicit_mesh(gen_implicit *f, const gen_implicit_box *box, float cell,
                             stp_pool *pool, gen_mesh *out, stp_error *err);

/* The surface's point next to one no further than about reach from it: Newton's method along the
 * gradient, and bisection where that does not settle, as at creases. The unit normal goes to
 * *normal. part as above. */
vec3s gen_implicit_project(gen_implicit *f, vec3s start, float reach, vec3s *normal,
                           unsigned *part);

#endif
