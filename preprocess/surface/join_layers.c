/* Moves points onto the planes of their neighbourhoods. */
#include "preprocess/surface/join_layers.h"

#include "preprocess/cloud/cloud_cells.h"

#include <stdlib.h>

#define TIMES 2

static void move_points(stp_joined_layers *joined, stp_cloud *cloud, const vec3s *shifts)
{
    double greatest = 0.0, sum = 0.0;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i)) {
        stp_dvec3 shift = stp_dvec3_from_float(shifts[i]);
        double length = stp_dvec3_length(shift);
        cloud->points[i].position = stp_dvec3_add(cloud->points[i].position, shift);
        greatest = stp_max(greatest, length);
        sum += length;
    }
    joined->greatest += greatest;
    joined->mean += sum / cloud->count;
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
        STP_TRY(stp_spill_alloc(cloud->spill, &params.shifts, cloud->count, sizeof *params.shifts,
                                "normals", err));
        STP_TRY(stp_surface_find(&none, cloud, &params, NULL, pool, progress, err));
        move_points(&joined, cloud, params.shifts);
        stp_spill_free(cloud->spill, params.shifts);
        params.shifts = NULL;
        stp_cloud_unsort(cloud);
        STP_TRY(stp_cloud_sort(cloud, pool, err));
    }
    *out = joined;
done:
    stp_spill_free(cloud->spill, params.shifts);
    return status;
}
