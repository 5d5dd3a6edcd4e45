/* Patches that are placed by their squares: how many samples they have, and where their vertices
 * are along the axes across the height, follow. formats/SPEC.md, "Placed patches", has the
 * arithmetic. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_PLACED_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_PLACED_H

#include "formats/chunk/codec/square/square_map.h"
#include "formats/chunk/codec/table/table.h"

/* By column: the bits of the mean that odds begin with. */
extern const uint8_t stp_placed_first[];

/* Fills the columns of a table whose others are filled. */
void stp_placed_encode(const stp_chunk *block, const stp_square_map *map, const stp_table *table);
/* Turns the column of counts into what it is of other patches. The squares are known. */
void stp_placed_count(const stp_chunk *block, const stp_table *table);
/* Sets the origins. All else of the patches is known. */
void stp_placed_decode(stp_chunk *block, const stp_square_map *map, const stp_table *table);

#endif
