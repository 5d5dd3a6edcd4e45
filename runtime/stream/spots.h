/* Where the samples of wide patches lie. A wide patch has samples far apart: what is left over when
 * all others are grouped. Its bound may be as large as the model; without these places all tiles
 * would be drawn. Threads: any (pure functions). */
#ifndef STP_RUNTIME_STREAM_SPOTS_H
#define STP_RUNTIME_STREAM_SPOTS_H

#include "formats/chunk/chunk_file.h"
#include "runtime/cut/level_choice.h"

/* The centre of a sample of level 0, in 1/256 of the cube around its patch's bound. */
typedef struct stp_spot {
    uint8_t at[3];
} stp_spot;

/* A block has at most so many spots for each of its patches. */
#define STP_SPOTS_A_PATCH 24

/* Lists the spots of a decoded block's wide patches, and sets their `spots`. *out: free it with
 * free(); NULL: there are none. Blocks of squares have none. Error: OUT_OF_MEMORY. */
stp_status stp_spots_list(stp_spot **out, stp_mirror_patch *patches, const stp_chunk *chunk,
                          stp_error *err);

/* A spot relative to the centre of its patch's bound. */
void stp_spot_offset(const stp_spot *spot, float bound_radius, float offset[3]);

/* How far a disc of radius `radius` may reach from its spot. */
float stp_spot_reach(float bound_radius, float radius);

#endif
