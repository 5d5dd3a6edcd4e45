/* The messages of prep: before and after the run, and as JSON. */
#ifndef STP_TOOLS_PREP_PREP_REPORT_H
#define STP_TOOLS_PREP_PREP_REPORT_H

#include "tools/prep/prep_inputs.h"

struct cJSON;

/* Removes temporary files of killed runs for this output, and says so on stderr. */
void prep_report_sweep(const char *output);
/* Prints on stderr how much space temporary files will take, if there will be any. */
void prep_report_plan(const stp_prep_plan *plan);
/* Prints on stderr what was read, dropped and written, and a table of the stages. inputs: for their
 * edges and plants. */
void prep_report_print(const stp_prep_stats *stats, const prep_inputs *inputs);
/* Parts of it: what became of the points; signs of normals and the table of stages. */
void prep_report_points(const stp_prep_stats *stats, const prep_inputs *inputs);
void prep_report_stages(const stp_prep_stats *stats);
/* Prints on stderr what to do about a grid that is far higher than wide. */
void prep_report_doubts(const stp_prep_stats *stats, const prep_inputs *inputs);
/* Prints on stderr a line with the reason for each input that is left out. */
void prep_report_unreadable(const prep_inputs *inputs);
/* The same as JSON with stable keys; the caller frees it. NULL if memory is exhausted. */
struct cJSON *prep_report_json(const stp_prep_stats *stats, const prep_inputs *inputs);

#endif
