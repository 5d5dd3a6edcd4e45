/* Reads the fields of an E57 scan's points. */
#include "formats/scan/e57/e57_prototype.h"

#include "base/checked.h"
#include "formats/attribute/attribute_list.h"
#include "formats/scan/number.h"

#include <math.h>
#include <string.h>

const char *stp_e57_attribute(const char *const *attributes, const char *name)
{
    for (; attributes[0]; attributes += 2)
        if (strcmp(attributes[0], name) == 0)
            return attributes[1];
    return NULL;
}

bool stp_e57_attribute_number(const char *const *attributes, const char *name, double otherwise,
                              double *out)
{
    const char *text = stp_e57_attribute(attributes, name);
    *out = otherwise;
    return !text || (stp_number_parse(text, text + strlen(text), out) && isfinite(*out));
}

/* Gets a signed whole number of up to 64 bits. */
static bool attribute_integer(const char *const *attributes, const char *name, int64_t otherwise,
                              int64_t *out)
{
    const char *text = stp_e57_attribute(attributes, name);
    uint64_t size;
    *out = otherwise;
    if (!text)
        return true;
    const bool negative = *text == '-';
    text += *text == '-' || *text == '+';
    if (!stp_number_parse_u64(text, text + strlen(text), &size) ||
        size > (uint64_t)INT64_MAX + (negative ? 1 : 0))
        return false;
    *out = negative ? (int64_t)(0 - size) : (int64_t)size;
    return true;
}

static uint32_t bits_of(uint64_t range)
{
    return range == 0 ? 0 : 64 - (uint32_t)__builtin_clzll(range);
}

static const char *read_integer(stp_e57_field *field, const char *const *attributes)
{
    int64_t maximum;
    if (!attribute_integer(attributes, "minimum", INT64_MIN, &field->minimum) ||
        !attribute_integer(attributes, "maximum", INT64_MAX, &maximum))
        return "has a minimum or maximum that is no whole number of 64 bits";
    if (maximum < field->minimum)
        return "has a maximum below its minimum";
    if (field->is_scaled && (!stp_e57_attribute_number(attributes, "scale", 1.0, &field->scale) ||
                             !stp_e57_attribute_number(attributes, "offset", 0.0, &field->offset) ||
                             field->scale == 0.0))
        return "has a scale or offset that is no number, or a scale of 0";
    field->bits = bits_of((uint64_t)maximum - (uint64_t)field->minimum);
    const double a = (double)field->minimum * field->scale + field->offset;
    const double b = (double)maximum * field->scale + field->offset;
    field->low = fmin(a, b);
    field->high = fmax(a, b);
    field->is_bounded = field->bits < 32 && isfinite(field->low) && isfinite(field->high);
    return NULL;
}

static const char *read_float(stp_e57_field *field, const char *const *attributes)
{
    const char *precision = stp_e57_attribute(attributes, "precision");
    const bool is_single = precision && strcmp(precision, "single") == 0;
    if (precision && !is_single && strcmp(precision, "double") != 0)
        return "has a precision other than single and double";
    field->type = is_single ? STP_E57_FLOAT : STP_E57_DOUBLE;
    field->bits = is_single ? 32 : 64;
    /* Bounds that are the whole range of the type say nothing. As text they often exceed what a
     * double can hold. */
    field->is_bounded = stp_e57_attribute(attributes, "minimum") &&
                        stp_e57_attribute(attributes, "maximum") &&
                        stp_e57_attribute_number(attributes, "minimum", 0.0, &field->low) &&
                        stp_e57_attribute_number(attributes, "maximum", 0.0, &field->high) &&
                        fabs(field->low) < 1e30 && fabs(field->high) < 1e30;
    return NULL;
}

static const char *const target_names[STP_E57_TARGET_COUNT] = {
    [STP_E57_X] = "cartesianX",
    [STP_E57_Y] = "cartesianY",
    [STP_E57_Z] = "cartesianZ",
    [STP_E57_RANGE] = "sphericalRange",
    [STP_E57_AZIMUTH] = "sphericalAzimuth",
    [STP_E57_ELEVATION] = "sphericalElevation",
    [STP_E57_CARTESIAN_INVALID] = "cartesianInvalidState",
    [STP_E57_SPHERICAL_INVALID] = "sphericalInvalidState",
    [STP_E57_NX] = "normalX",
    [STP_E57_NY] = "normalY",
    [STP_E57_NZ] = "normalZ",
    [STP_E57_RED] = "colorRed",
    [STP_E57_GREEN] = "colorGreen",
    [STP_E57_BLUE] = "colorBlue",
    [STP_E57_COLOUR_INVALID] = "isColorInvalid",
    [STP_E57_INTENSITY] = "intensity",
    [STP_E57_INTENSITY_INVALID] = "isIntensityInvalid",
    [STP_E57_CLASS] = "classification",
    [STP_E57_ROW] = "rowIndex",
    [STP_E57_COLUMN] = "columnIndex",
    [STP_E57_TIME_INVALID] = "isTimeStampInvalid",
};

