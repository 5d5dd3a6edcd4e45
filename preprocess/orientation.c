/* Which way normals point. */
#include "preprocess/orientation.h"

#include "preprocess/facing.h"
#include "preprocess/sheets.h"
#include "preprocess/turning.h"

static void mark_all(stp_cloud *cloud)
{
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->points[i].flags & STP_SAMPLE_HAS_NORMAL)
            cloud->points[i].flags |= STP_SAMPLE_ORIENTED;
}

static uint32_t count_normals(const stp_cloud *cloud)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        count += (cloud->points[i].flags & STP_SAMPLE_HAS_NORMAL) != 0;
    return count;
}

/* Parts the points into sheets, makes signs agree and turns the pieces. */
static stp_status connect(stp_cloud *cloud, const stp_neighbours *neighbours, stp_orient_mode mode,
                          const stp_dvec3 *stations, stp_pool *pool, uint32_t *oriented,
                          stp_error *err)
{
    stp_status status = STP_OK;
    stp_sheets sheets = {0};
    STP_TRY(stp_sheets_create(&sheets, cloud, neighbours, pool, err));
    if (mode == STP_ORIENT_NONE)
        goto done;
    STP_TRY(stp_sheets_cross(&sheets, err));
    STP_TRY(stp_turn_pieces(cloud, &sheets.forest, stations, oriented, err));
    if (stations)
        STP_TRY(stp_facing_settle(cloud, neighbours, stations, pool, err));
    if (*oriented > 0 && !stations) {
        STP_TRY(stp_turn_seen(cloud, sheets.parts, pool, err));
        STP_TRY(stp_crumbs_settle(&sheets.crumbs, cloud, neighbours, pool, err));
    }
done:
    stp_sheets_clear(&sheets);
    return status;
}

/* The stations to turn to, NULL if none: a given position is the station of all points. */
static const stp_dvec3 *choose_stations(stp_cloud *cloud, const stp_orient_params *params)
{
    if (params->mode == STP_ORIENT_AUTO)
        return params->stations;
    if (params->mode != STP_ORIENT_POSITION)
        return NULL;
    for (uint32_t i = 0; i < cloud->count; i++, stp_cloud_step(cloud->spill, i))
        cloud->points[i].station = 1;
    return &params->position;
}

stp_status stp_orientation_find(stp_cloud *cloud, const stp_neighbours *neighbours,
                                const stp_orient_params *params, stp_pool *pool,
                                stp_orientation *found, stp_error *err)
{
    uint32_t oriented = 0;
    if (params->mode == STP_ORIENT_FILE && !params->from_file)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the input has no normals to orient by: use --orient propagate");
    if (params->from_file && (params->mode == STP_ORIENT_FILE || params->mode == STP_ORIENT_AUTO)) {
        mark_all(cloud); /* signs are known: opposed sheets part by their normals */
        *found = STP_ORIENTATION_FILE;
        return STP_OK;
    }
    const stp_dvec3 *stations = choose_stations(cloud, params);
    stp_status status = connect(cloud, neighbours, params->mode, stations, pool, &oriented, err);
    if (status != STP_OK)
        return status;
    *found = STP_ORIENTATION_UNKNOWN;
    if (oriented > 0 && oriented == count_normals(cloud))
        *found = stations ? STP_ORIENTATION_POSITION : STP_ORIENTATION_PROPAGATED;
    else if (oriented > 0)
        *found = STP_ORIENTATION_MIXED;
    return STP_OK;
}
