/* Rebuilds an inner chunk from its children as a file holds them. */
#include "preprocess/tree/rebuild.h"

#include "base/memory.h"
#include "preprocess/tree/chunk_build.h"
#include "preprocess/tree/vertex_item.h"

#include <limits.h>
#include <stdlib.h>
#include <string.h>

/* The coarsest lattice on which all vertices of the children lie. */
static int shared_lattice(const stp_placed_chunk *children, uint32_t count)
{
    int lowest = INT_MAX;
    for (uint32_t c = 0; c < count; c++)
        for (uint32_t p = 0; p < children[c].chunk->patch_count; p++) {
            const stp_chunk *chunk = children[c].chunk;
            stp_dvec3 at =
                stp_sample_position(&chunk->samples[STP_LEVEL_COUNT - 1][p], &chunk->patches[p]);
            int own = stp_lowest_bits(stp_dvec3_add(children[c].origin, at));
            lowest = own < lowest ? own : lowest;
        }
    return lowest;
}

stp_status stp_rebuild_parent(const stp_placed_chunk *children, uint32_t count, stp_chunk **out,
                              stp_dvec3 *origin, stp_carry **carry, stp_error *err)
{
    stp_status status = STP_OK;
    stp_item_group groups[STP_CHUNK_CHILDREN_LIMIT];
    stp_item *items = NULL;
    stp_built_chunk built = {0};
    size_t sum = 0, at = 0;
    for (uint32_t c = 0; c < count; c++)
        sum += children[c].chunk->patch_count;
    if (count == 0 || count > STP_CHUNK_CHILDREN_LIMIT || sum > STP_CHUNK_SAMPLES_LIMIT)
        return stp_error_set(err, STP_LIMIT, "%u children of %zu patches make no chunk", count,
                             sum);
    const int shared = shared_lattice(children, count);
    STP_TRY(stp_alloc(&items, sum, sizeof *items, "samples", err));
    for (uint32_t c = 0; c < count; c++) {
        groups[c] = (stp_item_group){.items = items + at, .count = children[c].chunk->patch_count};
        for (uint32_t p = 0; p < children[c].chunk->patch_count; p++)
            items[at++] = stp_vertex_item(&children[c], p, shared);
    }
    STP_TRY(stp_chunk_build_inner(&built, groups, count, err));
    *out = built.chunk;
    *origin = built.origin;
    *carry = built.carry;
    built.chunk = NULL;
    built.carry = NULL;
done:
    stp_built_chunk_clear(&built);
    free(items);
    return status;
}
