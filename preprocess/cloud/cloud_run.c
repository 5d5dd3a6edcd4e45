/* Tasks over a cloud, within the limit of memory. */
#include "preprocess/cloud/cloud_blocks.h"

typedef struct relieved {
    stp_spill *spill;
    stp_pool_task *task;
    void *context;
    uint64_t first; /* index of the first task */
} relieved;

static stp_status run_relieved(void *context, size_t index, unsigned worker, stp_error *err)
{
    const relieved *r = context;
    stp_spill_relieve(r->spill);
    return r->task(r->context, r->first + index, worker, err);
}

stp_status stp_cloud_run(const stp_cloud *cloud, stp_pool *pool, size_t count, stp_pool_task *task,
                         void *context, stp_error *err)
{
    relieved r = {cloud->spill, task, context, 0};
    return stp_pool_run(pool, count, run_relieved, &r, err);
}

stp_status stp_cloud_run_own(const stp_cloud *cloud, stp_pool *pool, stp_pool_task *task,
                             void *context, stp_error *err)
{
    const stp_rank_part own = stp_cloud_own_cells(cloud);
    relieved r = {cloud->spill, task, context, own.begin};
    return stp_pool_run(pool, own.end - own.begin, run_relieved, &r, err);
}
