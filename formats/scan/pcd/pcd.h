/* PCD files of the Point Cloud Library as a stream of points: .5 to .7, ascii, binary and
 * binary_compressed (pcd_values.h says what memory that takes).
 *
 * Read are x y z, normal_x normal_y normal_z, rgb or rgba (packed in 4 bytes) or r g b, intensity
 * and label or class, of any type (packed colours of TYPE F as text: stp_pcd_values_find_packing);
 * the rest, and fields with a COUNT, are the note "left_out". A point of an organised cloud (HEIGHT
 * above 1) with a coordinate that is not finite is a ray without a return. The position of
 * VIEWPOINT is the station of all points, claimed where the line is not the default 0 0 0 1 0 0 0,
 * else by default the origin; its rotation is not used, since programs disagree about which way it
 * turns. An organised cloud is a grid. Ranges of intensity and of colours in parts are told by
 * value_range.h. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_PCD_PCD_H
#define STP_FORMATS_SCAN_PCD_PCD_H

#include "formats/scan/scan_reader.h"

extern const stp_scan_reader stp_pcd_reader;

#endif
