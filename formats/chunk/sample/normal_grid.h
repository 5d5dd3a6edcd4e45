/* Grids of normal codes. The grid of a step has the codes 2048 + k * step of each coordinate, k a
 * whole number, those beyond 0 and 4095 limited to them. So 0, 2048 and 4095 are on every grid, and
 * with them the directions of the axes. A grid of b bits has the step 2^(12 - b). A place is k,
 * counted from that of code 0.
 *
 * Noisy normals are rounded to a grid, because bits of noise take space. Threads: any (pure
 * functions). */
#ifndef STP_FORMATS_CHUNK_SAMPLE_NORMAL_GRID_H
#define STP_FORMATS_CHUNK_SAMPLE_NORMAL_GRID_H

#include "formats/chunk/chunk_file.h"

#include <stddef.h>

/* Bits of a coordinate of a normal code; least bits of a grid that a writer rounds to. */
#define STP_NORMAL_BITS 12u
#define STP_NORMAL_BITS_LEAST 6u
/* A shift is 12 - bits; the greatest one leaves the directions of the axes. */
#define STP_NORMAL_SHIFT_MOST 11u

/* The coordinates of the code in three bytes, 0 to 4095. */
static inline void stp_normal_codes_get(const uint8_t code[3], int32_t uv[2])
{
    uv[0] = code[0] | (code[1] & 15) << 8;
    uv[1] = code[1] >> 4 | code[2] << 4;
}

static inline void stp_normal_codes_put(const int32_t uv[2], uint8_t code[3])
{
    code[0] = (uint8_t)uv[0];
    code[1] = (uint8_t)(uv[0] >> 8 | (uv[1] & 15) << 4);
    code[2] = (uint8_t)(uv[1] >> 4);
}

/* The steps are (2 * odd + 1) * 2^shift, odd 0 to 3. If odd > 0, the shift is at most 9. */
#define STP_NORMAL_ODD_MOST 3u
#define STP_NORMAL_ODD_SHIFT_MOST 9u
static inline unsigned stp_normal_shift_most(unsigned odd)
{
    return odd > 0 ? STP_NORMAL_ODD_SHIFT_MOST : STP_NORMAL_SHIFT_MOST;
}

static inline unsigned stp_normal_step(unsigned shift, unsigned odd)
{
    return (2 * odd + 1) << shift;
}

/* The step of a grid of bits. */
static inline unsigned stp_normal_bits_step(unsigned bits)
{
    return 1u << (STP_NORMAL_BITS - bits);
}

/* A grid of any step. */
typedef struct stp_normal_grid {
    int32_t step;
    int32_t before;     /* how far before code 0 the place of code 0 is */
    int32_t shift;      /* of the step */
    int32_t reciprocal; /* of its odd part, times 2^STP_NORMAL_RECIPROCAL_BITS, rounded up */
} stp_normal_grid;

#define STP_NORMAL_RECIPROCAL_BITS 18

/* step: a step as above, or any up to 64: the odd part is less than 64, and numbers that are
 * divided by it are less than 2^12 + 2 * 64, so that quotients are exact in 31 bits. */
static inline stp_normal_grid stp_normal_grid_of(unsigned step)
{
    const int32_t shift = __builtin_ctz(step), odd = (int32_t)(step >> shift);
    return (stp_normal_grid){.step = (int32_t)step,
                             .before = (int32_t)((2048 + step - 1) / step * step) - 2048,
                             .shift = shift,
                             .reciprocal = ((1 << STP_NORMAL_RECIPROCAL_BITS) + odd - 1) / odd};
}

/* The nearest place to a code, 0 to 4095; of 0 and 4095 it may be a place beside theirs. */
static inline int32_t stp_normal_place_near(const stp_normal_grid *grid, int32_t code)
{
    const int32_t raised = code + grid->before + (grid->step >> 1);
    return (raised >> grid->shift) * grid->reciprocal >> STP_NORMAL_RECIPROCAL_BITS;
}

/* The place of a code on the grid. */
static inline int32_t stp_normal_place_of(const stp_normal_grid *grid, int32_t code)
{
    const int32_t half = (2048 + grid->before) / grid->step;
    return code == 0 ? 0 : code == 4095 ? 2 * half : stp_normal_place_near(grid, code);
}

/* The code at a place, of any other number the nearest code. place < 2^17 */
static inline int32_t stp_normal_code_at(const stp_normal_grid *grid, int32_t place)
{
    const int32_t code = (place > 0 ? place : 0) * grid->step - grid->before;
    return code < 0 ? 0 : code < 4095 ? code : 4095;
}

/* The place of a code on a grid of 12 - shift bits, of any other number the nearest place. */
static inline int32_t stp_normal_grid_place(int32_t code, unsigned shift)
{
    return (code + (1 << shift >> 1)) >> shift;
}

/* The code at a place, of any other number the nearest code. place < 2^20 */
static inline int32_t stp_normal_grid_code(int32_t place, unsigned shift)
{
    int32_t code = (int32_t)((uint32_t)(place > 0 ? place : 0) << shift);
    return code < 4095 ? code : 4095;
}

/* Each half of a side of the grid has the directions of the other half, so such a direction has two
 * places: takes the lesser. top: the last place of a coordinate. */
static inline void stp_normal_side(int32_t place[2], int32_t top)
{
    for (int i = 0; i < 2; i++)
        if ((place[i] == 0 || place[i] == top) && place[1 - i] > top - place[1 - i])
            place[1 - i] = top - place[1 - i];
}

/* The same of a code on the grid of `bits`. */
static inline void stp_normal_code_side(uint8_t code[3], unsigned bits)
{
    const unsigned shift = STP_NORMAL_BITS - bits;
    int32_t uv[2], place[2];
    stp_normal_codes_get(code, uv);
    for (int i = 0; i < 2; i++)
        place[i] = stp_normal_grid_place(uv[i], shift);
    stp_normal_side(place, stp_normal_grid_place(4095, shift));
    for (int i = 0; i < 2; i++)
        uv[i] = stp_normal_grid_code(place[i], shift);
    stp_normal_codes_put(uv, code);
}

/* Like stp_normal_encode, but takes the nearest code of the grid of a step, 1 to 64. */
void stp_normal_encode_by(vec3s normal, unsigned step, uint8_t out[3]);
/* The same of the grid of `bits`, 6 to 12. */
void stp_normal_encode_on(vec3s normal, unsigned bits, uint8_t out[3]);
/* The greatest angle between a direction and its nearest code on a grid, radians. */
double stp_normal_step_angle(unsigned step);
double stp_normal_grid_angle(unsigned bits);
/* The greatest shift for which all normals are on the grid. */
unsigned stp_normal_grid_shift(const stp_sample *samples, size_t count);
/* The greatest `odd` of a step of this shift, above, whose grid has all normals. */
unsigned stp_normal_grid_odd(const stp_sample *samples, size_t count, unsigned shift);
/* The shift of a level of a block; 0 for a chunk without blocks, which has no grids. */
unsigned stp_level_normal_shift(const stp_chunk *chunk, int level);
/* The same of `odd` for that shift. */
unsigned stp_level_normal_odd(const stp_chunk *chunk, int level);

#endif
