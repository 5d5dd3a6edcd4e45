/* Decides which way normals point: to the stations that saw them, or by agreement between
 * neighbours, outward for closed pieces.
 * 1. Normals that came with the file stay as they are.
 * 2. Else, if some points' stations are known, their normals face the stations (facing.h), and the
 *    other points follow.
 * 3. Else signs are propagated along the neighbour graph, best edges first (Hoppe et al. 1992;
 *    across creases by reflection, Xie et al. 2003). A connected piece is closed if its area
 *    vectors cancel. A closed piece is turned outward by the sign of its volume. Its sheets are
 *    then turned by what is seen of them from outside (visibility.h). An open piece has signs that
 *    agree, but its outside is unknown, so its points are not marked oriented.
 *
 * Signs agree inside each cell first, with cells on the pool, then between cells. The result is the
 * same for any number of threads. */
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
    bool from_file;            /* the cloud's normals came with the file or from its faces */
    const stp_dvec3 *stations; /* of the points, borrowed; NULL if none is known */
} stp_orient_params;

/* Whether the input's normals decide everything. Then no graphs are needed. */
bool stp_orient_by_file(const stp_orient_params *params);
/* The positions that points' station numbers refer to; NULL if none. A given position (mode
 * POSITION) is station 1, and the caller sets all points' station to 1. */
const stp_dvec3 *stp_orient_stations(const stp_orient_params *params);

/* Sets the cloud's marks and sheets. A sheet is a set of points connected by edges between
 * neighbours with similar normals and small plane offset. *graphs: one per cell, NULL if by file;
 * taken over. Errors: OUT_OF_MEMORY, IO, INVALID_ARGUMENT (mode FILE without normals). */
stp_status stp_orientation_find(stp_cloud *cloud, unsigned k, stp_graph **graphs,
                                const stp_orient_params *params, stp_pool *pool,
                                stp_orientation *found, stp_error *err);

#endif
