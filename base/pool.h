/* A pool of worker threads that runs indexed tasks.
 *
 * The pool has no queue: only one stp_pool_run at a time, from one thread. The calling thread works
 * too. A task must write its results to places that its index owns. Then the outcome is the same
 * for any number of threads. */
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

/* Runs task for every index and returns when all tasks have ended. Indices are taken in
 * increasing order; soon after a failure no further ones. Returns the failure of the lowest index
 * that failed. */
stp_status stp_pool_run(stp_pool *pool, size_t count, stp_pool_task *task, void *context,
                        stp_error *err);

/* The same, but calls `then` for each index in order, one call at a time, once this task and those
 * before have ended. Holds back tasks that are `ahead` (1 or more) or more beyond the first index
 * whose `then` is left, so that few results wait. Errors: those of both tasks, OUT_OF_MEMORY. */
stp_status stp_pool_run_in_order(stp_pool *pool, size_t count, size_t ahead, stp_pool_task *task,
                                 stp_pool_task *then, void *context, stp_error *err);

#endif
