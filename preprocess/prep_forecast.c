/* A model of the time of a run. */
#include "preprocess/prep_forecast.h"

#include <math.h>

/* User seconds a point of a statue of 4 M on one thread (docs/mpi.md). Every rank does the flood of
 * `closed` and the forest of pieces for all, on one thread. Reading and half of the sort, which
 * ranks share, are on one thread, too. */
#define LONE_SECONDS 0.26e-6
#define SHARED_SECONDS 0.08e-6
#define SHARED_THREAD_SECONDS 3.87e-6
/* Bytes of a point, which moves to the rank that sorts it. */
#define POINT_BYTES 56.0
/* Bytes a point that each other rank gets: patch vertices, pieces, boxes, voxels. */
#define RANK_BYTES 7.0
/* Bytes that a rank gets of what lies along its borders, by the root of its points. */
#define BORDER_BYTES 130e3
/* Bytes a point of the file, with colours. */
#define FILE_BYTES 10.0
/* Bytes a second that a file system takes from one machine, and from how many at once. */
#define DISK_RATE 1e9
#define DISK_MACHINES 16

stp_prep_forecast stp_prep_forecast_make(uint64_t points, unsigned ranks, unsigned threads,
                                         double network)
{
    const double n = (double)points, others = ranks - 1.0;
    const double moved = n * POINT_BYTES * others / ranks;
    const double border = ranks > 1 ? BORDER_BYTES * sqrt(n / ranks) : 0.0;
    return (stp_prep_forecast){
        .lone_s = n * LONE_SECONDS,
        .shared_s = n * (SHARED_SECONDS + SHARED_THREAD_SECONDS / threads) / ranks,
        /* A broadcast goes through log2(ranks) machines, one after the other; points go straight.
         */
        .sent_s = (n * RANK_BYTES * ceil(log2(ranks)) + moved / ranks + border) / network,
        .written_s = n * FILE_BYTES / (DISK_RATE * fmin(ranks, DISK_MACHINES)),
        .sent_bytes = n * RANK_BYTES * others + moved + border * ranks,
    };
}
