/* Keeps scanners' positions of the inputs. */
#include "tools/prep/prep_stations.h"

#include "base/memory.h"
#include "formats/scan/geo/projection.h"

/* Whether it may be that a sensor at the origin saw the points (preprocess/viewpoint/own_frame.h).
 */
static bool may_be_own_frame(const prep_inputs *in, const stp_scan_info *info)
{
    const uint32_t says = STP_POINT_HAS_NORMAL | STP_POINT_HAS_STATION;
    return in->count == 1 && info->station_count == 0 && (info->attributes & says) == 0 &&
           !info->heights && !info->y_up && !info->y_down && info->face_count == 0 &&
           info->edges.read == 0 && info->grid.columns == 0 && info->raster.columns == 0 &&
           info->image_count == 0;
}

stp_status prep_stations_add(prep_inputs *in, size_t i, const stp_scan_info *info, stp_error *err)
{
    stp_status status = STP_OK;
    stp_prep_file *file = &in->files[i];
    const bool guessed = may_be_own_frame(in, info);
    const uint32_t added = guessed ? 1 : info->station_count;
    const size_t count = in->station_count + added;
    if (count > STP_STATION_LIMIT)
        return stp_error_set(err, STP_LIMIT,
                             "%s: with it the inputs have more than %u scanner stations: give it "
                             "to another model",
                             in->paths[i], STP_STATION_LIMIT);
    STP_TRY(stp_grow(&in->stations, &in->station_capacity, count, sizeof *in->stations, "stations",
                     err));
    STP_TRY(stp_grow(&in->station_ups, &in->up_capacity, count, sizeof *in->station_ups, "stations",
                     err));
    for (uint32_t s = 0; s < added; s++) {
        const stp_dvec3 none = {0.0, 0.0, 0.0};
        in->stations[in->station_count + s] = guessed ? none : info->stations[s];
        in->station_ups[in->station_count + s] = info->station_ups ? info->station_ups[s] : none;
    }
    file->station_word = guessed ? STP_STATION_GUESSED : info->station_word;
    file->station_begin = (uint32_t)in->station_count;
    file->station_count = added;
    in->station_count = count;
done:
    return status;
}

void prep_stations_move(prep_inputs *in, size_t i)
{
    const stp_prep_file *file = &in->files[i];
    for (uint32_t s = 0; in->facts[i].way.projection && s < file->station_count; s++) {
        stp_dvec3 *at = &in->stations[file->station_begin + s];
        *at = stp_projection_apply(in->facts[i].way.projection, *at);
    }
}
