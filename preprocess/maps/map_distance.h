/* How far a point is from the surface of a map. Threads: any (pure functions). */
#ifndef STP_PREPROCESS_MAPS_MAP_DISTANCE_H
#define STP_PREPROCESS_MAPS_MAP_DISTANCE_H

#include "preprocess/maps/map.h"

/* The distance from a point to a triangle that has an area. */
double stp_triangle_distance(stp_dvec3 p, const stp_dvec3 corners[3]);
/* The distance from a world point to the nearest triangle of the map, of those in the 3 x 3 squares
 * about the point's own; INFINITY if there are none. So the map is no farther than this. */
double stp_map_distance(const stp_map *map, stp_dvec3 world);

#endif
