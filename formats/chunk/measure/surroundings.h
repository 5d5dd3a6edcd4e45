/* What of other chunks' surface reaches into a chunk's box: level-0 discs of the chunks of its
 * depth.
 *
 * Merged discs at a chunk's border lie over them, so they count where errors are measured
 * (overhang.h). Threads: any, on separate surroundings. */
#ifndef STP_FORMATS_CHUNK_MEASURE_SURROUNDINGS_H
#define STP_FORMATS_CHUNK_MEASURE_SURROUNDINGS_H

#include "formats/chunk/chunk_file.h"

/* In the coordinates of the chunk that is surrounded; a zero normal makes it a ball. */
typedef struct stp_flat_disc {
    stp_dvec3 centre, normal;
    double radius;
} stp_flat_disc;

/* What a level-0 sample of an inner chunk brings from below, world units. */
typedef struct stp_carry {
    double error, tangential_error;
} stp_carry;

/* A chunk in the world: its own coordinates begin at the origin. carry: by level-0 sample, NULL for
 * none. */
typedef struct stp_placed_chunk {
    const stp_chunk *chunk;
    stp_dvec3 origin;
    const stp_carry *carry;
} stp_placed_chunk;

/* A patch's bound, in the world. */
typedef struct stp_patch_ball {
    stp_dvec3 centre;
    double radius;
} stp_patch_ball;

#define STP_BALLS_A_BLOCK 32u
/* No more discs than this are kept: those of a surface are a fraction of a chunk's, but points that
 * pile up in one place would be all of them. */
#define STP_SURROUNDINGS_LIMIT 65536u

typedef struct stp_surroundings {
    stp_placed_chunk middle;
    stp_patch_ball *balls; /* its patches' */
    stp_dbox *blocks;      /* around so many balls in a row, STP_BALLS_A_BLOCK */
    stp_dbox box;          /* around them all */
    stp_flat_disc *discs;
    stp_carry *carry; /* by disc, where the chunks added had any */
    uint32_t count;
    size_t disc_capacity, carry_capacity;
} stp_surroundings;

stp_flat_disc stp_flat_disc_from_sample(const stp_sample *sample, const stp_patch *patch);
static inline stp_flat_disc stp_flat_disc_from_lanes(const stp_sample_lanes *l, unsigned i)
{
    return (stp_flat_disc){{l->centre[0][i], l->centre[1][i], l->centre[2][i]},
                           {l->normal[0][i], l->normal[1][i], l->normal[2][i]},
                           l->radius[i]};
}

/* World box of the bounds of its patches. */
stp_dbox stp_placed_chunk_box(const stp_placed_chunk *placed);

/* Nothing around `middle`, which is borrowed. Errors: OUT_OF_MEMORY. */
stp_status stp_surroundings_begin(stp_surroundings *out, const stp_placed_chunk *middle,
                                  stp_error *err);
/* Adds what of another chunk touches, but strips and triangles, as long as there is room. Those who
 * would measure the same errors add the same chunks in the same order. Errors: OUT_OF_MEMORY. */
stp_status stp_surroundings_add(stp_surroundings *s, const stp_placed_chunk *other, stp_error *err);
bool stp_surroundings_full(const stp_surroundings *s);
void stp_surroundings_clear(stp_surroundings *s);

#endif
