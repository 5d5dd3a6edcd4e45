/* Grids of normal codes. */
#include "formats/chunk/sample/normal_grid.h"

#include <math.h>

/* stp_normal_step_angle times 2^12 / step. Grids are coarsest near (1, 1, 1). There they are
 * triangles with sides of 2 sqrt(6) / 2^bits, whose corners are 2 sqrt(2) / 2^bits from their
 * middle. The rest is for the rim, where 4095 stands for 4096. */
#define ANGLE_OF_STEP 2.84

/* The two codes on the grid around a code, as a rule the nearer one first. */
static void find_codes(int32_t code, const stp_normal_grid *grid, int32_t out[2])
{
    const int32_t place = stp_normal_place_near(grid, code);
    out[0] = stp_normal_code_at(grid, place);
    out[1] = stp_normal_code_at(grid, place + (out[0] > code ? -1 : 1));
}

/* The nearest direction is not always the one whose coordinates are nearest, because cells are
 * skewed: tries the four codes around, in lanes. */
void stp_normal_encode_by(vec3s normal, unsigned step, uint8_t out[3])
{
    const stp_normal_grid grid = stp_normal_grid_of(step);
    int32_t nearest[2], u[2], v[2];
    uint32_t code[4];
    float at[3][4], squared[4];
    stp_normal_encode(normal, out);
    if (step == 1 || glms_vec3_norm2(normal) == 0.0f) /* the code of no normal is on each grid */
        return;
    stp_normal_codes_get(out, nearest);
    find_codes(nearest[0], &grid, u);
    find_codes(nearest[1], &grid, v);
    for (int i = 0; i < 4; i++)
        code[i] = (uint32_t)u[i & 1] | (uint32_t)v[i >> 1] << 12;
    stp_normals_decode(code, at);
    for (int i = 0; i < 4; i++) {
        const float x = at[0][i] - normal.x, y = at[1][i] - normal.y, z = at[2][i] - normal.z;
        squared[i] = x * x + y * y + z * z;
    }
    int best = 0;
    for (int i = 1; i < 4; i++)
        best = squared[i] < squared[best] ? i : best;
    for (int byte = 0; byte < 3; byte++)
        out[byte] = (uint8_t)(code[best] >> 8 * byte);
}

void stp_normal_encode_on(vec3s normal, unsigned bits, uint8_t out[3])
{
    stp_normal_encode_by(normal, stp_normal_bits_step(bits), out);
}

double stp_normal_step_angle(unsigned step)
{
    return ANGLE_OF_STEP * step / (1u << STP_NORMAL_BITS);
}

double stp_normal_grid_angle(unsigned bits)
{
    return stp_normal_step_angle(stp_normal_bits_step(bits));
}

unsigned stp_normal_grid_shift(const stp_sample *samples, size_t count)
{
    uint32_t bits = 1u << STP_NORMAL_SHIFT_MOST;
    unsigned shift = 0;
    for (size_t i = 0; i < count; i++) {
        int32_t uv[2];
        stp_normal_codes_get(samples[i].normal, uv);
        bits |= (uint32_t)((uv[0] == 4095 ? 0 : uv[0]) | (uv[1] == 4095 ? 0 : uv[1]));
    }
    while (!(bits >> shift & 1u))
        shift++;
    return shift;
}

unsigned stp_normal_grid_odd(const stp_sample *samples, size_t count, unsigned shift)
{
    unsigned fits = shift <= STP_NORMAL_ODD_SHIFT_MOST ? (2u << STP_NORMAL_ODD_MOST) - 1 : 1;
    for (size_t i = 0; fits > 1 && i < count; i++) {
        int32_t uv[2];
        stp_normal_codes_get(samples[i].normal, uv);
        for (int c = 0; c < 2; c++)
            for (unsigned odd = 1; odd <= STP_NORMAL_ODD_MOST; odd++)
                if (uv[c] != 0 && uv[c] != 4095 && (uv[c] - 2048) % (int32_t)(2 * odd + 1) != 0)
                    fits &= ~(1u << odd);
    }
    return 31u - (unsigned)__builtin_clz(fits);
}

unsigned stp_level_normal_shift(const stp_chunk *chunk, int level)
{
    const uint32_t count = chunk->level_begin[level][chunk->patch_count];
    return chunk->is_block ? stp_normal_grid_shift(chunk->samples[level], count) : 0;
}

unsigned stp_level_normal_odd(const stp_chunk *chunk, int level)
{
    const uint32_t count = chunk->level_begin[level][chunk->patch_count];
    const unsigned shift = stp_level_normal_shift(chunk, level);
    return chunk->is_block ? stp_normal_grid_odd(chunk->samples[level], count, shift) : 0;
}
