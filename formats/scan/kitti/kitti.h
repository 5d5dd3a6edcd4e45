/* Reads single turns of a lidar as KITTI and nuScenes have them: a .bin of floats, x y z intensity
 * or x y z intensity ring, little endian, without a header.
 *
 * z is up, and the scanner is at the origin. Intensities are within 0..1 or 0..255. The rings are
 * passed over and named in a note. Threads: one at a time per scan. */
#ifndef STP_FORMATS_SCAN_KITTI_KITTI_H
#define STP_FORMATS_SCAN_KITTI_KITTI_H

#include "formats/scan/scan_reader.h"

/* Whether a file of this size, which begins with these bytes, may be one: a whole number of
 * records, of which each (within these bytes) is less than 1 km away and has an intensity, and
 * perhaps a ring; not all alike. Its name must tell, too. */
bool stp_kitti_may_be(const char *bytes, size_t length, uint64_t file_size);

extern const stp_scan_reader stp_kitti_reader;

#endif
