/* The points of a compressed LAS file, through LASzip's C library where the build found it.
 *
 * Gives records as an uncompressed file of the same point format has them, as far as stipple reads
 * them: coordinates, intensity, class and its flags, colour; other bytes are zero. LASzip opens the
 * file itself. Threads: one at a time per reader. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_H
#define STP_FORMATS_SCAN_LAS_LAZ_H

#include "base/error.h"
#include "formats/scan/las/las_header.h"

#include <stddef.h>
#include <stdint.h>

typedef struct stp_laz stp_laz;

/* path must outlive the reader; its header was read from it. Errors: UNSUPPORTED (built without
 * LASzip, which the sentence tells how to get), CORRUPT, OUT_OF_MEMORY. */
stp_status stp_laz_open(stp_laz **out, const char *path, const stp_las_header *header,
                        stp_error *err);
/* Continues at this point. Errors: CORRUPT. */
stp_status stp_laz_seek(stp_laz *laz, uint64_t point, stp_error *err);
/* Unpacks the next count points into records of the header's record_bytes. Errors: CORRUPT. */
stp_status stp_laz_read(stp_laz *laz, unsigned char *records, size_t count, stp_error *err);
/* Sets *laz to NULL; NULL inside is fine. */
void stp_laz_close(stp_laz **laz);

#endif
