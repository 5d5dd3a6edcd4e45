/* Chooses points by condition and box. */
#include "tools/file/export_filter.h"

#include "tools/cli/cli_value.h"

#include <stdio.h>
#include <string.h>

/* What points have besides attributes. Colours are 0 to 255, as the model holds them. */
#define OWN_FIELDS(X)                                                                              \
    X(x, true, point->position.x)                                                                  \
    X(y, true, point->position.y)                                                                  \
    X(z, true, point->position.z)                                                                  \
    X(intensity, (attributes & STP_HAS_INTENSITY), point->intensity)                               \
    X(class, (attributes & STP_HAS_CLASS), point->class_id)                                        \
    X(outlier, (attributes & STP_HAS_OUTLIERS), point->outlier)                                    \
    X(red, (attributes & STP_HAS_COLOUR), point->rgb[0] / 257.0)                                   \
    X(green, (attributes & STP_HAS_COLOUR), point->rgb[1] / 257.0)                                 \
    X(blue, (attributes & STP_HAS_COLOUR), point->rgb[2] / 257.0)

enum {
#define X(name, there, value) OWN_##name,
    OWN_FIELDS(X)
#undef X
        OWN_COUNT
};

static const char *const own_names[] = {
#define X(name, there, value) #name,
    OWN_FIELDS(X)
#undef X
};

static bool has_own(uint32_t attributes, int own)
{
    const bool has[] = {
#define X(name, there, value) (there) != 0,
        OWN_FIELDS(X)
#undef X
    };
    return has[own];
}

static double own_value(const stp_point *point, int own)
{
    const double values[] = {
#define X(name, there, value) (double)(value),
        OWN_FIELDS(X)
#undef X
    };
    return values[own];
}

static stp_status no_field(const char *name, uint32_t attributes, const stp_attribute_list *list,
                           stp_error *err)
{
    char known[1024] = "";
    size_t at = 0;
    for (int own = 0; own < OWN_COUNT; own++)
        if (has_own(attributes, own) && stp_attribute_find(list, own_names[own]) == UINT32_MAX)
            at += (size_t)snprintf(known + at, sizeof known - at, "%s%s", at ? ", " : "",
                                   own_names[own]);
    for (uint32_t i = 0; i < list->count && at + 2 < sizeof known; i++)
        at += (size_t)snprintf(known + at, sizeof known - at, ", %s", list->items[i].name);
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "--where: the points have no '%s': they have %s%s", name, known,
                         list->count > 0 ? "" : " (prep --attributes all keeps more)");
}

/* An attribute of the name goes before the field that every point has: it has all its bits. */
static stp_status find_field(export_field *out, const char *name, uint32_t attributes,
                             const stp_attribute_list *list, stp_error *err)
{
    *out = (export_field){.own = 0};
    uint32_t found = stp_attribute_find(list, name);
    while (out->own < OWN_COUNT && strcmp(own_names[out->own], name) != 0)
        out->own++;
    if (found == UINT32_MAX && out->own < OWN_COUNT && has_own(attributes, out->own))
        return STP_OK;
    if (found == UINT32_MAX)
        found = stp_attribute_match(list, name);
    if (found == UINT32_MAX)
        return no_field(name, attributes, list, err);
    out->attribute = &list->items[found];
    for (uint32_t i = 0; i < found; i++)
        out->at += stp_attribute_bytes(list->items[i].type);
    return STP_OK;
}

stp_status export_filter_make(export_filter *out, const export_choice *choice,
                              const stp_chunk_file *file, const export_numbers *numbers,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    static const stp_attribute_list none = {.count = 0};
    *out = (export_filter){.conditional = choice->where != NULL, .clipped = choice->clip != NULL};
    if ((choice->where || choice->clip || choice->level > 0) &&
        info->attributes & (STP_HAS_LINES | STP_HAS_TRIANGLES))
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s has lines or triangles: --where, --clip and --level choose among "
                             "points alone",
                             stp_chunk_file_path(file));
    if (choice->clip)
        STP_TRY(cli_value_box("--clip", choice->clip, &info->box, &out->clip, err));
    if (choice->where)
        STP_TRY(where_parse(&out->condition, choice->where, err));
    for (unsigned i = 0; i < out->condition.name_count; i++)
        STP_TRY(find_field(&out->fields[i], out->condition.names[i], info->attributes,
                           numbers->list ? numbers->list : &none, err));
done:
    return status;
}

static bool is_inside(const stp_dbox *box, stp_dvec3 p)
{
    return p.x >= box->min.x && p.x <= box->max.x && p.y >= box->min.y && p.y <= box->max.y &&
           p.z >= box->min.z && p.z <= box->max.z;
}

bool export_filter_takes(const export_filter *filter, const stp_point *point, const uint8_t *packed)
{
    double values[WHERE_NAMES];
    if (filter->clipped && !is_inside(&filter->clip, point->position))
        return false;
    if (!filter->conditional)
        return true;
    for (unsigned i = 0; i < filter->condition.name_count; i++) {
        const export_field *field = &filter->fields[i];
        const stp_attribute *a = field->attribute;
        values[i] = a ? stp_attribute_value(a, stp_attribute_get(a->type, packed + field->at))
                      : own_value(point, field->own);
    }
    return where_holds(&filter->condition, values);
}
