/* What all commands share: options, help, messages, progress, Ctrl-C and exit codes.
 *
 * Every command is one file in tools/ that defines a cli_command and runs in one function. stdout
 * is data, stderr is messages. Exit codes: 0 done, 1 failed (one line), 2 wrong usage (one line and
 * a hint). Threads: the main thread only; but the callback of cli_progress() may be called from any
 * thread. */
#ifndef STP_TOOLS_CLI_CLI_H
#define STP_TOOLS_CLI_CLI_H

#include "base/error.h"
#include "base/progress.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { CLI_DONE = 0, CLI_FAILED = 1, CLI_USAGE = 2, CLI_CONTINUE = -1 };

typedef enum cli_kind {
    CLI_FLAG,    /* bool: present or not */
    CLI_STRING,  /* const char * */
    CLI_OPTIONS, /* const char *; options of its own, so it may begin with -- */
    CLI_CHOICE,  /* int: index in choices, "a|b|c" */
    CLI_UINT,    /* uint64_t; 1e6, 4M (10^6 multiples: K M G) */
    CLI_BYTES,   /* uint64_t; 256M, 1G (powers of 1024) */
    CLI_NUMBER,  /* double, finite */
    CLI_AMOUNT,  /* double, finite; if the number is missing, it is 1 */
    CLI_SECONDS, /* double, 0 to CLI_SECONDS_MOST */
    CLI_VEC3,    /* double[3]; x,y,z */
    CLI_EXTENT   /* int[2]; WxH, each 1..16384 */
} cli_kind;

#define CLI_SECONDS_MOST 86400.0

typedef struct cli_option {
    const char *name; /* "--threshold" */
    char letter;      /* 'o' for -o, 0 for none */
    cli_kind kind;
    void *target;         /* holds the default before parsing */
    const char *argument; /* "PX" in the help; for CLI_CHOICE the choices */
    const char *help;     /* one line; NULL: another spelling, not listed in the help */
    bool *given;          /* may be NULL; set if the user gave the option */
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
    const char *program; /* name of a program that is a single command; NULL: stipple NAME */
} cli_command;

/* Parses argv[1..]. The positional arguments, positional_min to positional_max of them, go to
 * positional. Every command understands --help, --quiet, --threads N and --version. Options and
 * positionals may be mixed; `--` ends the options; --name=value works. Returns CLI_CONTINUE or an
 * exit code. */
int cli_parse(const cli_command *command, const cli_option *options, size_t option_count, int argc,
              char **argv, const char **positional, size_t positional_min, size_t positional_max,
              size_t *positional_count, cli_common *common);

/* The bytes of the control character that begins `text`, in UTF-8: 1 (C0, delete) or 2 (C1, U+0080
 * to U+009F). 0 if another character begins it. A terminal may obey such a character, so none that
 * a file or a name brings is printed. */
size_t cli_control_bytes(const char *text, size_t length);

/* Prints "stipple NAME: MESSAGE" on stderr; returns CLI_FAILED. */
int cli_fail(const cli_command *command, const stp_error *err);
/* Prints "stipple NAME: FORMAT (try stipple NAME --help)"; returns CLI_USAGE. */
int cli_usage(const cli_command *command, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#define CLI_OUTPUT_LIMIT 4

/* Call it before any work. Refuses an output that exists (without force), cannot be made, is an
 * input or is named twice. NULL in either list is ignored. Errors: EXISTS, IO, INVALID_ARGUMENT,
 * OUT_OF_MEMORY. */
stp_status cli_check_outputs(const char *const outputs[CLI_OUTPUT_LIMIT], const char *const *inputs,
                             size_t input_count, bool force, stp_error *err);

/* Returns a progress callback for this terminal. On a tty it shows a bar with rate and time left,
 * elsewhere plain lines at most every few seconds, with --quiet nothing. The callback reports
 * cancelled after SIGINT or SIGTERM; the first call of cli_progress installs the handlers. The
 * pointer lives as long as the program. */
const stp_progress *cli_progress(const cli_common *common);

/* A stage that will be reported, and its share of the total time, in any unit. */
typedef struct cli_progress_stage {
    const char *name;
    double weight;
} cli_progress_stage;

/* The stages of a run in their order. With a plan, the time left is that of the whole run. json:
 * each report is a line of JSON instead of a bar or a plain line: stage done total seconds
 * seconds_left (null: unknown). */
typedef struct cli_progress_plan {
    const cli_progress_stage *stages;
    size_t count;
    bool json;
} cli_progress_plan;

/* Call it after cli_progress. The plan is copied, its stages are not. */
void cli_progress_expect(const cli_progress_plan *plan);
/* Ends the current bar's line, if one is shown. */
void cli_progress_end(void);
/* True once SIGINT or SIGTERM came (after cli_progress was called). */
bool cli_interrupted(void);

#endif
