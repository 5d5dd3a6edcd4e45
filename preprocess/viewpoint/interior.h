/* Whether a cloud is the inside of something, and where to stand in it.
 *
 * The eye is a clear place near the middle: of the voxels there, which rays leave in few directions
 * without meeting a surface, one with much room around and near to the middle. From it the cloud
 * is an interior if rays are enclosed, and if it is built like a room: most of what is below is
 * level, most of what is around is upright, and something stands within that is not seen from
 * outside - or, where nothing does, it is wider than high. Normals that the file gives decide
 * alone, where most of those in sight agree: facing the eye an interior, turned away an object.
 * Up is z or y, along whichever there is more floor and ceiling. Threads: one call at a time. */
#ifndef STP_PREPROCESS_VIEWPOINT_INTERIOR_H
#define STP_PREPROCESS_VIEWPOINT_INTERIOR_H

#include "preprocess/viewpoint/first_camera.h"
#include "preprocess/viewpoint/free_space.h"

/* What was found; shares are of rays or of sampled points. */
typedef struct stp_interior {
    stp_dvec3 eye;
    int up_axis;          /* 1: y, 2: z */
    double enclosed;      /* of rays from the eye */
    double level;         /* of what rays downwards meet */
    double upright;       /* of what level rays meet */
    double room;          /* distance from the eye to the next surface */
    double within;        /* of points: not seen from outside */
    double facing;        /* of given normals in sight from the eye; 0.5 if there are few */
    double height, width; /* of the box, along up and the longer side across */
    bool found;           /* it is an interior */
} stp_interior;

/* The cloud has points, and normals where these were found. */
stp_interior stp_interior_find(const stp_cloud *cloud, const stp_space *space);
/* From its eye along the longest way that is free, level but for a little. */
stp_first_camera stp_interior_camera(const stp_interior *interior, const stp_space *space);

#endif
