/* XYZ, TXT, CSV, ASC: one point a line, and nothing that says what its numbers are.
 *
 * Columns are those of params->columns, else of a header line (the first line that is no comment
 * and has no number, or the last comment before the points, as in `//X Y Z R G B`), else guessed
 * from a look at the file (columns.h). With params->columns a first line without numbers is passed
 * over. Coordinates with at most three digits behind the point have a step (text.h). The scan's
 * note `columns` says which were taken. A file without points is read as none. */
#ifndef STP_FORMATS_SCAN_TEXT_XYZ_H
#define STP_FORMATS_SCAN_TEXT_XYZ_H

#include "formats/scan/scan_reader.h"

/* Counts the lines: reads the whole file once. Errors: IO, FORMAT (no columns are to be found),
 * CORRUPT, INVALID_ARGUMENT (params->columns), UNSUPPORTED, LIMIT, OUT_OF_MEMORY. */
extern const stp_scan_reader stp_xyz_reader;

#endif
