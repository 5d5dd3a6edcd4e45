/* The values of PCD records as columns of numbers, whatever the encoding.
 *
 * ascii: a record is a line; empty lines are passed over; a line with fewer or more values than the
 * header declares is a fault. binary: records of a fixed size. binary_compressed: the fields one
 * after the other, each for all points, in one LZF block (lzf.h). To read those side by side, the
 * whole is decoded once, at open, and a decoder is kept where each wanted field begins: about
 * 40 KiB for each of at most 12, and twice the time of decoding, instead of the block of up to
 * 4 GiB in memory. So a damaged block is found at open too.
 *
 * Memory: that, and a block of records. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_PCD_PCD_VALUES_H
#define STP_FORMATS_SCAN_PCD_PCD_VALUES_H

#include "base/error.h"
#include "formats/scan/pcd/lzf.h"
#include "formats/scan/pcd/pcd_header.h"
#include "formats/scan/source.h"

#include <stddef.h>
#include <stdint.h>

#define STP_PCD_BLOCK_POINTS 512u

typedef struct stp_pcd_values {
    stp_source source;
    stp_pcd_header header;
    uint64_t index;      /* of the next record */
    size_t block_points; /* most records at once */
    stp_lzf *decoders;   /* compressed: by target, else NULL */
    bool float_seen;     /* a packed colour so far was written as only a float is */
    bool packed_floats;  /* and so all of them are the bits of floats */
    double columns[STP_PCD_PACKED][STP_PCD_BLOCK_POINTS];
    uint32_t packed[STP_PCD_BLOCK_POINTS];
} stp_pcd_values;

/* Reads the header and goes to the first record; *values is zero, but for source.descriptor -1, and
 * is to be closed even after a failure. path must outlive it. Errors: as stp_scan_open. */
stp_status stp_pcd_values_open(stp_pcd_values *values, const char *path, stp_error *err);
void stp_pcd_values_close(stp_pcd_values *values);
/* The next count <= block_points records, which exist, into columns and packed. Errors: IO,
 * CORRUPT, LIMIT, OUT_OF_MEMORY. */
stp_status stp_pcd_values_read(stp_pcd_values *values, size_t count, stp_error *err);
/* Tells, from the first 65,536 records of an ascii file, whether packed colours of TYPE F are
 * floats whose bits are the colour (one of them has a fraction, or is rounded above the ones:
 * 4.2108e+06) or whole numbers, 0xRRGGBB in decimal. Goes back to the first record. Errors: as
 * read. */
stp_status stp_pcd_values_find_packing(stp_pcd_values *values, stp_error *err);
/* Greatest value of the targets from first to last in a sample: 64 blocks spread over a binary
 * file, the first 65,536 records of another. Goes back to where it was, the first record. Errors:
 * as read. */
stp_status stp_pcd_values_maximum(stp_pcd_values *values, stp_pcd_target first, stp_pcd_target last,
                                  double *maximum, stp_error *err);

#endif
