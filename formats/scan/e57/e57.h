/* Reads E57 files (ASTM E2807) as a stream of points: all scans of data3D, one after the other.
 *
 * Fields that are read: cartesian coordinates, else spherical ones; normals (of the extension for
 * normals), colours, intensity and classification. Each scan's pose takes its coordinates to the
 * file's. The other numbers are attributes (e57_numbers.h). The note "left_out" names the fields
 * that are not kept; coordinateMetadata is the note "wkt". If only the direction of a record is
 * valid, the record is a ray without a return. If the record is not valid at all, or its state is
 * no number of the standard, it is an invalid point. A record at exactly the origin of a scan with
 * spherical coordinates, or rows or columns, is a hole (STP_REJECT_ORIGIN). A scan with a pose has
 * a station at the pose. Programs also write a pose that changes nothing for merged clouds. So such
 * a pose gives a station only if the scan has spherical coordinates, or rows or columns. Scans with
 * rows, columns and a station are images, if these are wanted (e57_images.h).
 *
 * Intensities and colours: the file's limits (of all scans together, so that scans stay comparable)
 * map to 0..65535. Without limits the bounds of the field do, else the range that value_range.h
 * finds in up to 65,536 points of each scan. If some points have a colour, the others are light
 * grey. Memory: about 1.5 MiB, with attributes up to 6 MiB, and 2 KiB per scan. images2D is
 * not read. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_E57_E57_H
#define STP_FORMATS_SCAN_E57_E57_H

#include "formats/scan/scan_reader.h"

extern const stp_scan_reader stp_e57_reader;

#endif
