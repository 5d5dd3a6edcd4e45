/* Lists columns by a header or by the names that the user gives. */
#include "formats/scan/text/columns.h"

#include "formats/scan/scan.h"

#include <stdio.h>
#include <string.h>
#include <strings.h>

void stp_column_copy_name(char *out, size_t capacity, stp_field field)
{
    size_t length = 0;
    for (const char *at = field.begin; at < field.end && length + 1 < capacity; at++)
        out[length++] = *at >= ' ' && *at <= '~' ? *at : '?';
    out[length] = '\0';
}

uint32_t stp_columns_find(const stp_columns *columns, stp_column column)
{
    for (uint32_t i = 0; i < columns->count; i++)
        if (columns->targets[i] == column)
            return i;
    return STP_COLUMNS_MAX;
}

static bool has(const stp_columns *columns, stp_column column)
{
    return stp_columns_find(columns, column) < STP_COLUMNS_MAX;
}

/* True if this column and the two that follow it in stp_column exist. */
static bool has_three(const stp_columns *columns, stp_column first)
{
    return has(columns, first) && has(columns, (stp_column)(first + 1u)) &&
           has(columns, (stp_column)(first + 2u));
}

uint32_t stp_columns_attributes(const stp_columns *columns)
{
    uint32_t out = 0;
    const bool colour = has_three(columns, STP_COLUMN_RED) || has(columns, STP_COLUMN_PACKED);
    out |= colour ? STP_POINT_HAS_COLOUR : 0u;
    out |= has_three(columns, STP_COLUMN_NX) ? STP_POINT_HAS_NORMAL : 0u;
    out |= has(columns, STP_COLUMN_INTENSITY) ? STP_POINT_HAS_INTENSITY : 0u;
    out |= has(columns, STP_COLUMN_CLASS) ? STP_POINT_HAS_CLASS : 0u;
    return out;
}

/* A unit in brackets among names between spaces: no column of its own. */
static bool is_unit(stp_separator separator, stp_field field)
{
    static const char *const units[] = {"m", "mm", "cm", "km", "ft", "feet", "deg", "s", "ns"};
    const size_t length = (size_t)(field.end - field.begin);
    bool known = false;
    for (size_t i = 0; i < sizeof units / sizeof *units; i++)
        known = known || (strlen(units[i]) + 2 == length &&
                          memcmp(units[i], field.begin + 1, length - 2) == 0);
    return known && separator == STP_SEPARATOR_SPACE && stp_is_opening(*field.begin);
}

bool stp_columns_next_name(stp_separator separator, const char **at, const char *end,
                           stp_field *field)
{
    do {
        if (!stp_field_next(separator, at, end, field))
            return false;
    } while (is_unit(separator, *field));
    return true;
}

/* Finds a colour in one piece among columns without a meaning, if there is no other. */
static void find_packed(stp_columns *columns, stp_separator separator, const char *begin,
                        const char *end)
{
    stp_field field;
    uint32_t i = 0;
    if (has(columns, STP_COLUMN_RED))
        return;
    for (const char *at = begin;
         i < columns->count && stp_columns_next_name(separator, &at, end, &field); i++) {
        if (columns->targets[i] != STP_COLUMN_NONE || !stp_column_is_packed(field.begin, field.end))
            continue;
        columns->targets[i] = STP_COLUMN_PACKED;
        return;
    }
}

/* Takes depths below the water in place of heights, if there are none. */
static void find_depths(stp_columns *columns)
{
    for (uint32_t i = 0; i < columns->count && !has(columns, STP_COLUMN_Z); i++)
        if (strncasecmp(columns->names[i], "depth", 5) == 0) {
            columns->targets[i] = STP_COLUMN_Z;
            columns->depths = true;
        }
}

static void drop_part(stp_columns *columns, stp_column first)
{
    for (uint32_t i = 0; i < columns->count && !has_three(columns, first); i++)
        if (columns->targets[i] >= first && columns->targets[i] < first + 3u)
            columns->targets[i] = STP_COLUMN_NONE;
}

/* COLMAP's TRACK[]: from here on lines differ in length. */
static bool is_list(stp_field field)
{
    return field.end - field.begin >= 7 && memcmp(field.begin, "TRACK[]", 7) == 0;
}

