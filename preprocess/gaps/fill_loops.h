/* Closes what small loops of wanted edges remain between maps. Threads: one. */
#ifndef STP_PREPROCESS_GAPS_FILL_LOOPS_H
#define STP_PREPROCESS_GAPS_FILL_LOOPS_H

#include "preprocess/gaps/fill_front.h"

/* Edges of a loop that is closed, at most: of any loop, and of one that is narrow. */
#define STP_FILL_LOOP_EDGES 24u
#define STP_FILL_NARROW_EDGES 224u

/* Fills each loop with the triangles of least area whose normals agree with their corners'
 * (Barequet and Sharir 1995), if there are such triangles. In slits between maps that lie over each
 * other, in folds, triangles may turn against the normals. The queue keeps the edges that are still
 * wanted. front->queue: all wanted edges. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status stp_fill_loops_close(stp_fill_front *front, stp_error *err);

#endif
