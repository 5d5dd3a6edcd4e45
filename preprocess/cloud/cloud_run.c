/* Tasks over a cloud, within the limit of memory. */
#include "preprocess/cloud/cloud.h"

typedef struct relieved {
    stp_spill *spill;
    stp_pool_task *task;
    void *context;
} relieved;

static stp_status run_relieved(void *context, size_t index, unsigned worker, stp_error *err)
{
    const relieved *r = context;
    stp_spill_relieve(r->spill);
    return r->task(r->context, index, worker, err);
}

stp_status stp_cloud_run(const stp_cloud *cloud, stp_pool *pool, size_t count, stp_pool_task *task,
                         void *context, stp_error *err)
{
    relieved r = {cloud->spill, task, context};
    return stp_pool_run(pool, count, run_relieved, &r, err);
}
