/* Which points' backs nobody outside can see: a proof that a surface is closed.
 *
 * The points' discs, as large as they are drawn, are put into a grid of voxels; the outside floods
 * what they leave open. A point is *closed* if the flood stands before it, along its normal, and
 * the nearest open voxel behind it was not reached: whoever looks at its back from outside looks
 * through another disc. docs/closed.md has the argument, its limits and its cost. */
#ifndef STP_PREPROCESS_CLOSED_ENCLOSURE_H
#define STP_PREPROCESS_CLOSED_ENCLOSURE_H

#include "formats/chunk/outside.h"
#include "preprocess/cloud/cloud.h"

typedef struct stp_enclosure_params {
    double lambda;         /* radius of a disc over its spacing */
    uint64_t memory_bytes; /* for the voxels */
    /* Signs are guesses: a point that is closed on its other side is turned, and which side is the
     * outside is known of closed points alone. */
    bool guessed;
} stp_enclosure_params;

/* Sets STP_MARK_CLOSED of a cloud whose spacings, normals and signs are known, and says where an
 * eye is outside; *out needs stp_outside_clear. None is closed if the voxels that the spacing asks
 * for do not fit in the memory given. The same for any number of threads. Errors: OUT_OF_MEMORY,
 * IO. */
stp_status stp_enclosure_find(stp_outside *out, stp_cloud *cloud,
                              const stp_enclosure_params *params, stp_pool *pool, stp_error *err);

#endif
