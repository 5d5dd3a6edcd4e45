/* Samples as byte planes: the residuals of a level after each sample is predicted from its parent
 * and its elder siblings, many families at once.
 *
 * predict.h codes one sample after the other, for the smallest file. This code works in lanes,
 * family beside family, for the fastest decoding, and its predictions are of the same kind but
 * simpler. formats/SPEC.md, "Families", has the arithmetic. Each single-precision step is rounded
 * by itself, so every machine gets the same result. Encoding and decoding run the same code. Writes
 * into the caller's memory and allocates nothing. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_PREDICT_FAMILIES_H
#define STP_FORMATS_CHUNK_CODEC_PREDICT_FAMILIES_H

#include "formats/chunk/chunk_file.h"

/* A family is a parent of level l + 1 and its 1 to 4 children of level l. It has four slots. Elder
 * children take slots 0, 1, 2 in order, the last child takes slot 3; the others are empty. */
#define STP_FAMILY_SLOTS 4u

/* Decoding may read this many bytes behind the end of a part; their values do not matter. */
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
    STP_PLANE_NORMAL_HIGH, /* the high 4 bits of u, above them those of v */
    STP_PLANE_A_LOW,       /* position along the patch's axes */
    STP_PLANE_A_HIGH,
    STP_PLANE_B_LOW,
    STP_PLANE_B_HIGH,
    STP_PLANE_C_LOW,
    STP_PLANE_C_HIGH,
    STP_FAMILY_PLANES
};

/* Working memory: aligned for int32_t, any content. */
size_t stp_families_scratch_bytes(void);

/* Families of a level (0 to 2): as many as the next coarser level has samples. */
uint32_t stp_families_count(const stp_chunk *chunk, int level);
/* Bytes of all planes of a level. */
size_t stp_families_plane_bytes(const stp_chunk *chunk, int level);

/* Makes the planes of a level from its samples. A plane has two parts. parts[plane] holds the elder
 * slots: slot k of family f at k * families + f. parts[STP_FAMILY_PLANES + plane] holds the last
 * slot. All parts must be zero at the start. Needs patches, level_begin and the samples of both
 * levels. normal_step: of the grid that the level's normals are on (normal_grid.h); 1 for none. */
void stp_families_encode(const stp_chunk *chunk, int level, unsigned normal_step,
                         uint8_t *const *parts, void *scratch);
/* Makes a level's samples from its planes, whatever bytes they hold. The next coarser level must be
 * there. */
void stp_families_decode(stp_chunk *chunk, int level, unsigned normal_step,
                         const uint8_t *const *parts, void *scratch);

#endif
