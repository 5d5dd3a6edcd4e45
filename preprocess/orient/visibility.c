/* Depth buffers of the cloud from 26 directions. */
#include "preprocess/orient/visibility.h"

#include "base/memory.h"
#include "preprocess/cloud/cloud_blocks.h"

#include <stdlib.h>

/* Each axis is viewed from both ends. */
#define AXES 13u
#define PIXELS_LIMIT 2048
#define PIXEL_SPACINGS 2.5
/* Of larger clouds only every second, third, ... point is drawn, in wider pixels. */
#define DRAWN_POINTS 1000000u
#define BLOCK 65536u
/* In flatter views, noise hides which side the normal is on. */
#define GRAZING_COSINE 0.25f

/* The drawn points nearest to the two viewers of an axis, numbered from 1; 0: none. */
typedef struct pixel {
    float front_depth, back_depth;
    uint32_t front, back;
} pixel;

typedef struct vote_job {
    _Atomic int *votes;
    const stp_cloud *cloud;
    stp_dvec3 centre;
    double radius;   /* of a ball around the cloud */
    uint64_t stride; /* points from one drawn to the next */
    uint32_t drawn_count;
    stp_rank_part own; /* drawn points of this process */
    vec3s *positions;  /* by drawn point: in pixels, from the centre */
    vec3s *normals; /* by drawn point; a copy, since seen points lie anywhere and the cloud may not
                       be in memory */
    pixel **pixels; /* by worker: all zero between axes */
    int size;       /* pixels */
} vote_job;

typedef struct view {
    vec3s right, up, back;
} view;

/* The directions are those from a cube's centre to its faces, edges and corners: 26 of the 3 x 3 x
 * 3 places. The first 13 places have one of each opposite pair. */
static view view_along(size_t axis)
{
    size_t row = axis / 3, layer = axis / 9;
    stp_dvec3 back = stp_dvec3_normalize(
        (stp_dvec3){(double)(axis % 3) - 1.0, (double)(row % 3) - 1.0, (double)layer - 1.0});
    stp_dvec3 side = fabs(back.x) < 0.8 ? (stp_dvec3){1.0, 0.0, 0.0} : (stp_dvec3){0.0, 1.0, 0.0};
    stp_dvec3 right = stp_dvec3_normalize(stp_dvec3_cross(side, back));
    return (view){stp_dvec3_to_float(right), stp_dvec3_to_float(stp_dvec3_cross(back, right)),
                  stp_dvec3_to_float(back)};
}

static stp_status place_block(void *context, size_t block, unsigned worker, stp_error *err)
{
    vote_job *job = context;
    const uint64_t begin = job->own.begin + (uint64_t)block * BLOCK;
    const uint64_t left = job->own.end - begin;
    double scale = 0.5 * (double)job->size / job->radius;
    (void)worker;
    (void)err;
    for (uint64_t i = begin; i < begin + (left < BLOCK ? left : BLOCK); i++) {
        const uint64_t at = job->cloud->first + i * job->stride;
        stp_dvec3 p = job->cloud->points[at].position;
        job->positions[i] =
            stp_dvec3_to_float(stp_dvec3_scale(stp_dvec3_sub(p, job->centre), scale));
        job->normals[i] = stp_cloud_normal(job->cloud, at);
        stp_cloud_stride(job->cloud->spill, at, job->stride);
    }
    return STP_OK;
}

static void draw(const vote_job *job, view v, pixel *pixels)
{
    float middle = 0.5f * (float)job->size;
    for (uint32_t i = 0; i < job->drawn_count; i++) {
        vec3s p = job->positions[i];
        int x = (int)(glms_vec3_dot(p, v.right) + middle);
        int y = (int)(glms_vec3_dot(p, v.up) + middle);
        float z = glms_vec3_dot(p, v.back);
        if (x < 0 || y < 0 || x >= job->size || y >= job->size)
            continue;
        pixel *at = &pixels[(size_t)y * (size_t)job->size + (size_t)x];
        if (at->front == 0 || z > at->front_depth) {
            at->front_depth = z;
            at->front = i + 1;
        }
        if (at->back == 0 || z < at->back_depth) {
            at->back_depth = z;
            at->back = i + 1;
        }
    }
}

static void vote(const vote_job *job, uint32_t drawn, vec3s towards)
{
    float cosine = glms_vec3_dot(job->normals[drawn - 1], towards);
    if (fabsf(cosine) >= GRAZING_COSINE)
        atomic_fetch_add_explicit(&job->votes[drawn - 1], cosine > 0.0f ? 1 : -1,
                                  memory_order_relaxed);
}

