/* Reads the XML section of an E57 file: its scans, where their points are and which fields they
 * have.
 *
 * Kept from the tree below e57Root: coordinateMetadata, and for each child of data3D the pose, the
 * limits of intensity and colours, and points with its prototype. Everything else is skipped;
 * images2D and blobs are not read. Expat parses the section as a stream. Hostile XML is bounded: no
 * document type (so no entities), at most 64 levels, 64 MiB, 1 MiB in one tag and a million tags
 * and attributes. Memory: some 2 KiB per scan,
 * and 100 bytes for each field that may be an attribute. Threads: any once read. */
#ifndef STP_FORMATS_SCAN_E57_E57_XML_H
#define STP_FORMATS_SCAN_E57_E57_XML_H

#include "base/error.h"
#include "formats/attribute/attribute.h"
#include "formats/scan/e57/e57_pages.h"
#include "formats/scan/name_list.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* What we use a field of a point for. */
typedef enum stp_e57_target {
    STP_E57_X,
    STP_E57_Y,
    STP_E57_Z,
    STP_E57_RANGE,
    STP_E57_AZIMUTH,
    STP_E57_ELEVATION,
    STP_E57_CARTESIAN_INVALID,
    STP_E57_SPHERICAL_INVALID,
    STP_E57_NX, /* of the extension for surface normals */
    STP_E57_NY,
    STP_E57_NZ,
    STP_E57_RED,
    STP_E57_GREEN,
    STP_E57_BLUE,
    STP_E57_COLOUR_INVALID,
    STP_E57_INTENSITY,
    STP_E57_INTENSITY_INVALID,
    STP_E57_CLASS,
    STP_E57_ROW, /* if images are wanted; else attributes alone */
    STP_E57_COLUMN,
    STP_E57_TIME_INVALID, /* of the attribute timeStamp */
    STP_E57_TARGET_COUNT  /* also: not used */
} stp_e57_target;

typedef enum stp_e57_type { STP_E57_INTEGER, STP_E57_FLOAT, STP_E57_DOUBLE } stp_e57_type;

/* A field as the prototype declares it. A whole number is stored less its minimum, in as many bits
 * as the maximum needs. The value is the whole number times scale plus offset. */
typedef struct stp_e57_field {
    bool present;
    stp_e57_type type;
    bool is_scaled;       /* a whole number with a scale */
    bool is_bounded;      /* the file gives low and high */
    uint32_t stream;      /* index among the bytestreams of a packet */
    uint32_t bits;        /* 0 to 64 */
    int64_t minimum;      /* of whole numbers */
    double scale, offset; /* 1 and 0 if there are none */
    double low, high;     /* bounds of the value */
} stp_e57_field;

/* A field that may be an attribute (e57_numbers.h). */
typedef struct stp_e57_extra {
    stp_e57_field field;   /* present: it is one */
    uint32_t name;         /* index in the document's names */
    stp_e57_target target; /* which also uses it */
    stp_e57_target
        invalid; /* which says that a value is not valid; fields[invalid] may be absent */
} stp_e57_extra;

/* Numbers that a scan may give. */
typedef enum stp_e57_slot {
    STP_E57_ROTATION_W,
    STP_E57_ROTATION_X,
    STP_E57_ROTATION_Y,
    STP_E57_ROTATION_Z,
    STP_E57_TRANSLATION_X,
    STP_E57_TRANSLATION_Y,
    STP_E57_TRANSLATION_Z,
    STP_E57_INTENSITY_MINIMUM,
    STP_E57_INTENSITY_MAXIMUM,
    STP_E57_RED_MINIMUM,
    STP_E57_RED_MAXIMUM,
    STP_E57_GREEN_MINIMUM,
    STP_E57_GREEN_MAXIMUM,
    STP_E57_BLUE_MINIMUM,
    STP_E57_BLUE_MAXIMUM,
    STP_E57_SLOT_COUNT
} stp_e57_slot;

typedef struct stp_e57_scan {
    stp_e57_field fields[STP_E57_TARGET_COUNT + 1]; /* the last is never present */
    size_t extra_first;                             /* in the document's extras */
    uint32_t extra_count;                           /* at most STP_ATTRIBUTES_LIMIT */
    uint64_t file_offset, record_count;             /* of the points; file_offset is physical */
    uint32_t stream_count;
    uint64_t record_bits; /* bits of all fields whose width is known */
    bool has_points, has_pose;
    bool has_grid;  /* rows, columns or angles, as in the sweep of one scanner */
    uint32_t given; /* bit set of the slots that the file gives */
    double numbers[STP_E57_SLOT_COUNT]; /* finite */
} stp_e57_scan;

typedef struct stp_e57_document {
    stp_e57_scan *scans;
    size_t scan_count, scan_capacity;
    stp_e57_extra *extras; /* scan by scan */
    size_t extra_count, extra_capacity;
    stp_attribute_list names; /* of the extras; their types mean nothing */
    bool keeps_numbers;       /* attributes are wanted, so they are not left out */
    bool keeps_grid;          /* rows and columns are wanted */
    char *wkt;                /* NULL: none */
    stp_name_list left_out;   /* fields that are not read */
} stp_e57_document;

/* *document must be zero, except keeps_numbers and keeps_grid. Free it even after a failure.
 * Errors: IO, CORRUPT (with the line), UNSUPPORTED, LIMIT, OUT_OF_MEMORY. */
stp_status stp_e57_xml_read(stp_e57_document *document, stp_e57_pages *pages, stp_error *err);
void stp_e57_document_free(stp_e57_document *document);

static inline bool stp_e57_gives(const stp_e57_scan *scan, stp_e57_slot slot)
{
    return scan->given >> slot & 1u;
}

#endif
