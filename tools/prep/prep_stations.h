/* Scanners' positions of the inputs. Threads: one at a time. */
#ifndef STP_TOOLS_PREP_PREP_STATIONS_H
#define STP_TOOLS_PREP_PREP_STATIONS_H

#include "tools/prep/prep_inputs.h"

/* Notes the stations of input i. A single scan that says nothing of normals, stations or heights
 * may have been seen from its origin: that is a station, too, which no point has yet. Errors:
 * LIMIT, OUT_OF_MEMORY. */
stp_status prep_stations_add(prep_inputs *in, size_t i, const stp_scan_info *info, stp_error *err);
/* Brings the stations of input i to where its points are. */
void prep_stations_move(prep_inputs *in, size_t i);

#endif
