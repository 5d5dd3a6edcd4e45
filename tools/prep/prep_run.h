/* What every command that prepares scans shares: prep's defaults, and its progress with the time
 * left. */
#ifndef STP_TOOLS_PREP_PREP_RUN_H
#define STP_TOOLS_PREP_PREP_RUN_H

#include "preprocess/prep.h"
#include "tools/cli/cli.h"

/* The parameters of prep without options. quiet: as --quiet. */
stp_prep_params prep_run_defaults(bool quiet);
/* Tells the progress which stages come, for the time left. Call it after cli_progress. stages must
 * live until prep_run_end. */
void prep_run_expect(const stp_prep_params *params, bool json,
                     cli_progress_stage stages[STP_PREP_STAGE_COUNT]);
void prep_run_end(void);

#endif
