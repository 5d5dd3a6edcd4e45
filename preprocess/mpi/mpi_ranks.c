/* Ranks over MPI. */
#include "preprocess/mpi/mpi_ranks.h"

#include "base/memory.h"

#include <mpi.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* Bytes of one call of MPI, which counts with int. */
#define SLICE_BYTES ((size_t)8 << 20)
/* A rank that waits looks so many times in a row, then now and then: another rank may need the
 * processor. */
#define QUICK_LOOKS 2000u
#define LOOK_NS 200000

static stp_status mpi_error(int code, stp_error *err)
{
    char text[MPI_MAX_ERROR_STRING] = "";
    int length = 0;
    MPI_Error_string(code, text, &length);
    return stp_error_set(err, STP_IO, "MPI failed: %s", text);
}

/* Waits for one call. Never spins for long, and ends when the user or mpirun wants it. */
static stp_status await(const stp_ranks *ranks, int code, MPI_Request *request, stp_error *err)
{
    const stp_progress *p = ranks->progress;
    int done = 0;
    for (unsigned look = 0; code == MPI_SUCCESS; look++) {
        code = MPI_Test(request, &done, MPI_STATUS_IGNORE);
        if (done)
            break;
        if (p && p->cancelled && p->cancelled(p->context))
            return stp_error_set(err, STP_CANCELLED,
                                 "interrupted while waiting for other ranks: nothing was written");
        if (look < QUICK_LOOKS)
            sched_yield();
        else
            nanosleep(&(struct timespec){.tv_nsec = LOOK_NS}, NULL);
    }
    return code == MPI_SUCCESS ? STP_OK : mpi_error(code, err);
}

static stp_status broadcast(stp_ranks *ranks, unsigned from, void *data, size_t bytes,
                            stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t at = 0, size; status == STP_OK && at < bytes; at += size) {
        MPI_Request request = MPI_REQUEST_NULL;
        size = bytes - at < SLICE_BYTES ? bytes - at : SLICE_BYTES;
        const int code =
            MPI_Ibcast((char *)data + at, (int)size, MPI_BYTE, (int)from, MPI_COMM_WORLD, &request);
        /* NOLINTNEXTLINE(clang-analyzer-optin.mpi.MPI-Checker): await waits */
        status = await(ranks, code, &request, err);
    }
    return status;
}

static stp_status send(stp_ranks *ranks, unsigned from, unsigned to, void *data, size_t bytes,
                       stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t at = 0, size; status == STP_OK && at < bytes; at += size) {
        MPI_Request request = MPI_REQUEST_NULL;
        char *slice = (char *)data + at;
        size = bytes - at < SLICE_BYTES ? bytes - at : SLICE_BYTES;
        const int code =
            ranks->self == from
                ? MPI_Isend(slice, (int)size, MPI_BYTE, (int)to, 0, MPI_COMM_WORLD, &request)
                : MPI_Irecv(slice, (int)size, MPI_BYTE, (int)from, 0, MPI_COMM_WORLD, &request);
        /* NOLINTNEXTLINE(clang-analyzer-optin.mpi.MPI-Checker): await waits */
        status = await(ranks, code, &request, err);
    }
    return status;
}

/* Bytes and places of each rank's part, as MPI wants them. */
static void lay_out(int *counts, int *places, const size_t *bytes, unsigned ranks)
{
    int sum = 0;
    for (unsigned r = 0; r < ranks; r++) {
        counts[r] = (int)bytes[r];
        places[r] = sum;
        sum += counts[r];
    }
}

static stp_status exchange(stp_ranks *ranks, const void *data, const size_t *sent, void *out,
                           const size_t *received, stp_error *err)
{
    stp_status status = STP_OK;
    MPI_Request request = MPI_REQUEST_NULL;
    const unsigned count = ranks->count;
    int *numbers = NULL;
    STP_TRY(stp_alloc(&numbers, 4 * (size_t)count, sizeof *numbers, "ranks", err));
    lay_out(numbers, numbers + count, sent, count);
    lay_out(numbers + 2 * count, numbers + 3 * count, received, count);
    const int code =
        MPI_Ialltoallv(data, numbers, numbers + count, MPI_BYTE, out, numbers + 2 * count,
                       numbers + 3 * count, MPI_BYTE, MPI_COMM_WORLD, &request);
    /* NOLINTNEXTLINE(clang-analyzer-optin.mpi.MPI-Checker): await waits */
    STP_TRY(await(ranks, code, &request, err));
done:
    free(numbers);
    return status;
}

static stp_status finish(stp_ranks *ranks, stp_error *err)
{
    MPI_Request request = MPI_REQUEST_NULL;
    const stp_status status = await(ranks, MPI_Ibarrier(MPI_COMM_WORLD, &request), &request, err);
    if (status == STP_OK)
        MPI_Finalize();
    return status;
}

static void abort_all(int code)
{
    MPI_Abort(MPI_COMM_WORLD, code);
}

stp_status stp_mpi_open(stp_ranks *out, char host[STP_HOST_BYTES], stp_error *err)
{
    int self = 0, count = 1, level = 0, length = 0;
    char name[MPI_MAX_PROCESSOR_NAME] = "";
    setenv("HWLOC_COMPONENTS", "-gl", 0); /* else MPI asks X servers, and dies with one that ends */
    if (MPI_Init_thread(NULL, NULL, MPI_THREAD_FUNNELED, &level) != MPI_SUCCESS)
        return stp_error_set(err, STP_IO, "MPI does not start");
    MPI_Comm_set_errhandler(MPI_COMM_WORLD, MPI_ERRORS_RETURN);
    MPI_Comm_rank(MPI_COMM_WORLD, &self);
    MPI_Comm_size(MPI_COMM_WORLD, &count);
    MPI_Get_processor_name(name, &length);
    snprintf(host, STP_HOST_BYTES, "%.*s", (int)STP_HOST_BYTES - 1, name);
    *out = (stp_ranks){.self = (unsigned)self,
                       .count = (unsigned)count,
                       .broadcast = broadcast,
                       .send = send,
                       .exchange = exchange,
                       .finish = finish,
                       .abort_all = abort_all};
    return STP_OK;
}
