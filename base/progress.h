/* Progress reports and cancellation, passed down to everything that takes long.
 *
 * The library only calls back; the program draws bars and rates. Threads: report may be called from
 * any thread, and calls for one stage may overlap. cancelled must be safe to call from any thread.
 * Both may be NULL, and so may the stp_progress pointer itself. */
#ifndef STP_BASE_PROGRESS_H
#define STP_BASE_PROGRESS_H

#include "base/error.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct stp_progress {
    void *context;
    /* done of total units of the named stage; total 0 means unknown. */
    void (*report)(void *context, const char *stage, uint64_t done, uint64_t total);
    bool (*cancelled)(void *context);
} stp_progress;

/* Calls report, then asks cancelled whether to go on. Errors: CANCELLED. */
stp_status stp_progress_update(const stp_progress *progress, const char *stage, uint64_t done,
                               uint64_t total, stp_error *err);

#endif
