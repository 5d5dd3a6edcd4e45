/* Writes samples as texels. */
#include "runtime/stream/texels.h"

#include <string.h>

#define POSITION_LIMIT 4096u

uint32_t stp_texels_colours(uint32_t begin, uint32_t samples)
{
    const uint32_t shift = (3 - begin % 3) % 3;
    return (begin + samples - (begin + shift) / 3) | shift << 30;
}

/* The flags of a surface's normal, by their code: unknown, known, oriented, closed. */
static const uint8_t known[4] = {0, STP_SAMPLE_HAS_NORMAL,
                                 STP_SAMPLE_HAS_NORMAL | STP_SAMPLE_ORIENTED,
                                 STP_SAMPLE_HAS_NORMAL | STP_SAMPLE_ORIENTED | STP_SAMPLE_CLOSED};

/* Four if the flags have no code. */
static unsigned code_of(uint8_t flags)
{
    unsigned code = 0;
    while (code < 4 && known[code] != (flags & ~STP_SAMPLE_FIT_MASK))
        code++;
    return code;
}

static bool is_narrow(const stp_sample *s)
{
    return (s->position[0] | s->position[1] | s->position[2]) < (int)POSITION_LIMIT &&
           (s->class_id | s->intensity) == 0 && code_of(s->flags) < 4;
}

bool stp_texels_are_narrow(const stp_chunk *chunk)
{
    for (int l = chunk->finest_level; l < STP_LEVEL_COUNT; l++)
        for (uint32_t i = 0; i < chunk->level_begin[l][chunk->patch_count]; i++)
            if (!is_narrow(&chunk->samples[l][i]))
                return false;
    return true;
}

void stp_texels_write_narrow(uint32_t (*out)[3], const stp_sample *samples, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        const stp_sample *s = &samples[i];
        const uint32_t normal =
            s->normal[0] | (uint32_t)s->normal[1] << 8 | (uint32_t)s->normal[2] << 16;
        out[i][0] = s->position[0] | (uint32_t)s->position[1] << 12 | (uint32_t)s->radius << 24;
        out[i][1] = s->position[2] | (normal & 4095u) << 12 | (uint32_t)s->rgb[0] << 24;
        out[i][2] = normal >> 12 | code_of(s->flags) << 12 | (uint32_t)stp_sample_fit_of(s) << 14 |
                    (uint32_t)s->rgb[1] << 16 | (uint32_t)s->rgb[2] << 24;
    }
}

void stp_texels_write_wide(uint32_t (*out)[3], uint32_t *colours, const stp_sample *samples,
                           uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) {
        memcpy(out[i], &samples[i], STP_TEXEL_BYTES);
        memcpy(&colours[i], (const uint8_t *)&samples[i] + STP_TEXEL_BYTES, sizeof *colours);
    }
}

stp_sample stp_texel_widen(const uint32_t texel[3])
{
    const uint32_t x = texel[0], y = texel[1], z = texel[2];
    const uint32_t normal = (y >> 12 & 4095u) | (z & 4095u) << 12;
    return (stp_sample){
        .position = {x & 4095u, x >> 12 & 4095u, y & 4095u},
        .radius = (uint8_t)(x >> 24),
        .flags = (uint8_t)(known[z >> 12 & 3u] | (z >> 14 & 3u) << STP_SAMPLE_FIT_SHIFT),
        .normal = {(uint8_t)normal, (uint8_t)(normal >> 8), (uint8_t)(normal >> 16)},
        .rgb = {(uint8_t)(y >> 24), (uint8_t)(z >> 16), (uint8_t)(z >> 24)}};
}
