/* The ladder of a block of squares: the few heights that its level-0 samples have, as depths of a
 * camera that measures in steps. Cells of heights then count its rungs.
 *
 * formats/SPEC.md, "Ladders", has the arithmetic. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_LADDER_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_LADDER_H

#include "formats/chunk/codec/inline.h"
#include "formats/chunk/codec/square/square_map.h"
#include "formats/chunk/codec/table/table.h"

/* Free `rungs`. */
typedef struct stp_ladder {
    int32_t *rungs; /* growing heights, in steps of the finest lattice from the chunk's origin */
    uint32_t count; /* 0: there is no ladder */
} stp_ladder;

/* Finds the ladder of a block. count = 0: it has too many rungs to be worth it. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_ladder_find(const stp_chunk *block, const stp_square_map *map, stp_ladder *out,
                           stp_error *err);
/* An empty table of rungs, a row for each; free table->values. Errors: OUT_OF_MEMORY. */
stp_status stp_ladder_table(uint32_t rungs, stp_table *table, stp_error *err);
void stp_ladder_encode(const stp_ladder *ladder, const stp_table *table);
/* Errors: CORRUPT (rungs do not grow), OUT_OF_MEMORY. */
stp_status stp_ladder_decode(const stp_table *table, stp_ladder *out, stp_error *err);

/* The first rung at a height or over it; count: there is none. */
STP_INLINE uint32_t stp_ladder_over(const stp_ladder *ladder, double height)
{
    uint32_t first = 0, left = ladder->count;
    while (left > 0) {
        const uint32_t half = left / 2;
        const bool below = ladder->rungs[first + half] < height;
        first = below ? first + half + 1 : first;
        left = below ? left - half - 1 : half;
    }
    return first;
}

/* The rung nearest to a height, the lower one of two. */
STP_INLINE uint32_t stp_ladder_nearest(const stp_ladder *ladder, double height)
{
    const uint32_t over = stp_ladder_over(ladder, height);
    if (over == 0)
        return 0;
    if (over == ladder->count || height - ladder->rungs[over - 1] <= ladder->rungs[over] - height)
        return over - 1;
    return over;
}

#endif
