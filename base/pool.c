/* A pool of worker threads that runs indexed tasks. */
#include "base/pool.h"

#include "base/memory.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <unistd.h>

#define STP_POOL_THREAD_LIMIT 256u

typedef struct worker {
    stp_pool *pool;
    unsigned number;
    pthread_t thread;
} worker;

struct stp_pool {
    unsigned thread_count; /* the caller included */
    unsigned started_count;
    worker *workers;

    /* Many short tasks would queue for a lock, so indices are taken without one. */
    atomic_size_t next;
    atomic_bool failed;

    pthread_mutex_t mutex; /* guards everything below; the only lock of the pool */
    pthread_cond_t work_ready;
    pthread_cond_t work_done;
    stp_pool_task *task;
    void *context;
    size_t count;
    unsigned busy_count;
    uint64_t generation; /* grows with each run, so that workers see a new one */
    bool stopping;
    stp_status status;
    size_t failed_index;
    stp_error error;
};

/* Keeps the failure of the lowest index. */
static void fail(stp_pool *pool, size_t index, stp_status status, const stp_error *error)
{
    pthread_mutex_lock(&pool->mutex);
    if (pool->status == STP_OK || index < pool->failed_index) {
        pool->status = status;
        pool->failed_index = index;
        pool->error = *error;
    }
    pthread_mutex_unlock(&pool->mutex);
    atomic_store(&pool->failed, true);
}

/* Takes indices until none is left. The mutex is held on entry and on return. */
static void work(stp_pool *pool, unsigned number)
{
    stp_pool_task *task = pool->task;
    void *context = pool->context;
    const size_t count = pool->count;
    pthread_mutex_unlock(&pool->mutex);
    for (size_t index; !atomic_load(&pool->failed) && count > 0 &&
                       (index = atomic_fetch_add(&pool->next, 1)) < count;) {
        stp_error error = {0};
        stp_status status = task(context, index, number, &error);
        if (status != STP_OK)
            fail(pool, index, status, &error);
    }
    pthread_mutex_lock(&pool->mutex);
}

