/* Finds and codes the ladder of a block of squares. */
#include "formats/chunk/codec/square/ladder.h"

#include "base/memory.h"

#include <stdlib.h>

/* A ladder has to have at least as many samples a rung. */
#define SAMPLES_OF_RUNG 6u
/* No rung is farther from the chunk's origin. */
#define RUNG_MOST 1073741824.0
/* A rung is that much more than what follows from the two before: low 16 bits, all above. */
enum { LOW, HIGH, COLUMN_COUNT };

static const int16_t beside[COLUMN_COUNT] = {STP_BESIDE_NONE, 0};
/* The bits of the means that odds begin with. */
static const uint8_t first_means[COLUMN_COUNT] = {12, 3};

/* The heights that round to a sample's. */
typedef struct height_range {
    int32_t least, most;
} height_range;

static int compare_most(const void *a, const void *b)
{
    const height_range *x = a, *y = b;
    return (x->most > y->most) - (x->most < y->most);
}

/* False if some height is too far away. */
static bool find_ranges(const stp_chunk *block, const stp_square_map *map, height_range *out)
{
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const stp_patch *patch = &block->patches[p];
        const unsigned axis = stp_square_grid_of(map, p)->raster->axis;
        const double steps = stp_square_map_steps(map, patch);
        const int32_t whole = (int32_t)steps;
        for (uint32_t i = block->level_begin[0][p]; i < block->level_begin[0][p + 1]; i++) {
            const double at =
                ((double)patch->origin[axis] + block->samples[0][i].position[axis]) * steps;
            if (fabs(at) > RUNG_MOST)
                return false;
            out[i].least = (int32_t)at - whole / 2;
            out[i].most = (int32_t)at + (whole - 1) / 2;
        }
    }
    return true;
}

stp_status stp_ladder_find(const stp_chunk *block, const stp_square_map *map, stp_ladder *out,
                           stp_error *err)
{
    stp_status status = STP_OK;
    height_range *ranges = NULL;
    const uint32_t samples = block->level_begin[0][block->patch_count];
    const uint32_t most = samples / SAMPLES_OF_RUNG;
    *out = (stp_ladder){0};
    if (most == 0)
        return STP_OK;
    STP_TRY(stp_alloc(&ranges, samples, sizeof *ranges, "heights", err));
    STP_TRY(stp_alloc(&out->rungs, most, sizeof *out->rungs, "heights", err));
    if (!find_ranges(block, map, ranges))
        goto done;
    /* The fewest rungs with one in each range: always the greatest height that the next one has. */
    qsort(ranges, samples, sizeof *ranges, compare_most);
    for (uint32_t i = 0; i < samples; i++) {
        if (out->count > 0 && ranges[i].least <= out->rungs[out->count - 1])
            continue;
        if (out->count == most) {
            out->count = 0;
            break;
        }
        out->rungs[out->count++] = ranges[i].most;
    }
done:
    free(ranges);
    return status;
}

stp_status stp_ladder_table(uint32_t rungs, stp_table *table, stp_error *err)
{
    *table = (stp_table){.beside = beside,
                         .by_odds = true,
                         .tight = true,
                         .tight_first = first_means,
                         .known = stp_known_ladder()};
    return stp_table_create(table, COLUMN_COUNT, rungs, err);
}

void stp_ladder_encode(const stp_ladder *ladder, const stp_table *table)
{
    uint32_t rung = 0, step = 0;
    for (uint32_t i = 0; i < ladder->count; i++) {
        const uint32_t next = (uint32_t)ladder->rungs[i] - rung, cell = next - step;
        stp_table_column(table, LOW)[i] = (int16_t)cell;
        stp_table_column(table, HIGH)[i] = (int16_t)((cell + 0x8000u) >> 16);
        rung += next;
        step = i > 0 ? next : 0;
    }
}

stp_status stp_ladder_decode(const stp_table *table, stp_ladder *out, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t rung = 0, step = 0;
    int32_t *rungs = NULL;
    STP_TRY(stp_alloc(&rungs, table->row_count, sizeof *rungs, "heights", err));
    for (uint32_t i = 0; i < table->row_count; i++) {
        const int32_t low = stp_table_column(table, LOW)[i];
        const int32_t high = stp_table_column(table, HIGH)[i];
        const uint32_t next = step + (uint32_t)low + ((uint32_t)high << 16);
        rung += next;
        step = i > 0 ? next : 0;
        rungs[i] = (int32_t)rung;
        if (i > 0 && rungs[i] <= rungs[i - 1]) {
            status = stp_error_set(err, STP_CORRUPT, "the heights of a ladder do not grow");
            goto done;
        }
    }
    *out = (stp_ladder){rungs, table->row_count};
    rungs = NULL;
done:
    free(rungs);
    return status;
}
