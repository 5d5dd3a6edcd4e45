/* Tells a source which of its records are rejected. */
#include "preprocess/prep_rejects.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

/* A rejected record. */
typedef struct rejected {
    uint64_t record, reason;
} rejected;

stp_status stp_prep_reject(stp_prep_job *job, uint64_t place, stp_reject reason, stp_error *err)
{
    const stp_prep_source *source = job->source;
    const rejected found = {place, reason};
    if (job->in_parts && job->lists_rejects)
        return stp_bytes_append(&job->rejects, &found, sizeof found, err);
    return source->rejected ? source->rejected(source->context, place, reason, err) : STP_OK;
}

static int compare_rejected(const void *a, const void *b)
{
    const uint64_t x = ((const rejected *)a)->record, y = ((const rejected *)b)->record;
    return (x > y) - (x < y);
}

stp_status stp_prep_give_rejects(stp_prep_job *job, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_prep_source *source = job->source;
    stp_ranks *ranks = job->params->ranks;
    stp_bytes all = job->rejects, other = {0};
    rejected *list = NULL;
    job->rejects = (stp_bytes){0};
    for (unsigned rank = 1; rank < ranks->count && job->lists_rejects; rank++) {
        STP_TRY(stp_ranks_send_bytes(ranks, rank, rank == ranks->self ? &all : &other, err));
        if (ranks->self == 0)
            STP_TRY(stp_bytes_append(&all, other.data, other.size, err));
    }
    if (ranks->self > 0 || all.size == 0)
        goto done;
    const size_t count = all.size / sizeof *list;
    STP_TRY(stp_alloc(&list, count, sizeof *list, "rejects", err));
    memcpy(list, all.data, all.size);
    qsort(list, count, sizeof *list, compare_rejected);
    for (size_t i = 0; i < count; i++)
        STP_TRY(source->rejected(source->context, list[i].record, (stp_reject)list[i].reason, err));
done:
    free(list);
    free(all.data);
    free(other.data);
    return status;
}
