/* Finds points whose backs nobody outside can see: a proof that a surface is closed.
 *
 * Each point's disc, as large as it is drawn, occupies voxels of a grid. The outside floods the
 * voxels that are left open. A point is *closed* if the nearest open voxel in front of it, along
 * its normal, is flooded, and the nearest open voxel behind it is not. Then every line of sight
 * from outside to the point's back passes another disc.
 *
 *                             closed point
 *     eye ~ ~ ~ |disc| . . . . |back  front| ~ ~ ~     ~ flooded voxel   . not reached
 *
 * docs/closed.md has the proof, its limits and its cost. */
#ifndef STP_PREPROCESS_CLOSED_ENCLOSURE_H
#define STP_PREPROCESS_CLOSED_ENCLOSURE_H

#include "formats/chunk/outside.h"
#include "preprocess/cloud/cloud.h"
#include "preprocess/ranks/ranks.h"

typedef struct stp_enclosure_params {
    double lambda; /* radius of a disc over its spacing */
    /* The signs of the normals are guesses. A point that is closed on its other side is turned, and
     * only closed points count as oriented. */
    bool guessed;
    /* Scans of more points have voxels as large as a quarter of the points would; 0: 2^25. Tests
     * give less, to be quick. */
    uint64_t fine_points;
    stp_ranks *ranks; /* each looks at a part of the points; NULL: there is one process */
} stp_enclosure_params;

/* Sets STP_MARK_CLOSED in a cloud whose spacings, normals and signs are known. *out says where an
 * eye is outside; free it with stp_outside_clear. If the spacing asks for too many voxels, no point
 * is closed. The result is the same for any number of threads and ranks and any memory. Errors:
 * OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_enclosure_find(stp_outside *out, stp_cloud *cloud,
                              const stp_enclosure_params *params, stp_pool *pool, stp_error *err);

#endif
