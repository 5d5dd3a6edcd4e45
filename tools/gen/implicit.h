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

/* Negative inside. */
typedef gen_dual gen_implicit(vec3s p);

typedef struct gen_implicit_box {
    vec3s min, max;  /* holds the surface with a margin */
    float lipschitz; /* no |f(a) - f(b)| above this times |a - b| */
} gen_implicit_box;

/* cell: the side of the lattice's cubes. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status gen_implicit_mesh(gen_implicit *f, const gen_implicit_box *box, float cell,
                             stp_pool *pool, gen_mesh *out, stp_error *err);

/* Newton's method along the gradient; the unit normal goes to *normal. */
vec3s gen_implicit_project(gen_implicit *f, vec3s start, vec3s *normal);

#endif
