/* What prep says of itself: before, at the end, and as JSON. */
#ifndef STP_TOOLS_PREP_PREP_REPORT_H
#define STP_TOOLS_PREP_PREP_REPORT_H

#include "tools/prep/prep_inputs.h"

struct cJSON;

/* Removes what killed runs left of an output, and says so on stderr. */
void prep_report_sweep(const char *output);
/* On stderr: what temporary files will take, if there will be any. */
void prep_report_plan(const stp_prep_plan *plan);
/* What was read, dropped and written, and a table of the stages, on stderr. inputs: for their edges
 * and plants.
 */
void prep_report_print(const stp_prep_stats *stats, const prep_inputs *inputs);
/* A line for each input that is left out, and why, on stderr. */
void prep_report_unreadable(const prep_inputs *inputs);
/* The same with stable keys; to be freed. NULL: memory is exhausted. */
struct cJSON *prep_report_json(const stp_prep_stats *stats, const prep_inputs *inputs);

#endif
