/* The stages of points: from the stations that files claim to maps and images. */
#ifndef STP_PREPROCESS_PREP_POINTS_H
#define STP_PREPROCESS_PREP_POINTS_H

#include "preprocess/prep_job.h"

/* Runs all stages of points from the stations that files claim to maps and images. Errors: those
 * of the stages. */
stp_status stp_prep_treat_points(stp_prep_job *job, stp_error *err);
/* Chooses the stations that normals will be turned to, if any. */
void stp_prep_choose_stations(stp_prep_job *job);
/* How the cloud's surface is to be found, once the cloud and the plan are there. */
stp_surface_params stp_prep_surface_params(const stp_prep_job *job);

#endif
