/* Samples as texels of the Object Texture, two words each.
 *
 * A patch begins with what it needs besides its record (stp_gpu_patch). The finer the patch is
 * resident, the more it has:
 *
 *     always                 2 texels: its vertex, as formats/chunk/sample/sample.h has it
 *     STP_GPU_PATCH_APART    bound_centre: 3 x 16 bits
 *     finer than level 3     widths
 *                            errors of level 2: perpendicular, tangential; by quarter
 *     finer than level 2     by bytes: radius of levels 0, 1; colour_error of levels 2, 1, 0; error
 *                            and tangential_error of level 0
 *                            errors of level 1
 *
 * Then come the samples of the finer levels, bit by bit, coarse levels first. A field of such a
 * sample tells how far it is from that of the vertex, in as many bits as the patch needs; a radius,
 * how far it is below the greatest of its level. Nothing is lost.
 *
 * The first word of the widths: bits of x, y, z, five bits each; of both parts u, v of the normal
 * and of the flags, four bits each; by how many bits the steps of normals are shifted, four bits;
 * one bit: radii are shifted by two. The second word: bits of radius, red, green, blue, class and
 * intensity, and by how many bits the steps of x and y are shifted, four bits each; two bits each,
 * q of u and of z. The fields of a sample have this order, the lowest bits first. Columns and rows
 * of surveys are whole numbers of steps apart, radii quarters of an octave, hence the shifts.
 *
 * Let d be value - vertex's, shifted, and n its bits. Positions, normals, colours and intensity are
 * stored as d + floor(q 2^n / 4), where q is 2 of all but u and z, and d wraps around at the
 * greatest value; class as vertex's ^ value, flags likewise, turned by two bits so that the fit
 * comes first. shaders/project/patch.glsl reads all this. Threads: any (pure functions). */
#ifndef STP_RUNTIME_STREAM_TEXELS_H
#define STP_RUNTIME_STREAM_TEXELS_H

#include "formats/chunk/chunk_file.h"
#include "runtime/gl/gpu_layout.h"

#define STP_TEXEL_BYTES 8
/* Shaders may read so many texels behind a patch. */
#define STP_TEXELS_SPARE 7
/* The most texels of a patch before the samples that are packed. */
#define STP_TEXELS_HEAD 7
/* The most packed samples of one patch, and the most texels of it. */
#define STP_TEXELS_PACKED_LIMIT (STP_PATCH_SAMPLES + 16 + 4)
#define STP_TEXELS_OF_PATCH (STP_TEXELS_HEAD + 2 * STP_TEXELS_PACKED_LIMIT)

/* The most texels that so many samples take. */
static inline uint64_t stp_texels_most(uint64_t samples, uint64_t patches)
{
    return 2 * samples + (STP_TEXELS_HEAD - 2) * patches;
}

/* The number of a level's first sample in a patch: the vertex has 0. count: of level 0. */
static inline uint32_t stp_level_number(uint32_t count, int level)
{
    const uint32_t of_1 = stp_level_count_above(count), of_2 = stp_level_count_above(of_1);
    return (level < 3) + (level < 2 ? of_2 : 0) + (level < 1 ? of_1 : 0);
}

/* The finest level whose samples a chunk has for a patch (stp_patch_levels_keep). */
int stp_texels_finest(const stp_chunk *chunk, uint32_t patch);
/* Whether the centre of a patch's bound is not where its vertex is. */
bool stp_texels_apart(const stp_chunk *chunk, uint32_t patch);
/* How many texels of a patch come before the samples that are packed. */
uint32_t stp_texels_head(bool apart, int finest);
/* Writes the texels of a patch, with the samples that the chunk has. Returns their number. */
uint32_t stp_texels_write(uint64_t *out, const stp_chunk *chunk, uint32_t patch);
/* Reads a sample of a patch, by its number (stp_level_number). texels: of the patch,
 * STP_TEXELS_OF_PATCH and STP_TEXELS_SPARE. False if these are the texels of no patch that has the
 * sample. */
bool stp_texels_read(const uint64_t *texels, const stp_gpu_patch *patch, uint32_t number,
                     stp_sample *out);

#endif
