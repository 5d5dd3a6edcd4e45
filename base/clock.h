/* Monotonic time in seconds and the process's peak memory. */
#ifndef STP_BASE_CLOCK_H
#define STP_BASE_CLOCK_H

#include <stdint.h>

double stp_clock_seconds(void);
/* Greatest resident set of the process so far, in bytes (0 if the system does not say). */
uint64_t stp_peak_rss_bytes(void);

#endif
