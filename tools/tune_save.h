/* The threshold that was solved for, kept in the model. Threads: the main thread only. */
#ifndef STP_TOOLS_TUNE_SAVE_H
#define STP_TOOLS_TUNE_SAVE_H

#include "base/error.h"

/* Stores the threshold as the model's default. Below 0: only says whether it could be. Errors:
 * UNSUPPORTED. */
stp_status tune_save(const char *model_path, double threshold_px, stp_error *err);

#endif
