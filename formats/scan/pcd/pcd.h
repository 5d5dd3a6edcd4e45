/* Reads PCD files of the Point Cloud Library as a stream of points: .5 to .7, ascii, binary and
 * binary_compressed (pcd_values.h says how much memory that takes).
 *
 * Fields that are read, of any type: x y z, normal_x normal_y normal_z, rgb or rgba (packed in 4
 * bytes) or r g b, intensity, and label or class. For packed colours of TYPE F in text, see
 * stp_pcd_values_find_packing. All other fields, and fields with a COUNT, are attributes
 * (pcd_numbers.h); the note "left_out" names those that are not kept.
 * If HEIGHT is above 1, the cloud is organised: it is a grid, and a point with a coordinate that is
 * not finite is a ray without a return. Several points at exactly (0, 0, 0) are holes, too
 * (STP_REJECT_ORIGIN). The position of VIEWPOINT is the station of all points. If
 * the line is not the default 0 0 0 1 0 0 0, the station is claimed; else the origin is the default
 * station. The rotation of VIEWPOINT is not used, because programs disagree about which way it
 * turns. value_range.h finds the ranges of intensity and of separate colours. Threads: one at a
 * time. */
#ifndef STP_FORMATS_SCAN_PCD_PCD_H
#define STP_FORMATS_SCAN_PCD_PCD_H

#include "formats/scan/scan_reader.h"

extern const stp_scan_reader stp_pcd_reader;

#endif
