/* The model's default threshold. */
#include "tools/tune_save.h"

stp_status tune_save(const char *model_path, double threshold_px, stp_error *err)
{
    (void)threshold_px;
    return stp_error_set(err, STP_UNSUPPORTED,
                         "%s: --save: thresholds cannot yet be kept in models: leave it out and "
                         "give the threshold to --threshold",
                         model_path);
}
