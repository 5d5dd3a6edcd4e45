/* Which threshold a sweep speaks for, as one sentence. Threads: any (pure functions). */
#ifndef STP_TOOLS_TUNE_TUNE_ADVICE_H
#define STP_TOOLS_TUNE_TUNE_ADVICE_H

#include <stdbool.h>
#include <stddef.h>

/* A picture within so many dB of the finest one looks like it. */
#define TUNE_ADVICE_DB 0.5
/* A gain in time below this is none: clocks differ as much from run to run. */
#define TUNE_ADVICE_FASTER 1.05

/* What was measured at a threshold. */
typedef struct tune_choice {
    double threshold_px, psnr_db, points, ms;
} tune_choice;

typedef struct tune_advice {
    size_t chosen, finest, next; /* of the choices; next: the one that follows the finest */
    double loss_db;              /* of the chosen against the finest; below 0: it is better */
    double faster, fewer;        /* times, in milliseconds and in samples */
} tune_advice;

/* Chooses the greatest threshold up to which every picture is within TUNE_ADVICE_DB of that of the
 * least one. False if there are fewer than two choices. */
bool tune_advise(const tune_choice *choices, size_t count, tune_advice *out);
void tune_advice_words(const tune_advice *advice, const tune_choice *choices, char out[240]);

#endif
