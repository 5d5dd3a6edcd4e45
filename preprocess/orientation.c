/* Which way normals point. */
#include "preprocess/orientation.h"

#include "preprocess/sheets.h"
#include "preprocess/turning.h"

static void mark_all(stp_cloud *cloud)
{
    for (uint32_t i = 0; i < cloud->count; i++)
        if (cloud->points[i].flags & STP_SAMPLE_HAS_NORMAL)
            cloud->points[i].flags |= STP_SAMPLE_ORIENTED;
}

/* Parts the points into sheets, makes signs agree and turns the pieces. */
static stp_status connect(stp_cloud *cloud, const stp_neighbours *neighbours,
                          const stp_orient_params *params, stp_pool *pool, uint32_t *oriented,
                          stp_error *err)
{
    stp_status status = STP_OK;
    stp_sheets sheets = {0};
    STP_TRY(stp_sheets_create(&sheets, cloud, neighbours, pool, err));
    if (params->mode != STP_ORIENT_NONE)
        STP_TRY(stp_sheets_cross(&sheets, err));
    if (params->mode == STP_ORIENT_POSITION)
        STP_TRY(stp_turn_to(cloud, &sheets.forest, params->position, err));
    else if (params->mode != STP_ORIENT_NONE)
        STP_TRY(stp_turn_outward(cloud, &sheets.forest, oriented, err));
    if (*oriented > 0) {
        STP_TRY(stp_turn_seen(cloud, sheets.parts, pool, err));
        STP_TRY(stp_crumbs_settle(&sheets.crumbs, cloud, neighbours, pool, err));
    }
done:
    stp_sheets_clear(&sheets);
    return status;
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
    stp_status status = connect(cloud, neighbours, params, pool, &oriented, err);
    if (status != STP_OK)
        return status;
    *found = STP_ORIENTATION_UNKNOWN;
    if (params->mode == STP_ORIENT_POSITION) {
        mark_all(cloud);
        *found = STP_ORIENTATION_POSITION;
    } else if (oriented > 0) {
        *found = oriented == cloud->count ? STP_ORIENTATION_PROPAGATED : STP_ORIENTATION_MIXED;
    }
    return STP_OK;
}
