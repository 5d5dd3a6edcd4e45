/* Rejects points by a condition. */
#include "tools/prep/prep_where.h"

cli_option prep_where_option(const char **condition)
{
    return (cli_option){.name = "--where",
                        .kind = CLI_STRING,
                        .target = (void *)condition,
                        .argument = "CONDITION",
                        .help = "store only points that fulfil it, like 'return==1 && class!=7'"};
}

stp_status prep_where_parse(prep_where *w, const char *text, stp_error *err)
{
    w->text = text;
    return text ? stp_where_parse(&w->where, text, err) : STP_OK;
}

static uint32_t fields_of(const stp_scan_info *info)
{
    const uint32_t colours = 1u << STP_FIELD_red | 1u << STP_FIELD_green | 1u << STP_FIELD_blue;
    return 1u << STP_FIELD_x | 1u << STP_FIELD_y | 1u << STP_FIELD_z |
           (info->attributes & STP_POINT_HAS_INTENSITY ? 1u << STP_FIELD_intensity : 0u) |
           (info->attributes & STP_POINT_HAS_CLASS ? 1u << STP_FIELD_class : 0u) |
           (info->attributes & STP_POINT_HAS_COLOUR ? colours : 0u);
}

stp_status prep_where_add(prep_where *w, const stp_scan_info *info, const char *path,
                          stp_error *err)
{
    if (!w->text)
        return STP_OK;
    w->fields |= fields_of(info);
    if (info->extra && !stp_attribute_union_add(&w->joined, info->extra))
        return stp_error_set(err, STP_LIMIT,
                             "%s: with it the inputs have more than %u attributes: give it to "
                             "another model",
                             path, STP_ATTRIBUTES_LIMIT);
    return STP_OK;
}

stp_status prep_where_check(prep_where *w, stp_error *err)
{
    return w->text ? stp_condition_make(&w->condition, &w->where, w->fields, &w->joined.list, err)
                   : STP_OK;
}

void prep_where_open(prep_where *w, const stp_scan_info *info)
{
    stp_condition_bind(&w->condition, info->extra);
}

/* The values of a point; if its scan has no class, it is 0 in the model, too, and so on. */
static void values_of(const stp_point *p, double out[STP_FIELD_COUNT])
{
    out[STP_FIELD_x] = p->position.x;
    out[STP_FIELD_y] = p->position.y;
    out[STP_FIELD_z] = p->position.z;
    out[STP_FIELD_intensity] = p->intensity;
    out[STP_FIELD_class] = p->class_id;
    out[STP_FIELD_outlier] = 0.0; /* not known yet; no input has it */
    out[STP_FIELD_red] = p->rgb[0] / 257.0;
    out[STP_FIELD_green] = p->rgb[1] / 257.0;
    out[STP_FIELD_blue] = p->rgb[2] / 257.0;
}

void prep_where_reject(const prep_where *w, const stp_scan_info *info, const uint8_t *packed,
                       stp_point *points, size_t count)
{
    const size_t stride = packed ? stp_attribute_list_bytes(info->extra) : 0;
    for (size_t i = 0; w->text && i < count; i++) {
        double fields[STP_FIELD_COUNT];
        stp_point *p = &points[i];
        if (p->reject != STP_REJECT_NONE || !stp_dvec3_finite(p->position))
            continue; /* rejected for another reason */
        values_of(p, fields);
        if (!stp_condition_holds(&w->condition, fields, packed ? packed + i * stride : NULL))
            p->reject = STP_REJECT_WHERE;
    }
}
