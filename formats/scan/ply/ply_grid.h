/* Reads the range image or the camera of a PLY file, from which its vertices come.
 *
 * Range images, as in Stanford's archive: header lines `obj_info num_cols C` and `obj_info num_rows
 * R`, and an element range_grid of R x C records, row by row. The list of a record is empty or
 * names a vertex. Range maps of MeshLab: an element camera of one record with its position view_px
 * view_py view_pz and its axis y_axisx y_axisy y_axisz, which points up. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_PLY_PLY_GRID_H
#define STP_FORMATS_SCAN_PLY_PLY_GRID_H

#include "formats/scan/ply/ply_columns.h"

/* Largest number of pixels that the reader passes on. */
#define STP_PLY_GRID_CELLS 32768u

/* Reads the element camera: takes its position and axis and skips the rest. Errors: as for any
 * element. */
stp_status stp_ply_camera_read(stp_ply *ply, const stp_ply_element *element, stp_error *err);
/* Reads the range image, if there is one, and goes back to the first vertex. Ignores a grid that is
 * cut off or names a vertex that does not exist. Errors: IO, OUT_OF_MEMORY. */
stp_status stp_ply_grid_read(stp_ply *ply, stp_error *err);

#endif
