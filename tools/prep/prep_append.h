/* What `prep --append` does besides prep. */
#ifndef STP_TOOLS_PREP_PREP_APPEND_H
#define STP_TOOLS_PREP_PREP_APPEND_H

#include "preprocess/append/append.h"
#include "tools/prep/prep_inputs.h"

/* Makes the model's coordinate system the one that inputs are brought to. Errors: those of opening
 * the model, OUT_OF_MEMORY. */
stp_status prep_append_begin(prep_system *system, const char *model, stp_error *err);
/* Prints on stderr what became of the model. */
void prep_append_print(const stp_append_result *result, const stp_prep_stats *stats,
                       const prep_inputs *inputs);

#endif
