/* Decides whether a cloud is the inside of something, and where to stand in it.
 *
 * The eye is a clear place near the middle. Among the voxels there, one from which few rays leave
 * the cloud goes first; then much room around and a small distance from the middle count. If no
 * voxel there is enclosed, as in corridors around a corner or a court, the eye may be anywhere, if
 * most of the surface has an enclosed side.
 *
 * Seen from the eye, the cloud is an interior if most rays are enclosed and it is built like a
 * room:
 * - most of what is below is level;
 * - most of what is around is upright;
 * - most of the surface has an enclosed side: the garden around a closed house has none;
 * - something stands within that is not seen from outside; or else it is wider than high.
 *
 * If most given normals in sight agree, they decide instead of the build: facing the eye is an
 * interior, turned away is an object. Up is z or y, whichever has more floor and ceiling, and on
 * whose low end things stand. Threads: one call at a time. */
#ifndef STP_PREPROCESS_VIEWPOINT_INTERIOR_H
#define STP_PREPROCESS_VIEWPOINT_INTERIOR_H

#include "preprocess/viewpoint/first_camera.h"
#include "preprocess/viewpoint/free_space.h"

/* What was found. Shares are of rays or of sampled points. */
typedef struct stp_interior {
    stp_dvec3 eye;
    int up_axis;     /* 1: y, 2: z */
    double enclosed; /* share of rays from the eye that hit something */
    double level;    /* level share of what rays downwards hit */
    double upright;  /* upright share of what level rays hit */
    double room;     /* from the eye to the nearest surface */
    double within;   /* share of points not seen from outside */
    bool aside;      /* no place near the middle is enclosed, but the eye is */
    double lining;   /* share of the surface with an enclosed side */
    double facing;   /* share of given normals in sight that face the eye; 0.5 if there are few */
    double height, width; /* of the box: along up, and the longer side across */
    bool found;           /* the cloud is an interior */
} stp_interior;

/* Examines a cloud. It has points, and normals if they were found. Errors: OUT_OF_MEMORY, and if
 * ranks share the cloud IO, CANCELLED. */
stp_status stp_interior_find(stp_interior *out, const stp_cloud *cloud, const stp_space *space,
                             stp_error *err);
/* The camera at the interior's eye. It looks along the longest free way, nearly level. */
stp_first_camera stp_interior_camera(const stp_interior *interior, const stp_space *space);

#endif
