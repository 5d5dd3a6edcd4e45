/* How ranks find each other, and how they part: at the end of the work, or when one of them fails.
 *
 * A token, a file beside the output with the name of a temporary file, shows that all ranks see the
 * same folder. When ranks fail, or are ended since another one died, whoever removes the token says
 * why: one line, however many ranks there are. Threads: the main thread only. */
#ifndef STP_PREPROCESS_RANKS_MEETING_H
#define STP_PREPROCESS_RANKS_MEETING_H

#include "preprocess/ranks/ranks.h"

typedef struct stp_meeting stp_meeting;

/* Joins the other ranks. *out is NULL if this process is alone. Errors: IO (MPI fails), UNSUPPORTED
 * (several processes, and this build has no MPI), OUT_OF_MEMORY. */
stp_status stp_meeting_begin(stp_meeting **out, stp_error *err);
/* NULL for NULL. Valid until stp_meeting_end. */
stp_ranks *stp_meeting_ranks(stp_meeting *meeting);
/* Makes the token, which must be seen by all ranks. From here on whoever waits for other ranks
 * gives up when `progress`, borrowed, says so. Errors: IO (no file can be made there),
 * INVALID_ARGUMENT (a rank does not see it), CANCELLED. */
stp_status stp_meeting_at(stp_meeting *meeting, const char *output, const stp_progress *progress,
                          stp_error *err);
/* Waits for all ranks, and parts. *meeting becomes NULL. Errors: CANCELLED, IO: then abort. */
stp_status stp_meeting_end(stp_meeting **meeting, stp_error *err);

/* When something failed: whether this rank is to say so. One of all ranks that fail gets true. */
bool stp_meeting_speaks(stp_meeting *meeting);
/* Ends all ranks: the caller is to exit if it still can. code: what mpirun ends with. spoken: what
 * stp_meeting_speaks said. */
void stp_meeting_abort(stp_meeting *meeting, int code, bool spoken);

#endif
