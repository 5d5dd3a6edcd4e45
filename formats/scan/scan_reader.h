/* A streaming reader of one format, for stp_scan. To add a format, add its name to detect.h, its
 * reader to the table of scan.c and a file of its own. Threads: one at a time per state. */
#ifndef STP_FORMATS_SCAN_SCAN_READER_H
#define STP_FORMATS_SCAN_SCAN_READER_H

#include "formats/scan/scan.h"

typedef struct stp_scan_reader {
    size_t state_bytes;
    /* state is zero. Reads the header and fills info; the state owns the lists in info. path stays
     * valid until close; params are the caller's. Errors: as stp_scan_open. */
    stp_status (*open)(void *state, stp_scan_info *info, const char *path,
                       const stp_scan_params *params, stp_error *err);
    /* As stp_scan_read. */
    stp_status (*read)(void *state, stp_point *points, size_t capacity, size_t *count,
                       stp_error *err);
    /* Frees what the state holds, also after a failed open. */
    void (*close)(void *state);
    /* As stp_scan_seek. NULL: the reader cannot, and leaves info.seek_points 0. */
    stp_status (*seek)(void *state, uint64_t point, stp_error *err);
    /* As stp_scan_numbers, if params.numbers was set. NULL: the reader leaves info.extra NULL. */
    const uint8_t *(*numbers)(const void *state);
} stp_scan_reader;

#endif
