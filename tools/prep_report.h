/* What prep says of itself: before, at the end, and as JSON. */
#ifndef STP_TOOLS_PREP_REPORT_H
#define STP_TOOLS_PREP_REPORT_H

#include "preprocess/prep.h"

struct cJSON;

/* One line on stderr of the room on disk that will be taken, if any. Errors: those of the plan. */
stp_status prep_report_plan(const char *path, const stp_prep_source *source,
                            const stp_prep_params *params, const stp_pool *pool, stp_error *err);
/* What was read, dropped and written, and a table of the stages, on stderr. */
void prep_report_print(const stp_prep_stats *stats);
/* The same with stable keys; to be freed. NULL: memory is exhausted. */
struct cJSON *prep_report_json(const stp_prep_stats *stats);

#endif
