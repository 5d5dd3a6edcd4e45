/* prep's defaults and progress. */
#include "tools/prep/prep_run.h"

#include "tools/prep/prep_report.h"

#include <string.h>

/* Shares of the stages in the total time, for the time left; measured for 4 M points on 2 cores. */
static const cli_progress_stage stage_weights[STP_PREP_STAGE_COUNT] = {
    {"read", 3.0},        {"sort", 3.0},   {"layers", 0.0}, {"outliers", 0.0}, {"surface", 30.0},
    {"orientation", 4.0}, {"closed", 5.0}, {"maps", 0.0},   {"patches", 60.0}};
/* Joining layers finds the surface two more times. */
#define LAYERS_WEIGHT 60.0
/* Maps search for a few neighbours, and sample the surface. */
#define MAPS_WEIGHT 30.0
/* Finding outliers searches for neighbours once more. */
#define OUTLIERS_WEIGHT 20.0

stp_prep_params prep_run_defaults(bool quiet)
{
    return (stp_prep_params){.codec = STP_CODEC_DRACO,
                             .format = STP_CHUNK_FILE_MAJOR,
                             .planned = quiet ? NULL : prep_report_plan};
}

void prep_run_expect(const stp_prep_params *params, bool json,
                     cli_progress_stage stages[STP_PREP_STAGE_COUNT])
{
    const cli_progress_plan plan = {stages, STP_PREP_STAGE_COUNT, json};
    for (int i = 0; i < STP_PREP_STAGE_COUNT; i++) {
        stages[i] = stage_weights[i];
        if (strcmp(stages[i].name, "outliers") == 0 && params->outliers != STP_OUTLIERS_KEEP)
            stages[i].weight = OUTLIERS_WEIGHT;
        if (strcmp(stages[i].name, "layers") == 0 && params->join_layers)
            stages[i].weight = LAYERS_WEIGHT;
        if (strcmp(stages[i].name, "maps") == 0 && params->maps)
            stages[i].weight = MAPS_WEIGHT;
    }
    cli_progress_expect(&plan);
}

void prep_run_end(void)
{
    cli_progress_end();
    cli_progress_expect(&(cli_progress_plan){0});
}
