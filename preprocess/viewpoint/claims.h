/* Checks what files say about how their points were seen, before the points are sorted. Depends on
 * the points, the order they came in and what their files say; not on threads or memory. Threads:
 * one call at a time. */
#ifndef STP_PREPROCESS_VIEWPOINT_CLAIMS_H
#define STP_PREPROCESS_VIEWPOINT_CLAIMS_H

#include "preprocess/prep.h"
#include "preprocess/viewpoint/first_camera.h"

/* Checks each file.
 * - Station: if its points cannot have been seen from the claimed station (seen_from.h), they lose
 *   the station, and stats counts them.
 * - Image: sets *out if a camera is found (image_fit.h), and the normals if a station saw the image
 *   (image_normals.h).
 *
 * begins: by rank, its first record; then all ranks check the files whose points several have, and
 * each its others. NULL: the cloud has all points. Errors: OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_claims_check(stp_first_camera *out, stp_cloud *cloud, const stp_prep_source *source,
                            stp_ranks *ranks, const uint64_t *begins, stp_pool *pool,
                            stp_prep_stats *stats, stp_error *err);

#endif
