/* Reads the points of an E57 scan as columns of numbers: unpacks bytestreams field by field.
 * Attributes are read as words (attribute.h).
 *
 * Whole numbers of b bits follow each other from the lowest bit of the first byte on, across bytes
 * and packets. Floats are 4 or 8 bytes, little-endian. A field of 0 bits has one value and no
 * bytes. Memory: the packets in use and a block of values per field. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_E57_E57_VECTOR_H
#define STP_FORMATS_SCAN_E57_E57_VECTOR_H

#include "base/error.h"
#include "formats/scan/e57/e57_packets.h"

#include <stddef.h>
#include <stdint.h>

#define STP_E57_BLOCK_POINTS 512u

/* A bytestream that is being unpacked. */
typedef struct stp_e57_stream {
    stp_e57_cursor cursor;
    uint32_t bit;  /* bit of the first byte where the next value begins: 0 to 7 */
    size_t staged; /* bytes taken but not unpacked: 0 or 1 */
    /* Room for a block of the widest values from any bit on, and for what a 9-byte read may touch.
     */
    unsigned char bytes[8 * STP_E57_BLOCK_POINTS + 24];
} stp_e57_stream;

/* An attribute that is read. */
typedef struct stp_e57_lane {
    const stp_e57_extra *extra; /* borrowed */
    stp_e57_stream stream;
    uint64_t words[STP_E57_BLOCK_POINTS];
} stp_e57_lane;

typedef struct stp_e57_vector {
    const stp_e57_document *document; /* borrowed */
    const stp_e57_scan *scan;         /* borrowed; NULL: none */
    uint64_t index;                   /* of the next record */
    stp_e57_section section;
    stp_e57_stream streams[STP_E57_TARGET_COUNT];
    double columns[STP_E57_TARGET_COUNT][STP_E57_BLOCK_POINTS];
    stp_e57_lane *lanes; /* of the scan's extras that are present, in their order */
    uint32_t lane_count; /* 0 if the document keeps no numbers */
} stp_e57_vector;

/* *vector must be zero. Makes room for the fields of any scan. Free *vector even after a failure.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_e57_vector_create(stp_e57_vector *vector, const stp_e57_document *document,
                                 stp_error *err);
void stp_e57_vector_free(stp_e57_vector *vector);
/* Goes to the first record of a scan and checks its recordCount against its section. Errors: IO,
 * CORRUPT, LIMIT. */
stp_status stp_e57_vector_open(stp_e57_vector *vector, stp_e57_pages *pages,
                               const stp_e57_scan *scan, stp_error *err);
/* Goes to a record, right after open. Reads the packets up to there. Errors: IO, CORRUPT,
 * OUT_OF_MEMORY. */
stp_status stp_e57_vector_seek(stp_e57_vector *vector, uint64_t record, stp_error *err);
/* Reads the next count <= STP_E57_BLOCK_POINTS records, which must exist, into the columns of the
 * scan's fields and its lanes. After the last record, checks that the packets hold no more. Errors:
 * IO, CORRUPT.
 */
stp_status stp_e57_vector_read(stp_e57_vector *vector, size_t count, stp_error *err);

#endif
