/* Reads PTS, Leica's list of points: a line with their number, then one line per point: x y z, x y
 * z i, x y z i r g b or x y z r g b. If several lists follow each other, each has its number.
 *
 * params->columns names the columns; else content decides as in columns.h, with intensity before
 * colour. Intensities from -2048 to 2047 become 0 to 65535 (text.h). A number that disagrees with
 * the lines is an error. A list without its number is an XYZ file. */
#ifndef STP_FORMATS_SCAN_TEXT_PTS_H
#define STP_FORMATS_SCAN_TEXT_PTS_H

#include "formats/scan/scan_reader.h"

/* Reads all lines once at open. Errors: as stp_xyz_open. */
extern const stp_scan_reader stp_pts_reader;

#endif
