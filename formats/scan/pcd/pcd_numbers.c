/* The attributes of PCD points. */
#include "formats/scan/pcd/pcd_numbers.h"

#include "base/memory.h"
#include "formats/attribute/attribute_list.h"
#include "formats/scan/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Whole numbers up to it are exact as doubles. */
#define WHOLE_MAX 0x1p53

static stp_attribute_type type_of(const stp_pcd_field *field)
{
    static const char letters[] = {'U', 'I', 'F'};
    static const char names[] = {'u', 'i', 'f'};
    char name[8] = "";
    for (size_t i = 0; i < sizeof letters; i++)
        if (field->type == letters[i])
            snprintf(name, sizeof name, "%c%u", names[i], 8 * field->size);
    return stp_attribute_type_from(name);
}

static bool is_extra(const stp_pcd_field *field)
{
    const bool is_byte = field->type == 'U' && field->size == 1;
    const bool coarse = field->target == STP_PCD_INTENSITY || field->target == STP_PCD_CLASS;
    return field->target == STP_PCD_TARGET_COUNT ? !stp_pcd_field_is_padding(field)
                                                 : coarse && !is_byte;
}

/* Adds all values of a field or none. */
static bool add_values(stp_attribute_list *list, const stp_pcd_field *field)
{
    const uint32_t before = list->count;
    char name[STP_PCD_NAME_CHARS + 24];
    for (uint64_t k = 0; k < field->count; k++) {
        snprintf(name, sizeof name, "%s", field->name);
        if (field->count > 1)
            snprintf(name, sizeof name, "%s_%llu", field->name, (unsigned long long)k);
        if (!stp_attribute_list_add(list, name, type_of(field))) {
            list->count = before;
            return false;
        }
    }
    return true;
}

void stp_pcd_numbers_find(stp_pcd_numbers *n, stp_pcd_header *header)
{
    for (size_t i = 0; i < header->field_count; i++) {
        stp_pcd_field *field = &header->fields[i];
        if (!is_extra(field) || !add_values(&n->list, field))
            continue;
        const size_t bytes = field->size * (size_t)field->count;
        n->extras[n->count++] = (stp_pcd_extra){i, n->stride, bytes, type_of(field)};
        n->stride += bytes;
        field->extra = n->count;
    }
}

stp_status stp_pcd_numbers_reserve(stp_pcd_numbers *n, size_t points, stp_error *err)
{
    return stp_grow(&n->packed, &n->capacity, points * n->stride, 1, "attributes", err);
}

static bool parse_whole(stp_attribute_type type, const char *begin, const char *end, uint64_t *word)
{
    const unsigned bits = 8 * (unsigned)stp_attribute_bytes(type);
    const bool is_signed = stp_attribute_type_name(type)[0] == 'i';
    const bool negative = *begin == '-';
    const char *digits = begin + (*begin == '-' || *begin == '+');
    uint64_t magnitude = 0, most = UINT64_MAX >> (64 - bits);
    double value = 0.0;
    if (!stp_number_parse_u64(digits, end, &magnitude)) { /* as 1e+06 or 3.0 */
        if (!stp_number_parse(begin, end, &value) || value != floor(value) ||
            fabs(value) > WHOLE_MAX)
            return false;
        magnitude = (uint64_t)fabs(value);
    }
    if (is_signed)
        most = (most >> 1) + (negative ? 1 : 0);
    else if (negative)
        most = 0;
    *word = negative ? 0 - magnitude : magnitude;
    return magnitude <= most;
}

bool stp_pcd_number_parse(stp_attribute_type type, const char *begin, const char *end,
                          uint64_t *word)
{
    double value = 0.0;
    if (!stp_attribute_is_float(type))
        return parse_whole(type, begin, end, word);
    if (!stp_number_parse(begin, end, &value))
        return false;
    memcpy(word, &value, sizeof value);
    *word = stp_attribute_convert(STP_ATTRIBUTE_F64, *word, type);
    return true;
}

void stp_pcd_numbers_clear(stp_pcd_numbers *numbers)
{
    free(numbers->packed);
    *numbers = (stp_pcd_numbers){0};
}
