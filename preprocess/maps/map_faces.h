/* The triangles of meshes over the grid of a map. Heights of the map are interpolated linearly in
 * them (Ochotta and others 2006, section 3.1).
 *
 * A triangle counts if it faces the plane's side: that is how most triangles at own points turn.
 * Corners that are own points make a triangle own. Own triangles support all places under them, so
 * maps overlap along the triangles between them:
 *
 *      x---x---y---y       x: points of a map, y: of another;
 *      |  /|  /|  /|       the triangles between x and y are own to both
 *      x---x---y---y
 *
 * Threads: any, a map each. */
#ifndef STP_PREPROCESS_MAPS_MAP_FACES_H
#define STP_PREPROCESS_MAPS_MAP_FACES_H

#include "preprocess/maps/face_tree.h"
#include "preprocess/maps/map_points.h"

/* Corners in the map's frame, in spacings of the grid. */
typedef struct stp_map_face {
    stp_dvec3 at[3];
    bool own;
} stp_map_face;

typedef struct stp_map_faces {
    stp_map_face *list;
    size_t count;
} stp_map_faces;

/* Finds the triangles over the grid of the own points' map. tree NULL: there are none. Errors:
 * OUT_OF_MEMORY. Free with stp_map_faces_clear. */
stp_status stp_map_faces_create(stp_map_faces *out, const stp_face_tree *tree,
                                const stp_map_points *points, const stp_map_frame *frame,
                                const stp_dbox *box, stp_error *err);
void stp_map_faces_clear(stp_map_faces *faces);
/* Sets covered[row * columns + column] of all places under own triangles. */
void stp_map_faces_cover(const stp_map_faces *faces, uint32_t columns, uint32_t rows,
                         uint8_t *covered);
/* Replaces heights, in spacings, by those of the nearest triangle, if one is near, and if they do
 * not jump where the heights before did not: a fold of the mesh. NaN stays NaN. slopes: of the
 * surface at each place, squared. jumps: stp_map_jumps (map_make.h). lifted: scratch for as many
 * heights. */
void stp_map_faces_lift(const stp_map_faces *faces, uint32_t columns, uint32_t rows,
                        const float *slopes, const double jumps[STP_MAP_BESIDE], float *heights,
                        float *lifted);

#endif
