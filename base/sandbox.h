/* Least power: a process that lets go of what it will not need, before it reads what may be
 * hostile.
 *
 * By Landlock, where the kernel has it (Linux 5.13; connections and signals later): after enter the
 * calling thread, and those it starts, open no file but those named, and connect nowhere. What is
 * open already stays. It cannot be undone. Threads: the main thread, before others are started. */
#ifndef STP_BASE_SANDBOX_H
#define STP_BASE_SANDBOX_H

#include "base/error.h"

#include <stdbool.h>

#define STP_SANDBOX_PATHS 6

typedef struct stp_sandbox {
    const char *read[STP_SANDBOX_PATHS]; /* files or folders; NULL, or what is not there: nothing */
    const char *write_beside; /* files may be made, replaced and removed in this one's folder */
    bool connects;            /* may connect to web servers */
} stp_sandbox;

/* Does nothing, without an error, on a kernel that has no Landlock. Errors: IO (it has, and
 * refuses). */
stp_status stp_sandbox_enter(const stp_sandbox *sandbox, stp_error *err);

#endif
