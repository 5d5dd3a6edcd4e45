/* Signs of new normals, from old points. */
#include "preprocess/append/append_job.h"

/* The old points of a sheet must agree so far, and this part of them must have a sign. */
#define AGREE_LEAST 0.8
#define KNOWN_LEAST 0.5

/* What the old points of a sheet say. */
typedef struct vote {
    uint32_t count, known;
    int64_t sum; /* of those that point as the cloud's normal does, less the others */
} vote;

static const stp_old_point *old_of(const stp_append *a, const stp_cloud_point *p)
{
    return p->source >= a->read_count ? &a->old[p->source - a->read_count] : NULL;
}

static bool is_oriented(const stp_old_point *old)
{
    const unsigned known = STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL;
    return (old->flags & known) == known;
}

static void count_votes(const stp_append *a, vote *votes)
{
    const stp_cloud *cloud = &a->job.cloud;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        const stp_old_point *old = old_of(a, &cloud->points[i]);
        if (!old || cloud->sheets[i] == STP_SHEET_NONE || !stp_has_normal(&cloud->points[i]))
            continue;
        vote *v = &votes[cloud->sheets[i]];
        v->count++;
        if (!is_oriented(old))
            continue;
        v->known++;
        v->sum += glms_vec3_dot(stp_cloud_normal(cloud, i), stp_normal_decode(old->normal)) < 0.0f
                      ? -1
                      : 1;
    }
}

/* 1 or -1: the sheet's normals have that sign; 0: unknown. */
static int decide(const vote *v)
{
    const double sum = (double)v->sum, known = (double)v->known;
    if (v->known == 0 || known < KNOWN_LEAST * v->count || fabs(sum) < AGREE_LEAST * known)
        return 0;
    return sum > 0.0 ? 1 : -1;
}

stp_status stp_append_sign(stp_append *a, bool guessed, stp_error *err)
{
    stp_status status = STP_OK;
    stp_cloud *cloud = &a->job.cloud;
    vote *votes = NULL;
    uint32_t sheets = 0;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->sheets[i] != STP_SHEET_NONE && cloud->sheets[i] >= sheets)
            sheets = cloud->sheets[i] + 1;
    STP_TRY(stp_spill_alloc(cloud->spill, &votes, sheets, sizeof *votes, "sheets", err));
    count_votes(a, votes);
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        if (cloud->points[i].source >= a->read_count)
            continue;
        if (guessed)
            cloud->marks[i] &= (uint8_t)~STP_MARK_ORIENTED;
        if (cloud->marks[i] & STP_MARK_ORIENTED || cloud->sheets[i] == STP_SHEET_NONE ||
            !stp_has_normal(&cloud->points[i]))
            continue;
        const int sign = decide(&votes[cloud->sheets[i]]);
        if (sign != 0)
            cloud->marks[i] |= STP_MARK_ORIENTED;
        if (sign < 0)
            cloud->marks[i] ^= STP_MARK_TURNED;
    }
done:
    stp_spill_free(cloud->spill, votes);
    return status;
}
