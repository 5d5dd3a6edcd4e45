/* The header of a PLY file: which records follow.
 *
 * Turk's PLY 1.0: elements in file order, each with scalar and list properties of eight types under
 * two conventions of names (char or int8, ..., double or float64); int64 and uint64 are read, too.
 * Reads ASCII and both byte orders. Lines end in \n or \r\n. obj_info lines, and comments other
 * than those of ply_stations.h, are skipped. */
#ifndef STP_FORMATS_SCAN_PLY_PLY_HEADER_H
#define STP_FORMATS_SCAN_PLY_PLY_HEADER_H

#include "base/error.h"
#include "formats/scan/column_name.h"
#include "formats/scan/mesh/material.h"
#include "formats/scan/ply/ply_stations.h"
#include "formats/scan/source.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum stp_ply_encoding {
    STP_PLY_ASCII,
    STP_PLY_BINARY_LITTLE_ENDIAN,
    STP_PLY_BINARY_BIG_ENDIAN
} stp_ply_encoding;

typedef enum stp_ply_type {
    STP_PLY_INT8,
    STP_PLY_UINT8,
    STP_PLY_INT16,
    STP_PLY_UINT16,
    STP_PLY_INT32,
    STP_PLY_UINT32,
    STP_PLY_INT64, /* as programs of NumPy write them */
    STP_PLY_UINT64,
    STP_PLY_FLOAT32,
    STP_PLY_FLOAT64
} stp_ply_type;

/* What we use a scalar property of a vertex for. */
typedef enum stp_ply_target {
    STP_PLY_X = STP_COLUMN_X,
    STP_PLY_Y = STP_COLUMN_Y,
    STP_PLY_Z = STP_COLUMN_Z,
    STP_PLY_RED = STP_COLUMN_RED,
    STP_PLY_GREEN = STP_COLUMN_GREEN,
    STP_PLY_BLUE = STP_COLUMN_BLUE,
    STP_PLY_NX = STP_COLUMN_NX,
    STP_PLY_NY = STP_COLUMN_NY,
    STP_PLY_NZ = STP_COLUMN_NZ,
    STP_PLY_INTENSITY = STP_COLUMN_INTENSITY,
    STP_PLY_CLASS = STP_COLUMN_CLASS,
    STP_PLY_STATION = STP_COLUMN_COUNT,
    STP_PLY_RADIUS, /* half the width of lines through the vertex */
    STP_PLY_S,      /* place in an image, if the file names one */
    STP_PLY_T,
    STP_PLY_TARGET_COUNT /* also: not used */
} stp_ply_target;

#define STP_PLY_NAME_CHARS 64

typedef struct stp_ply_property {
    char name[STP_PLY_NAME_CHARS];
    stp_ply_type type; /* of the scalar, or of a list's entries */
    bool is_list;
    stp_ply_type count_type; /* of a list's length */
    stp_ply_target target;   /* vertex scalars only */
    uint32_t extra;          /* the attribute that it is, counted from 1; 0: none */
    size_t offset;           /* in the record, if the element has no lists (binary) */
} stp_ply_property;

/* Whether the property is a whole colour, 0xRRGGBB, as PCD has them: `rgb` or `rgba`, an integer of
 * 32 bits or a float of these bits. stp_ply_read_columns parts it. */
bool stp_ply_is_packed(const stp_ply_property *property);

typedef struct stp_ply_element {
    char name[STP_PLY_NAME_CHARS];
    uint64_t count;
    size_t property_first, property_count; /* indices into the header's properties */
    bool has_lists;
    size_t stride; /* bytes of a binary record, in which a list counts as its length alone */
} stp_ply_element;

typedef struct stp_ply_header {
    stp_ply_encoding encoding;
    stp_ply_element *elements;
    size_t element_count, element_capacity;
    stp_ply_property *properties;
    size_t property_count, property_capacity;
    stp_ply_stations stations; /* sorted */
    stp_materials textures;    /* images, of lines `comment TextureFile NAME` */
    uint64_t grid_size[2];     /* columns and rows of a range image; 0: not given */
    uint64_t data_offset;      /* first byte after the header */
    uint64_t header_lines;
} stp_ply_header;

/* Bytes of one value. */
size_t stp_ply_type_size(stp_ply_type type);

/* Reads from the start of source to the end of the line end_header. Errors: IO, CORRUPT (with the
 * line), UNSUPPORTED (unknown PLY version or encoding), LIMIT, OUT_OF_MEMORY. */
stp_status stp_ply_header_read(stp_ply_header *out, stp_source *source, stp_error *err);
void stp_ply_header_free(stp_ply_header *header);

/* The element of this name, or NULL. */
const stp_ply_element *stp_ply_header_find(const stp_ply_header *header, const char *name);
/* The element of vertices: `vertex`, else `vertices`, `point` or `points`; or NULL. */
const stp_ply_element *stp_ply_header_find_vertices(const stp_ply_header *header);
/* The scalar property of an element by its name, or NULL. */
const stp_ply_property *stp_ply_number_property(const stp_ply_header *header,
                                                const stp_ply_element *element, const char *name);
/* The list of vertex numbers of a `face` or `tristrips` element, or NULL. */
const stp_ply_property *stp_ply_index_list(const stp_ply_header *header,
                                           const stp_ply_element *element);

#endif
