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
/* Whether y points down, as cameras of photogrammetry have it: what is level lies at the high end
 * of y, under a third of all columns more than at the low end, and the file's own normals there
 * point against y, 19 of 20. What has a level top has normals along y there. A flat wall that faces
 * low y fits as well: whoever finds a broad side (broad_side.h) goes by that. Errors:
 * OUT_OF_MEMORY.
 */
stp_status stp_up_is_against_y(bool *out, const stp_cloud *cloud, const stp_space *space,
                               stp_error *err);

#endif
