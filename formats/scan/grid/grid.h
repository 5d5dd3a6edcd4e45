/* Reads a grid of heights, or a depth camera's image, as points: one for each pixel, row by row,
 * the top row first.
 *
 * Heights: column c and row r of a grid that has no place in the world give x = c dx,
 * y = (rows - 1 - r) dy, z = scale * number, so that row 0 is +y. GeoTIFF and ESRI ASCII grids have
 * their own place and spacing. Normals are those of the grid, by differences of the neighbours, and
 * point upwards.
 *
 * With a pinhole, z = scale * number is the distance along the camera's axis, or along the ray; or
 * z = F B / number for disparities. x = (c - cx) z / fx to the right, y = (r - cy) z / fy
 * downwards, as depth cameras have it. Numbers <= 0 are no samples. The camera stands at the
 * origin. Without it, depth_guess.h may know the camera; the note "camera" says so.
 *
 * An image of colours that are all grey has heights in its first channel.
 *
 * One row or one column is a line of points: no grid, and without normals.
 *
 * If columns and rows are degrees, there are no normals: whoever projects the samples finds them.
 * The note "geokeys" names the system.
 *
 * No samples are numbers that are not finite, equal the file's no-data or `invalid`, -9999, -32767,
 * -32768, -99999 if the numbers beside them in the row are more than a tenth off and no `invalid`
 * is given, or where alpha is 0, of the heights or of the colours, or where the mask has no channel
 * above 0, or its alpha is 0: STP_REJECT_INVALID. */
#ifndef STP_FORMATS_SCAN_GRID_GRID_H
#define STP_FORMATS_SCAN_GRID_GRID_H

#include "formats/scan/scan_reader.h"

/* Errors: as raster.h; UNSUPPORTED (an image of colours), INVALID_ARGUMENT (colours or
 * a mask of another size). */
extern const stp_scan_reader stp_grid_reader;

#endif
