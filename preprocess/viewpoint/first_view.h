/* Decides the camera that first shows a model, when all points are there.
 * - A station is known: the camera stands there. For an image (claims.h) it takes in the rays of
 *   all pixels. For other points it takes in their rays; if these go all around, it looks towards
 *   the largest surface.
 * - No station is known, and the cloud is the inside of something (interior.h): the camera stands
 *   within.
 * - A few points lie so far from all others that these would be specks, or their class calls them
 *   noise, and they lie beyond the others: the camera shows the others.
 * - Several parts lie so far apart: it shows the one that has the most points.
 * - Otherwise there is no camera, and the whole model is shown.
 * Without a station it also tells what is up, where points say it and the format does not.
 *
 * Depends on the points, the order they came in and what their files say; not on threads or memory.
 * Threads: one call at a time. */
#ifndef STP_PREPROCESS_VIEWPOINT_FIRST_VIEW_H
#define STP_PREPROCESS_VIEWPOINT_FIRST_VIEW_H

#include "preprocess/prep.h"
#include "preprocess/viewpoint/first_camera.h"

/* Sets *out unless it is set already. Call it after normals are found; the cloud has points.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_first_view_of_points(stp_first_camera *out, const stp_cloud *cloud,
                                    const stp_prep_source *source, stp_error *err);
/* For a grid of heights in box `all`: shows the heights from low to high, a share `share` of all,
 * if the others are so far away that these would be a speck. */
void stp_first_view_of_heights(stp_first_camera *out, const stp_dbox *all, double low, double high,
                               double share, const stp_prep_source *source);

#endif
