/* prep as several ranks: only rank 0 speaks and writes. If ranks fail, one of them says why and
 * ends all. */
#ifndef STP_TOOLS_PREP_PREP_RANKS_H
#define STP_TOOLS_PREP_PREP_RANKS_H

#include "preprocess/ranks/meeting.h"
#include "tools/cli/cli.h"
#include "tools/prep/prep_inputs.h"

/* Zero is a process alone. */
typedef struct prep_ranks {
    stp_meeting *meeting; /* NULL: alone */
    int messages;         /* descriptor of the true stderr; -1: stderr itself */
    uint64_t words;       /* of the command line: the same on all ranks */
} prep_ranks;

/* Joins the other ranks, if there are any; argv: the command's words. All but rank 0 become silent.
 * Errors: those of stp_meeting_begin. */
stp_status prep_ranks_begin(prep_ranks *out, int argc, char **argv, stp_error *err);
/* Fails on all ranks unless each of them sees the same inputs and has the same options. Errors:
 * INVALID_ARGUMENT (names the first input that differs), CANCELLED. */
stp_status prep_ranks_agree(const prep_ranks *ranks, const prep_inputs *in, stp_error *err);
/* Rank 0 goes on, to say that the run failed; all others wait until it ends them. Errors:
 * CANCELLED.
 */
stp_status prep_ranks_let_first_end(const prep_ranks *ranks, stp_error *err);
/* Ends the run with `code`, of a command that has said what it has to say. If several ranks run and
 * the code is not that of success, ends all of them. */
int prep_ranks_end(prep_ranks *ranks, const cli_command *command, int code);
/* Says what failed, unless another rank does, and ends the run. */
int prep_ranks_fail(prep_ranks *ranks, const cli_command *command, const stp_error *err);

#endif
