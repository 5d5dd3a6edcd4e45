/* Layers that are closer than their noise, moved onto the surface they share.
 *
 * Where scans overlap, each lies off the others by the error of its registration, which no normal
 * mends: outlines are torn, and which layer is in front changes from pixel to pixel. A point whose
 * plane noise has widened (normals.h) moves along its normal onto that plane, as in moving least
 * squares of degree 1 (Levin 1998); done twice, for planes are better among points that have
 * moved. Folds that are finer than the sampling are taken for noise. Positions change, so only
 * where that is asked for. Threads: those of the pool; the same
 * for any number. */
#ifndef STP_PREPROCESS_SURFACE_JOIN_LAYERS_H
#define STP_PREPROCESS_SURFACE_JOIN_LAYERS_H

#include "preprocess/surface/surface.h"

/* How far points have moved, at most: the sums of both times. */
typedef struct stp_joined_layers {
    double greatest, mean; /* scan's units */
} stp_joined_layers;

/* Moves the points of a sorted cloud and sorts it anew: marks, sheets, spacings and normals are to
 * be found again. Normals of images stay, and the places of their points: their noise is along
 * their rays (image_normals.h). Errors: those of stp_surface_find and of the sort. */
stp_status stp_layers_join(stp_joined_layers *out, stp_cloud *cloud,
                           const stp_surface_params *surface, stp_pool *pool,
                           const stp_progress *progress, stp_error *err);

#endif
