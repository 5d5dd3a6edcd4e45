/* Reads the points of COLMAP's sparse models: points3D.bin, little endian.
 *
 * The number of points, 64 bits. Then each: its identity (64 bits), x y z (doubles), red green blue
 * (bytes), the error of its projections (double), and its track: a length (64 bits), and for each
 * picture two numbers of 32 bits. Identities, errors and tracks are passed over and named in a
 * note. y points down, as in points3D.txt. Threads: one at a time per scan. */
#ifndef STP_FORMATS_SCAN_COLMAP_COLMAP_H
#define STP_FORMATS_SCAN_COLMAP_COLMAP_H

#include "formats/scan/scan_reader.h"

/* Whether a file of this size, which begins with these bytes, may be one: it has room for its
 * points, all of these bytes' are made of numbers, and it ends after the last. */
bool stp_colmap_may_be(const char *bytes, size_t length, uint64_t file_size);

extern const stp_scan_reader stp_colmap_reader;

#endif
