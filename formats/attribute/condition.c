/* Finds the names of conditions, and asks points. */
#include "formats/attribute/condition.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const char *const field_names[] = {
#define X(name) #name,
    STP_FIELD_LIST(X)
#undef X
};

static stp_status no_such_name(const char *name, uint32_t fields, const stp_attribute_list *list,
                               stp_error *err)
{
    char known[1024] = "";
    size_t at = 0;
    for (int f = 0; f < (int)STP_FIELD_COUNT; f++)
        if (fields >> f & 1 && stp_attribute_find(list, field_names[f]) == UINT32_MAX)
            at += (size_t)snprintf(known + at, sizeof known - at, "%s%s", at ? ", " : "",
                                   field_names[f]);
    for (uint32_t i = 0; i < list->count && at + 2 < sizeof known; i++)
        at += (size_t)snprintf(known + at, sizeof known - at, ", %s", list->items[i].name);
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "--where: the points have no '%s': they have %s%s", name, known,
                         list->count > 0 ? "" : " (prep --attributes all keeps more)");
}

static void take_attribute(stp_condition_source *out, const stp_attribute_list *list,
                           uint32_t index)
{
    *out = (stp_condition_source){.attribute = &list->items[index], .field = STP_FIELD_COUNT};
    for (uint32_t i = 0; i < index; i++)
        out->at += stp_attribute_bytes(list->items[i].type);
}

static stp_status find_source(stp_condition_source *out, char name[STP_ATTRIBUTE_NAME_BYTES],
                              uint32_t fields, const stp_attribute_list *list, stp_error *err)
{
    uint32_t found = stp_attribute_find(list, name);
    int f = 0;
    while (f < (int)STP_FIELD_COUNT && strcmp(field_names[f], name) != 0)
        f++;
    *out = (stp_condition_source){.field = (stp_point_field)f};
    if (found == UINT32_MAX && f < (int)STP_FIELD_COUNT && fields >> f & 1)
        return STP_OK;
    if (found == UINT32_MAX)
        found = stp_attribute_match(list, name);
    if (found == UINT32_MAX)
        return no_such_name(name, fields, list, err);
    take_attribute(out, list, found);
    memcpy(name, list->items[found].name, STP_ATTRIBUTE_NAME_BYTES);
    return STP_OK;
}

stp_status stp_condition_make(stp_condition *out, const stp_where *where, uint32_t fields,
                              const stp_attribute_list *list, stp_error *err)
{
    stp_status status = STP_OK;
    out->where = *where;
    for (unsigned i = 0; i < where->name_count && status == STP_OK; i++)
        status = find_source(&out->sources[i], out->where.names[i], fields, list, err);
    return status;
}

void stp_condition_bind(stp_condition *c, const stp_attribute_list *list)
{
    for (unsigned i = 0; i < c->where.name_count; i++) {
        if (!c->sources[i].attribute && c->sources[i].field != STP_FIELD_COUNT)
            continue;
        const uint32_t found = list ? stp_attribute_find(list, c->where.names[i]) : UINT32_MAX;
        if (found != UINT32_MAX)
            take_attribute(&c->sources[i], list, found);
        else
            c->sources[i] = (stp_condition_source){.field = STP_FIELD_COUNT};
    }
}

bool stp_condition_holds(const stp_condition *c, const double fields[STP_FIELD_COUNT],
                         const uint8_t *packed)
{
    double values[STP_WHERE_NAMES];
    for (unsigned i = 0; i < c->where.name_count; i++) {
        const stp_condition_source *source = &c->sources[i];
        const stp_attribute *a = source->attribute;
        values[i] = a ? stp_attribute_value(a, stp_attribute_get(a->type, packed + source->at))
                    : source->field == STP_FIELD_COUNT ? (double)NAN
                                                       : fields[source->field];
    }
    return stp_where_holds(&c->where, values);
}
