/* Raises stored errors. */
#include "formats/chunk/measure/raise.h"

#include "base/memory.h"

#include <stdlib.h>

stp_status stp_carry_tell(const stp_chunk *chunk, stp_carry **out, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_alloc(out, chunk->level_begin[0][chunk->patch_count], sizeof **out, "errors", err));
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++)
            (*out)[i] = (stp_carry){stp_error_decode(patch->error[0], patch->exponent),
                                    stp_error_decode(patch->tangential_error[0], patch->exponent)};
    }
done:
    return status;
}

static uint8_t greater(uint8_t a, uint8_t b)
{
    return a > b ? a : b;
}

/* Raises a patch's tangential errors to what was measured. */
static void raise_patch(stp_patch *patch, const stp_overhang *measured)
{
    uint8_t *level = patch->tangential_error;
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        level[l] = greater(level[l], stp_error_encode(measured->level[l], patch->exponent));
        for (unsigned q = 0; (l == 1 || l == 2) && q < patch->counts[2]; q++) {
            uint8_t *code = &patch->quarter_tangential_error[l - 1][q];
            *code = greater(*code, stp_error_encode(measured->quarter[l - 1][q], patch->exponent));
            level[l] = greater(level[l], *code);
        }
    }
}

stp_status stp_overhang_raise(stp_chunk *chunk, const stp_carry *carry,
                              const stp_surroundings *around, stp_error *err)
{
    stp_status status = STP_OK;
    stp_overhang *measured = NULL;
    STP_TRY(stp_alloc(&measured, chunk->patch_count, sizeof *measured, "errors", err));
    STP_TRY(stp_overhang_measure(measured, chunk, carry, around, NULL, err));
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        raise_patch(&chunk->patches[p], &measured[p]);
done:
    free(measured);
    return status;
}
