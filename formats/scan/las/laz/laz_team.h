/* Reads a LAZ file by several readers at once: each unpacks whole chunks.
 *
 * The order of points and all errors are those of one reader. One reader reads alone until
 * stp_laz_team_together, if there is no pool, if chunks have no table or are large, after a seek,
 * and if chosen nodes come from an address. Memory: twice STP_LAZ_TEAM_BYTES, and 2 MiB for each
 * reader. Threads: the pool's, while stp_laz_team_read runs; else one at a time. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_TEAM_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_TEAM_H

#include "base/pool.h"
#include "formats/scan/las/laz/laz.h"

/* Unpacked records of all readers together, at most. */
#define STP_LAZ_TEAM_BYTES ((size_t)16 << 20)
#define STP_LAZ_TEAM_READERS 16u

typedef struct stp_laz_team stp_laz_team;

/* pool: borrowed, and idle whenever this reads; NULL: none. Errors: those of stp_laz_open. */
stp_status stp_laz_team_open(stp_laz_team **out, const stp_laz_params *params, stp_pool *pool,
                             stp_error *err);
/* All readers read from here on, up to the next seek. */
void stp_laz_team_together(stp_laz_team *team);
/* As stp_laz_seek. One reader reads on from there. */
stp_status stp_laz_team_seek(stp_laz_team *team, uint64_t point, stp_error *err);
/* As stp_laz_chunk_points and stp_laz_chunk_begin. */
uint64_t stp_laz_team_chunk_points(const stp_laz_team *team);
uint64_t stp_laz_team_chunk_begin(const stp_laz_team *team, uint64_t point);
/* As stp_laz_read. */
stp_status stp_laz_team_read(stp_laz_team *team, unsigned char *records, size_t count,
                             stp_error *err);
/* Sets *team to NULL; NULL inside is fine. */
void stp_laz_team_close(stp_laz_team **team);

#endif
