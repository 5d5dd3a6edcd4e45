/* Progress reports and cancellation. */
#include "base/progress.h"

#include <stddef.h>

stp_status stp_progress_update(const stp_progress *progress, const char *stage, uint64_t done,
                               uint64_t total, stp_error *err)
{
    if (progress && progress->report)
        progress->report(progress->context, stage, done, total);
    if (progress && progress->cancelled && progress->cancelled(progress->context))
        return stp_error_set(err, STP_CANCELLED, "interrupted while %s: nothing was written",
                             stage);
    return STP_OK;
}
