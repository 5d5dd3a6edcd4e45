/* The camera that a model is first seen by, decided when all points are there.
 *
 * If a scanner's position is known, the camera stands there: of an image (claims.h) it takes in the
 * rays of all its pixels, of other points their rays or, where these go all around, those towards
 * the largest surface. If none is known and the cloud is the inside of something (interior.h), it
 * stands within. Else there is none, and the whole model is seen. Depends on the points, the order
 * they came in and what their files say; not on threads or memory. Threads: one call at a time. */
#ifndef STP_PREPROCESS_VIEWPOINT_FIRST_VIEW_H
#define STP_PREPROCESS_VIEWPOINT_FIRST_VIEW_H

#include "preprocess/prep.h"
#include "preprocess/viewpoint/first_camera.h"

/* When normals are found, the cloud having points: sets *out unless it is set. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_first_view_of_points(stp_first_camera *out, const stp_cloud *cloud,
                                    const stp_prep_source *source, stp_error *err);

#endif
