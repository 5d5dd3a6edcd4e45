/* Prints the times of roads on stdout: a table for people, CSV for scripts. Threads: the render
 * thread. */
#ifndef STP_TOOLS_BENCH_ROADS_TABLE_H
#define STP_TOOLS_BENCH_ROADS_TABLE_H

#include "tools/bench/roads_run.h"

/* Prints medians. First of frames drawn without waiting, with the ratios of the full road and of
 * bare points; then of frames that wait, by the GPU's clock. A context must be current. Errors:
 * OUT_OF_MEMORY. */
stp_status roads_table_print(const roads_run_result *result, const stp_model *model,
                             const stp_view *view, stp_error *err);
/* One line per round and road: times, points drawn, and a description of the run. */
void roads_table_csv(const roads_run_result *result, const stp_model *model, const stp_view *view);

/* The columns that say what was drawn where, and their values, which end the row. A context must be
 * current. */
#define ROADS_TABLE_RUN ",points,width,height,model,gl_vendor,gl_renderer,gl_version"
void roads_table_csv_run(const stp_model *model, const stp_view *view);

#endif
