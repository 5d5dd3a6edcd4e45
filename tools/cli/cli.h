/* The command line's shared manner: options, help, progress, Ctrl-C, exit codes.
 *
 * Every command is one file in tools/ that offers a cli_command and runs in one function. stdout is
 * data, stderr is messages. Exit: 0 done, 1 failed (one line), 2 wrong usage (one line and a hint).
 * Threads: the main thread only, but cli_progress() may be called back from any thread. */
#ifndef STP_TOOLS_CLI_CLI_H
#define STP_TOOLS_CLI_CLI_H

#include "base/error.h"
#include "base/progress.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { CLI_DONE = 0, CLI_FAILED = 1, CLI_USAGE = 2, CLI_CONTINUE = -1 };

typedef enum cli_kind {
    CLI_FLAG,   /* bool: present or not */
    CLI_STRING, /* const char * */
    CLI_CHOICE, /* int: index in choices, "a|b|c" */
    CLI_UINT,   /* uint64_t; 1e6, 4M (10^6 multiples: K M G) */
    CLI_BYTES,  /* uint64_t; 256M, 1G (powers of 1024) */
    CLI_NUMBER, /* double, finite */
    CLI_AMOUNT, /* double, finite; the number may be left out: then 1 */
    CLI_VEC3,   /* double[3]; x,y,z */
    CLI_EXTENT  /* int[2]; WxH, each 1..16384 */
} cli_kind;

typedef struct cli_option {
    const char *name; /* "--threshold" */
    char letter;      /* 'o' for -o, 0 for none */
    cli_kind kind;
    void *target;         /* holds the default before parsing */
    const char *argument; /* "PX" in the help; for CLI_CHOICE the choices */
    const char *help;     /* one line; NULL: another spelling, not listed */
    bool *given;          /* may be NULL; set when the user gave it */
} cli_option;

typedef struct cli_common {
    bool quiet;
    uint64_t threads; /* 0: one per processor */
} cli_common;

typedef struct cli_command {
    const char *name;                  /* "prep" */
    const char *summary;               /* one line of `stipple --help` */
    const char *usage;                 /* "stipple prep IN... -o M.stipple [options]" */
    const char *details;               /* further lines of the command's --help; may be NULL */
    int (*run)(int argc, char **argv); /* argv[0] is the command's name */
    const char *program;               /* of a program that is one command; NULL: stipple NAME */
} cli_command;

/* Parses argv[1..]; the positional arguments, at least min and at most max, go to positional.
 * --help, --quiet, --threads N and --version are understood everywhere. Options and positionals may
 * be mixed; `--` ends the options; --name=value works. Returns CLI_CONTINUE or an exit code. */
int cli_parse(const cli_command *command, const cli_option *options, size_t option_count, int argc,
              char **argv, const char **positional, size_t positional_min, size_t positional_max,
              size_t *positional_count, cli_common *common);

/* Prints "stipple NAME: MESSAGE" on stderr; returns CLI_FAILED. */
int cli_fail(const cli_command *command, const stp_error *err);
/* Prints "stipple NAME: FORMAT (try stipple NAME --help)"; returns CLI_USAGE. */
int cli_usage(const cli_command *command, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#define CLI_OUTPUT_LIMIT 4

/* Before any work, refuses outputs that exist without force, cannot be made, are inputs or are
 * named twice; NULL in either list is nothing. Errors: EXISTS, IO, INVALID_ARGUMENT, OUT_OF_MEMORY.
 */
stp_status cli_check_outputs(const char *const outputs[CLI_OUTPUT_LIMIT], const char *const *inputs,
                             size_t input_count, bool force, stp_error *err);

/* A progress callback for this terminal: a bar with rate and time left on a tty, plain lines at
 * most every few seconds elsewhere, nothing when quiet; cancelled after SIGINT or SIGTERM (handlers
 * are installed by the first call). The pointer lives as long as the program. */
const stp_progress *cli_progress(const cli_common *common);

/* A stage that will be reported, and what part of the whole time it takes, in any unit. */
typedef struct cli_progress_stage {
    const char *name;
    double weight;
} cli_progress_stage;

/* The stages of a run in their order: then the time left is the whole's. json: a line of JSON a
 * report instead of bars and plain lines: stage done total seconds seconds_left (null: not known).
 */
typedef struct cli_progress_plan {
    const cli_progress_stage *stages;
    size_t count;
    bool json;
} cli_progress_plan;

/* After cli_progress; the plan is copied, its stages are not. */
void cli_progress_expect(const cli_progress_plan *plan);
/* Ends the current bar's line, if one is shown. */
void cli_progress_end(void);
/* True once SIGINT or SIGTERM came (after cli_progress was called). */
bool cli_interrupted(void);

#endif
