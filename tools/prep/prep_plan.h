/* prep --plan: what a run will need and how long it will take, on one machine and on several. */
#ifndef STP_TOOLS_PREP_PREP_PLAN_H
#define STP_TOOLS_PREP_PREP_PLAN_H

#include "preprocess/prep.h"

/* Prints the plan on stdout, for ranks with `threads` threads each. Errors: those of
 * stp_prep_check_count and stp_prep_plan_make; after all is printed, of stp_prep_plan_check. */
stp_status prep_plan_print(const char *output, const stp_prep_source *source,
                           const stp_prep_params *params, unsigned threads, stp_error *err);

#endif
