/* Reads the variable length records of a LAS file that stipple keeps: the coordinate system, as WKT
 * or GeoTIFF keys, the names of extra bytes, how points are packed, and the octree of COPC.
 *
 * Plain records (VLRs) lie between header and points, extended ones (EVLRs) after the points. If a
 * record comes twice, the first one counts. Memory: at most STP_LAS_RECORD_MAX bytes for a record
 * that is kept. Threads: any. */
#ifndef STP_FORMATS_SCAN_LAS_LAS_RECORDS_H
#define STP_FORMATS_SCAN_LAS_LAS_RECORDS_H

#include "base/error.h"
#include "formats/scan/las/las_header.h"
#include "formats/scan/source.h"

#include <stddef.h>

#define STP_LAS_RECORD_MAX ((size_t)1 << 20)

typedef enum stp_las_record_kind {
    STP_LAS_WKT,
    STP_LAS_GEO_KEYS, /* directory of keys, 16-bit numbers */
    STP_LAS_GEO_DOUBLES,
    STP_LAS_GEO_ASCII,
    STP_LAS_EXTRA_BYTES, /* 192 bytes for each */
    STP_LAS_LASZIP,      /* how the points are packed */
    STP_LAS_COPC,        /* the octree whose nodes are the chunks (copc.h) */
    STP_LAS_RECORD_KIND_COUNT
} stp_las_record_kind;

typedef struct stp_las_record {
    unsigned char *bytes; /* NULL: the file has none */
    size_t length;
} stp_las_record;

typedef struct stp_las_records {
    stp_las_record kept[STP_LAS_RECORD_KIND_COUNT];
} stp_las_records;

/* Walks all records. *out must be zero. Free it even after a failure. Errors: IO, CORRUPT (a record
 * lies where none may, with its byte), LIMIT (a record to keep is too long), OUT_OF_MEMORY. */
stp_status stp_las_records_read(stp_las_records *out, const stp_las_header *header,
                                stp_source *source, stp_error *err);
void stp_las_records_free(stp_las_records *records);

#endif
