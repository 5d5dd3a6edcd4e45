/* Positions on the world's own lattices. A lattice is the multiples of a power of two; a chunk's
 * origin is a multiple of each of its lattices, so lattices are the same in every chunk. Pure
 * functions. Threads: any. */
#ifndef STP_PREPROCESS_PATCH_WORLD_LATTICE_H
#define STP_PREPROCESS_PATCH_WORLD_LATTICE_H

#include "formats/chunk/sample/sample.h"

#include <stdbool.h>

/* World coordinates are at most 2^48 steps, so doubles hold them exactly. */
#define STP_WORLD_OCTAVES 48
/* The model is at most 2^28 steps of patch vertices' lattices wide. */
#define STP_MODEL_OCTAVES 28
/* A patch vertex's step is at most 2^12 steps of its patch. */
#define STP_VERTEX_OCTAVES 12
/* A patch vertex's centre is kept to its radius over this. */
#define STP_VERTEX_PARTS 32.0

/* Exponents of a patch's lattice and of its patch vertex's. */
typedef struct stp_lattices {
    int exponent, vertex_exponent;
} stp_lattices;

/* Lattices that are no finer than `exponent`, and no finer than doubles and a model `side` wide
 * allow. box: of the patch's vertices. radius: about that of its patch vertex, or 0 if that is like
 * a sample. */
stp_lattices stp_lattices_choose(int exponent, const stp_dbox *box, double radius, double side);

/* The nearest point of the lattice; |p| < 2^51 steps. */
stp_dvec3 stp_on_lattice(stp_dvec3 p, int exponent);

/* Sets the patch's exponent and origin so that positions in the box (world), and one step of the
 * `coarsest` lattice around it, fit in 16 bits. False if they do not fit. */
bool stp_world_place(stp_patch *patch, const stp_dbox *box, int exponent, int coarsest,
                     stp_dvec3 chunk_origin);

/* Writes a position into a sample of a patch that has its origin. p: world, on a lattice no finer
 * than the patch's. */
void stp_world_store(const stp_patch *patch, stp_dvec3 chunk_origin, stp_dvec3 p, stp_sample *out);

#endif
