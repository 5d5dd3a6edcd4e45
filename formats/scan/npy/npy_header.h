/* The header of a .npy file of NumPy: where the numbers of its points lie.
 *
 * Read are arrays of N rows of 3 to 64 numbers, those of such rows in H x W, those of 3 to 64 rows
 * of more numbers (transposed), all in either order of memory, and arrays of N records whose fields
 * have names; their gaps and texts are passed over. Numbers are floats of 32 or 64 bits, integers
 * of 8 to 64 bits, or bool, in either byte order. Threads: any. */
#ifndef STP_FORMATS_SCAN_NPY_NPY_HEADER_H
#define STP_FORMATS_SCAN_NPY_NPY_HEADER_H

#include "formats/scan/source.h"
#include "formats/scan/text/columns.h"

/* One number of each point: that of point i begins at byte offset + i * stride of the data. */
typedef struct stp_npy_column {
    char kind; /* f, i, u or b */
    uint8_t bytes;
    bool big; /* the high byte is the first */
    uint64_t offset;
} stp_npy_column;

typedef struct stp_npy_header {
    uint32_t column_count;
    stp_npy_column columns[STP_COLUMNS_MAX];
    char names[STP_COLUMNS_MAX * STP_ATTRIBUTE_NAME_BYTES]; /* with commas; "": they have none */
    uint64_t points, stride;
    uint64_t begin; /* of the data, in the file */
    bool apart;     /* each column's numbers lie together */
} stp_npy_header;

/* Reads from the begin of source. Errors: IO, CORRUPT, UNSUPPORTED (other arrays), LIMIT,
 * OUT_OF_MEMORY. */
stp_status stp_npy_header_read(stp_npy_header *out, stp_source *source, stp_error *err);

#endif
