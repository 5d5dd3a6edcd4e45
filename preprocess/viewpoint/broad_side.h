/* Finds things that are flat and stand upright, or lie in any way but level: facades, walls,
 * paintings, tablets. They are seen from their broad side, whatever the axes of their file.
 * Threads: the main thread. */
#ifndef STP_PREPROCESS_VIEWPOINT_BROAD_SIDE_H
#define STP_PREPROCESS_VIEWPOINT_BROAD_SIDE_H

#include "preprocess/cloud/cloud.h"

typedef struct stp_broad_side {
    bool found;
    stp_dvec3 normal; /* unit vector to where the side is seen from */
    stp_dvec3 up;     /* y or z */
} stp_broad_side;

/* Looks at the points within the box, one at least. up: what is up, y or z; zero: not known. If it
 * is not known, the axis of y and z that lies more along the side is up: z, if y or x is thin.
 * Points that are thin along z are ground. Normals tell which side is seen; without normals it is
 * the side that the view of a whole model shows. Errors: OUT_OF_MEMORY, and if ranks share the
 * cloud IO, CANCELLED. */
stp_status stp_broad_side_find(stp_broad_side *out, const stp_cloud *cloud, const stp_dbox *box,
                               stp_dvec3 up, stp_error *err);

#endif
