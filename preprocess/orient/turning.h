/* Turns whole pieces of surface whose points' signs agree already. Threads: one call at a time. */
#ifndef STP_PREPROCESS_ORIENT_TURNING_H
#define STP_PREPROCESS_ORIENT_TURNING_H

#include "preprocess/orient/sheets.h"

/* How many points there are of a kind. */
typedef struct stp_turned {
    uint32_t with_normal, oriented;
} stp_turned;

/* Applies the forest's signs, turns points to where their outside is known to be and marks them
 * oriented. stations: of the points (NULL: none is known). A point faces its station; one without
 * goes with its piece, and the piece faces the stations of its points. Where none is known it is
 * turned outward by the sign of its volume if it is closed, that is, if its area vectors cancel.
 * Errors: OUT_OF_MEMORY, IO. */
stp_status stp_turn_pieces(stp_sheets *sheets, const stp_dvec3 *stations, stp_turned *out,
                           stp_error *err);
/* Turns those sheets of oriented points that are seen from their inside (visibility.h), after
 * stp_sheets_cross. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_turn_seen(const stp_sheets *sheets, stp_pool *pool, stp_error *err);

#endif
