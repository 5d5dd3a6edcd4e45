/* Puts patches into the middles of their lattices. Threads: any. */
#ifndef STP_PREPROCESS_PATCH_MIDDLE_H
#define STP_PREPROCESS_PATCH_MIDDLE_H

#include "preprocess/patch/patch_build.h"

/* Moves the patch's origin so that the centre of its bounding sphere is the middle of its lattice,
 * as in most patches: then it costs no bytes. No sample moves. The origin stays near, since floats
 * of the GPU tell positions from it. A patch that is too wide for that stays as it is. */
void stp_patch_centre(stp_patch *patch, stp_patch_samples *samples);

#endif
