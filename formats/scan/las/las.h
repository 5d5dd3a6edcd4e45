/* Reads LAS and LAZ files as a stream of points, for scan.c.
 *
 * LAS 1.0 to 1.5, point formats 0 to 10 (las_header.h). LAZ by laz.h.
 * Coordinates are integer * scale + offset in double, in the file's own unit; the least scale is
 * the coordinate_step. Colour has 8 or 16 bits (las_depth.h). The class has 5 bits in formats 0 to
 * 5 and 8 in formats 6 to 10. Withheld points are rejects (INVALID), unless params->keep_withheld.
 * LAS has no normals. Fields that are not read and the coordinate system are notes (las_notes.h).
 * Memory: bounded. */
#ifndef STP_FORMATS_SCAN_LAS_LAS_H
#define STP_FORMATS_SCAN_LAS_LAS_H

#include "formats/scan/scan_reader.h"

/* Errors of open: IO, CORRUPT (with the byte), VERSION, UNSUPPORTED (point formats
 * beyond 10; unknown ways to pack LAZ), LIMIT, OUT_OF_MEMORY. */
extern const stp_scan_reader stp_las_reader;

#endif
