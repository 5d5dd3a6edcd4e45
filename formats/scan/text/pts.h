/* PTS, Leica's list of points: a line with their number, then a line a point: x y z, x y z i,
 * x y z i r g b or x y z r g b; again a number and points where several lists follow each other.
 *
 * Columns are told by content as in columns.h, an intensity before the colour, unless
 * params->columns names them; intensities from -2048 to 2047 become 0 to 65535 (text.h). A number
 * that disagrees with the lines is an error. A list without its number is an XYZ file. */
#ifndef STP_FORMATS_SCAN_TEXT_PTS_H
#define STP_FORMATS_SCAN_TEXT_PTS_H

#include "formats/scan/scan_reader.h"

/* Goes through all lines once. Errors: as stp_xyz_open. */
extern const stp_scan_reader stp_pts_reader;

#endif
