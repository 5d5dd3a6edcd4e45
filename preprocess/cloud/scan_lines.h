/* Chooses how many neighbours a point needs to see beyond its own scan line.
 *
 * Profile scanners on vehicles, and scanners that turn fast, measure dense lines far apart. All 16
 * nearest points then lie on the point's own line, and the plane through them is any plane through
 * the line. So if a fifth of all neighbourhoods are lines, and 64 neighbours make surfaces of
 * half of these, points have 64. Wires and contour lines stay lines, so their points have 16. */
#ifndef STP_PREPROCESS_CLOUD_SCAN_LINES_H
#define STP_PREPROCESS_CLOUD_SCAN_LINES_H

#include "preprocess/cloud/cloud.h"

#define STP_SCAN_LINE_NEIGHBOURS 64u

/* Sets *k to few or STP_SCAN_LINE_NEIGHBOURS for a sorted cloud. Looks at some points of some
 * cells, and for neighbours in their run of the order alone. The same result for any number of
 * ranks. Threads: one. Errors: IO, CANCELLED, if ranks share the cloud. */
stp_status stp_scan_lines_choose(unsigned *k, unsigned few, const stp_cloud *cloud, stp_error *err);

#endif
