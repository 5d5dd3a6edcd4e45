/* What scanner stations see of a triangle mesh: rays against a bounding-volume tree.
 *
 * The triangles must be sorted along a space-filling curve: the tree is the implicit binary one
 * over that order, so it needs no building beyond its boxes. Threads: any once created. */
#ifndef STP_TOOLS_GEN_VISIBILITY_H
#define STP_TOOLS_GEN_VISIBILITY_H

#include "tools/gen/surface.h"

enum { GEN_STATION_LIMIT = 64 };

typedef struct gen_triangle {
    vec3s corners[3];
} gen_triangle;

typedef struct gen_visibility gen_visibility;

/* Stations stand around the surface at 2.5 radii (above it, for the terrain). triangles are
 * borrowed. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status gen_visibility_create(gen_visibility **out, const gen_surface *surface,
                                 const gen_triangle *triangles, size_t triangle_count,
                                 size_t station_count, stp_error *err);
void gen_visibility_destroy(gen_visibility **visibility);
const stp_dvec3 *gen_visibility_stations(const gen_visibility *visibility);
/* True if a station faces the point and nothing is between them, but for what is within a proxy
 * triangle's reach of the point itself. */
bool gen_visibility_sees(const gen_visibility *visibility, const gen_hit *hit);

#endif
