/* Makes a map of a part of a surface: chooses the frame, finds where the part supports the grid,
 * and samples the surface there.
 *
 * Frame: heights go along the axis of the normals' cone, rows along the part's longer side. The
 * grid's spacing is such that a part that carries all of its grid has as many samples as points.
 *
 * Support: all corners of squares with points, so every point lies over a square of the map, and
 * maps reach past each other's borders by up to a square; places that the disc of a sparse point
 * would cover; and places with points on all four sides, within two squares, so single gaps of the
 * sampling are closed:
 *
 *      .  .  x  .           x: points. o: has points within two squares in each quadrant, so it
 *      x  .  |  .              is supported though no square around it has a point
 *      -  -  o  -  -
 *         .  |  x
 *         x  .  .
 *
 * Heights are those of the surface through the points (map_points.h), or of a mesh's triangles
 * (map_faces.h).
 *
 * Rough: noise, or the steps of a depth camera, may be wider than the surface is averaged. Planes
 * through heights then say nothing. If the points' normals are fitted more widely and are far from
 * those planes, the map is rough: its samples have the mean of the points' normals.
 *
 * Threads: any, a map each. */
#ifndef STP_PREPROCESS_MAPS_MAP_MAKE_H
#define STP_PREPROCESS_MAPS_MAP_MAKE_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/maps/map.h"
#include "preprocess/maps/map_faces.h"
#include "preprocess/maps/parts/normal_cone.h"

/* Samples the surface of own points of the cloud, at least 1, whose normals have the cone, with the
 * help of the points around (map_points.h). cone_rad: the angle that all cones keep. *fits: false
 * if the part is no height field: heights jump between neighbours by more than the cone allows, or
 * the part is too thin and bent for a grid; *out is then empty. Errors: OUT_OF_MEMORY. Free
 * out->samples with free(). */
stp_status stp_map_make(stp_map *out, bool *fits, const stp_cloud *cloud,
                        const stp_map_places *places, const stp_normal_cone *cone, double cone_rad,
                        stp_error *err);
/* By neighbour (stp_map_beside): how much its height may differ, in spacings of the grid. */
void stp_map_jumps(double cone_rad, double out[STP_MAP_BESIDE]);
/* How many squares the grid of so many points may have. */
double stp_map_squares_most(uint32_t count);

#endif
