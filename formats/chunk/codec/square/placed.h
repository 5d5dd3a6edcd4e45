/* Codes patches that their squares place. A square tells how many samples its patch has, and, once
 * the height of the patch is known, where its vertex is along the other two axes. So the table has
 * but the height, and what is left of the rest. formats/SPEC.md, "Patches of squares", has the
 * arithmetic. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_PLACED_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_PLACED_H

#include "formats/chunk/codec/square/square_map.h"
#include "formats/chunk/codec/table/table.h"

/* First means of the table of patches, by column, as powers of two (stp_table.tight_first). */
extern const uint8_t stp_placed_first[];

/* Fills the columns of origins and counts. */
void stp_placed_encode(const stp_chunk *block, const stp_square_map *map, const stp_table *table);
/* Changes the column of counts to one that stp_patches_decode takes. block->squares are known. */
void stp_placed_count(const stp_chunk *block, const stp_table *table);
/* Sets the origins. All else of the patches is known. */
void stp_placed_decode(stp_chunk *block, const stp_square_map *map, const stp_table *table);

#endif
