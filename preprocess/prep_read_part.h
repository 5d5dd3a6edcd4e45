/* Reads the points of a source by several ranks, a part each. */
#ifndef STP_PREPROCESS_PREP_READ_PART_H
#define STP_PREPROCESS_PREP_READ_PART_H

#include "preprocess/prep_job.h"

/* Decides whether each rank reads a part of the inputs alone. All ranks decide alike. Errors:
 * CANCELLED, IO. */
stp_status stp_prep_choose_parts(stp_prep_job *job, stp_error *err);
/* How much a run has to prepare, once parts are chosen. */
stp_prep_size stp_prep_job_size(const stp_prep_job *job);
/* Lets `read` read this rank's part, and adds up what all ranks read. If any rank fails, each reads
 * everything, which says why or leaves a file out. Errors: those of read. */
stp_status stp_prep_read_part(stp_prep_job *job, stp_status (*read)(stp_prep_job *, stp_error *),
                              stp_error *err);
/* Sorts the parts that ranks read, once the claims of their files are checked; ranks then share
 * the points. Errors: those of stp_claims_check and stp_cloud_sort_parts. */
stp_status stp_prep_sort_parts(stp_prep_job *job, stp_error *err);

#endif
