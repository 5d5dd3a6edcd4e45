/* Packs records of points as the points of a LAZ file: chunks of equal size, then their table.
 *
 * Bytes are those that LASzip writes. Memory: the models (some 2 MiB), one packed chunk, and four
 * bytes for each chunk. Threads: one at a time per packer. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_PACK_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_PACK_H

#include "base/error.h"
#include "base/file.h"
#include "formats/scan/las/laz/laz_layout.h"

/* Points of a chunk, as LASzip has it. */
#define STP_LAZ_CHUNK_POINTS 50000u

typedef struct stp_laz_packer stp_laz_packer;

/* Begins at the output's end, where the header says that points begin. layout is copied. The output
 * is borrowed and must outlive the packer. Errors: UNSUPPORTED (a layout that can only be
 * unpacked), IO, OUT_OF_MEMORY. */
stp_status stp_laz_packer_create(stp_laz_packer **out, const stp_laz_layout *layout,
                                 stp_output *output, stp_error *err);
/* Packs count records. Errors: IO, OUT_OF_MEMORY. */
stp_status stp_laz_packer_records(stp_laz_packer *packer, unsigned char *records, size_t count,
                                  stp_error *err);
/* Writes the last chunk and the table. Errors: IO, OUT_OF_MEMORY. */
stp_status stp_laz_packer_finish(stp_laz_packer *packer, stp_error *err);
/* Sets *packer to NULL; NULL inside is fine. */
void stp_laz_packer_destroy(stp_laz_packer **packer);

#endif
