/* Decides which way normals point. */
#include "preprocess/orient/orientation.h"

#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/orient/crumbs.h"
#include "preprocess/orient/facing.h"
#include "preprocess/orient/turning.h"

/* The file tells the signs of its own normals alone. */
static void mark_given(stp_cloud *cloud)
{
    const stp_rank_part own = stp_cloud_own(cloud);
    for (uint64_t i = own.begin; i < own.end; i++, stp_cloud_step(cloud->spill, i))
        if (cloud->points[i].given)
            cloud->marks[i] |= STP_MARK_ORIENTED;
}

/* Splits the points into sheets, makes signs agree and turns the pieces. */
static stp_status connect(stp_cloud *cloud, unsigned k, stp_graph **graphs,
                          const stp_orient_params *params, stp_pool *pool, stp_turned *turned,
                          stp_error *err)
{
    stp_status status = STP_OK;
    stp_sheets sheets = {0};
    const stp_dvec3 *stations = stp_orient_stations(params);
    STP_TRY(stp_sheets_create(&sheets, cloud, k, graphs, pool, err));
    if (params->mode != STP_ORIENT_NONE) {
        STP_TRY(stp_sheets_cross(&sheets, err));
        STP_TRY(stp_turn_pieces(&sheets, stations, turned, err));
        STP_TRY(stp_cloud_refresh(cloud, STP_ARRAY_MARKS, err));
    }
    if (turned->oriented > 0 && stations)
        STP_TRY(stp_facing_correct(&sheets, stations, pool, err));
    if (turned->oriented > 0 && !stations) {
        STP_TRY(stp_turn_seen(&sheets, pool, err));
        STP_TRY(stp_cloud_refresh(cloud, STP_ARRAY_MARKS, err));
        STP_TRY(stp_crumbs_turn(&sheets, pool, err));
    }
    STP_TRY(stp_sheets_adopt(&sheets, pool, err));
    stp_cloud_let_go(cloud);
done:
    stp_sheets_clear(&sheets);
    return status;
}

bool stp_orient_by_file(const stp_orient_params *params)
{
    return params->from_file &&
           (params->mode == STP_ORIENT_FILE || params->mode == STP_ORIENT_AUTO);
}

const stp_dvec3 *stp_orient_stations(const stp_orient_params *params)
{
    if (params->mode == STP_ORIENT_POSITION)
        return &params->position;
    return params->mode == STP_ORIENT_AUTO ? params->stations : NULL;
}

stp_status stp_orientation_find(stp_cloud *cloud, unsigned k, stp_graph **graphs,
                                const stp_orient_params *params, stp_pool *pool,
                                stp_orientation *found, stp_error *err)
{
    stp_turned turned = {0};
    if (params->mode == STP_ORIENT_FILE && !params->from_file)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "the input has no normals to orient by: use --orient propagate");
    if (stp_orient_by_file(params)) {
        mark_given(cloud); /* signs are known, so normals alone separate opposed sheets */
        *found = STP_ORIENTATION_FILE;
        return STP_OK;
    }
    stp_status status = connect(cloud, k, graphs, params, pool, &turned, err);
    if (status != STP_OK)
        return status;
    *found = STP_ORIENTATION_UNKNOWN;
    if (turned.oriented > 0 && turned.oriented == turned.with_normal)
        *found =
            stp_orient_stations(params) ? STP_ORIENTATION_POSITION : STP_ORIENTATION_PROPAGATED;
    else if (turned.oriented > 0)
        *found = STP_ORIENTATION_MIXED;
    return STP_OK;
}
