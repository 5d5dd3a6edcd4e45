/* The step of coordinates that are written in decimals and stored as binary floats.
 *
 * Surveys are in hundredths or millimetres whatever the format: 513449.69 in a PCD or PLY file is
 * the float next to it. Such a step says how exactly points must come back, as the scale of LAS
 * does. Threads: one at a time per stp_scan. */
#ifndef STP_FORMATS_SCAN_COORDINATE_STEP_H
#define STP_FORMATS_SCAN_COORDINATE_STEP_H

#include "formats/scan/scan.h"

/* Reads the first 65536 points of a scan that was just opened, or fewer, and finds the coarsest of
 * 1, 0.1, 0.01 and 0.001 of which all their coordinates are multiples, as closely as the float or
 * the double that each was can say; 0 where they are of none, or lie farther apart than 1e9 such
 * steps: then one of them is no measurement, and a model could not keep the step. fine: down to
 * 1e-9, where some are no floats. What the scan's info says comes first: then nothing is read.
 * Errors: as stp_scan_read, OUT_OF_MEMORY. */
stp_status stp_scan_find_step(stp_scan *scan, bool fine, double *step, stp_error *err);

#endif
