/* Makes triangle meshes of parameter domains: grids (open, or closed in both directions) and
 * spheres. */
#ifndef STP_TOOLS_GEN_GRID_H
#define STP_TOOLS_GEN_GRID_H

#include "tools/gen/surface.h"

/* The point at (u, v) in [0, 1]^2. */
typedef stp_dvec3 gen_grid_map(const gen_surface *surface, double u, double v);

typedef struct gen_grid {
    gen_grid_map *map;
    size_t columns, rows; /* cells */
    bool wraps;           /* u = 1 is u = 0 and v = 1 is v = 0 */
} gen_grid;

/* Makes one mesh of one or more grids. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status gen_grid_mesh(const gen_surface *surface, const gen_grid *grids, size_t grid_count,
                         gen_mesh *out, stp_error *err);

/* Makes a subdivided octahedron whose vertices are projected onto the surface, for star shapes
 * around the origin. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status gen_star_mesh(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                         gen_mesh *out, stp_error *err);

#endif
