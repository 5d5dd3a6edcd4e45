/* Marks or drops outliers. */
#ifndef STP_PREPROCESS_PREP_OUTLIERS_H
#define STP_PREPROCESS_PREP_OUTLIERS_H

#include "preprocess/prep_job.h"

/* Marks outliers, or drops them and tells the source. Errors: those of stp_outliers_find and
 * stp_outliers_drop, and of the source. */
stp_status stp_prep_treat_outliers(stp_prep_job *job, stp_error *err);

#endif
