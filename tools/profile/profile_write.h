/* Writes a profile as CSV or as a chart. Threads: any, one profile each. */
#ifndef STP_TOOLS_PROFILE_PROFILE_WRITE_H
#define STP_TOOLS_PROFILE_PROFILE_WRITE_H

#include "base/file.h"
#include "tools/profile/profile_cut.h"

/* A line "distance,x,y,z,r,g,b" for each point, under a line with these names. Lengths in the
 * scan's units, colours 0 to 255. Errors: IO. */
stp_status profile_write_csv(const profile *p, stp_output *output, stp_error *err);
/* An SVG chart: a dot for each point in its colour, heights over distances. Dots that would cover
 * each other are drawn once. Errors: IO, OUT_OF_MEMORY. */
stp_status profile_write_svg(const profile *p, stp_output *output, stp_error *err);

#endif
