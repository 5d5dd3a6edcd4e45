/* Finds what points' neighbourhoods tell: spacings, normals, and the pieces of each cell.
 *
 * Works unit by unit (unit.h); a unit touches a run of the cloud once. The result is the same for
 * any number of threads and any size of units. */
#ifndef STP_PREPROCESS_SURFACE_SURFACE_H
#define STP_PREPROCESS_SURFACE_SURFACE_H

#include "base/progress.h"
#include "preprocess/orient/graph.h"
#include "preprocess/ranks/ranks.h"

typedef struct stp_surface_params {
    unsigned k;                /* neighbours of a point, 3 to STP_NEIGHBOURS_LIMIT */
    bool pieces;               /* find pieces and graphs, too */
    const stp_dvec3 *stations; /* that normals will be turned to; NULL for none */
    uint32_t unit_points;      /* points of a unit, at most; 0: one cell per unit */
    vec3s *shifts;    /* by point: gets its way to its plane (normals.h); NULL: not wanted */
    stp_ranks *ranks; /* that share the work, borrowed; NULL: this process alone */
} stp_surface_params;

/* What noise led to, and how exact the normals are in spite of it. */
typedef struct stp_surface_counts {
    uint64_t computed; /* points whose normals were not given and are known */
    uint64_t grown;    /* points whose planes have more than their nearest neighbours */
    uint64_t averaged; /* points whose given normals are averaged (given_normals.h) */
    double
        normal_error; /* median standard error of normals that were not given, radians; 0: none */
} stp_surface_counts;

/* Sets the spacings and normals of a sorted cloud. If pieces are wanted, also sets its marks, its
 * sheets (numbers of pieces in their cells) and *graphs, one per cell, for stp_orientation_find;
 * else *graphs is NULL. counts may be NULL. Errors: OUT_OF_MEMORY, IO, INVALID_ARGUMENT (k),
 * CANCELLED. */
stp_status stp_surface_find(stp_graph **graphs, stp_cloud *cloud, const stp_surface_params *params,
                            stp_surface_counts *counts, stp_pool *pool,
                            const stp_progress *progress, stp_error *err);
/* Frees graphs that nobody took. */
void stp_surface_clear(stp_graph **graphs, const stp_cloud *cloud);

#endif
