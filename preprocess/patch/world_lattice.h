/* Positions on the world's own lattices, multiples of powers of two: the same ones in every chunk,
 * whose origin is a multiple of each lattice. Pure functions. Threads: any. */
#ifndef STP_PREPROCESS_PATCH_WORLD_LATTICE_H
#define STP_PREPROCESS_PATCH_WORLD_LATTICE_H

#include "formats/chunk/sample.h"

#include <stdbool.h>

/* World coordinates are no more than so many octaves of steps, to be exact. */
#define STP_WORLD_OCTAVES 48
/* The model is no more than so many octaves of the steps of patches' vertices wide, */
#define STP_MODEL_OCTAVES 28
/* and these no more than so many of the steps of patches. */
#define STP_VERTEX_OCTAVES 12
/* The centre of a patch's vertex is kept to so many parts of its radius. */
#define STP_VERTEX_PARTS 32.0

/* A patch's lattice and its vertex's. */
typedef struct stp_lattices {
    int exponent, vertex_exponent;
} stp_lattices;

/* What is no finer than `exponent` and than doubles and a model `side` wide allow, for a patch
 * whose vertices lie in the box and whose vertex has about this radius, 0 for one like a sample. */
stp_lattices stp_lattices_settle(int exponent, const stp_dbox *box, double radius, double side);

/* The lattice's point that is nearest; |p| < 2^51 steps. */
stp_dvec3 stp_on_lattice(stp_dvec3 p, int exponent);

/* Sets the patch's exponent and its origin so that positions in the box (world), and `coarsest`
 * lattice's steps around it, lie in 16 bits. False if they do not. */
bool stp_world_place(stp_patch *patch, const stp_dbox *box, int exponent, int coarsest,
                     stp_dvec3 chunk_origin);

/* Writes a position (world, on a lattice no finer than the patch's) of a patch that is placed. */
void stp_world_store(const stp_patch *patch, stp_dvec3 chunk_origin, stp_dvec3 p, stp_sample *out);

#endif
