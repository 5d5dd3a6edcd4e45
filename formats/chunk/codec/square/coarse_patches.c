/* Codes rounded errors and axes of patches of squares. */
#include "formats/chunk/codec/square/coarse_patches.h"

#include "formats/chunk/sample/normal_grid.h"

/* Columns of errors of levels 3 to 1, and of tangential ones; of both coordinates of axes. */
#define ERRORS 9u
static const unsigned error_begin[2] = {14, 24};
#define AXIS_COLUMN 43u
#define ERROR_SHIFT_BITS 2u
#define ERROR_SHIFT_MOST ((1u << ERROR_SHIFT_BITS) - 1)
#define AXIS_MASK ((1u << (STP_PATCH_SHIFTS_BITS - ERROR_SHIFT_BITS)) - 1)

/* All bits that errors of a patch's levels 3 to 1 have. Those of levels follow from quarters. */
static unsigned error_bits(const stp_patch *p)
{
    unsigned bits = p->error[3] | p->tangential_error[3];
    for (int l = 0; l < 2; l++)
        for (int q = 0; q < STP_PATCH_QUARTERS; q++)
            bits |= p->quarter_error[l][q] | p->quarter_tangential_error[l][q];
    return bits;
}

static unsigned axis_shift(const stp_chunk *block)
{
    unsigned shift = STP_NORMAL_SHIFT_MOST;
    for (uint32_t p = 0; p < block->patch_count; p++) {
        int32_t uv[2];
        stp_normal_codes_get(block->patches[p].cone_axis, uv);
        for (int i = 0; i < 2; i++)
            while (stp_normal_grid_code(stp_normal_grid_place(uv[i], shift), shift) != uv[i])
                shift--;
    }
    return shift;
}

stp_patch_shifts stp_patch_shifts_find(const stp_chunk *block)
{
    stp_patch_shifts out = {.axes = axis_shift(block)};
    unsigned bits = 1u << ERROR_SHIFT_MOST;
    for (uint32_t p = 0; p < block->patch_count; p++)
        bits |= error_bits(&block->patches[p]);
    out.errors = (unsigned)__builtin_ctz(bits);
    return out;
}

uint32_t stp_patch_shifts_bits(const stp_patch_shifts *shifts)
{
    return shifts->errors | shifts->axes << ERROR_SHIFT_BITS;
}

stp_status stp_patch_shifts_take(uint32_t bits, stp_patch_shifts *out, stp_error *err)
{
    *out = (stp_patch_shifts){.errors = bits & ERROR_SHIFT_MOST,
                              .axes = bits >> ERROR_SHIFT_BITS & AXIS_MASK};
    if (out->axes > STP_NORMAL_SHIFT_MOST)
        return stp_error_set(err, STP_CORRUPT, "axes of its patches have no grid");
    return STP_OK;
}

void stp_patch_shifts_encode(const stp_patch_shifts *shifts, const stp_chunk *block,
                             const stp_table *table)
{
    for (unsigned k = 0; k < 2 * ERRORS && shifts->errors > 0; k++) {
        int16_t *cells = stp_table_column(table, error_begin[k / ERRORS] + k % ERRORS);
        for (uint32_t p = 0; p < table->row_count; p++)
            cells[p] = (int16_t)(cells[p] / (1 << shifts->errors));
    }
    int32_t before[2] = {0};
    for (uint32_t p = 0; p < table->row_count && shifts->axes > 0; p++) {
        int32_t uv[2];
        stp_normal_codes_get(block->patches[p].cone_axis, uv);
        for (unsigned i = 0; i < 2; i++) {
            const int32_t place = stp_normal_grid_place(uv[i], shifts->axes);
            stp_table_column(table, AXIS_COLUMN + i)[p] = (int16_t)(place - before[i]);
            before[i] = place;
        }
    }
}

void stp_patch_shifts_decode(const stp_patch_shifts *shifts, const stp_table *table)
{
    for (unsigned k = 0; k < 2 * ERRORS && shifts->errors > 0; k++) {
        int16_t *cells = stp_table_column(table, error_begin[k / ERRORS] + k % ERRORS);
        for (uint32_t p = 0; p < table->row_count; p++)
            cells[p] = (int16_t)((uint16_t)cells[p] << shifts->errors);
    }
    for (unsigned i = 0; i < 2 && shifts->axes > 0; i++) {
        int16_t *cells = stp_table_column(table, AXIS_COLUMN + i);
        int32_t before = 0;
        for (uint32_t p = 0; p < table->row_count; p++) {
            const int32_t place = stp_normal_grid_place(before, shifts->axes) + cells[p];
            const int32_t code = stp_normal_grid_code(place, shifts->axes);
            cells[p] = (int16_t)(code - before);
            before = code;
        }
    }
}
