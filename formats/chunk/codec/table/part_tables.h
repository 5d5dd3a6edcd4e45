/* The tables of a part, empty: how the columns of each are coded. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_TABLE_PART_TABLES_H
#define STP_FORMATS_CHUNK_CODEC_TABLE_PART_TABLES_H

#include "formats/chunk/codec/predict/predict.h"

/* Tables of blocks with fewer rows are coded by odds. Long ones gain less by it, and Draco decodes
 * them faster. */
#define STP_ODDS_ROWS 1500u

/* Columns of a table of patches. */
unsigned stp_patch_columns(const stp_chunk *chunk);
/* A table of patches or of samples; squares: the block is one of squares. Free table->values.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_part_table_create(const stp_chunk *chunk, bool squares, stp_table *table,
                                 unsigned column_count, uint32_t row_count, stp_error *err);
/* The tables of level 0 to 2, whose corners are known; to be destroyed even if it fails. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_level_tables_create(const stp_chunk *chunk, int level, bool squares,
                                   stp_level_tables *tables, stp_error *err);
/* Finds the kinds of rows of a level. The next coarser level must be there. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_level_row_kinds(const stp_chunk *chunk, int level, stp_level_tables *tables,
                               stp_error *err);
/* The greatest shift of a grid that has all radii of a level. */
unsigned stp_radius_shift(const stp_chunk *chunk, int level);
/* Sets the coarsest grid of radii and, at level 0, the coarsest sublattices that all samples are
 * on.
 */
void stp_level_coarsen(const stp_chunk *chunk, int level, stp_level_tables *tables);
void stp_level_tables_destroy(stp_level_tables *tables);

#endif
