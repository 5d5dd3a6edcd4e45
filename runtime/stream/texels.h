/* Samples as texels of the Object Texture, three words each.
 *
 * If all samples of a block are narrow, a texel is a sample: 12 bytes. Else a texel is the first
 * three words of a sample, and the fourth words (colours) of the block's samples follow them, three
 * a texel. shaders/project/patch.glsl reads both, and has the layout of narrow samples. They lose
 * nothing: each position is less than 4096, class, intensity and the flags that have no place are
 * 0. Threads: any (pure functions). */
#ifndef STP_RUNTIME_STREAM_TEXELS_H
#define STP_RUNTIME_STREAM_TEXELS_H

#include "formats/chunk/chunk_file.h"

#define STP_TEXEL_BYTES 12

/* In place of stp_texels_colours: the block's samples are narrow. */
#define STP_TEXELS_NARROW UINT32_C(0xc0000000)

/* The most texels that so many samples take, and how many samples take that. */
static inline uint64_t stp_texels_most(uint64_t samples)
{
    return samples + (samples + 2) / 3;
}
static inline uint32_t stp_texels_samples(uint32_t most)
{
    return (uint32_t)((uint64_t)most * 3 / 4);
}

/* Where the colours of a block are, if its samples begin at a texel: with s the two highest bits
 * and c the others, that of the sample at index i is word (i + s) % 3 of texel c + (i + s) / 3. */
uint32_t stp_texels_colours(uint32_t begin, uint32_t samples);

/* The word, counted from the first texel's, of a sample's colour. index: of the sample's texel. */
static inline uint32_t stp_texels_colour_word(uint32_t colours, uint32_t index)
{
    return 3 * (colours & ~STP_TEXELS_NARROW) + (colours >> 30) + index;
}

/* Whether all samples of a decoded block are narrow. */
bool stp_texels_are_narrow(const stp_chunk *chunk);
/* Writes the samples of a level into out[i], i from 0 on. */
void stp_texels_write_narrow(uint32_t (*out)[3], const stp_sample *samples, uint32_t count);
/* The same, and their colours. */
void stp_texels_write_wide(uint32_t (*out)[3], uint32_t *colours, const stp_sample *samples,
                           uint32_t count);
/* The sample of a narrow texel. */
stp_sample stp_texel_widen(const uint32_t texel[3]);

#endif
