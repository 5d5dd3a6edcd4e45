/* How long the stream rests after a failed read, and why. Threads: the render thread. */
#ifndef STP_RUNTIME_STREAM_REST_H
#define STP_RUNTIME_STREAM_REST_H

#include <stdbool.h>

/* Zero: there is no trouble. */
typedef struct stp_rest {
    double until, seconds; /* stp_clock_seconds; the length of this rest */
    char words[512];       /* the trouble; empty: none */
} stp_rest;

bool stp_rest_lasts(const stp_rest *rest);
/* Begins a rest, longer each time. While one lasts, failures are the same trouble, and so are those
 * of reads that were under way when it began (late), even if they fail after it. */
void stp_rest_begin(stp_rest *rest, const char *message, bool late);

#endif
