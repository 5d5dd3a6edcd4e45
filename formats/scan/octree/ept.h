/* Reads an Entwine Point Tile set (EPT) as a stream of points, for scan.c.
 *
 * The path is that of ept.json, in a folder or on a web server. Tiles are LAZ, binary or zstandard.
 * Nodes come by depth, so that a part from the beginning on is the whole, coarser. With a region,
 * only nodes that it needs are opened, and all of their points are given. Coordinates, colours,
 * intensities and classes are as of LAS (las.h); normals are read from tiles that are not LAZ.
 * Notes: the coordinate system that ept.json says, as LAS has it; "left_out"; "counts", if the
 * hierarchy has another number of points than ept.json. Memory: bounded by the number of nodes that
 * are read, 40 bytes each. */
#ifndef STP_FORMATS_SCAN_OCTREE_EPT_H
#define STP_FORMATS_SCAN_OCTREE_EPT_H

#include "formats/scan/scan_reader.h"

/* Errors of open: NOT_FOUND, IO, FORMAT, VERSION, UNSUPPORTED, CORRUPT, LIMIT, OUT_OF_MEMORY. */
extern const stp_scan_reader stp_ept_reader;

#endif
