/* Reads a PLY file as a stream of points, or whole as a mesh.
 *
 * Bytes after the last element that is read are tolerated. Faces and edges (element `edge` with
 * vertex1, vertex2 and perhaps red, green, blue) are read only if a mesh is asked for. Colours and
 * intensities that have more than 8 bits in the file are scaled to the full 16-bit range, see
 * stp_ply_find_depths. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_PLY_PLY_H
#define STP_FORMATS_SCAN_PLY_PLY_H

#include "base/error.h"
#include "formats/scan/mesh/point_mesh.h"
#include "formats/scan/ply/ply_columns.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Reads the header and goes to the first vertex. salvage: of a cut file, counts the vertices that
 * it has room for. path must outlive it. Errors: as stp_scan_open. */
stp_status stp_ply_open(stp_ply **out, const char *path, bool salvage, stp_error *err);
void stp_ply_close(stp_ply **ply);
/* Reads the next points; *count is 0 only at the end. Errors: IO, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_ply_read(stp_ply *ply, stp_point *points, size_t capacity, size_t *count,
                        stp_error *err);
/* Whether images or, where vertices have none, faces have the colours. */
bool stp_ply_faces_have_colours(const stp_ply *ply);
/* Reads on at this vertex, of records of one size. */
void stp_ply_seek(stp_ply *ply, uint64_t vertex);
/* Reads all vertices, faces and edges from the start. *mesh must be empty. Errors: IO, CORRUPT,
 * LIMIT, OUT_OF_MEMORY. */
stp_status stp_ply_read_mesh(stp_ply *ply, stp_point_mesh *mesh, stp_error *err);

/* From here on stp_ply_read also packs the attributes. Errors: OUT_OF_MEMORY. */
stp_status stp_ply_numbers_keep(stp_ply *ply, stp_error *err);

#endif
