/* Lists of attributes, and what joins them. */
#include "formats/attribute/attribute_list.h"

#include <string.h>

static bool is_name(const char *name)
{
    const size_t length = strlen(name);
    for (size_t i = 0; i < length; i++)
        if (name[i] < 32 || name[i] > 126)
            return false;
    return length > 0 && length < STP_ATTRIBUTE_NAME_BYTES &&
           !(length == 1 && strchr("xyz", name[0]));
}

stp_attribute *stp_attribute_list_add(stp_attribute_list *list, const char *name,
                                      stp_attribute_type type)
{
    if (list->count == STP_ATTRIBUTES_LIMIT || !is_name(name) ||
        stp_attribute_find(list, name) != UINT32_MAX)
        return NULL;
    stp_attribute *a = &list->items[list->count++];
    *a = (stp_attribute){.type = type, .scale = 1.0};
    memcpy(a->name, name, strlen(name) + 1);
    return a;
}

static bool same_scale(const stp_attribute *a, const stp_attribute *b)
{
    return a->scale == b->scale && a->offset == b->offset;
}

static bool same_coarse(const stp_attribute *a, const stp_attribute *b)
{
    return a->coarse == b->coarse && a->coarse_scale == b->coarse_scale;
}

static bool same_numbers(const stp_attribute *a, const stp_attribute *b)
{
    return a->type == b->type && a->has_missing == b->has_missing && a->missing == b->missing &&
           same_scale(a, b) && same_coarse(a, b);
}

/* Makes attribute i hold what `other` has; NULL: some points lack it. Different scales become plain
 * numbers: then the type is a float. */
static void join(stp_attribute_union *all, uint32_t i, const stp_attribute *other)
{
    stp_attribute *a = &all->list.items[i];
    stp_attribute_type *plain = &all->plain[i];
    if (other && same_numbers(a, other))
        return;
    if (other && !same_coarse(a, other))
        a->coarse = STP_COARSE_NOT;
    if (other)
        *plain = stp_attribute_join(*plain, other->type, false);
    if (other && !same_scale(a, other)) {
        *plain = STP_ATTRIBUTE_F64;
        a->scale = 1.0;
        a->offset = 0.0;
    }
    a->has_missing |= other == NULL || other->has_missing;
    a->type = a->has_missing ? stp_attribute_join(*plain, *plain, true) : *plain;
    a->missing = stp_attribute_is_float(a->type) ? 0 : stp_attribute_spare(a->type);
    if (stp_attribute_is_float(a->type))
        a->coarse = STP_COARSE_NOT;
}

bool stp_attribute_union_add(stp_attribute_union *all, const stp_attribute_list *source)
{
    stp_attribute_list *list = &all->list;
    for (uint32_t i = 0; i < list->count; i++) {
        const uint32_t k = stp_attribute_find(source, list->items[i].name);
        join(all, i, k == UINT32_MAX ? NULL : &source->items[k]);
    }
    for (uint32_t k = 0; k < source->count; k++) {
        if (stp_attribute_find(list, source->items[k].name) != UINT32_MAX)
            continue;
        if (list->count == STP_ATTRIBUTES_LIMIT)
            return false;
        list->items[list->count] = source->items[k];
        all->plain[list->count] = source->items[k].type;
        list->count++;
        if (all->begun) /* the sources before lack it */
            join(all, list->count - 1, NULL);
    }
    all->begun = true;
    return true;
}

void stp_attribute_union_lack(stp_attribute_union *all)
{
    for (uint32_t i = 0; i < all->list.count; i++)
        join(all, i, NULL);
}

uint64_t stp_attribute_union_word(const stp_attribute *to, const stp_attribute *from, uint64_t word)
{
    if (from->has_missing && !stp_attribute_is_float(from->type) && word == (uint64_t)from->missing)
        return stp_attribute_missing(to);
    if (same_scale(from, to))
        return stp_attribute_convert(from->type, word, to->type);
    const double value = stp_attribute_value(from, word);
    uint64_t out = 0;
    memcpy(&out, &value, sizeof out);
    return stp_attribute_convert(STP_ATTRIBUTE_F64, out, to->type);
}
