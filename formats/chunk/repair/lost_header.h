/* The header of a damaged chunk file, rebuilt where its checksum fails.
 *
 * Most of it follows from the directory, which ends the file, and from the metadata. What it says
 * of the points is told from them; the header's own checksum, if that survived, proves it. */
#ifndef STP_FORMATS_CHUNK_REPAIR_LOST_HEADER_H
#define STP_FORMATS_CHUNK_REPAIR_LOST_HEADER_H

#include "formats/chunk/repair/damaged.h"

/* Sets d->header: as stored, with a bit put back, or as far as the directory tells. Errors: FORMAT,
 * VERSION, CORRUPT (no directory ends the file), IO, OUT_OF_MEMORY. */
stp_status stp_lost_header_read(stp_damaged *d, stp_error *err);
/* Once the directory is read: the rest of a rebuilt header; of any other nothing. Errors: IO,
 * OUT_OF_MEMORY. */
stp_status stp_lost_header_finish(stp_damaged *d, stp_error *err);

#endif
