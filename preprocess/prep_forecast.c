/* A model of the time of a run. */
#include "preprocess/prep_forecast.h"

#include <math.h>

/* Seconds a point: a scan of a room, 3.2 M points, with 1 and 2 threads. Of orientation, and of the
 * flood of closed, a part goes on one thread, however many there are; so do reading and a part of
 * the sort, which ranks share. */
#define LONE_SECONDS 0.34e-6
#define LONE_THREAD_SECONDS 0.03e-6
#define SHARED_SECONDS 0.14e-6
#define SHARED_THREAD_SECONDS 5.02e-6
/* Bytes of a point, which moves to the rank that sorts it, and from there to all others. */
#define POINT_BYTES 56.0
/* Bytes a point that each other rank gets: of the surface, what closes it, and patch vertices. */
#define SURFACE_BYTES 25.0
#define CLOSED_BYTES 3.0
#define VERTEX_BYTES 4.0
/* Bytes a point of the file, with colours. */
#define FILE_BYTES 10.0
/* Bytes a second that a file system takes from one machine. */
#define DISK_RATE 1e9

stp_prep_forecast stp_prep_forecast_make(uint64_t points, unsigned ranks, unsigned threads,
                                         double network)
{
    const double n = (double)points, others = ranks - 1.0;
    const double per_rank = SURFACE_BYTES + CLOSED_BYTES + VERTEX_BYTES;
    const double moved = n * POINT_BYTES * others / ranks;
    const double handed = n * FILE_BYTES * others / ranks;
    return (stp_prep_forecast){
        .lone_s = n * (LONE_SECONDS + LONE_THREAD_SECONDS / threads),
        .shared_s = n * (SHARED_SECONDS + SHARED_THREAD_SECONDS / threads) / ranks,
        /* A broadcast goes through log2(ranks) machines, one after the other; points go straight.
         */
        .sent_s = (n * per_rank * ceil(log2(ranks)) + moved + moved / ranks) / network,
        .written_s = handed / network + n * FILE_BYTES / DISK_RATE,
        .sent_bytes = n * (per_rank + POINT_BYTES) * others + moved + handed,
    };
}