static stp_status vote_task(void *context, size_t index, unsigned worker, stp_error *err)
{
    vote_job *job = context;
    view v = view_along(index);
    size_t count = (size_t)job->size * (size_t)job->size;
    if (!job->pixels[worker]) {
        stp_status status = stp_spill_alloc(job->cloud->spill, &job->pixels[worker], count,
                                            sizeof *job->pixels[worker], "a depth buffer", err);
        if (status != STP_OK)
            return status;
    }
    draw(job, v, job->pixels[worker]);
    for (size_t i = 0; i < count; i++) {
        pixel *at = &job->pixels[worker][i];
        if (at->front == 0)
            continue;
        vote(job, at->front, v.back);
        vote(job, at->back, glms_vec3_negate(v.back));
        *at = (pixel){0};
    }
    return STP_OK;
}

uint64_t stp_visibility_stride(const stp_cloud *cloud)
{
    return (cloud->count - 1) / DRAWN_POINTS + 1;
}

/* The drawn points among a run of points. */
static stp_rank_part drawn_of(const vote_job *job, stp_rank_part run)
{
    const uint64_t first = job->cloud->first, last = job->stride - 1;
    return (stp_rank_part){(run.begin - first + last) / job->stride,
                           (run.end - first + last) / job->stride};
}

/* Places the drawn points: each process its own, for all. */
static stp_status place(vote_job *job, stp_pool *pool, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_cloud_blocks *b = job->cloud->blocks;
    job->own = drawn_of(job, stp_cloud_own(job->cloud));
    STP_TRY(stp_cloud_run(job->cloud, pool, (job->own.end - job->own.begin + BLOCK - 1) / BLOCK,
                          place_block, job, err));
    for (unsigned rank = 0; b && rank < b->ranks->count; rank++) {
        const stp_rank_part run = {b->begins[rank], b->begins[rank + 1]}, part = drawn_of(job, run);
        const size_t bytes = (part.end - part.begin) * sizeof(vec3s);
        STP_TRY(stp_ranks_broadcast(b->ranks, rank, job->positions + part.begin, bytes, err));
        STP_TRY(stp_ranks_broadcast(b->ranks, rank, job->normals + part.begin, bytes, err));
    }
done:
    return status;
}

typedef struct spacing_sum {
    const stp_cloud *cloud;
    double sum;
} spacing_sum;

static void sum_spacings(void *context)
{
    spacing_sum *s = context;
    const stp_rank_part own = stp_cloud_own(s->cloud);
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(s->cloud->spill, i))
        s->sum += (double)s->cloud->points[i].spacing;
}

stp_status stp_visibility_vote(_Atomic int *votes, const stp_cloud *cloud, stp_pool *pool,
                               stp_error *err)
{
    stp_status status = STP_OK;
    unsigned workers = stp_pool_thread_count(pool);
    spacing_sum all = {.cloud = cloud};
    vote_job job = {
        .votes = votes,
        .cloud = cloud,
        .centre = stp_dvec3_scale(stp_dvec3_add(cloud->box.min, cloud->box.max), 0.5),
        .stride = stp_visibility_stride(cloud),
        .radius =
            0.5 * (1.0 + 1e-5) * stp_dvec3_length(stp_dvec3_sub(cloud->box.max, cloud->box.min)),
    };
    STP_TRY(stp_cloud_in_turn(cloud, sum_spacings, &all, &all.sum, sizeof all.sum, err));
    const double spacing = all.sum / (double)cloud->count;
    if (!(job.radius > 0.0) || !(spacing > 0.0))
        return STP_OK; /* no extent: nothing is seen */
    double wanted = 2.0 * job.radius / (PIXEL_SPACINGS * spacing * sqrt((double)job.stride));
    job.size = wanted < PIXELS_LIMIT ? (int)wanted + 1 : PIXELS_LIMIT;
    job.drawn_count = (uint32_t)((cloud->count - 1) / job.stride + 1);
    STP_TRY(stp_spill_alloc(cloud->spill, &job.positions, job.drawn_count, sizeof *job.positions,
                            "views", err));
    STP_TRY(stp_spill_alloc(cloud->spill, &job.normals, job.drawn_count, sizeof *job.normals,
                            "views", err));
    STP_TRY(stp_alloc(&job.pixels, workers, sizeof *job.pixels, "views", err));
    STP_TRY(place(&job, pool, err));
    STP_TRY(stp_cloud_run(cloud, pool, AXES, vote_task, &job, err));
done:
    for (unsigned i = 0; job.pixels && i < workers; i++)
        stp_spill_free(cloud->spill, job.pixels[i]);
    free(job.pixels);
    stp_spill_free(cloud->spill, job.positions);
    stp_spill_free(cloud->spill, job.normals);
    return status;
}
