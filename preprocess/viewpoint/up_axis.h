/* Tells from a cloud's points whether z points up, where neither its file nor the shape of its box
 * says so: an object that was scanned alone.
 *
 * z is up if something level lies at the low end of z, under much of what is there: a floor, or
 * what an object stands on; or if the cloud is a tall thing along z, and nothing lies so at the low
 * end of y. Else y is up, as objects have it. Threads: any (pure function). */
#ifndef STP_PREPROCESS_VIEWPOINT_UP_AXIS_H
#define STP_PREPROCESS_VIEWPOINT_UP_AXIS_H

#include "preprocess/viewpoint/free_space.h"

/* Share of the columns of voxels along an axis (1: y, 2: z) whose lowest tenth of the cloud's
 * extent has a level voxel, among all columns with points, less that of columns whose highest tenth
 * has one: what is level at both ends are the walls of a street that lies on its side. At least 0.
 */
double stp_floor_share(const stp_space *space, int axis);
bool stp_up_is_z(const stp_space *space);
/* Whether y points down, as cameras of photogrammetry have it. Two things must hold. At the high
 * end of y more columns are level than at the low end, by 0.3 of all. And of the file's own normals
 * there that lie along y, 19 of 20 point against it: a ground faces the cameras above it, while
 * the normals of a level top point along y. A flat wall that faces low y fits as well: whoever
 * finds a broad side (broad_side.h) goes by that. Errors: OUT_OF_MEMORY, and if ranks share the
 * cloud IO, CANCELLED. */
stp_status stp_up_is_against_y(bool *out, const stp_cloud *cloud, const stp_space *space,
                               stp_error *err);
/* Whether a camera at the origin that looks along z may have seen the points: they lie before it,
 * within 20 m, and the file's own normals point against z, on average by half. Its y points down.
 * If ground lies about the origin, such normals are wrong: many programs turn all of them the same
 * way by chance. Errors: likewise. */
stp_status stp_faces_along_z(bool *out, const stp_cloud *cloud, stp_error *err);

#endif
