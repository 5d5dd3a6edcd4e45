/* Whether the points of a file can have been seen from a position that the file claims.
 *
 * A scanner's rays leave one place, so it sees one surface along each. The rule:
 *  - Points that are an image (scan.h: a grid): rays from the position meet the pixels of one
 *    projective map, 95 % of them to within a pixel (image_fit.h), or they go on evenly: where the
 *    distance jumps between neighbours in a row by more than 5 %, the step from ray to ray changes
 *    by less than itself, in 90 % of the jumps.
 *  - Other points: a depth image from the position has one surface: at most 5 % of the points lie
 *    behind others in the same pixel, pixels being so large that a few points share one.
 * A position that nobody wrote (STP_STATION_DEFAULT) wants evidence, too: from places beside it,
 * away along each axis by a tenth of the median distance (an image) or a quarter of it (other
 * points), the same is not so: of six at most two may do, or at least three hide more points. From
 * an image of a plane, any place is as good.
 *
 * Before the cloud is sorted. At most STP_SEEN_POINTS points are looked at. Threads: any (the cloud
 * is only read). */
#ifndef STP_PREPROCESS_VIEWPOINT_SEEN_FROM_H
#define STP_PREPROCESS_VIEWPOINT_SEEN_FROM_H

#include "preprocess/viewpoint/image_fit.h"

#define STP_SEEN_POINTS 131072u

/* image: of the points, or NULL. *out: whether they may have been seen from there. word: not TOLD,
 * which needs no check. Errors: OUT_OF_MEMORY. */
stp_status stp_seen_from(bool *out, const stp_file_points *points, const stp_image *image,
                         stp_dvec3 position, stp_station_word word, stp_error *err);

/* Share of the points that lie behind others as seen from a position: positions is a sample.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_hidden_share(double *out, const stp_dvec3 *positions, uint32_t count,
                            stp_dvec3 position, stp_error *err);

#endif
