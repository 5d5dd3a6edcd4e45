/* Measures chunks that are built, and keeps them until they are needed. */
#include "preprocess/tree/built_chunk.h"

#include "base/memory.h"
#include "formats/chunk/block/block_cut.h"
#include "formats/chunk/codec/square/square.h"
#include "formats/chunk/measure/overhang.h"
#include "preprocess/patch/patch_build.h"

#include <stdlib.h>

stp_placed_chunk stp_built_chunk_place(const stp_built_chunk *built)
{
    return (stp_placed_chunk){built->chunk, built->origin, built->carry};
}

/* Raises errors to those that the patch has. */
static void take_greater(stp_overhang *out, const stp_patch *patch)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        out->level[l] =
            stp_max(out->level[l], stp_error_decode(patch->tangential_error[l], patch->exponent));
    for (int l = 0; l < 2; l++)
        for (int q = 0; q < STP_PATCH_QUARTERS; q++)
            out->quarter[l][q] =
                stp_max(out->quarter[l][q],
                        stp_error_decode(patch->quarter_tangential_error[l][q], patch->exponent));
}

/* Of depth images' chunks, errors of merged samples are rounded. */
static uint8_t error_code(const stp_chunk *chunk, const stp_patch *patch, int level, double error)
{
    const bool rough = level > 0 && chunk->raster_count > 0 && stp_raster_spreads(chunk->rasters);
    const uint8_t code = stp_error_encode(error, patch->exponent);
    return rough ? stp_rough_error(code) : code;
}

stp_status stp_built_chunk_measure(stp_built_chunk *built, const stp_surroundings *around,
                                   stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    stp_chunk *chunk = built->chunk;
    stp_overhang *overhang = NULL;
    STP_TRY(stp_alloc(&overhang, chunk->patch_count, sizeof *overhang, "errors", err));
    STP_TRY(stp_overhang_measure(overhang, chunk, built->carry, around, pool, err));
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        stp_patch *patch = &chunk->patches[p];
        if (built->limited)
            take_greater(&overhang[p], patch);
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            patch->tangential_error[l] = error_code(chunk, patch, l, overhang[p].level[l]);
        for (int l = 0; l < 2; l++)
            for (int q = 0; q < STP_PATCH_QUARTERS; q++)
                patch->quarter_tangential_error[l][q] =
                    error_code(chunk, patch, l + 1, overhang[p].quarter[l][q]);
        built->vertices[p].disc.tangential_error =
            stp_error_decode(patch->tangential_error[STP_LEVEL_COUNT - 1], patch->exponent);
    }
done:
    free(overhang);
    return status;
}

stp_status stp_built_chunk_cut(const stp_built_chunk *built, stp_codec codec, stp_error *err)
{
    stp_chunk *chunk = built->chunk;
    if (chunk->block_ends && stp_codec_of_part(codec) == STP_CODEC_DRACO)
        return STP_OK;
    return stp_chunk_cut(chunk, built->run_ends, built->run_count, stp_block_samples_least(codec),
                         err);
}

/* Moves a pointer from one block to another. `from` may be freed: only its address counts. */
static void *rebase(void *pointer, const void *from, void *to)
{
    return pointer ? (char *)to + ((uintptr_t)pointer - (uintptr_t)from) : NULL;
}

/* Moves the chunk's arrays, which are one block. From here on the built chunk owns the block. */
static stp_status stow_arrays(stp_built_chunk *built, stp_error *err)
{
    stp_chunk *c = built->chunk;
    void *from = built->chunk_arrays = c->memory;
    c->memory = NULL;
    stp_status status = stp_spill_move(built->spill, &built->chunk_arrays,
                                       c->memory_bytes - sizeof *c, 1, "chunks", err);
    c->patches = rebase(c->patches, from, built->chunk_arrays);
    for (int level = 0; level < STP_LEVEL_COUNT; level++) {
        c->level_begin[level] = rebase(c->level_begin[level], from, built->chunk_arrays);
        c->samples[level] = rebase(c->samples[level], from, built->chunk_arrays);
    }
    return status;
}

stp_status stp_built_chunk_stow(stp_built_chunk *built, stp_spill *spill, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk *c = built->chunk;
    built->spill = spill;
    STP_TRY(stow_arrays(built, err));
    STP_TRY(stp_spill_move(spill, &built->carry,
                           built->carry ? c->level_begin[0][c->patch_count] : 0,
                           sizeof *built->carry, "errors", err));
    STP_TRY(stp_spill_move(spill, &built->vertices, built->vertex_count, sizeof *built->vertices,
                           "patches", err));
done:
    return status;
}

void stp_built_chunk_clear(stp_built_chunk *built)
{
    stp_chunk_destroy(&built->chunk);
    stp_spill_free(built->spill, built->chunk_arrays);
    stp_spill_free(built->spill, built->carry);
    stp_spill_free(built->spill, built->vertices);
    free(built->run_ends);
    free(built->sources);
    *built = (stp_built_chunk){0};
}
