/* The file that `stipple gen` writes a scan to. */
#include "tools/gen/gen_scan.h"

#include "base/file.h"

#include <math.h>

/* Steps per sample spacing, like scanners: well below the resolution, but not so fine that files
 * grow. */
static const double steps_per_spacing = 100.0;
/* Gaussian noise stays within this many standard deviations. */
static const double noise_reach = 10.0;

bool gen_scan_is_las(const char *path)
{
    return stp_path_ends_in(path, ".las") || stp_path_ends_in(path, ".laz");
}

static stp_status create_las(gen_scan *out, const char *path, bool force, uint32_t attributes,
                             const gen_sampler *sampler, const gen_sampler_params *sampling,
                             stp_error *err)
{
    const gen_surface *surface = sampling->surface;
    const double spacing = gen_sampler_spacing(sampler);
    stp_las_writer_params params = {
        .force = force, .packed = stp_path_ends_in(path, ".laz"), .attributes = attributes};
    params.offset = (stp_dvec3){nearbyint(surface->centre.x), nearbyint(surface->centre.y),
                                nearbyint(surface->centre.z)};
    const double reach = stp_dvec3_length(stp_dvec3_sub(surface->centre, params.offset)) +
                         surface->radius + noise_reach * sampling->noise_spacings * spacing;
    /* The finest step for this reach is the wanted power of ten. */
    params.step = stp_las_finest_step(fmax(reach, spacing / steps_per_spacing * INT32_MAX / 10.0));
    return stp_las_writer_create(&out->las, path, &params, err);
}

stp_status gen_scan_create(gen_scan *out, const char *path, bool force, uint32_t attributes,
                           const gen_sampler *sampler, const gen_sampler_params *params,
                           stp_error *err)
{
    *out = (gen_scan){0};
    if (gen_scan_is_las(path))
        return create_las(out, path, force, attributes, sampler, params, err);
    stp_ply_writer_params ply = {.force = force,
                                 .vertex_count = params->point_count,
                                 .attributes = attributes,
                                 .station_count = (uint32_t)params->station_count};
    if (params->station_count > 0)
        ply.stations = gen_sampler_stations(sampler);
    return stp_ply_writer_create(&out->ply, path, &ply, err);
}

stp_status gen_scan_points(gen_scan *scan, const stp_point *points, size_t count, stp_error *err)
{
    return scan->las ? stp_las_writer_points(scan->las, points, count, err)
                     : stp_ply_writer_points(scan->ply, points, count, err);
}

stp_status gen_scan_finish(gen_scan *scan, stp_error *err)
{
    return scan->las ? stp_las_writer_finish(&scan->las, err)
                     : stp_ply_writer_finish(&scan->ply, err);
}

void gen_scan_destroy(gen_scan *scan)
{
    stp_las_writer_destroy(&scan->las);
    stp_ply_writer_destroy(&scan->ply);
}
