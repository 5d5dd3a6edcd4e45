/* A PLY file that is being read: its vertices, a block at a time, as columns of numbers. For the
 * files of this folder; ply.h reads points. */
#ifndef STP_FORMATS_SCAN_PLY_PLY_COLUMNS_H
#define STP_FORMATS_SCAN_PLY_PLY_COLUMNS_H

#include "base/error.h"
#include "formats/scan/ply/ply_header.h"
#include "formats/scan/ply/ply_values.h"
#include "formats/scan/scan.h"
#include "formats/scan/source.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_PLY_BLOCK_POINTS 512u

/* Attributes of the vertices: scalar properties that points have no field for, by their names, and
 * intensities of more than 8 bits. */
typedef struct stp_ply_numbers {
    stp_attribute_list list;
    double (*columns)[STP_PLY_BLOCK_POINTS]; /* by attribute; NULL: numbers are not kept */
    uint8_t *packed;                         /* of the points read last */
    size_t capacity;
} stp_ply_numbers;

typedef struct stp_ply {
    stp_source source;
    stp_ply_header header;
    stp_ply_cursor cursor;
    uint64_t lost_count; /* vertices that the header declares, and the file has no room for */
    const stp_ply_element *vertex;
    const stp_ply_element *faces;        /* NULL: there are none, or they cannot be read */
    const stp_ply_element *edges;        /* NULL likewise */
    uint64_t vertex_offset, vertex_line; /* byte and line where the vertices start */
    uint32_t attributes;                 /* STP_POINT_HAS_* */
    bool lone_station;                   /* one station saw all points */
    bool has_camera;                     /* that station comes from an element camera */
    stp_dvec3 camera, camera_up;
    stp_scan_grid grid;
    stp_grid_cell *cells;          /* the grid's */
    bool packed;                   /* vertices are packed splats (ply_splats.h) */
    struct stp_ply_splats *splats; /* their chunks */
    uint64_t splat_chunks;
    double colour_low, intensity_low;     /* file values that mean 0 */
    double colour_scale, intensity_scale; /* file value to 0..65535 */
    double columns[STP_PLY_TARGET_COUNT][STP_PLY_BLOCK_POINTS];
    stp_ply_numbers numbers;
} stp_ply;

/* Whether all records of vertices have the same size in bytes. */
static inline bool stp_ply_has_fixed_records(const stp_ply *ply)
{
    return ply->cursor.encoding != STP_PLY_ASCII && !ply->vertex->has_lists;
}

/* Whether the property is a spherical harmonic, as Gaussian splats have them: for the coefficient c
 * of degree 0, the colour is 1/2 + c / (2 sqrt(pi)) of full. */
bool stp_ply_is_harmonic(const stp_ply_property *property);
/* Whether the vertices have such colours. */
bool stp_ply_has_splats(const stp_ply *ply);

/* Finds the attributes; makes room for the numbers of so many points; packs those
 * of a block from point `first` of the read on. */
void stp_ply_numbers_find(stp_ply *ply);
stp_status stp_ply_numbers_reserve(stp_ply *ply, size_t points, stp_error *err);
void stp_ply_numbers_pack(stp_ply *ply, size_t first, size_t count);
void stp_ply_numbers_clear(stp_ply_numbers *numbers);

/* Reads the next count <= STP_PLY_BLOCK_POINTS records into the columns. */
stp_status stp_ply_read_columns(stp_ply *ply, size_t count, stp_error *err);
/* Returns the vertex property for this target, NULL if there is none. */
const stp_ply_property *stp_ply_target_property(const stp_ply *ply, stp_ply_target target);
/* Sets the scales of colour and intensity. 8-bit types: times 257. For wider types the greatest
 * value m of a sample of the vertices decides: floats up to 1 are fractions; other values up to 255
 * are 8-bit values that were stored wide; all others are 16-bit. The sample is 64 blocks of 512
 * vertices spread over the file, or the first 65,536 vertices if records have no fixed size. Values
 * above the range found are clamped. Leaves the cursor at the first vertex. Errors: IO, CORRUPT. */
stp_status stp_ply_find_depths(stp_ply *ply, stp_error *err);

#endif
