/* Gives what each rank found of the surface to all ranks. */
#ifndef STP_PREPROCESS_SURFACE_SURFACE_RANKS_H
#define STP_PREPROCESS_SURFACE_SURFACE_RANKS_H

#include "preprocess/surface/surface.h"

/* What stp_surface_find sets, besides the cloud. */
typedef struct stp_surface_arrays {
    stp_graph *graphs;        /* by cell; NULL: none */
    vec3s *averaged, *shifts; /* by point; NULL: none */
} stp_surface_arrays;

/* Exchanges spacings, normals, marks, sheets and the arrays, cell by cell. If ranks share the
 * points, each keeps its own, and only the sizes of pieces are exchanged. Errors: OUT_OF_MEMORY,
 * IO, CANCELLED. */
stp_status stp_surface_share(stp_ranks *ranks, stp_cloud *cloud, const stp_surface_arrays *arrays,
                             stp_error *err);

#endif
