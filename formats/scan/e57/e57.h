/* E57 files (ASTM E2807) as a stream of points: all scans of data3D, one after the other.
 *
 * Read are cartesian coordinates, else spherical ones, in the file's coordinates by each scan's
 * pose; normals (of the extension for them), colours, intensity and classification; the rest of the
 * fields is the note "left_out", coordinateMetadata the note "wkt". A record of which only the
 * direction is valid is a ray without a return; one that is not valid at all, or of which the state
 * is no number of the standard, an invalid point. A scan that has a pose has a station there; but a
 * pose that changes nothing says so only of a scan with spherical coordinates or with rows or
 * columns, since programs write it for merged clouds too.
 *
 * Intensities and colours: the file's limits (of all scans together, so that scans stay comparable)
 * stand for 0..65535, else the bounds of the field, else what value_range.h tells from up to 65,536
 * points of each scan. Points without a colour where others have one are light grey. Memory: about
 * 1.5 MiB, and 2 KiB for each scan. Images are not read. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_E57_E57_H
#define STP_FORMATS_SCAN_E57_E57_H

#include "formats/scan/scan_reader.h"

extern const stp_scan_reader stp_e57_reader;

#endif
