/* The pose of a scan in an E57 file. */
#include "formats/scan/e57/e57_pose.h"

#include <math.h>

stp_status stp_e57_pose_of(stp_e57_pose *pose, const stp_e57_scan *scan, const char *path,
                           stp_error *err)
{
    const double *n = scan->numbers;
    /* Without a rotation, the rotation is the identity. A number that is missing or empty is zero.
     */
    const bool rotated = scan->given & (0xFu << STP_E57_ROTATION_W);
    double w = rotated ? n[STP_E57_ROTATION_W] : 1.0;
    double x = n[STP_E57_ROTATION_X], y = n[STP_E57_ROTATION_Y], z = n[STP_E57_ROTATION_Z];
    const double length = hypot(hypot(w, x), hypot(y, z));
    if (!(length > 1e-6 && length < 1e6))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: the pose of the scan with points at byte %llu is rotated by the "
                             "quaternion %g %g %g %g, which is no rotation: export the file again",
                             path, (unsigned long long)scan->file_offset, w, x, y, z);
    w /= length;
    x /= length;
    y /= length;
    z /= length;
    *pose = (stp_e57_pose){
        .rows = {{1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)},
                 {2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)},
                 {2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)}},
        .translation = {n[STP_E57_TRANSLATION_X], n[STP_E57_TRANSLATION_Y],
                        n[STP_E57_TRANSLATION_Z]},
    };
    pose->is_identity = x == 0.0 && y == 0.0 && z == 0.0 && pose->translation.x == 0.0 &&
                        pose->translation.y == 0.0 && pose->translation.z == 0.0;
    return STP_OK;
}
