/* Finds the step of coordinates that were written in decimals and are stored as binary floats.
 *
 * Surveys use hundredths or millimetres in every format. If a PCD or PLY file has the coordinate
 * 513449.69, it stores the float next to it. The step says how exactly points must come back, like
 * the scale of LAS. Threads: one at a time per stp_scan. */
#ifndef STP_FORMATS_SCAN_COORDINATE_STEP_H
#define STP_FORMATS_SCAN_COORDINATE_STEP_H

#include "formats/scan/scan.h"

/* Reads the first 65536 points, or fewer, of a scan that was just opened. *step is the coarsest of
 * 1, 0.1, 0.01 and 0.001 such that every coordinate is a multiple of it, to the precision of the
 * coordinate's float or double. *step is 0 if no step fits, or if the points lie more than 1e9
 * steps apart: then one point is no measurement, and a model could not keep the step. In a grid of
 * heights only z counts, unless `fine` is set: *step is then the step of the file's numbers times
 * their scale. A step finer than 0.001 is none if 8 x 8 cells are too wide for it. fine: also tries
 * steps down to 1e-9, if some coordinates are no floats. If the scan's info gives a step, that step
 * is the answer and nothing is read. Errors: as stp_scan_read, OUT_OF_MEMORY. */
stp_status stp_scan_find_step(stp_scan *scan, bool fine, double *step, stp_error *err);

#endif
