/* Finds what scanner stations see of a triangle mesh: rays against a bounding-volume tree.
 *
 * The triangles must be sorted along a space-filling curve. The tree is the implicit binary tree
 * over that order, so only its boxes are built. Threads: any once created. */
#ifndef STP_TOOLS_GEN_VISIBILITY_H
#define STP_TOOLS_GEN_VISIBILITY_H

#include "tools/gen/surface.h"

enum { GEN_STATION_LIMIT = 64 };

typedef struct gen_triangle {
    vec3s corners[3];
} gen_triangle;

typedef struct gen_visibility gen_visibility;

/* Places stations around the surface at 2.5 radii (above it for the terrain). triangles are
 * borrowed. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status gen_visibility_create(gen_visibility **out, const gen_surface *surface,
                                 const gen_triangle *triangles, size_t triangle_count,
                                 size_t station_count, stp_error *err);
void gen_visibility_destroy(gen_visibility **visibility);
const stp_dvec3 *gen_visibility_stations(const gen_visibility *visibility);
/* True if a station sees the point: the point faces it and nothing is between them. What lies
 * within a proxy triangle's reach of the point itself does not count. */
bool gen_visibility_sees(const gen_visibility *visibility, const gen_hit *hit);
/* Draws the station of a point among those that see it, counted from 1. The chance of a station is
 * proportional to the solid angle under which it sees the point's surroundings, like the densities
 * of scanners. 0 if none sees the point. The draw depends on key and counter alone. */
uint16_t gen_visibility_station(const gen_visibility *visibility, const gen_hit *hit, uint64_t key,
                                uint64_t counter);

#endif
