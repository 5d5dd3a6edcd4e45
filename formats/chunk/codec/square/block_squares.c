/* Finds the squares of a block that is to be written, and their map. */
#include "formats/chunk/codec/square/block_squares.h"

#include "base/memory.h"
#include "formats/chunk/codec/square/square.h"

#include <stdlib.h>

/* Makes the map, or takes the one that segment 0 made. */
static stp_status map_find(const stp_chunk *block, int segment, stp_block_squares *out,
                           stp_error *err)
{
    stp_square_map *kept = block->map;
    out->kept = kept != NULL;
    if (kept && segment > 0) {
        out->map = *kept;
        return STP_OK;
    }
    const stp_status status = stp_square_map_create(block, out->of, true, &out->map, err);
    if (kept && status == STP_OK)
        *kept = out->map;
    return status;
}

stp_status stp_block_squares_find(const stp_chunk *block, int segment, stp_block_squares *out,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    if (!block->is_block || block->raster_count == 0)
        return STP_OK;
    if (!block->squares)
        STP_TRY(stp_alloc(&out->own, block->patch_count, sizeof *out->own, "squares", err));
    out->of = block->squares ? block->squares : out->own;
    out->found = block->squares && segment > 0 ? stp_chunk_is_squares(block)
                                               : stp_squares_find(block, out->of);
    if (out->found)
        status = map_find(block, segment, out, err);
    out->found = out->found && status == STP_OK;
    if (status == STP_CORRUPT) /* no map holds these squares */
        status = STP_OK;
    if (!out->found)
        out->of[0].samples = 0;
done:
    return status;
}

void stp_block_squares_clear(stp_block_squares *s)
{
    if (!s->kept)
        stp_square_map_clear(&s->map);
    free(s->own);
}
