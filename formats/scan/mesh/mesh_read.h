/* Reads OBJ, OFF and STL into a point mesh through OpenMesh, and glTF. Threads: any, one file each.
 */
#ifndef STP_FORMATS_SCAN_MESH_MESH_READ_H
#define STP_FORMATS_SCAN_MESH_MESH_READ_H

#include "base/error.h"
#include "formats/scan/detect.h"
#include "formats/scan/mesh/point_mesh.h"

/* *mesh must be empty. Normals of corners are averaged per vertex. STL corners at the same place
 * become one vertex. Errors: NOT_FOUND, IO, CORRUPT (with line or byte), UNSUPPORTED, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_mesh_read(stp_point_mesh *mesh, const char *path, stp_scan_format format,
                         stp_error *err);

#endif
