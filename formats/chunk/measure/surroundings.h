/* Surroundings of a chunk: the level-0 discs of other chunks of its depth that reach into its
 * patches' bounds.
 *
 * Merged discs at a chunk's border lie over these discs, so errors are measured against them, too
 * (overhang.h). Threads: any, on separate surroundings. */
#ifndef STP_FORMATS_CHUNK_MEASURE_SURROUNDINGS_H
#define STP_FORMATS_CHUNK_MEASURE_SURROUNDINGS_H

#include "formats/chunk/measure/chunk_boxes.h"

/* A disc in the coordinates of the surrounded chunk. A zero normal makes it a ball. */
typedef struct stp_flat_disc {
    stp_dvec3 centre, normal;
    double radius;
} stp_flat_disc;

/* The errors that a level-0 sample of an inner chunk carries from the chunk below, world units:
 * those of the patch vertex that it copies. */
typedef struct stp_carry {
    double error, tangential_error;
} stp_carry;

/* A chunk in the world; origin is where its own coordinates begin. carry: by level-0 sample, NULL
 * for none. */
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
/* At most this many discs are kept. A surface brings a fraction of a chunk's samples; points that
 * pile up in one place would bring all of them. */
#define STP_SURROUNDINGS_LIMIT 65536u

typedef struct stp_surroundings {
    stp_placed_chunk middle;
    stp_patch_ball *balls; /* bounds of middle's patches */
    stp_dbox *blocks;      /* boxes around each STP_BALLS_A_BLOCK balls in a row */
    stp_dbox box;          /* around all balls */
    stp_flat_disc *discs;
    stp_carry *carry; /* by disc, if the added chunks carry any */
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

/* World box of a patch's bound. */
stp_dbox stp_placed_patch_box(const stp_placed_chunk *placed, uint32_t patch);
/* World box of the bounds of all its patches. */
stp_dbox stp_placed_chunk_box(const stp_placed_chunk *placed);

/* The chunks among which surroundings are sought. add(context, index, out, err) calls
 * stp_surroundings_add for the chunk of this index, or does nothing if it has another depth. */
typedef struct stp_surrounding_chunks {
    const stp_chunk_boxes *boxes; /* of their patches' bounds, world */
    stp_status (*add)(void *context, uint32_t index, stp_surroundings *out, stp_error *err);
    void *context;
} stp_surrounding_chunks;

/* Finds the surroundings of `middle`, which is borrowed: adds every chunk but its own (`self`)
 * whose box meets the bounds of its patches, by index, as long as there is room. Whoever wants to
 * measure the same errors must add the same chunks in the same order. Clear *out also after a
 * failure. Errors: OUT_OF_MEMORY; those of `add`. */
stp_status stp_surroundings_find(stp_surroundings *out, const stp_placed_chunk *middle,
                                 uint32_t self, const stp_surrounding_chunks *chunks,
                                 stp_error *err);
/* Adds the discs of those patches of `other` whose bound meets that of a patch of `middle`, as long
 * as there is room; leaves out strips and triangles. Errors: OUT_OF_MEMORY. */
stp_status stp_surroundings_add(stp_surroundings *s, const stp_placed_chunk *other, stp_error *err);
void stp_surroundings_clear(stp_surroundings *s);

#endif
