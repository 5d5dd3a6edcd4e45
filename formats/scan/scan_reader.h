/* What a streaming reader of one format gives stp_scan. A format adds its name to detect.h, its
 * open function to the table of scan.c and a file of its own. Threads: one at a time per reader. */
#ifndef STP_FORMATS_SCAN_SCAN_READER_H
#define STP_FORMATS_SCAN_SCAN_READER_H

#include "formats/scan/scan.h"

typedef struct stp_scan_reader {
    void *state;
    /* As stp_scan_read. */
    stp_status (*read)(void *state, stp_point *points, size_t capacity, size_t *count,
                       stp_error *err);
    void (*close)(void *state);
} stp_scan_reader;

/* Reads the header and fills info, whose lists are the reader's own. path stays valid until close,
 * params what is asked for. Errors: as stp_scan_open. */
typedef stp_status stp_scan_reader_open(stp_scan_reader *out, stp_scan_info *info, const char *path,
                                        const stp_scan_params *params, stp_error *err);

#endif
