/* The public header of a LAS file: where its points lie and how to read them.
 *
 * LAS 1.0 to 1.5 of the ASPRS, point data record formats 0 to 10; compressed files (LAZ) have the
 * same header. Every number is checked against the file before it is used. Tolerated: headers and
 * records that are longer than their version and format need, a 1.3 header without the one field
 * that 1.3 adds, a 64-bit count of 0 beside a 32-bit count. Threads: any. */
#ifndef STP_FORMATS_SCAN_LAS_LAS_HEADER_H
#define STP_FORMATS_SCAN_LAS_LAS_HEADER_H

#include "base/error.h"
#include "formats/scan/source.h"

#include <stdbool.h>
#include <stdint.h>

#define STP_LAS_FORMAT_COUNT 11u
/* Takes the place of a scale of 0, with which all points would be one. */
#define STP_LAS_SCALE_ASSUMED 0.001
/* Bytes of the public header up to 1.2, of 1.4, and of 1.5. */
#define STP_LAS_HEADER_BYTES 227u
#define STP_LAS_HEADER_BYTES_1_4 375u
#define STP_LAS_HEADER_BYTES_1_5 393u

/* The layout of a point data record format. Offsets are bytes from the record's begin; 0: not in
 * the format. */
typedef struct stp_las_format {
    uint8_t bytes; /* of the record; longer records have extra bytes */
    bool extended; /* a format of LAS 1.4: 8-bit class, other flags */
    uint8_t gps_time, rgb, nir, wave;
} stp_las_format;

typedef struct stp_las_header {
    unsigned minor_version;
    unsigned point_format; /* below STP_LAS_FORMAT_COUNT */
    const stp_las_format *format;
    bool compressed; /* LAZ */
    uint32_t header_bytes;
    uint32_t record_bytes; /* from one point to the next, at least format->bytes */
    uint64_t point_offset; /* in the file, also in a compressed one */
    uint64_t point_count;
    uint64_t lost_count;         /* that are declared, and the file has no room for (salvage) */
    uint64_t count_64, count_32; /* as written; 0 if there is none */
    uint32_t vlr_count, evlr_count;
    uint64_t evlr_offset;       /* undefined without EVLRs */
    double scale[3], offset[3]; /* coordinate = integer * scale + offset; no scale is 0 */
    unsigned scales_assumed;    /* bit of each axis whose scale is 0 in the file */
    bool has_time_offset;       /* of 1.5: GPS times begin after time_offset million seconds */
    unsigned time_offset;
} stp_las_header;

/* Format number < STP_LAS_FORMAT_COUNT. */
const stp_las_format *stp_las_format_get(unsigned number);

/* Reads from the start of source. salvage: of a cut file, counts the points that it has room for.
 * Errors: IO, CORRUPT (with the byte), VERSION (later than 1.5), UNSUPPORTED (unknown point
 * format). */
stp_status stp_las_header_read(stp_las_header *out, stp_source *source, bool salvage,
                               stp_error *err);

#endif
