/* Chooses points by condition and box. */
#include "tools/file/export_filter.h"

#include "tools/cli/cli_value.h"

stp_status export_filter_make(export_filter *out, const export_choice *choice,
                              const stp_chunk_file *file, const export_numbers *numbers,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    static const stp_attribute_list none = {.count = 0};
    stp_where where;
    *out = (export_filter){.conditional = choice->where != NULL,
                           .clipped = choice->clip != NULL,
                           .intensity_step = stp_sample_intensity_step(info)};
    if ((choice->where || choice->clip || choice->level > 0) &&
        info->attributes & (STP_HAS_LINES | STP_HAS_TRIANGLES))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s has lines or triangles: --where, --clip and --level choose among "
                             "points alone",
                             stp_chunk_file_path(file));
    if (choice->clip)
        STP_TRY(cli_value_box("--clip", choice->clip, &info->box, &out->clip, err));
    if (choice->where) {
        STP_TRY(stp_where_parse(&where, choice->where, err));
        STP_TRY(stp_condition_make(&out->condition, &where, stp_sample_fields(info),
                                   numbers->list ? numbers->list : &none, err));
    }
done:
    return status;
}

bool export_filter_takes(const export_filter *filter, const stp_sample *sample, stp_dvec3 position,
                         const uint8_t *packed)
{
    double fields[STP_FIELD_COUNT];
    if (filter->clipped && stp_dbox_distance_squared(&filter->clip, position) > 0.0)
        return false;
    if (!filter->conditional)
        return true;
    stp_sample_values(sample, position, filter->intensity_step, fields);
    return stp_condition_holds(&filter->condition, fields, packed);
}
