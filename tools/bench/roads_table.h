/* What roads took, as a table for people and as CSV for scripts, on stdout. Threads: the render
 * thread. */
#ifndef STP_TOOLS_BENCH_ROADS_TABLE_H
#define STP_TOOLS_BENCH_ROADS_TABLE_H

#include "tools/bench/roads_run.h"

/* Medians: of frames drawn at a stretch, with how many times as long the full road and bare points
 * take; then of frames that wait, by the GPU's clock. A context is current. Errors: OUT_OF_MEMORY.
 */
stp_status roads_table_print(const roads_run_result *result, const stp_model *model,
                             const stp_view *view, stp_error *err);
/* A line a round and road: times, points drawn, and of what they are. */
void roads_table_csv(const roads_run_result *result, const stp_model *model, const stp_view *view);

#endif
