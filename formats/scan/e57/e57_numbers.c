/* The attributes of E57 points. */
#include "formats/scan/e57/e57_numbers.h"

#include "base/memory.h"

#include <stdlib.h>

/* The greatest whole number that the field's bits can say. Beyond 64 bits, the numbers wrap. */
static int64_t greatest_of(const stp_e57_field *field)
{
    const uint64_t range = field->bits == 0 ? 0 : UINT64_MAX >> (64 - field->bits);
    const uint64_t room = (uint64_t)INT64_MAX - (uint64_t)field->minimum;
    return range < room ? (int64_t)((uint64_t)field->minimum + range) : INT64_MAX;
}

/* The least type for the field's numbers and, if `missing`, one more. */
static stp_attribute_type type_of(const stp_e57_field *field, bool missing)
{
    static const struct {
        stp_attribute_type type;
        int64_t least, greatest;
    } types[] = {{STP_ATTRIBUTE_U8, 0, UINT8_MAX},   {STP_ATTRIBUTE_I8, INT8_MIN, INT8_MAX},
                 {STP_ATTRIBUTE_U16, 0, UINT16_MAX}, {STP_ATTRIBUTE_I16, INT16_MIN, INT16_MAX},
                 {STP_ATTRIBUTE_U32, 0, UINT32_MAX}, {STP_ATTRIBUTE_I32, INT32_MIN, INT32_MAX}};
    const int64_t greatest = greatest_of(field);
    if (field->type != STP_E57_INTEGER)
        return field->type == STP_E57_FLOAT ? STP_ATTRIBUTE_F32 : STP_ATTRIBUTE_F64;
    for (size_t i = 0; i < sizeof types / sizeof *types; i++)
        if (field->minimum >= types[i].least && greatest <= types[i].greatest - (missing ? 1 : 0))
            return types[i].type;
    return STP_ATTRIBUTE_I64;
}

/* Whether a sample's 8 bits are the field's numbers. */
static bool is_byte(const stp_e57_field *field)
{
    return field->type == STP_E57_INTEGER && !field->is_scaled && field->minimum >= 0 &&
           greatest_of(field) <= 255;
}

static bool is_held(const stp_e57_extra *extra, const stp_e57_ranges *ranges)
{
    const bool plain = ranges->intensity.low == 0.0 && ranges->intensity.high == 255.0;
    return is_byte(&extra->field) &&
           (extra->target == STP_E57_CLASS || (extra->target == STP_E57_INTENSITY && plain));
}

/* Makes the list of a scan's attributes, in the order of its extras that are present. */
static void list_own(stp_attribute_list *out, const stp_e57_document *document,
                     const stp_e57_scan *scan)
{
    out->count = 0;
    for (uint32_t e = 0; e < scan->extra_count; e++) {
        const stp_e57_extra *extra = &document->extras[scan->extra_first + e];
        const stp_e57_field *field = &extra->field;
        const bool missing = scan->fields[extra->invalid].present;
        const char *name = document->names.items[extra->name].name;
        stp_attribute *a =
            field->present ? stp_attribute_list_add(out, name, type_of(field, missing)) : NULL;
        if (!a)
            continue;
        a->has_missing = missing;
        if (field->type != STP_E57_INTEGER)
            continue;
        a->scale = field->scale;
        a->offset = field->offset;
        a->missing = missing ? stp_attribute_spare(a->type) : 0;
    }
}

void stp_e57_numbers_find(stp_e57_numbers *n, stp_e57_document *document,
                          const stp_e57_ranges *ranges)
{
    for (size_t i = 0; i < document->scan_count; i++) {
        const stp_e57_scan *scan = &document->scans[i];
        for (uint32_t e = 0; e < scan->extra_count; e++) {
            stp_e57_extra *extra = &document->extras[scan->extra_first + e];
            extra->field.present = extra->field.present && !is_held(extra, ranges);
        }
        list_own(&n->own, document, scan);
        if (scan->record_count > 0) /* all names together fit into a list */
            (void)stp_attribute_union_add(&n->all, &n->own);
    }
}

stp_status stp_e57_numbers_reserve(stp_e57_numbers *n, size_t points, stp_error *err)
{
    return stp_grow(&n->packed, &n->capacity, points * stp_attribute_list_bytes(&n->all.list), 1,
                    "attributes", err);
}

void stp_e57_numbers_begin(stp_e57_numbers *n, const stp_e57_document *document,
                           const stp_e57_scan *scan)
{
    list_own(&n->own, document, scan);
}

/* Packs an attribute that the scan has as number `own` of its list. */
static void pack_one(const stp_e57_vector *v, const stp_attribute *to, const stp_attribute *from,
                     uint32_t own, uint8_t *out, size_t stride, size_t count)
{
    const stp_e57_lane *lane = &v->lanes[own];
    const double *invalid =
        v->scan->fields[lane->extra->invalid].present ? v->columns[lane->extra->invalid] : NULL;
    for (size_t i = 0; i < count; i++) {
        const bool missing = invalid && invalid[i] != 0.0;
        stp_attribute_put(to->type,
                          missing ? stp_attribute_missing(to)
                                  : stp_attribute_union_word(to, from, lane->words[i]),
                          out + i * stride);
    }
}

void stp_e57_numbers_pack(stp_e57_numbers *n, const stp_e57_vector *v, size_t first, size_t count)
{
    const stp_attribute_list *list = &n->all.list;
    const size_t stride = stp_attribute_list_bytes(list);
    uint8_t *to = n->packed + first * stride;
    for (uint32_t a = 0; a < list->count; a++) {
        const stp_attribute *attribute = &list->items[a];
        const uint32_t own = stp_attribute_find(&n->own, attribute->name);
        if (own != UINT32_MAX)
            pack_one(v, attribute, &n->own.items[own], own, to, stride, count);
        for (size_t i = 0; own == UINT32_MAX && i < count; i++)
            stp_attribute_put(attribute->type, stp_attribute_missing(attribute), to + i * stride);
        to += stp_attribute_bytes(attribute->type);
    }
}

void stp_e57_numbers_clear(stp_e57_numbers *numbers)
{
    free(numbers->packed);
    *numbers = (stp_e57_numbers){0};
}
