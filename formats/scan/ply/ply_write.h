/* Points, faces and edges out as binary little-endian PLY, streamed.
 *
 * The counts are fixed when the writer is created, because PLY states them in the header: first all
 * points, then all triangles, then all edges, then finish. The file appears whole or not at all
 * (base/file.h). Vertex properties, in this order: x y z; nx ny nz (float); red green blue (uchar:
 * the upper byte of the 16-bit colour, rounded); intensity (ushort); classification (uchar);
 * station (its number, counted from 0, as uchar, or as ushort where there are more than 255;
 * unknown: the type's greatest value); outlier (uchar, 1 or 0); radius (float: half the width of
 * lines; where there are edges). Stations' positions are comments, see ply_stations.h. Faces are
 * `list uchar int vertex_indices` (uint where a vertex index needs it), edges `int vertex1`, `int
 * vertex2` (likewise). Does not write textures or ASCII. Coordinates are written as given. Memory:
 * bounded. Threads: one at a time per writer. */
#ifndef STP_FORMATS_SCAN_PLY_PLY_WRITE_H
#define STP_FORMATS_SCAN_PLY_PLY_WRITE_H

#include "base/error.h"
#include "formats/scan/scan.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_ply_writer_params {
    bool force;              /* replace an existing file */
    bool double_coordinates; /* else float */
    uint64_t vertex_count;
    uint64_t triangle_count;   /* 0: no face element */
    uint64_t edge_count;       /* 0: no edge element, and no radius */
    uint32_t attributes;       /* STP_POINT_HAS_* */
    const stp_dvec3 *stations; /* positions for the header, borrowed */
    uint32_t station_count;
} stp_ply_writer_params;

typedef struct stp_ply_writer stp_ply_writer;

/* Writes the header. params is copied, path too. Errors: EXISTS, IO, OUT_OF_MEMORY,
 * INVALID_ARGUMENT (points of stations without positions, more than STP_STATION_LIMIT of them,
 * triangles or edges without vertices or of more than 2^32 vertices). */
stp_status stp_ply_writer_create(stp_ply_writer **out, const char *path,
                                 const stp_ply_writer_params *params, stp_error *err);
/* Appends count points. Errors: IO; INVALID_ARGUMENT (more than vertex_count in all). */
stp_status stp_ply_writer_points(stp_ply_writer *writer, const stp_point *points, size_t count,
                                 stp_error *err);
/* The same with the points' radii, NULL for none; left out where there are no edges. */
stp_status stp_ply_writer_wide_points(stp_ply_writer *writer, const stp_point *points,
                                      const float *radii, size_t count, stp_error *err);
/* Appends count triangles, after all points. Errors: IO; INVALID_ARGUMENT (points are missing, more
 * than triangle_count in all, an index not below vertex_count). */
stp_status stp_ply_writer_triangles(stp_ply_writer *writer, const uint32_t (*triangles)[3],
                                    size_t count, stp_error *err);
/* Appends count edges, after all triangles. Errors: likewise. */
stp_status stp_ply_writer_edges(stp_ply_writer *writer, const uint32_t (*edges)[2], size_t count,
                                stp_error *err);
/* Makes the file appear and destroys the writer (*writer NULL, also on failure, then without a
 * file). Errors: IO, EXISTS; INVALID_ARGUMENT (fewer points, triangles or edges than announced). */
stp_status stp_ply_writer_finish(stp_ply_writer **writer, stp_error *err);
/* Abandons the file if not finished. Sets *writer to NULL; NULL inside is fine. */
void stp_ply_writer_destroy(stp_ply_writer **writer);

#endif
