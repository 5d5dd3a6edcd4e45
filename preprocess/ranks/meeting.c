/* How ranks find each other, and how they part. */
#include "preprocess/ranks/meeting.h"

#include "base/memory.h"
#include "base/temporary.h"
#include "preprocess/mpi/mpi_ranks.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* How long a rank that failed waits to be ended by another rank, which speaks. */
#define SPEECH_SECONDS 10u
#define NAME_BYTES (STP_HOST_BYTES + 32)

struct stp_meeting {
    stp_ranks ranks;
    char (*names)[NAME_BYTES]; /* by rank */
    const char **name_list;
    char *token; /* path of a file beside the output; whoever removes it speaks; NULL: none yet */
    int token_file; /* of rank 0: holds the token's lock; -1: none */
};

/* How many processes a launcher started, as it says in one of these variables. */
static const char *launched(void)
{
    static const char *const counts[] = {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE",
                                         "SLURM_STEP_NUM_TASKS"};
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++) {
        const char *count = getenv(counts[i]);
        if (count && strtol(count, NULL, 10) > 1)
            return count;
    }
    return NULL;
}

/* The module stays loaded: its libraries keep threads. */
static stp_status open_ranks(stp_meeting *m, const char *count, char host[STP_HOST_BYTES],
                             stp_error *err)
{
    stp_mpi_opener *opener = NULL;
    void *module = dlopen("libstipple-mpi.so", RTLD_NOW | RTLD_LOCAL);
    void *symbol = module ? dlsym(module, "stp_mpi_open") : NULL;
    memcpy(&opener, &symbol, sizeof symbol); /* POSIX allows it */
    if (!opener)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s processes are to prepare one model, but this stipple has no MPI: "
                             "build it with -DSTIPPLE_MPI=ON, or leave out mpirun (%s)",
                             count, dlerror());
    return opener(&m->ranks, host, err);
}

static stp_status learn_names(stp_meeting *m, const char *host, stp_error *err)
{
    stp_status status = STP_OK;
    const unsigned count = m->ranks.count;
    STP_TRY(stp_alloc(&m->names, count, sizeof *m->names, "ranks", err));
    STP_TRY(stp_alloc(&m->name_list, count, sizeof *m->name_list, "ranks", err));
    snprintf(m->names[m->ranks.self], NAME_BYTES, "rank %u on %s", m->ranks.self, host);
    for (unsigned r = 0; r < count; r++) {
        m->name_list[r] = m->names[r];
        STP_TRY(stp_ranks_broadcast(&m->ranks, r, m->names[r], NAME_BYTES, err));
    }
    m->ranks.names = m->name_list;
done:
    return status;
}

static void destroy(stp_meeting *m)
{
    if (m->token_file >= 0)
        close(m->token_file);
    free(m->token);
    free(m->names);
    free((void *)m->name_list);
    free(m);
}

stp_status stp_meeting_begin(stp_meeting **out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_meeting *m = NULL;
    const char *count = launched();
    char host[STP_HOST_BYTES] = "";
    *out = NULL;
    if (!count)
        return STP_OK;
    STP_TRY(stp_alloc(&m, 1, sizeof *m, "ranks", err));
    m->token_file = -1;
    STP_TRY(open_ranks(m, count, host, err));
    STP_TRY(learn_names(m, host, err));
    *out = m;
    m = NULL;
done:
    if (m)
        destroy(m);
    return status;
}

stp_ranks *stp_meeting_ranks(stp_meeting *meeting)
{
    return meeting ? &meeting->ranks : NULL;
}

/* A run that is killed leaves the token like the output's other temporary files. */
static stp_status make_token(stp_meeting *m, const char *output, stp_error *err)
{
    const bool named = stp_temporary_name(m->token, output);
    m->token_file = named ? open(m->token, O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0600) : -1;
    if (m->token_file < 0)
        return stp_error_set(err, STP_IO, "%s: no file can be made beside it: %s", output,
                             strerror(errno));
    (void)stp_temporary_mark(m->token_file);
    return STP_OK;
}

stp_status stp_meeting_at(stp_meeting *m, const char *output, const stp_progress *progress,
                          stp_error *err)
{
    stp_status status = STP_OK;
    stp_error made = {0};
    size_t bytes = strlen(output) + STP_TEMPORARY_BYTES;
    if (!m)
        return STP_OK;
    m->ranks.progress = progress;
    STP_TRY(stp_ranks_broadcast(&m->ranks, 0, &bytes, sizeof bytes, err));
    STP_TRY(stp_alloc(&m->token, bytes, 1, "a path", err));
    if (m->ranks.self == 0)
        (void)make_token(m, output, &made);
    STP_TRY(stp_ranks_broadcast(&m->ranks, 0, &made, sizeof made, err));
    if (made.status != STP_OK) {
        free(m->token);
        m->token = NULL;
        return stp_error_set(err, made.status, "%s", made.message);
    }
    STP_TRY(stp_ranks_broadcast(&m->ranks, 0, m->token, bytes, err));
    STP_TRY(stp_ranks_agree(&m->ranks, access(m->token, F_OK) == 0,
                            "another view of the folder that the model is written to than", err));
done:
    return status;
}

bool stp_meeting_speaks(stp_meeting *m)
{
    if (!m)
        return true;
    return m->token ? unlink(m->token) == 0 : m->ranks.self == 0;
}

void stp_meeting_abort(stp_meeting *m, int code, bool spoken)
{
    if (!spoken)
        sleep(SPEECH_SECONDS);
    m->ranks.abort_all(code);
}

stp_status stp_meeting_end(stp_meeting **meeting, stp_error *err)
{
    stp_status status = STP_OK;
    stp_meeting *m = *meeting;
    if (!m)
        return STP_OK;
    STP_TRY(m->ranks.finish(&m->ranks, err));
    if (m->token && m->ranks.self == 0)
        (void)unlink(m->token);
    destroy(m);
    *meeting = NULL;
done:
    return status;
}
