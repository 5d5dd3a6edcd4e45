/* A model of the time of a run. */
#include "preprocess/prep_forecast.h"

#include <math.h>

/* Seconds a point: a scan of a room, 3.2 M points, with 1 and 2 threads. Of read, sort, orientation
 * and closed, a part goes on one thread, however many there are. */
#define LONE_SECONDS 0.48e-6
#define LONE_THREAD_SECONDS 0.48e-6
#define SHARED_THREAD_SECONDS 4.57e-6
/* Bytes a point that each other rank gets: of the surface, and patch vertices. */
#define SURFACE_BYTES 25.0
#define VERTEX_BYTES 4.0
/* Bytes a point of the file, with colours. */
#define FILE_BYTES 10.0
/* Bytes a second that a file system takes from one machine. */
#define DISK_RATE 1e9

stp_prep_forecast stp_prep_forecast_make(uint64_t points, unsigned ranks, unsigned threads,
                                         double network)
{
    const double n = (double)points, others = ranks - 1.0, per_rank = SURFACE_BYTES + VERTEX_BYTES;
    const double handed = n * FILE_BYTES * others / ranks;
    return (stp_prep_forecast){
        .lone_s = n * (LONE_SECONDS + LONE_THREAD_SECONDS / threads),
        .shared_s = n * SHARED_THREAD_SECONDS / threads / ranks,
        /* A broadcast goes through log2(ranks) machines, one after the other. */
        .sent_s = n * per_rank * ceil(log2(ranks)) / network,
        .written_s = handed / network + n * FILE_BYTES / DISK_RATE,
        .sent_bytes = n * per_rank * others + handed,
    };
}
