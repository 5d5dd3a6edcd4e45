/* Grids of normal codes: a grid of b bits has the codes min(k * 2^(12 - b), 4095), k = 0 to 2^b, of
 * each coordinate. So 0, 2048 and 4095 are on every grid, and with them the directions of the axes.
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

/* The place k of a code on a grid, of any other number the nearest place. */
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

/* Like stp_normal_encode, but takes the nearest code of the grid of `bits`, 6 to 12. */
void stp_normal_encode_on(vec3s normal, unsigned bits, uint8_t out[3]);
/* The greatest angle between a direction and its nearest code on a grid, radians. */
double stp_normal_grid_angle(unsigned bits);
/* The greatest shift for which all normals are on the grid. */
unsigned stp_normal_grid_shift(const stp_sample *samples, size_t count);
/* The same of a level of a block; 0 for a chunk without blocks, which has no grids. */
unsigned stp_level_normal_shift(const stp_chunk *chunk, int level);

#endif
