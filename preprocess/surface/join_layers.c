/* Moves points onto the planes of their neighbourhoods. */
#include "preprocess/surface/join_layers.h"

#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/cloud/cloud_cells.h"
#include "preprocess/cloud/cloud_parts.h"

#include <stdlib.h>

#define TIMES 2

/* How far own points moved, added to those before them. */
typedef struct moving {
    stp_cloud *cloud;
    const vec3s *shifts;
    struct {
        double greatest, sum;
    } so_far;
} moving;

static void move_own(void *context)
{
    moving *m = context;
    stp_cloud *cloud = m->cloud;
    const stp_rank_part own = stp_cloud_own(cloud);
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i)) {
        stp_dvec3 shift = stp_dvec3_from_float(m->shifts[i]);
        double length = stp_dvec3_length(shift);
        cloud->points[i].position = stp_dvec3_add(cloud->points[i].position, shift);
        m->so_far.greatest = stp_max(m->so_far.greatest, length);
        m->so_far.sum += length;
    }
}

static stp_status move_points(stp_joined_layers *joined, stp_cloud *cloud, const vec3s *shifts,
                              stp_error *err)
{
    moving m = {.cloud = cloud, .shifts = shifts};
    const stp_status status =
        stp_cloud_in_turn(cloud, move_own, &m, &m.so_far, sizeof m.so_far, err);
    if (status != STP_OK)
        return status;
    joined->greatest += m.so_far.greatest;
    joined->mean += m.so_far.sum / (double)cloud->count;
    return STP_OK;
}

/* Sorts points that moved. */
static stp_status sort_again(stp_cloud *cloud, stp_pool *pool, stp_error *err)
{
    if (!cloud->blocks) {
        stp_cloud_unsort(cloud);
        return stp_cloud_sort(cloud, pool, err);
    }
    return stp_cloud_sort_again(cloud, 0, pool, err);
}

stp_status stp_layers_join(stp_joined_layers *out, stp_cloud *cloud,
                           const stp_surface_params *surface, stp_pool *pool,
                           const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    stp_graph *none = NULL;
    stp_surface_params params = *surface;
    stp_joined_layers joined = {0};
    params.pieces = false;
    for (int time = 0; time < TIMES && cloud->count > 0; time++) {
        STP_TRY(stp_cloud_array(cloud, &params.shifts, sizeof *params.shifts, "normals", err));
        STP_TRY(stp_surface_find(&none, cloud, &params, NULL, pool, progress, err));
        STP_TRY(move_points(&joined, cloud, params.shifts, err));
        stp_spill_free(cloud->spill, params.shifts);
        params.shifts = NULL;
        STP_TRY(sort_again(cloud, pool, err));
    }
    *out = joined;
done:
    stp_spill_free(cloud->spill, params.shifts);
    return status;
}
