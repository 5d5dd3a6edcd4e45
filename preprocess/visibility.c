/* Depth buffers of the cloud from 26 directions. */
#include "preprocess/visibility.h"

#include "base/memory.h"
#include "formats/chunk/sample.h"

#include <stdlib.h>

#define DIRECTIONS 26u
#define PIXELS_LIMIT 2048
#define PIXEL_SPACINGS 2.5
#define NOBODY UINT32_MAX
/* Views flatter than this do not tell the sides of a noisy normal apart. */
#define GRAZING_COSINE 0.25

typedef struct vote_job {
    _Atomic int *votes;
    const stp_cloud *cloud;
    stp_dvec3 centre;
    double radius; /* of a ball around the cloud */
    double pixel;  /* world units */
    int size;      /* pixels */
} vote_job;

typedef struct axes {
    stp_dvec3 right, up, back;
} axes;

/* Faces, edges and corners of a cube: the places but the middle one of 3 x 3 x 3. */
static axes direction(size_t index)
{
    size_t place = index < 13 ? index : index + 1;
    stp_dvec3 back = stp_dvec3_normalize((stp_dvec3){
        (double)(place % 3) - 1.0, (double)(place / 3 % 3) - 1.0, (double)(place / 9) - 1.0});
    stp_dvec3 side = fabs(back.x) < 0.8 ? (stp_dvec3){1.0, 0.0, 0.0} : (stp_dvec3){0.0, 1.0, 0.0};
    stp_dvec3 right = stp_dvec3_normalize(stp_dvec3_cross(side, back));
    return (axes){right, stp_dvec3_cross(back, right), back};
}

static void draw(const vote_job *job, const axes *view, float *depth, uint32_t *nearest)
{
    for (uint32_t i = 0; i < job->cloud->count; i++) {
        stp_dvec3 p = stp_dvec3_sub(job->cloud->points[i].position, job->centre);
        int x = (int)((stp_dvec3_dot(p, view->right) + job->radius) / job->pixel);
        int y = (int)((stp_dvec3_dot(p, view->up) + job->radius) / job->pixel);
        float z = (float)stp_dvec3_dot(p, view->back);
        if (x < 0 || y < 0 || x >= job->size || y >= job->size)
            continue;
        size_t at = (size_t)y * (size_t)job->size + (size_t)x;
        if (nearest[at] == NOBODY || z > depth[at]) {
            depth[at] = z;
            nearest[at] = i;
        }
    }
}

static stp_status vote_task(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    vote_job *job = context;
    axes view = direction(index);
    size_t pixels = (size_t)job->size * (size_t)job->size;
    float *depth = NULL;
    uint32_t *nearest = NULL;
    (void)worker;
    STP_TRY(stp_alloc(&depth, pixels, sizeof *depth, "a depth buffer", err));
    STP_TRY(stp_alloc(&nearest, pixels, sizeof *nearest, "a depth buffer", err));
    for (size_t i = 0; i < pixels; i++)
        nearest[i] = NOBODY;
    draw(job, &view, depth, nearest);
    for (size_t i = 0; i < pixels; i++) {
        if (nearest[i] == NOBODY)
            continue;
        const stp_cloud_point *p = &job->cloud->points[nearest[i]];
        double cosine = stp_dvec3_dot(stp_dvec3_from_float(p->normal), view.back);
        if (p->flags & STP_SAMPLE_HAS_NORMAL && fabs(cosine) >= GRAZING_COSINE)
            atomic_fetch_add_explicit(&job->votes[nearest[i]], cosine > 0.0 ? 1 : -1,
                                      memory_order_relaxed);
    }
done:
    free(nearest);
    free(depth);
    return status;
}

stp_status stp_visibility_vote(_Atomic int *votes, const stp_cloud *cloud, stp_pool *pool,
                               stp_error *err)
{
    double spacing = 0.0;
    for (uint32_t i = 0; i < cloud->count; i++)
        spacing += (double)cloud->points[i].spacing;
    spacing /= cloud->count;
    vote_job job = {
        .votes = votes,
        .cloud = cloud,
        .centre = stp_dvec3_scale(stp_dvec3_add(cloud->box.min, cloud->box.max), 0.5),
        .radius = 0.5 * stp_dvec3_length(stp_dvec3_sub(cloud->box.max, cloud->box.min)),
    };
    if (!(job.radius > 0.0) || !(spacing > 0.0))
        return STP_OK; /* no extent: nothing is seen */
    double wanted = 2.0 * job.radius / (PIXEL_SPACINGS * spacing);
    job.size = wanted < PIXELS_LIMIT ? (int)wanted + 1 : PIXELS_LIMIT;
    job.pixel = 2.0 * job.radius * (1.0 + 1e-9) / job.size;
    return stp_pool_run(pool, DIRECTIONS, vote_task, &job, err);
}
