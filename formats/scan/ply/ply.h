/* A PLY file as points, streamed, or as a mesh, whole.
 *
 * Trailing bytes after the elements that are read are tolerated, and faces and edges (element
 * `edge` with vertex1, vertex2 and perhaps red, green, blue) are looked at only when a mesh is
 * asked for. Colours and intensities that the file stores in more than 8 bits are brought to the
 * full 16-bit range by what the values are, see stp_ply_find_depths. Threads: one at a time.
 */
#ifndef STP_FORMATS_SCAN_PLY_PLY_H
#define STP_FORMATS_SCAN_PLY_PLY_H

#include "base/error.h"
#include "formats/scan/mesh/point_mesh.h"
#include "formats/scan/ply/ply_header.h"
#include "formats/scan/ply/ply_values.h"
#include "formats/scan/scan.h"
#include "formats/scan/source.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_PLY_BLOCK_POINTS 512u

typedef struct stp_ply {
    stp_source source;
    stp_ply_header header;
    stp_ply_cursor cursor;
    const stp_ply_element *vertex;
    const stp_ply_element *faces;        /* NULL: none that can be read */
    const stp_ply_element *edges;        /* likewise */
    uint64_t vertex_offset, vertex_line; /* where the vertices start */
    uint32_t attributes;                 /* STP_POINT_HAS_* */
    bool lone_station;                   /* one position, which saw all points */
    bool has_camera;                     /* which is that of an element camera */
    stp_dvec3 camera, camera_up;
    stp_scan_grid grid;
    stp_grid_cell *cells;                 /* the grid's */
    double colour_scale, intensity_scale; /* file value to 0..65535 */
    double columns[STP_PLY_TARGET_COUNT][STP_PLY_BLOCK_POINTS];
} stp_ply;

/* Reads the header and goes to the first vertex. path must outlive it. Errors: as stp_scan_open. */
stp_status stp_ply_open(stp_ply **out, const char *path, stp_error *err);
void stp_ply_close(stp_ply **ply);
/* Next points; *count 0 only at the end. Errors: IO, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_ply_read(stp_ply *ply, stp_point *points, size_t capacity, size_t *count,
                        stp_error *err);
/* All vertices, faces and edges, from the start. *mesh must be empty. Errors: IO, CORRUPT, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_ply_read_mesh(stp_ply *ply, stp_point_mesh *mesh, stp_error *err);

/* The next count <= STP_PLY_BLOCK_POINTS records into the columns. For ply.c and ply_depth.c. */
stp_status stp_ply_read_columns(stp_ply *ply, size_t count, stp_error *err);
/* Has the vertex element a property for this target, and of which type? */
const stp_ply_property *stp_ply_target_property(const stp_ply *ply, stp_ply_target target);
/* Sets the scales of colour and intensity. 8-bit types: times 257. Wider ones by the greatest value
 * m of a sample of the vertices: floats up to 1 are fractions; any values up to 255 are 8-bit ones
 * that were stored wide; others are taken as 16-bit. The sample is 64 blocks of 512 vertices spread
 * over the file, or where records have no fixed size the first 65,536 vertices; values that exceed
 * the range found are clamped. Leaves the cursor at the first vertex. Errors: IO, CORRUPT. */
stp_status stp_ply_find_depths(stp_ply *ply, stp_error *err);

#endif
