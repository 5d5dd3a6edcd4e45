/* The pose of a scan in an E57 file: takes the scan's coordinates to the file's. */
#ifndef STP_FORMATS_SCAN_E57_E57_POSE_H
#define STP_FORMATS_SCAN_E57_E57_POSE_H

#include "base/vec.h"
#include "formats/scan/e57/e57_xml.h"

/* x' = rows x + translation; rows are orthonormal. */
typedef struct stp_e57_pose {
    bool is_identity;
    stp_dvec3 rows[3], translation;
} stp_e57_pose;

/* Gets the scan's pose; the identity if the scan has none. path: for messages. Errors: CORRUPT (a
 * rotation by a quaternion of length 0). */
stp_status stp_e57_pose_of(stp_e57_pose *pose, const stp_e57_scan *scan, const char *path,
                           stp_error *err);
/* Rotates a direction. For a position, add the translation. */
static inline stp_dvec3 stp_e57_rotate(const stp_e57_pose *pose, stp_dvec3 v)
{
    return (stp_dvec3){stp_dvec3_dot(pose->rows[0], v), stp_dvec3_dot(pose->rows[1], v),
                       stp_dvec3_dot(pose->rows[2], v)};
}

#endif
