/* Reads the points of a source into the cloud, or into the grid. */
#ifndef STP_PREPROCESS_PREP_READ_H
#define STP_PREPROCESS_PREP_READ_H

#include "preprocess/prep_job.h"

/* Reads all points into the cloud, or into the grid if the job keeps it. If the scanner's position
 * is given, they all belong to station 1. A cloud without colours gets a light grey. Errors: those
 * of the source, EMPTY, CORRUPT (more points than the source counts), CANCELLED, OUT_OF_MEMORY, IO.
 */
stp_status stp_prep_read(stp_prep_job *job, stp_error *err);
/* Counts a stored point in the statistics. */
void stp_prep_count(stp_prep_stats *stats, const stp_cloud_point *point);

#endif