static void *worker_main(void *argument)
{
    worker *self = argument;
    stp_pool *pool = self->pool;
    uint64_t seen = 0;
    pthread_mutex_lock(&pool->mutex);
    while (!pool->stopping) {
        if (pool->generation == seen) {
            pthread_cond_wait(&pool->work_ready, &pool->mutex);
            continue;
        }
        seen = pool->generation;
        pool->busy_count++;
        work(pool, self->number);
        if (--pool->busy_count == 0)
            pthread_cond_signal(&pool->work_done);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

static unsigned processor_count(void)
{
    long count = sysconf(_SC_NPROCESSORS_ONLN);
    return count < 1 ? 1u : (unsigned)count;
}

stp_status stp_pool_create(stp_pool **out, unsigned thread_count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_pool *pool = NULL;
    if (thread_count > STP_POOL_THREAD_LIMIT)
        return stp_error_set(err, STP_LIMIT, "%u threads asked for: use at most %u", thread_count,
                             STP_POOL_THREAD_LIMIT);
    if (thread_count == 0)
        thread_count = processor_count();
    if (thread_count > STP_POOL_THREAD_LIMIT)
        thread_count = STP_POOL_THREAD_LIMIT;
    STP_TRY(stp_alloc(&pool, 1, sizeof *pool, "thread pool", err));
    pthread_mutex_init(&pool->mutex, NULL);
    pthread_cond_init(&pool->work_ready, NULL);
    pthread_cond_init(&pool->work_done, NULL);
    pool->thread_count = thread_count;
    STP_TRY(stp_alloc(&pool->workers, thread_count, sizeof *pool->workers, "threads", err));
    for (unsigned i = 1; i < thread_count; i++) {
        worker *w = &pool->workers[pool->started_count];
        *w = (worker){.pool = pool, .number = i};
        if (pthread_create(&w->thread, NULL, worker_main, w) != 0) {
            status = stp_error_set(err, STP_LIMIT,
                                   "thread %u of %u could not be started: use --threads with a "
                                   "smaller number",
                                   i + 1, thread_count);
            goto done;
        }
        pool->started_count++;
    }
    *out = pool;
    pool = NULL;
done:
    stp_pool_destroy(&pool);
    return status;
}

void stp_pool_destroy(stp_pool **pool)
{
    stp_pool *p = *pool;
    if (!p)
        return;
    pthread_mutex_lock(&p->mutex);
    p->stopping = true;
    pthread_cond_broadcast(&p->work_ready);
    pthread_mutex_unlock(&p->mutex);
    for (unsigned i = 0; i < p->started_count; i++)
        pthread_join(p->workers[i].thread, NULL);
    pthread_cond_destroy(&p->work_done);
    pthread_cond_destroy(&p->work_ready);
    pthread_mutex_destroy(&p->mutex);
    free(p->workers);
    free(p);
    *pool = NULL;
}

unsigned stp_pool_thread_count(const stp_pool *pool)
{
    return pool->thread_count;
}

/* Wakes no more workers than there are tasks beside the caller's first. */
static void wake(stp_pool *pool, size_t count)
{
    if (count > pool->started_count) {
        pthread_cond_broadcast(&pool->work_ready);
        return;
    }
    for (size_t i = 1; i < count; i++)
        pthread_cond_signal(&pool->work_ready);
}

stp_status stp_pool_run(stp_pool *pool, size_t count, stp_pool_task *task, void *context,
                        stp_error *err)
{
    pthread_mutex_lock(&pool->mutex);
    pool->task = task;
    pool->context = context;
    pool->count = count;
    atomic_store(&pool->next, 0);
    atomic_store(&pool->failed, false);
    pool->status = STP_OK;
    pool->generation++;
    wake(pool, count);
    work(pool, 0);
    while (pool->busy_count > 0)
        pthread_cond_wait(&pool->work_done, &pool->mutex);
    /* A worker that wakes only now finds no task left and does nothing. */
    pool->count = 0;
    stp_status status = pool->status;
    if (status != STP_OK && err)
        *err = pool->error;
    pthread_mutex_unlock(&pool->mutex);
    return status;
}

typedef struct ordered {
    stp_pool_task *task, *then;
    void *context;
    size_t count, ahead;
    pthread_mutex_t mutex; /* guards everything below; no other lock is taken under it */
    pthread_cond_t moved;  /* next or stopped has changed */
    bool *ended;           /* by index: its task has ended */
    size_t next;           /* index whose `then` is left */
    bool taken, stopped;   /* a thread calls `then`; something failed */
} ordered;

/* Calls `then` for the tasks that have ended, in order. The mutex is held on entry and on return.
 */
static stp_status take_ended(ordered *o, unsigned number, stp_error *err)
{
    stp_status status = STP_OK;
    o->taken = true;
    while (status == STP_OK && !o->stopped && o->next < o->count && o->ended[o->next]) {
        const size_t index = o->next;
        pthread_mutex_unlock(&o->mutex);
        status = o->then(o->context, index, number, err);
        pthread_mutex_lock(&o->mutex);
        o->next++;
        pthread_cond_broadcast(&o->moved);
    }
    o->taken = false;
    return status;
}

static stp_status run_ordered(void *context, size_t index, unsigned number, stp_error *err)
{
    stp_status status = STP_OK;
    ordered *o = context;
    pthread_mutex_lock(&o->mutex);
    while (!o->stopped && index - o->next >= o->ahead)
        pthread_cond_wait(&o->moved, &o->mutex);
    if (index - o->next < o->ahead) { /* even if stopped: a greater index may have failed */
        pthread_mutex_unlock(&o->mutex);
        status = o->task(o->context, index, number, err);
        pthread_mutex_lock(&o->mutex);
        o->ended[index] = status == STP_OK;
        if (status == STP_OK && !o->taken)
            status = take_ended(o, number, err);
    }
    if (status != STP_OK) {
        o->stopped = true;
        pthread_cond_broadcast(&o->moved);
    }
    pthread_mutex_unlock(&o->mutex);
    return status;
}

stp_status stp_pool_run_in_order(stp_pool *pool, size_t count, size_t ahead, stp_pool_task *task,
                                 stp_pool_task *then, void *context, stp_error *err)
{
    ordered o = {.task = task, .then = then, .context = context, .count = count, .ahead = ahead};
    stp_status status = stp_alloc(&o.ended, count, sizeof *o.ended, "tasks", err);
    if (status != STP_OK)
        return status;
    pthread_mutex_init(&o.mutex, NULL);
    pthread_cond_init(&o.moved, NULL);
    status = stp_pool_run(pool, count, run_ordered, &o, err);
    pthread_cond_destroy(&o.moved);
    pthread_mutex_destroy(&o.mutex);
    free(o.ended);
    return status;
}