static stp_e57_target target_of(const stp_e57_document *document, const char *name)
{
    for (int t = 0; t < STP_E57_TARGET_COUNT; t++)
        if (strcmp(name, target_names[t]) == 0 &&
            (document->keeps_grid || (t != STP_E57_ROW && t != STP_E57_COLUMN)))
            return (stp_e57_target)t;
    return STP_E57_TARGET_COUNT;
}

void stp_e57_leave_out(stp_e57_document *document, stp_e57_scan *scan, stp_e57_target target)
{
    if (scan->fields[target].present)
        stp_name_list_add(&document->left_out, target_names[target]);
    scan->fields[target].present = false;
}

/* The index of a name among those of all extras; adds it if it is new. False: it is no name of an
 * attribute, or there are too many. */
static bool find_extra_name(stp_attribute_list *names, const char *name, uint32_t *out)
{
    *out = stp_attribute_find(names, name);
    if (*out != UINT32_MAX)
        return true;
    *out = names->count;
    return stp_attribute_list_add(names, name, STP_ATTRIBUTE_U8) != NULL;
}

static bool has_extra(const stp_e57_document *document, const stp_e57_scan *scan, uint32_t name)
{
    for (uint32_t e = 0; e < scan->extra_count; e++)
        if (document->extras[scan->extra_first + e].name == name)
            return true;
    return false;
}

/* Adds the field as an extra. False: it is none. */
static bool add_extra(stp_e57_document *document, stp_e57_scan *scan, const char *name,
                      const stp_e57_field *field, stp_e57_target target)
{
    stp_e57_extra extra = {.field = *field, .target = target, .invalid = STP_E57_TARGET_COUNT};
    if (target == STP_E57_INTENSITY)
        extra.invalid = STP_E57_INTENSITY_INVALID;
    else if (strcmp(name, "timeStamp") == 0)
        extra.invalid = STP_E57_TIME_INVALID;
    if (!find_extra_name(&document->names, name, &extra.name) ||
        has_extra(document, scan, extra.name))
        return false;
    document->extras[document->extra_count++] = extra;
    scan->extra_count++;
    return true;
}

/* Whether a field of this target may also be an attribute. */
static bool may_be_extra(stp_e57_target target)
{
    return target == STP_E57_TARGET_COUNT || target == STP_E57_INTENSITY ||
           target == STP_E57_CLASS || target == STP_E57_ROW || target == STP_E57_COLUMN;
}

const char *stp_e57_prototype_add(stp_e57_document *document, stp_e57_scan *scan, const char *name,
                                  const char *type, const char *const *attributes, bool top)
{
    stp_e57_field field = {.present = true, .stream = scan->stream_count++, .scale = 1.0};
    const char *colon = strchr(name, ':'), *wrong = NULL;
    const char *local = colon ? colon + 1 : name;
    const stp_e57_target target = top ? target_of(document, local) : STP_E57_TARGET_COUNT;
    const bool is_text = strcmp(type, "String") == 0;
    if (strcmp(type, "Integer") == 0 || strcmp(type, "ScaledInteger") == 0) {
        field.is_scaled = *type == 'S';
        wrong = read_integer(&field, attributes);
    } else if (strcmp(type, "Float") == 0) {
        wrong = read_float(&field, attributes);
    } else if (!is_text || target != STP_E57_TARGET_COUNT) {
        return "has a type that no field of a point has";
    }
    if (wrong)
        return wrong;
    if (!stp_add_u64(scan->record_bits, field.bits, &scan->record_bits))
        return "is one too many";
    scan->has_grid |= strcmp(local, "rowIndex") == 0 || strcmp(local, "columnIndex") == 0;
    if (target != STP_E57_TARGET_COUNT && scan->fields[target].present)
        return "stands there twice";
    if (target != STP_E57_TARGET_COUNT)
        scan->fields[target] = field;
    const bool is_extra =
        top && !is_text && may_be_extra(target) && add_extra(document, scan, local, &field, target);
    if (target == STP_E57_TARGET_COUNT && !(is_extra && document->keeps_numbers))
        stp_name_list_add(&document->left_out, name);
    return NULL;
}
