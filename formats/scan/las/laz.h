/* Reads the points of a compressed LAS file through LASzip's C library, if the build found it.
 *
 * A record has the layout of an uncompressed file of the same point format. It holds what stipple
 * reads: coordinates, intensity, class and its flags, colour; other bytes are zero. LASzip opens
 * the file itself. Threads: one at a time per reader. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_H
#define STP_FORMATS_SCAN_LAS_LAZ_H

#include "base/error.h"
#include "formats/scan/las/las_header.h"

#include <stddef.h>
#include <stdint.h>

typedef struct stp_laz stp_laz;

/* path must outlive the reader; header was read from that file. Errors: UNSUPPORTED (built without
 * LASzip; the message says how to get it), CORRUPT, OUT_OF_MEMORY. */
stp_status stp_laz_open(stp_laz **out, const char *path, const stp_las_header *header,
                        stp_error *err);
/* Continues at this point. Errors: CORRUPT. */
stp_status stp_laz_seek(stp_laz *laz, uint64_t point, stp_error *err);
/* Unpacks the next count points into records of the header's record_bytes. Errors: CORRUPT. */
stp_status stp_laz_read(stp_laz *laz, unsigned char *records, size_t count, stp_error *err);
/* Sets *laz to NULL; NULL inside is fine. */
void stp_laz_close(stp_laz **laz);

#endif
