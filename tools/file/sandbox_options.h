/* --no-sandbox, and the sandbox of commands that read what may be hostile and need little.
 * Threads: the main thread, before others are started. */
#ifndef STP_TOOLS_FILE_SANDBOX_OPTIONS_H
#define STP_TOOLS_FILE_SANDBOX_OPTIONS_H

#include "tools/cli/cli.h"

/* The option; *off: false before. */
cli_option sandbox_options_off(bool *off);
/* Lets go of all rights but to read the input, a path or an address, and to write the output, which
 * may be NULL. Errors: IO. */
stp_status sandbox_options_enter(bool off, const char *input, const char *output, stp_error *err);

#endif
