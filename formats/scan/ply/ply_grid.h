/* What a PLY file says of the image or the camera that its vertices come from.
 *
 * Range images, as of Stanford's archive: header lines `obj_info num_cols C` and `obj_info num_rows
 * R` and an element range_grid of R x C records, row by row, whose list is empty or names a vertex.
 * Range maps of MeshLab: an element camera of one record with its position view_px view_py view_pz
 * and its axis y_axisx y_axisy y_axisz, which is upwards. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_PLY_PLY_GRID_H
#define STP_FORMATS_SCAN_PLY_PLY_GRID_H

#include "formats/scan/ply/ply.h"

/* Most pixels of a range image that are told. */
#define STP_PLY_GRID_CELLS 32768u

/* Passes over the element camera and takes its position and axis. Errors: as for any element. */
stp_status stp_ply_camera_read(stp_ply *ply, const stp_ply_element *element, stp_error *err);
/* Reads the range image, if there is one, and goes back to the first vertex. A grid that is cut or
 * names no vertex is none. Errors: IO, OUT_OF_MEMORY. */
stp_status stp_ply_grid_read(stp_ply *ply, stp_error *err);

#endif
