/* Ranks over MPI: the one entry of the module stipple-mpi, which a build with STIPPLE_MPI has.
 *
 * It is loaded when mpirun or srun starts several processes (ranks/meeting.h). Nothing else here
 * knows MPI. Threads: the main thread only. */
#ifndef STP_PREPROCESS_MPI_MPI_RANKS_H
#define STP_PREPROCESS_MPI_MPI_RANKS_H

#include "preprocess/ranks/ranks.h"

typedef stp_status stp_mpi_opener(stp_ranks *out, char host[STP_HOST_BYTES], stp_error *err);

/* Starts MPI. Sets everything of *out but names and progress, and the name of this machine. Errors:
 * IO. End with out->finish or out->abort. */
stp_mpi_opener stp_mpi_open;

#endif
