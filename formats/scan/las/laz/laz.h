/* Unpacks the points of a compressed LAS file (LAZ) into records of an uncompressed one.
 *
 * LASzip's ways of packing: by point, by chunk, and in layers; point formats 0 to 10. Coded anew
 * from the format's description, since Debian has no library for it. Layers that stipple does not
 * read are left out unless asked for: their fields are then those of the chunk's first point.
 * Waveforms of layered files are zero. Memory: bounded, some 2 MiB.
 * Threads: one at a time per reader. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_H

#include "base/error.h"
#include "formats/scan/las/las_header.h"
#include "formats/scan/las/las_records.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_laz stp_laz;

typedef struct stp_laz_params {
    const stp_source *source; /* open; only its file is used. All three must outlive the reader. */
    const stp_las_header *header;
    const stp_las_record *record; /* "laszip encoded" */
    bool all_fields;              /* of layered files, too */
    /* The chunks to read, which make up the header's points, instead of all of them. Moves into the
     * reader if opening succeeds. NULL: all. */
    struct stp_laz_chunks *chosen;
} stp_laz_params;

/* Errors: UNSUPPORTED (a way of packing that is not known), CORRUPT, OUT_OF_MEMORY. */
stp_status stp_laz_open(stp_laz **out, const stp_laz_params *params, stp_error *err);
/* Continues at this point. Errors: as stp_laz_read. */
stp_status stp_laz_seek(stp_laz *laz, uint64_t point, stp_error *err);
/* Where seeks cost little: at multiples of so many points. 0: nowhere, chunks have many sizes. */
uint64_t stp_laz_chunk_points(const stp_laz *laz);
/* The first point of the last known chunk that begins at or before this point: seeking there costs
 * little. */
uint64_t stp_laz_chunk_begin(const stp_laz *laz, uint64_t point);
/* The points of the chunk that begins at this point. 0: none is known to. */
uint64_t stp_laz_chunk_at(const stp_laz *laz, uint64_t point);
/* The points of the open chunk that are not read yet. 0: none is open. */
uint64_t stp_laz_chunk_left(const stp_laz *laz);
/* Unpacks the next count points into records of the header's record_bytes. Errors: CORRUPT, IO,
 * OUT_OF_MEMORY. */
stp_status stp_laz_read(stp_laz *laz, unsigned char *records, size_t count, stp_error *err);
/* Sets *laz to NULL; NULL inside is fine. */
void stp_laz_close(stp_laz **laz);

#endif
