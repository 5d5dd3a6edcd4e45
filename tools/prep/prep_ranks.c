/* prep as several ranks. */
#include "tools/prep/prep_ranks.h"

#include <fcntl.h>
#include <inttypes.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>
#include <xxhash.h>

/* Sends stdout and stderr nowhere, and keeps the true stderr for a last word. */
static void silence(prep_ranks *r)
{
    const int nowhere = open("/dev/null", O_WRONLY | O_CLOEXEC);
    r->messages = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 3);
    if (nowhere < 0)
        return;
    (void)dup2(nowhere, STDOUT_FILENO);
    (void)dup2(nowhere, STDERR_FILENO);
    close(nowhere);
}

/* A number of the words of the command line, but for options that may differ from rank to rank. */
static uint64_t number_of(int argc, char **argv)
{
    static const char *const own[] = {"--memory", "--temp",     "--threads",
                                      "--stats",  "--progress", "--rejects"};
    uint64_t number = 0;
    for (int i = 1; i < argc; i++) {
        const size_t length = strcspn(argv[i], "=");
        bool is_own = strcmp(argv[i], "--quiet") == 0;
        for (size_t k = 0; k < sizeof own / sizeof *own && !is_own; k++)
            if (strlen(own[k]) == length && strncmp(argv[i], own[k], length) == 0) {
                is_own = true;
                i += argv[i][length] == '=' ? 0 : 1; /* its value follows */
            }
        if (!is_own)
            number = XXH3_64bits_withSeed(argv[i], strlen(argv[i]), number);
    }
    return number;
}

stp_status prep_ranks_begin(prep_ranks *out, int argc, char **argv, stp_error *err)
{
    prep_ranks r = {.messages = -1, .words = number_of(argc, argv)};
    const stp_status status = stp_meeting_begin(&r.meeting, err);
    if (status != STP_OK)
        return status;
    if (!stp_ranks_is_first(stp_meeting_ranks(r.meeting)))
        silence(&r);
    *out = r;
    return STP_OK;
}

stp_status prep_ranks_agree(const prep_ranks *r, const prep_inputs *in, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ranks *ranks = stp_meeting_ranks(r->meeting);
    char what[512] = "other inputs than";
    if (!ranks)
        return STP_OK;
    STP_TRY(stp_ranks_agree(ranks, in->count, what, err));
    for (size_t i = 0; i < in->count; i++) {
        const prep_input *f = &in->facts[i];
        char text[512];
        snprintf(text, sizeof text, "%s %" PRId64 " %" PRId64 " %ld %d", in->paths[i],
                 (int64_t)f->size, (int64_t)f->changed.tv_sec, f->changed.tv_nsec, f->why != NULL);
        snprintf(what, sizeof what, "another %.400s than", in->paths[i]);
        STP_TRY(stp_ranks_broadcast(ranks, 0, what, sizeof what, err)); /* all say the same */
        STP_TRY(stp_ranks_agree(ranks, XXH3_64bits(text, strlen(text)), what, err));
    }
    STP_TRY(stp_ranks_agree(ranks, r->words, "other options than", err));
done:
    return status;
}

stp_status prep_ranks_let_first_end(const prep_ranks *r, stp_error *err)
{
    stp_ranks *ranks = stp_meeting_ranks(r->meeting);
    uint8_t never = 0; /* rank 0 sends nothing any more */
    return stp_ranks_is_first(ranks) ? STP_OK
                                     : stp_ranks_broadcast(ranks, 0, &never, sizeof never, err);
}

int prep_ranks_end(prep_ranks *r, const cli_command *command, int code)
{
    stp_error err = {0};
    if (r->meeting && code != CLI_DONE) {
        stp_meeting_abort(r->meeting, code, stp_meeting_speaks(r->meeting));
        return code;
    }
    if (stp_meeting_end(&r->meeting, &err) != STP_OK)
        return prep_ranks_fail(r, command, &err);
    return code;
}

int prep_ranks_fail(prep_ranks *r, const cli_command *command, const stp_error *err)
{
    const stp_ranks *ranks = stp_meeting_ranks(r->meeting);
    stp_error named = *err;
    if (!ranks)
        return cli_fail(command, err);
    const bool speaks = stp_meeting_speaks(r->meeting);
    if (ranks->self > 0 && strncmp(err->message, "rank ", 5) != 0)
        snprintf(named.message, sizeof named.message, "%s: %.900s", ranks->names[ranks->self],
                 err->message[0] ? err->message : stp_status_text(err->status));
    if (speaks && r->messages >= 0)
        (void)dup2(r->messages, STDERR_FILENO);
    if (speaks)
        (void)cli_fail(command, &named);
    stp_meeting_abort(r->meeting, CLI_FAILED, speaks);
    return CLI_FAILED;
}
