/* Decides whether the points of a file can have been seen from a position that the file claims.
 *
 * A scanner's rays leave one place, so a scanner sees one surface along each ray. The rule:
 * - Points that are an image (scan.h: a grid): one projective map takes rays from the position to
 *   pixels, 95 % of them to within a pixel (image_fit.h). Or else the rays go on evenly: look where
 *   the distance jumps by more than 5 % between neighbours in a row; in 90 % of these jumps the
 *   step from ray to ray changes by less than half of the longer step.
 * - Other points: a depth image from the position shows one surface. At most 5 % of the points lie
 *   behind others in the same pixel. Pixels are so large that a few points share one.
 *
 * A position that nobody wrote (STP_STATION_DEFAULT) needs more evidence. The same test is made
 * from six places beside the position, one step either way along each axis. A step is a tenth of
 * the median distance (image) or a quarter of it (other points). For an image at most two of the
 * six places may pass; for other points at least three must hide more points. For an image of a
 * plane, any place is as good.
 *
 * A position that is only guessed needs rays like those of a sensor, too (own_frame.h). A depth
 * camera's are proof enough.
 *
 * Call it before the cloud is sorted. At most STP_SEEN_POINTS points are used. Threads: any (the
 * cloud is only read). */
#ifndef STP_PREPROCESS_VIEWPOINT_SEEN_FROM_H
#define STP_PREPROCESS_VIEWPOINT_SEEN_FROM_H

#include "preprocess/viewpoint/image_fit.h"

#define STP_SEEN_POINTS 131072u

/* *out: whether the points may have been seen from the position. image: of the points, or NULL.
 * word: not TOLD, which needs no check. All ranks of points->ranks call it. Errors: OUT_OF_MEMORY,
 * IO, CANCELLED. */
stp_status stp_seen_from(bool *out, const stp_file_points *points, const stp_file_image *image,
                         stp_dvec3 position, stp_station_word word, stp_error *err);

/* The share of points that lie behind others as seen from a position. positions: a sample of the
 * points. Errors: OUT_OF_MEMORY. */
stp_status stp_hidden_share(double *out, const stp_dvec3 *positions, uint32_t count,
                            stp_dvec3 position, stp_error *err);

#endif
