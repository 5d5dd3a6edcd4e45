/* Moves layers that are closer than their noise onto the surface they share.
 *
 * Where scans overlap, each is off by the error of its registration, and no normal mends that:
 * outlines are torn, and which layer is in front changes from pixel to pixel. If noise has widened
 * a point's plane (normals.h), the point moves along its normal onto that plane, as in moving least
 * squares of degree 1 (Levin 1998). This is done twice, because planes are better among points that
 * have moved. Folds finer than the sampling are taken for noise. Positions change, so it is done
 * only on request. Threads: those of the pool; the same result for any number. */
#ifndef STP_PREPROCESS_SURFACE_JOIN_LAYERS_H
#define STP_PREPROCESS_SURFACE_JOIN_LAYERS_H

#include "preprocess/surface/surface.h"

/* How far points have moved: sums over both times. */
typedef struct stp_joined_layers {
    double greatest, mean; /* scan's units */
} stp_joined_layers;

/* Moves the points of a sorted cloud and sorts it again. Find marks, sheets, spacings and normals
 * again after this. Points with normals from images stay, and so do those normals: their noise is
 * along their rays (image_normals.h). Errors: those of stp_surface_find and of the sort. */
stp_status stp_layers_join(stp_joined_layers *out, stp_cloud *cloud,
                           const stp_surface_params *surface, stp_pool *pool,
                           const stp_progress *progress, stp_error *err);

#endif
