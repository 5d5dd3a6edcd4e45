/* Reads the values of PCD records as columns of numbers, in any encoding.
 *
 * ascii: a record is a line. Empty lines are skipped. A line with fewer or more values than the
 * header declares is a fault. binary: records of a fixed size. binary_compressed: one LZF block
 * (lzf.h) has the fields one after the other, each for all points. To read the fields side by side,
 * open decodes the whole block once and keeps a decoder where each wanted field begins. That takes
 * about 40 KiB for each of at most 12 fields, and of at most 64 with attributes, and twice the
 * decoding time, instead of up to 4 GiB of memory for the block. So open also finds a damaged
 * block.
 *
 * Memory: the decoders, and a block of records. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_PCD_PCD_VALUES_H
#define STP_FORMATS_SCAN_PCD_PCD_VALUES_H

#include "base/error.h"
#include "formats/scan/pcd/lzf.h"
#include "formats/scan/pcd/pcd_header.h"
#include "formats/scan/pcd/pcd_numbers.h"
#include "formats/scan/source.h"
#include "formats/scan/value_range.h"

#include <stddef.h>
#include <stdint.h>

#define STP_PCD_BLOCK_POINTS 512u

typedef struct stp_pcd_values {
    stp_source source;
    stp_pcd_header header;
    uint64_t index;      /* of the next record */
    size_t block_points; /* largest number of records per read */
    stp_pcd_numbers numbers;
    bool keeps_numbers;  /* attributes are wanted */
    bool salvage;        /* the file may be cut */
    uint64_t lost_count; /* records that the header declares, and the file has no room for */
    stp_lzf *decoders;   /* compressed: one per target, then one per extra; else NULL */
    bool float_seen;     /* a packed colour so far was written in a way that only floats are */
    bool packed_floats;  /* so all packed colours are the bits of floats */
    double columns[STP_PCD_PACKED][STP_PCD_BLOCK_POINTS];
    uint32_t packed[STP_PCD_BLOCK_POINTS];
} stp_pcd_values;

/* Reads the header and goes to the first record. *values must be zero, except source.descriptor,
 * which is -1, keeps_numbers and salvage. Close *values even after a failure. path must outlive it.
 * Errors: as stp_scan_open.
 */
stp_status stp_pcd_values_open(stp_pcd_values *values, const char *path, stp_error *err);
void stp_pcd_values_close(stp_pcd_values *values);
/* Goes to a record of a binary file. */
void stp_pcd_values_seek(stp_pcd_values *values, uint64_t record);
/* Reads the next count <= block_points records, which must exist, into columns and packed. numbers:
 * room for count packed points, if values->keeps_numbers; NULL: their attributes are passed over.
 * In a compressed file, they must be taken for all records or none. Errors: IO, CORRUPT, LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_pcd_values_read(stp_pcd_values *values, size_t count, uint8_t *numbers,
                               stp_error *err);
/* Looks at the first 65,536 records of an ascii file and decides how packed colours of TYPE F are
 * written. They are floats whose bits are the colour, if one of them has a fraction or is rounded
 * above the ones (4.2108e+06). Else they are whole numbers, 0xRRGGBB in decimal. Goes back to the
 * first record. Errors: as read. */
stp_status stp_pcd_values_find_packing(stp_pcd_values *values, stp_error *err);
/* Whether several records are at exactly (0, 0, 0). No two pixels of an image see one place, so
 * these are its holes. Looks at no record behind a damaged one. Starts at the first record and goes
 * back there. Errors: OUT_OF_MEMORY. */
stp_status stp_pcd_values_find_zeros(stp_pcd_values *values, bool *several, stp_error *err);
/* Finds the values of the targets from first to last in a sample: 64 blocks spread over a binary
 * file, the first 65,536 records of other files, and on to a value above 0. A packed colour
 * counts as 0xRRGGBB. Starts at the first record and goes back there. Errors: as read. */
stp_status stp_pcd_values_span(stp_pcd_values *values, stp_pcd_target first, stp_pcd_target last,
                               stp_value_span *span, stp_error *err);

#endif
