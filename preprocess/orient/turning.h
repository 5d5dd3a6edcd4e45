/* Turns whole pieces of surface whose points' signs agree. Threads: one call at a time. */
#ifndef STP_PREPROCESS_ORIENT_TURNING_H
#define STP_PREPROCESS_ORIENT_TURNING_H

#include "preprocess/orient/sheets.h"

/* Counts of points. */
typedef struct stp_turned {
    uint64_t with_normal, oriented;
} stp_turned;

/* Applies the forest's signs, turns points to their outside if it is known, and marks those points
 * oriented. stations: of the points; NULL: none is known. A point with a station faces it. A point
 * without one follows its piece, and the piece faces the stations of its points. If a piece has no
 * station, but is closed (its area vectors cancel), it is turned outward by the sign of its volume.
 * Errors: OUT_OF_MEMORY, IO. */
stp_status stp_turn_pieces(stp_sheets *sheets, const stp_dvec3 *stations, stp_turned *out,
                           stp_error *err);
/* Turns sheets of oriented points that are seen from their inside (visibility.h). Call it after
 * stp_sheets_cross. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_turn_seen(const stp_sheets *sheets, stp_pool *pool, stp_error *err);

#endif
