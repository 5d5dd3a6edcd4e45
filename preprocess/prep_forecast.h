/* How long a run takes on one machine and on several: a model, for a decision before a day of
 * machine time is spent. docs/mpi.md says how its rates were measured. Threads: any (a pure
 * function). */
#ifndef STP_PREPROCESS_PREP_FORECAST_H
#define STP_PREPROCESS_PREP_FORECAST_H

#include <stdint.h>

typedef struct stp_prep_forecast {
    double lone_s;     /* stages that every rank runs over all points */
    double shared_s;   /* all others; each rank does a part */
    double sent_s;     /* results to all other ranks */
    double written_s;  /* the file, by all ranks */
    double sent_bytes; /* by all ranks together */
} stp_prep_forecast;

/* For `ranks` processes with `threads` threads each, on machines of their own. network: bytes a
 * second into and out of a machine. */
stp_prep_forecast stp_prep_forecast_make(uint64_t points, unsigned ranks, unsigned threads,
                                         double network);

static inline double stp_prep_forecast_seconds(const stp_prep_forecast *f)
{
    return f->lone_s + f->shared_s + f->sent_s + f->written_s;
}

#endif
