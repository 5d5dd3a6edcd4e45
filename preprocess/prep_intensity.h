/* Decides what 255 stands for in a sample's intensity. */
#ifndef STP_PREPROCESS_PREP_INTENSITY_H
#define STP_PREPROCESS_PREP_INTENSITY_H

#include "preprocess/prep_job.h"

/* Sets what 255 stands for in a sample's intensity. Errors: those of stp_cloud_every. */
stp_status stp_prep_decide_intensity(stp_prep_job *job, stp_error *err);

#endif
