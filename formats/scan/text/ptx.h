/* Reads PTX: scans on a grid, each with the pose of its scanner.
 *
 * A scan is two lines with the numbers of columns and rows; four lines of three numbers: the
 * scanner's position and its axes; four lines of four numbers: the pose that takes its points to
 * the world; then columns * rows lines x y z, x y z i, x y z i r g b or x y z r g b. Further scans
 * follow.
 *
 * Poses are applied in double. In the format, a point is a row vector that is multiplied from the
 * left, and the last row of the pose is the translation. If the last column of a pose is the
 * translation and its last row is 0 0 0 1, the pose is transposed first. Points are measured from
 * the scanner's own origin, so the pose of that origin is where the scanner stood. If the pose is
 * the identity, the second part of the header says where it stood. Points at 0 0 0 are rays without
 * a return (STP_REJECT_NO_RETURN) and may have fewer numbers than the others. If some scans have
 * colour, scans without colour are light grey. Ranges of colours and intensities: as in text.h,
 * from about 4096 points of each scan. */
#ifndef STP_FORMATS_SCAN_TEXT_PTX_H
#define STP_FORMATS_SCAN_TEXT_PTX_H

#include "formats/scan/scan_reader.h"

/* Reads all lines once at open. info's stations are the scanners of the scans, in their order, and
 * every point names its own. Errors: IO, CORRUPT, LIMIT (more than STP_STATION_LIMIT scans),
 * UNSUPPORTED, OUT_OF_MEMORY. */
extern const stp_scan_reader stp_ptx_reader;

#endif
