/* Reads XYZ, TXT, CSV and ASC: one point per line, in a format that does not say what its numbers
 * mean.
 *
 * The columns are those of params->columns, else of a header line, else guessed from a sample
 * (columns.h). A header line is the first line that is no comment and has no number, or the last
 * comment before the points, as in `//X Y Z R G B`. With params->columns, a first line without
 * numbers is skipped. Coordinates with at most three digits after the point have a step (text.h).
 * The scan's note `columns` names the columns taken. A file without points gives no points. */
#ifndef STP_FORMATS_SCAN_TEXT_XYZ_H
#define STP_FORMATS_SCAN_TEXT_XYZ_H

#include "formats/scan/scan_reader.h"

/* Reads the whole file once to count the lines. Errors: IO, FORMAT (no columns found), CORRUPT,
 * INVALID_ARGUMENT (params->columns), UNSUPPORTED, LIMIT, OUT_OF_MEMORY. */
extern const stp_scan_reader stp_xyz_reader;

#endif
