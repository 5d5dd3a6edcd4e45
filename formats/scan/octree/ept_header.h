/* The ept.json of an Entwine Point Tile set: its box, its spacing, how tiles are packed and what
 * their points have.
 *
 * EPT 1.x. Only what is read is checked; other keys may be anything. Threads: any. */
#ifndef STP_FORMATS_SCAN_OCTREE_EPT_HEADER_H
#define STP_FORMATS_SCAN_OCTREE_EPT_HEADER_H

#include "formats/scan/las/las_numbers.h"
#include "formats/scan/las/las_text.h"
#include "formats/scan/octree/octree.h"

#include <cjson/cJSON.h>

/* Bytes of a point of a tile that is not LAZ, at most. */
#define STP_EPT_RECORD_MOST 65535u

typedef enum stp_ept_packing {
    STP_EPT_LASZIP,   /* a LAZ file */
    STP_EPT_BINARY,   /* records one after the other */
    STP_EPT_ZSTANDARD /* the same in a frame of zstd */
} stp_ept_packing;

/* The fields that are read. */
typedef enum stp_ept_role {
    STP_EPT_X,
    STP_EPT_Y,
    STP_EPT_Z,
    STP_EPT_INTENSITY,
    STP_EPT_CLASS,
    STP_EPT_RED,
    STP_EPT_GREEN,
    STP_EPT_BLUE,
    STP_EPT_NORMAL_X,
    STP_EPT_NORMAL_Y,
    STP_EPT_NORMAL_Z,
    STP_EPT_WITHHELD,    /* not 0: the point is none, unless withheld points are kept */
    STP_EPT_CLASS_FLAGS, /* LAS's: bit 2 is withheld */
    STP_EPT_ROLE_COUNT
} stp_ept_role;

typedef enum stp_ept_type { STP_EPT_SIGNED, STP_EPT_UNSIGNED, STP_EPT_FLOAT } stp_ept_type;

typedef struct stp_ept_field {
    uint32_t at;   /* byte in the record */
    uint8_t bytes; /* 1, 2, 4, 8; 0: the set has no such field */
    stp_ept_type type;
    double scale, offset; /* number = value * scale + offset */
} stp_ept_field;

typedef struct stp_ept_header {
    bool keeps_withheld; /* withheld points are points, with an attribute that says so */
    stp_ept_packing packing;
    stp_octree octree;
    uint64_t point_count;  /* as written */
    uint32_t record_bytes; /* not of laszip */
    stp_ept_field fields[STP_EPT_ROLE_COUNT];
    stp_las_numbers numbers; /* attributes of records, by names like LAS's; not of laszip */
    double step;             /* the least scale of coordinates; 0: one has none */
    stp_las_text wkt, keys;  /* the coordinate system, one of them or none */
    stp_las_text left_out;   /* names of fields that are not read */
} stp_ept_header;

/* Reads the content of ept.json. path is for messages. *out must be zero, except keeps_withheld.
 * Free it even after a failure. Errors: FORMAT, VERSION, UNSUPPORTED (a way of packing),
 * OUT_OF_MEMORY. */
stp_status stp_ept_header_read(stp_ept_header *out, const cJSON *json, const char *path,
                               stp_error *err);
void stp_ept_header_free(stp_ept_header *header);

static inline bool stp_ept_has(const stp_ept_header *header, stp_ept_role role)
{
    return header->fields[role].bytes > 0;
}

static inline bool stp_ept_has_colours(const stp_ept_header *header)
{
    return stp_ept_has(header, STP_EPT_RED) && stp_ept_has(header, STP_EPT_GREEN) &&
           stp_ept_has(header, STP_EPT_BLUE);
}

/* Tiles that are LAZ have no normals. */
static inline bool stp_ept_has_normals(const stp_ept_header *header)
{
    return header->packing != STP_EPT_LASZIP && stp_ept_has(header, STP_EPT_NORMAL_X) &&
           stp_ept_has(header, STP_EPT_NORMAL_Y) && stp_ept_has(header, STP_EPT_NORMAL_Z);
}

#endif
