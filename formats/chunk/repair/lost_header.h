/* Rebuilds the header of a damaged chunk file if its checksum fails.
 *
 * Most of the header follows from the directory, which ends the file, and from the metadata. What
 * the header says of the points is derived from the points. If the header's own checksum survived,
 * it proves the result. */
#ifndef STP_FORMATS_CHUNK_REPAIR_LOST_HEADER_H
#define STP_FORMATS_CHUNK_REPAIR_LOST_HEADER_H

#include "formats/chunk/repair/damaged.h"

/* Sets d->header: as stored, with a bit put back, or as far as the directory shows. Errors: FORMAT,
 * VERSION, CORRUPT (no directory ends the file), IO, OUT_OF_MEMORY. */
stp_status stp_lost_header_read(stp_damaged *d, stp_error *err);
/* Completes a rebuilt header; call it once the directory is read. Does nothing for any other
 * header. Errors: IO, OUT_OF_MEMORY. */
stp_status stp_lost_header_finish(stp_damaged *d, stp_error *err);

#endif
