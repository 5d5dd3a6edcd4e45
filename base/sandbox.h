/* Least privilege: gives up the process's rights before it reads input that may be hostile.
 *
 * Uses Landlock, if the kernel has it (Linux 5.13; later kernels add connections and signals).
 * After enter, the calling thread and the threads that it starts can open only the named files.
 * They cannot connect anywhere unless `connects` is set. Open files stay open. There is no way
 * back. Threads: call it from the main thread, before others start. */
#ifndef STP_BASE_SANDBOX_H
#define STP_BASE_SANDBOX_H

#include "base/error.h"

#include <stdbool.h>

#define STP_SANDBOX_PATHS 6

typedef struct stp_sandbox {
    const char *read[STP_SANDBOX_PATHS]; /* files or folders; NULL and missing paths are skipped */
    const char *write_beside; /* its folder: files may be made, replaced and removed there */
    bool connects;            /* may connect to web servers */
} stp_sandbox;

/* Gives up all rights but those in `sandbox`. If the kernel has no Landlock, does nothing and
 * returns OK. Errors: IO (the kernel has Landlock but refuses). */
stp_status stp_sandbox_enter(const stp_sandbox *sandbox, stp_error *err);

#endif
