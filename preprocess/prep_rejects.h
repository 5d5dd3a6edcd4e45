/* Tells a source which of its records are rejected. */
#ifndef STP_PREPROCESS_PREP_REJECTS_H
#define STP_PREPROCESS_PREP_REJECTS_H

#include "preprocess/prep_job.h"

/* Tells the source of a rejected record, at once or when all parts are read. Errors: those of the
 * source, OUT_OF_MEMORY. */
stp_status stp_prep_reject(stp_prep_job *job, uint64_t place, stp_reject reason, stp_error *err);
/* Tells the source, on rank 0, of the rejected records that ranks have kept, in ascending order.
 * Errors: likewise, IO, CANCELLED. */
stp_status stp_prep_give_rejects(stp_prep_job *job, stp_error *err);

#endif
