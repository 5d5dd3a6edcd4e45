/* Finds whether all inputs are one grid of heights, or the tiles of one; says why rows and columns
 * are not kept. */
#ifndef STP_TOOLS_PREP_PREP_GRIDS_H
#define STP_TOOLS_PREP_PREP_GRIDS_H

#include "tools/prep/prep_inputs.h"

/* Sets the source's raster, if there is one. Several inputs make one grid if their columns and rows
 * go on from one to the other, if all are moved in the same way, or none, and if they fill a
 * quarter of it. Attributes are kept by record, so with them such grids become points. Call it when
 * the survey is complete. Errors: OUT_OF_MEMORY. */
stp_status prep_grids_find(prep_inputs *inputs, stp_prep_source *source, stp_error *err);
/* Says why rows and columns of a model's inputs are not kept, if they are grids of heights or
 * inputs->params.keep_grid asks. */
void prep_grids_print(const stp_prep_stats *stats, const prep_inputs *inputs,
                      const stp_prep_params *params, bool appends);

#endif
