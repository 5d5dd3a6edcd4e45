/* Types of attributes, and their numbers as words and as bytes. */
#include "formats/attribute/attribute.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const struct {
    const char *text;
    size_t bytes;
} types[STP_ATTRIBUTE_TYPE_COUNT] = {
#define X(name, text, bytes) {text, bytes},
    STP_ATTRIBUTE_TYPE_LIST(X)
#undef X
};

const char *stp_attribute_type_name(stp_attribute_type type)
{
    return types[type].text;
}

stp_attribute_type stp_attribute_type_from(const char *name)
{
    for (int i = 0; i < STP_ATTRIBUTE_TYPE_COUNT; i++)
        if (strcmp(types[i].text, name) == 0)
            return (stp_attribute_type)i;
    return STP_ATTRIBUTE_TYPE_COUNT;
}

size_t stp_attribute_bytes(stp_attribute_type type)
{
    return types[type].bytes;
}

size_t stp_attribute_list_bytes(const stp_attribute_list *list)
{
    size_t bytes = 0;
    for (uint32_t i = 0; i < list->count; i++)
        bytes += types[list->items[i].type].bytes;
    return bytes;
}

uint32_t stp_attribute_find(const stp_attribute_list *list, const char *name)
{
    for (uint32_t i = 0; i < list->count; i++)
        if (strcmp(list->items[i].name, name) == 0)
            return i;
    return UINT32_MAX;
}

uint32_t stp_attribute_match(const stp_attribute_list *list, const char *words)
{
    char name[STP_ATTRIBUTE_NAME_BYTES];
    uint32_t begins = 0, has = 0, first_begins = UINT32_MAX, first_has = UINT32_MAX;
    const uint32_t exact = stp_attribute_find(list, words);
    if (exact != UINT32_MAX || *words == '\0')
        return exact;
    snprintf(name, sizeof name, "%s", words);
    for (char *c = name; *c; c++)
        *c = *c == '-' ? '_' : *c;
    for (uint32_t i = 0; i < list->count; i++) {
        const char *at = strstr(list->items[i].name, name);
        if (at && has++ == 0)
            first_has = i;
        if (at == list->items[i].name && begins++ == 0)
            first_begins = i;
    }
    return begins == 1 ? first_begins : has == 1 ? first_has : UINT32_MAX;
}

static bool is_signed(stp_attribute_type type)
{
    return type == STP_ATTRIBUTE_I8 || type == STP_ATTRIBUTE_I16 || type == STP_ATTRIBUTE_I32 ||
           type == STP_ATTRIBUTE_I64;
}

void stp_attribute_put(stp_attribute_type type, uint64_t word, uint8_t *bytes)
{
    for (size_t i = 0; i < types[type].bytes; i++)
        bytes[i] = (uint8_t)(word >> (8 * i));
}

uint64_t stp_attribute_get(stp_attribute_type type, const uint8_t *bytes)
{
    const unsigned count = (unsigned)types[type].bytes;
    uint64_t word = is_signed(type) && bytes[count - 1] >> 7 ? UINT64_MAX : 0;
    for (unsigned i = count; i-- > 0;)
        word = word << 8 | bytes[i];
    return word;
}

static double double_of(uint64_t word)
{
    double value;
    memcpy(&value, &word, sizeof value);
    return value;
}

static uint64_t word_of(double value)
{
    uint64_t word;
    memcpy(&word, &value, sizeof word);
    return word;
}

static double number_of(stp_attribute_type type, uint64_t word)
{
    const uint32_t low = (uint32_t)word;
    float narrow;
    memcpy(&narrow, &low, sizeof narrow);
    return type == STP_ATTRIBUTE_F64   ? double_of(word)
           : type == STP_ATTRIBUTE_F32 ? (double)narrow
           : type == STP_ATTRIBUTE_U64 ? (double)word
                                       : (double)(int64_t)word;
}

static uint64_t float_word(stp_attribute_type type, double value)
{
    const float narrow = (float)value;
    uint32_t low;
    memcpy(&low, &narrow, sizeof low);
    return type == STP_ATTRIBUTE_F32 ? low : word_of(value);
}

uint64_t stp_attribute_missing(const stp_attribute *attribute)
{
    return stp_attribute_is_float(attribute->type) ? float_word(attribute->type, (double)NAN)
                                                   : (uint64_t)attribute->missing;
}

double stp_attribute_value(const stp_attribute *a, uint64_t word)
{
    if (a->has_missing && !stp_attribute_is_float(a->type) && word == (uint64_t)a->missing)
        return (double)NAN;
    return number_of(a->type, word) * a->scale + a->offset;
}

uint64_t stp_attribute_convert(stp_attribute_type from, uint64_t word, stp_attribute_type to)
{
    if (from == to || (!stp_attribute_is_float(from) && !stp_attribute_is_float(to)))
        return word;
    const double number = number_of(from, word);
    if (stp_attribute_is_float(to))
        return float_word(to, number);
    return fabs(number) < 0x1p63 ? (uint64_t)(int64_t)number : 0;
}

/* Whether `wide` holds all integers of `narrow`, and one more if `spare`. */
static bool holds(stp_attribute_type wide, stp_attribute_type narrow, bool spare)
{
    const size_t w = types[wide].bytes, n = types[narrow].bytes;
    if (stp_attribute_is_float(narrow))
        return stp_attribute_is_float(wide) && w >= n;
    if (stp_attribute_is_float(wide))
        return n < w;
    if (is_signed(wide) == is_signed(narrow))
        return spare ? w > n : w >= n;
    return is_signed(wide) && w > n;
}

stp_attribute_type stp_attribute_join(stp_attribute_type a, stp_attribute_type b, bool missing)
{
    for (int i = 0; i < STP_ATTRIBUTE_TYPE_COUNT; i++)
        if (holds((stp_attribute_type)i, a, missing) && holds((stp_attribute_type)i, b, missing))
            return (stp_attribute_type)i;
    return STP_ATTRIBUTE_F64;
}

int64_t stp_attribute_spare(stp_attribute_type type)
{
    const unsigned bits = 8 * (unsigned)types[type].bytes - (is_signed(type) ? 1u : 0u);
    return bits >= 63 ? INT64_MAX : (int64_t)((UINT64_C(1) << bits) - 1);
}
