/* PTX: scans on a grid, each with the pose of its scanner.
 *
 * A scan is two lines with the numbers of columns and rows; four lines of three numbers, where the
 * scanner stood and its axes; four lines of four, the pose that takes its points to the world; then
 * columns * rows lines x y z, x y z i, x y z i r g b or x y z r g b. Further scans follow.
 *
 * Poses are applied in double. As the format has it, a point is a row that is multiplied from the
 * left and the translation is the last row; a pose whose last column is the translation, and whose
 * last row is 0 0 0 1, is taken the other way round. Points are measured from the scanner's own
 * origin, so it stood where the pose takes that; where the pose is the identity, where the second
 * part of the header says. Points at 0 0 0 are rays without a return (STP_REJECT_NO_RETURN), and
 * may have fewer numbers than the others. Scans without colour among others with it are light grey.
 * Colours and intensities: as in text.h, by a look at about 4096 points of each scan. */
#ifndef STP_FORMATS_SCAN_TEXT_PTX_H
#define STP_FORMATS_SCAN_TEXT_PTX_H

#include "formats/scan/scan_reader.h"

/* Goes through all lines once. info's stations are the scans' scanners, in their order, and every
 * point names its own. Errors: IO, CORRUPT, LIMIT (more than STP_STATION_LIMIT scans),
 * UNSUPPORTED, OUT_OF_MEMORY. */
extern const stp_scan_reader stp_ptx_reader;

#endif
