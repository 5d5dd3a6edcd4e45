/* Which way normals point: to the stations that saw them, or by agreement between neighbours,
 * outward for closed pieces.
 *
 * Normals that came with the file are taken as they are. Else, where it is known of some points
 * where the scanner stood that saw them, they face it (facing.h), and others go with them. Else
 * signs are propagated along the neighbour graph, best edges first (Hoppe et al. 1992; across
 * creases by reflection, Xie et al. 2003); a connected piece is turned outward by the sign of its
 * volume if its area vectors cancel, that is, if it is closed; an open piece has agreeing signs of
 * which nothing is known, and its points are not marked oriented. The sheets of a closed piece are
 * then turned by what is seen of them from outside (visibility.h). Signs agree inside each cell
 * first, cells on the pool, and then between cells: the same result for any number of threads. */
#ifndef STP_PREPROCESS_ORIENT_ORIENTATION_H
#define STP_PREPROCESS_ORIENT_ORIENTATION_H

#include "formats/chunk/chunk_file.h"
#include "preprocess/orient/graph.h"

typedef enum stp_orient_mode {
    STP_ORIENT_AUTO = 0, /* the file's normals, else the points' stations, else propagation */
    STP_ORIENT_FILE,
    STP_ORIENT_PROPAGATE,
    STP_ORIENT_NONE,
    STP_ORIENT_POSITION /* towards a given scanner position */
} stp_orient_mode;

typedef struct stp_orient_params {
    stp_orient_mode mode;
    stp_dvec3 position;
    bool from_file;            /* the cloud's normals came with the file or its faces */
    const stp_dvec3 *stations; /* of the points, borrowed; NULL if no point's is known */
} stp_orient_params;

/* Whether the input's normals say it all: no graphs are needed. */
bool stp_orient_by_file(const stp_orient_params *params);
/* The positions that points' stations number, NULL if none; a given position is that of station 1,
 * which all points are then to have. */
const stp_dvec3 *stp_orient_stations(const stp_orient_params *params);

/* Sets the cloud's marks and sheets (points connected by edges between neighbours of like normals
 * and small plane offset). *graphs: of its cells, NULL if by file; taken. Errors: OUT_OF_MEMORY,
 * IO, INVALID_ARGUMENT (mode FILE without normals). */
stp_status stp_orientation_find(stp_cloud *cloud, unsigned k, stp_graph **graphs,
                                const stp_orient_params *params, stp_pool *pool,
                                stp_orientation *found, stp_error *err);

#endif
