/* Samples as byte planes: a level's residuals after predicting each sample from its parent and its
 * elder siblings, many families at once.
 *
 * What predict.h does one sample after the other for the smallest file, this does in lanes, family
 * beside family, for the fastest decoding: predictions are the same in kind, but simpler.
 * formats/SPEC.md, "Families", has the arithmetic; its single-precision steps are each rounded by
 * themselves, so every machine gets the same. Encoding and decoding run the same code. Writes into
 * the caller's memory and allocates nothing. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_FAMILIES_H
#define STP_FORMATS_CHUNK_CODEC_FAMILIES_H

#include "formats/chunk/chunk_file.h"

/* A family is a parent of level l + 1 and its 1 to 4 children of level l. It has four slots: elder
 * children take those from 0 on, the last child slot 3; what is between is empty. */
#define STP_FAMILY_SLOTS 4u

/* Decoding may read so many bytes behind the end of a part, whatever they are. */
#define STP_FAMILY_SLACK 16u

/* Planes of a level, in this order: one byte a slot. */
enum {
    STP_PLANE_RADIUS,
    STP_PLANE_FLAGS,
    STP_PLANE_CLASS,
    STP_PLANE_GREEN,
    STP_PLANE_RED,
    STP_PLANE_BLUE,
    STP_PLANE_INTENSITY,
    STP_PLANE_NORMAL_U, /* low bytes */
    STP_PLANE_NORMAL_V,
    STP_PLANE_NORMAL_HIGH, /* the high 4 bits of u, and of v above them */
    STP_PLANE_A_LOW,       /* position along the patch's axes */
    STP_PLANE_A_HIGH,
    STP_PLANE_B_LOW,
    STP_PLANE_B_HIGH,
    STP_PLANE_C_LOW,
    STP_PLANE_C_HIGH,
    STP_FAMILY_PLANES
};

/* Memory for what is computed on the way: aligned for int32_t, any content. */
size_t stp_families_scratch_bytes(void);

/* Families of a level (0 to 2): the samples of the next coarser one. */
uint32_t stp_families_count(const stp_chunk *chunk, int level);
/* Bytes of all planes of a level. */
size_t stp_families_plane_bytes(const stp_chunk *chunk, int level);

/* Planes of a level from its samples. A plane has two parts: parts[plane] has the elder slots, slot
 * k of family f at k * families + f, and parts[STP_FAMILY_PLANES + plane] the last one's; they are
 * zero when it begins. Needs patches, level_begin and both levels' samples. */
void stp_families_encode(const stp_chunk *chunk, int level, uint8_t *const *parts, void *scratch);
/* A level's samples from its planes, whatever bytes they hold; the next coarser level is there. */
void stp_families_decode(stp_chunk *chunk, int level, const uint8_t *const *parts, void *scratch);

#endif
