/* A pool of worker threads that runs indexed tasks.
 *
 * Does not queue: one stp_pool_run at a time per pool, from one thread; the caller works too.
 * Results must be written to places owned by the index, so that the outcome is the same for any
 * number of threads. */
#ifndef STP_BASE_POOL_H
#define STP_BASE_POOL_H

#include "base/error.h"

#include <stddef.h>

typedef struct stp_pool stp_pool;

/* One piece of work: index in [0, count), worker in [0, thread_count). */
typedef stp_status stp_pool_task(void *context, size_t index, unsigned worker, stp_error *err);

/* thread_count 0 means one per processor; at most 256. Errors: OUT_OF_MEMORY, LIMIT. */
stp_status stp_pool_create(stp_pool **out, unsigned thread_count, stp_error *err);
void stp_pool_destroy(stp_pool **pool);
unsigned stp_pool_thread_count(const stp_pool *pool);

/* Runs task for every index, in increasing order of start, and returns when all have ended. After a
 * failure no further index is started; the failure of the lowest failing index is returned. */
stp_status stp_pool_run(stp_pool *pool, size_t count, stp_pool_task *task, void *context,
                        stp_error *err);

#endif
