/* Makes images of one size that are given together one kind: heights, or a depth camera's. */
#ifndef STP_TOOLS_PREP_PREP_SERIES_H
#define STP_TOOLS_PREP_PREP_SERIES_H

#include "tools/prep/prep_inputs.h"

/* Looks at images that no pinhole and no spacing is given for, and sets inputs->grids if there are
 * several. If half of those of one size and type of numbers look like a depth camera's, all are,
 * with the least scale. What cannot be read is left to the survey. Errors: OUT_OF_MEMORY. */
stp_status prep_series_decide(prep_inputs *inputs, stp_error *err);
/* How to read the grid of an input; NULL: as it says. */
const stp_grid_params *prep_series_grid(const prep_inputs *inputs, size_t i);

#endif