bool stp_columns_from_header(stp_columns *out, stp_separator separator, const char *begin,
                             const char *end)
{
    stp_columns columns = {.separator = separator};
    size_t names[STP_COLUMN_COUNT]; /* index of the name by which each was found */
    stp_field field;
    memset(columns.targets, STP_COLUMN_NONE, sizeof columns.targets);
    for (int i = 0; i < STP_COLUMN_COUNT; i++)
        names[i] = STP_COLUMN_NO_NAME;
    for (const char *at = begin; stp_columns_next_name(separator, &at, end, &field);) {
        if (columns.count == STP_COLUMNS_MAX || is_list(field)) {
            columns.open_end = true;
            break;
        }
        const size_t name = stp_column_find_name(field.begin, field.end);
        const uint32_t place = columns.count++;
        stp_column_copy_name(columns.names[place], sizeof columns.names[place], field);
        const stp_column column = stp_column_by_name(name);
        if (column == STP_COLUMN_NONE || name >= names[column])
            continue;
        const uint32_t before = stp_columns_find(&columns, column);
        if (before < STP_COLUMNS_MAX)
            columns.targets[before] = STP_COLUMN_NONE;
        columns.targets[place] = (uint8_t)column;
        names[column] = name;
    }
    if (has(&columns, STP_COLUMN_X) && has(&columns, STP_COLUMN_Y))
        find_depths(&columns);
    if (!has_three(&columns, STP_COLUMN_X))
        return false;
    columns.angles =
        stp_column_is_angle(names[STP_COLUMN_X]) && stp_column_is_angle(names[STP_COLUMN_Y]);
    drop_part(&columns, STP_COLUMN_RED);
    drop_part(&columns, STP_COLUMN_NX);
    find_packed(&columns, separator, begin, end);
    *out = columns;
    return true;
}

bool stp_comment_names_axes(const char *begin, const char *end)
{
    stp_columns columns;
    bool named = false;
    while (begin < end && (stp_is_blank(*begin) || strchr("#/%!", *begin)))
        begin++;
    for (int h = 0; h < STP_SEPARATOR_COUNT && !named; h++)
        named = stp_columns_from_header(&columns, (stp_separator)h, begin, end);
    return named;
}

static stp_status check_list(const stp_columns *columns, const char *list, stp_error *err)
{
    static const struct {
        stp_column first;
        const char *names;
    } threes[] = {{STP_COLUMN_X, "x, y and z"},
                  {STP_COLUMN_RED, "r, g and b"},
                  {STP_COLUMN_NX, "nx, ny and nz"}};
    for (size_t i = 0; i < sizeof threes / sizeof *threes; i++) {
        bool any = i == 0;
        for (unsigned k = 0; k < 3; k++)
            any = any || has(columns, (stp_column)(threes[i].first + k));
        if (any && !has_three(columns, threes[i].first))
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "--columns %.200s: give all of %s, as in x,y,z,r,g,b", list,
                                 threes[i].names);
    }
    return STP_OK;
}

/* True if an earlier column has this meaning or, without a meaning, this name. */
static bool is_named_before(const stp_columns *columns, uint32_t place, stp_column column)
{
    if (column != STP_COLUMN_NONE)
        return has(columns, column);
    for (uint32_t i = 0; i < place; i++)
        if (strcmp(columns->names[i], columns->names[place]) == 0)
            return true;
    return false;
}

static bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z');
}

/* Adds the next column of a list. */
static stp_status add_listed(stp_columns *columns, const char *list, stp_field field, bool others,
                             stp_error *err)
{
    const int length = field.end - field.begin < 40 ? (int)(field.end - field.begin) : 40;
    const uint32_t place = columns->count++;
    if (length == 1 && (*field.begin == '_' || *field.begin == '-'))
        return STP_OK;
    const size_t name = stp_column_find_name(field.begin, field.end);
    const bool packed = stp_column_is_packed(field.begin, field.end);
    const stp_column column = packed ? STP_COLUMN_PACKED : stp_column_by_name(name);
    if (column == STP_COLUMN_NONE && !(others && length > 0 && is_letter(*field.begin)))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--columns %.200s: `%.*s` is no known column: give x, y, z, r, g, b, "
                             "rgb, i, nx, ny, nz, class, or _ for one to pass over (%s)",
                             list, length, field.begin,
                             others ? "names of attributes begin with a letter"
                                    : "--attributes keeps columns of other names");
    if (column == STP_COLUMN_NONE)
        stp_column_copy_name(columns->names[place], sizeof columns->names[place], field);
    if (is_named_before(columns, place, column))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--columns %.200s: `%.*s` is named twice: give each column once, _ "
                             "for one to pass over",
                             list, length, field.begin);
    columns->targets[place] = (uint8_t)column;
    columns->angles = columns->angles || stp_column_is_angle(name);
    return STP_OK;
}

stp_status stp_columns_from_list(stp_columns *out, const char *list, bool others, stp_error *err)
{
    stp_status status = STP_OK;
    stp_columns columns = {.separator = out->separator, .open_end = true};
    stp_field field;
    const char *end = list + strlen(list);
    memset(columns.targets, STP_COLUMN_NONE, sizeof columns.targets);
    for (const char *at = list; stp_field_next(STP_SEPARATOR_COMMA, &at, end, &field);) {
        if (columns.count == STP_COLUMNS_MAX)
            return stp_error_set(err, STP_INVALID_ARGUMENT,
                                 "--columns: more than %u columns: name those up to the last that "
                                 "is wanted",
                                 STP_COLUMNS_MAX);
        STP_TRY(add_listed(&columns, list, field, others, err));
    }
    STP_TRY(check_list(&columns, list, err));
    *out = columns;
done:
    return status;
}
