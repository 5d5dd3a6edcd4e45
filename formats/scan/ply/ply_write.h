/* Writes points, faces and edges as a stream of binary little-endian PLY.
 *
 * The counts are fixed when the writer is created, because the PLY header states them. Write all
 * points, then all triangles, then all edges, then call finish. The file appears whole or not at
 * all (base/file.h). Does not write textures or ASCII. Memory: bounded. Threads: one at a time per
 * writer.
 *
 * Vertex properties, in this order: x y z (as given); nx ny nz (float); red green blue (uchar: the
 * upper byte of the 16-bit colour, rounded); intensity (ushort); classification (uchar); station
 * (its number, counted from 0, as uchar, or ushort if there are more than 255; unknown: the type's
 * greatest value); outlier (uchar, 1 or 0); radius (float, half the width of lines; only if there
 * are edges); attributes by their names, spaces as _, in their own type, as double if they have a
 * scale or 64 bits of an integer. Those with a name from above get _full behind it. Positions of
 * stations are comments, see ply_stations.h. Faces are `list uchar int vertex_indices`, edges are
 * `int vertex1`, `int vertex2`; int becomes uint if an index needs it.
 */
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
    uint64_t triangle_count;           /* 0: no face element */
    uint64_t edge_count;               /* 0: no edge element, and no radius */
    uint32_t attributes;               /* STP_POINT_HAS_* */
    const stp_attribute_list *numbers; /* attributes, borrowed; NULL: none */
    const stp_dvec3 *stations;         /* positions for the header, borrowed */
    uint32_t station_count;
} stp_ply_writer_params;

typedef struct stp_ply_writer stp_ply_writer;

/* Writes the header. params and path are copied. Errors: EXISTS, IO, OUT_OF_MEMORY,
 * INVALID_ARGUMENT (points with stations but no positions, more than STP_STATION_LIMIT stations,
 * triangles or edges without vertices or with more than 2^32 vertices). */
stp_status stp_ply_writer_create(stp_ply_writer **out, const char *path,
                                 const stp_ply_writer_params *params, stp_error *err);
/* Appends count points. Errors: IO; INVALID_ARGUMENT (more than vertex_count in all). */
stp_status stp_ply_writer_points(stp_ply_writer *writer, const stp_point *points, size_t count,
                                 stp_error *err);
/* The same with the points' radii and packed attributes; NULL for none. Radii are left out if there
 * are no edges. */
stp_status stp_ply_writer_wide_points(stp_ply_writer *writer, const stp_point *points,
                                      const float *radii, const uint8_t *packed, size_t count,
                                      stp_error *err);
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
