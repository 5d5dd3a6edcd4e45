/* The option --no-sandbox, and the sandbox of commands that read possibly hostile files and need
 * few rights. Threads: the main thread, before it starts others. */
#ifndef STP_TOOLS_FILE_SANDBOX_OPTIONS_H
#define STP_TOOLS_FILE_SANDBOX_OPTIONS_H

#include "tools/cli/cli.h"

/* The option. Set *off to false before. */
cli_option sandbox_options_off(bool *off);
/* Drops all rights except to read the input (a path or an address) and to write the output (may be
 * NULL). Errors: IO. */
stp_status sandbox_options_enter(bool off, const char *input, const char *output, stp_error *err);

#endif
