/* The header of a PCD file (Point Cloud Library), versions .5 to .7.
 *
 * Each line is a keyword and its values, up to DATA. # begins a comment. Lines end in \n or \r\n.
 * Each field has a SIZE in bytes, a TYPE (I, U, F) and a COUNT of values per record; fields come in
 * any order. COUNT, HEIGHT, VIEWPOINT and one of WIDTH and POINTS may be missing. Threads: any once
 * read. */
#ifndef STP_FORMATS_SCAN_PCD_PCD_HEADER_H
#define STP_FORMATS_SCAN_PCD_PCD_HEADER_H

#include "base/error.h"
#include "base/vec.h"
#include "formats/scan/column_name.h"
#include "formats/scan/source.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef enum stp_pcd_encoding {
    STP_PCD_ASCII,
    STP_PCD_BINARY,
    STP_PCD_COMPRESSED
} stp_pcd_encoding;

/* What we use a field for. */
typedef enum stp_pcd_target {
    STP_PCD_X = STP_COLUMN_X,
    STP_PCD_Y = STP_COLUMN_Y,
    STP_PCD_Z = STP_COLUMN_Z,
    STP_PCD_RED = STP_COLUMN_RED,
    STP_PCD_GREEN = STP_COLUMN_GREEN,
    STP_PCD_BLUE = STP_COLUMN_BLUE,
    STP_PCD_NX = STP_COLUMN_NX,
    STP_PCD_NY = STP_COLUMN_NY,
    STP_PCD_NZ = STP_COLUMN_NZ,
    STP_PCD_INTENSITY = STP_COLUMN_INTENSITY,
    STP_PCD_CLASS = STP_COLUMN_CLASS,
    STP_PCD_PACKED = STP_COLUMN_COUNT, /* 0xAARRGGBB in the bits of 4 bytes, whatever their type */
    STP_PCD_TARGET_COUNT               /* also: not used */
} stp_pcd_target;

#define STP_PCD_NAME_CHARS 64

typedef struct stp_pcd_field {
    char name[STP_PCD_NAME_CHARS];
    char type; /* I, U or F; F has 4 or 8 bytes, the others 1, 2, 4 or 8 */
    uint32_t size;
    uint64_t count;
    size_t offset; /* in a binary record */
    stp_pcd_target target;
    uint32_t extra; /* 1 + index among the extras of pcd_numbers.h; 0: none */
} stp_pcd_field;

typedef struct stp_pcd_header {
    stp_pcd_encoding encoding;
    stp_pcd_field *fields;
    size_t field_count, field_capacity;
    size_t stride;           /* bytes per binary record, at most STP_PCD_STRIDE_MAX */
    uint64_t values;         /* per record */
    uint64_t height, points; /* height > 1: organised, the rows of an image */
    bool has_viewpoint;      /* VIEWPOINT exists and differs from its default */
    stp_dvec3 viewpoint;     /* the position of VIEWPOINT, else the origin; may be not finite */
    uint64_t data_offset, lines;
} stp_pcd_header;

#define STP_PCD_STRIDE_MAX ((size_t)1 << 24)

/* Reads from the start of source to the end of the DATA line. Each target gets at most one field.
 * Normals and colours get all their parts or none. Errors: IO, CORRUPT (with the line), VERSION,
 * UNSUPPORTED, LIMIT, OUT_OF_MEMORY. */
stp_status stp_pcd_header_read(stp_pcd_header *header, stp_source *source, stp_error *err);
void stp_pcd_header_free(stp_pcd_header *header);
/* NULL: no field has this target. */
const stp_pcd_field *stp_pcd_header_find(const stp_pcd_header *header, stp_pcd_target target);
/* True if the field only fills up records. */
bool stp_pcd_field_is_padding(const stp_pcd_field *field);

#endif
