/* Finds files that are given twice, by whatever names. */
#ifndef STP_TOOLS_PREP_PREP_TWICE_H
#define STP_TOOLS_PREP_PREP_TWICE_H

#include "tools/prep/prep_inputs.h"

/* Rejects a file that is named twice: each of its points would be stored twice. Errors:
 * INVALID_ARGUMENT, OUT_OF_MEMORY. */
stp_status prep_inputs_check_twice(const prep_inputs *inputs, stp_error *err);

#endif
