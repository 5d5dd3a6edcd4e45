/* Finds columns by their names. */
#include "formats/scan/text/columns.h"

#include "formats/scan/scan.h"

#include <stdio.h>
#include <string.h>

#define STP_NAME_CHARS_MAX 32

/* In order of preference: an earlier name wins over a later one with the same meaning. */
static const struct {
    const char *name;
    stp_column column;
} known_names[] = {
    {"x", STP_COLUMN_X},
    {"xcoordinate", STP_COLUMN_X},
    {"xcoord", STP_COLUMN_X},
    {"coordinatex", STP_COLUMN_X},
    {"coordx", STP_COLUMN_X},
    {"positionx", STP_COLUMN_X},
    {"posx", STP_COLUMN_X},
    {"px", STP_COLUMN_X},
    {"easting", STP_COLUMN_X},
    {"east", STP_COLUMN_X},
    {"e", STP_COLUMN_X},
    {"rechtswert", STP_COLUMN_X},
    {"ostwert", STP_COLUMN_X},
    {"longitude", STP_COLUMN_X},
    {"long", STP_COLUMN_X},
    {"lon", STP_COLUMN_X},
    {"lng", STP_COLUMN_X},
    {"y", STP_COLUMN_Y},
    {"ycoordinate", STP_COLUMN_Y},
    {"ycoord", STP_COLUMN_Y},
    {"coordinatey", STP_COLUMN_Y},
    {"coordy", STP_COLUMN_Y},
    {"positiony", STP_COLUMN_Y},
    {"posy", STP_COLUMN_Y},
    {"py", STP_COLUMN_Y},
    {"northing", STP_COLUMN_Y},
    {"north", STP_COLUMN_Y},
    {"n", STP_COLUMN_Y},
    {"hochwert", STP_COLUMN_Y},
    {"nordwert", STP_COLUMN_Y},
    {"latitude", STP_COLUMN_Y},
    {"lat", STP_COLUMN_Y},
    {"z", STP_COLUMN_Z},
    {"zcoordinate", STP_COLUMN_Z},
    {"zcoord", STP_COLUMN_Z},
    {"coordinatez", STP_COLUMN_Z},
    {"coordz", STP_COLUMN_Z},
    {"positionz", STP_COLUMN_Z},
    {"posz", STP_COLUMN_Z},
    {"pz", STP_COLUMN_Z},
    {"elevation", STP_COLUMN_Z},
    {"elev", STP_COLUMN_Z},
    {"altitude", STP_COLUMN_Z},
    {"alt", STP_COLUMN_Z},
    {"height", STP_COLUMN_Z},
    {"h", STP_COLUMN_Z},
    {"hoehe", STP_COLUMN_Z},
    {"h\xc3\xb6he", STP_COLUMN_Z}, /* UTF-8, Latin 1 */
    {"h\xf6he", STP_COLUMN_Z},
    {"red", STP_COLUMN_RED},
    {"r", STP_COLUMN_RED},
    {"diffusered", STP_COLUMN_RED},
    {"colorred", STP_COLUMN_RED},
    {"colorr", STP_COLUMN_RED},
    {"green", STP_COLUMN_GREEN},
    {"g", STP_COLUMN_GREEN},
    {"diffusegreen", STP_COLUMN_GREEN},
    {"colorgreen", STP_COLUMN_GREEN},
    {"colorg", STP_COLUMN_GREEN},
    {"blue", STP_COLUMN_BLUE},
    {"b", STP_COLUMN_BLUE},
    {"diffuseblue", STP_COLUMN_BLUE},
    {"colorblue", STP_COLUMN_BLUE},
    {"colorb", STP_COLUMN_BLUE},
    {"nx", STP_COLUMN_NX},
    {"normalx", STP_COLUMN_NX},
    {"ny", STP_COLUMN_NY},
    {"normaly", STP_COLUMN_NY},
    {"nz", STP_COLUMN_NZ},
    {"normalz", STP_COLUMN_NZ},
    {"intensity", STP_COLUMN_INTENSITY},
    {"i", STP_COLUMN_INTENSITY},
    {"int", STP_COLUMN_INTENSITY},
    {"reflectance", STP_COLUMN_INTENSITY},
    {"reflectivity", STP_COLUMN_INTENSITY},
    {"refl", STP_COLUMN_INTENSITY},
    {"remission", STP_COLUMN_INTENSITY},
    {"amplitude", STP_COLUMN_INTENSITY},
    {"classification", STP_COLUMN_CLASS},
    {"class", STP_COLUMN_CLASS},
    {"classid", STP_COLUMN_CLASS},
    {"label", STP_COLUMN_CLASS},
};

#define STP_NAMES (sizeof known_names / sizeof *known_names)

/* Index among the known names; STP_NAMES if the name is unknown. */
static size_t find_name(stp_field field)
{
    char name[STP_NAME_CHARS_MAX];
    size_t length = 0;
    for (const char *at = field.begin; at < field.end && *at != '(' && *at != '['; at++) {
        if (*at == '_' || *at == '-' || *at == '.' || *at == ' ')
            continue;
        if (length == sizeof name)
            return STP_NAMES;
        name[length++] = *at >= 'A' && *at <= 'Z' ? (char)(*at - 'A' + 'a') : *at;
    }
    const size_t skip = length > 6 && memcmp(name, "scalar", 6) == 0 ? 6 : 0;
    for (size_t i = 0; i < STP_NAMES; i++)
        if (strlen(known_names[i].name) == length - skip &&
            memcmp(known_names[i].name, name + skip, length - skip) == 0)
            return i;
    return STP_NAMES;
}

/* Whether the name is that of a longitude or latitude. */
static bool is_angle(size_t name)
{
    return known_names[name].column <= STP_COLUMN_Y && known_names[name].name[0] == 'l';
}

const char *stp_column_name(stp_column column)
{
    static const char *const names[] = {"x",  "y",  "z",  "red",       "green", "blue",
                                        "nx", "ny", "nz", "intensity", "class", "not read"};
    return names[column];
}

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
    out |= has_three(columns, STP_COLUMN_RED) ? STP_POINT_HAS_COLOUR : 0u;
    out |= has_three(columns, STP_COLUMN_NX) ? STP_POINT_HAS_NORMAL : 0u;
    out |= has(columns, STP_COLUMN_INTENSITY) ? STP_POINT_HAS_INTENSITY : 0u;
    out |= has(columns, STP_COLUMN_CLASS) ? STP_POINT_HAS_CLASS : 0u;
    return out;
}

static void drop_part(stp_columns *columns, stp_column first)
{
    for (uint32_t i = 0; i < columns->count && !has_three(columns, first); i++)
        if (columns->targets[i] >= first && columns->targets[i] < first + 3u)
            columns->targets[i] = STP_COLUMN_NONE;
}

bool stp_columns_from_header(stp_columns *out, stp_separator separator, const char *begin,
                             const char *end)
{
    stp_columns columns = {.separator = separator};
    size_t names[STP_COLUMN_COUNT]; /* index of the name by which each was found */
    stp_field field;
    memset(columns.targets, STP_COLUMN_NONE, sizeof columns.targets);
    for (int i = 0; i < STP_COLUMN_COUNT; i++)
        names[i] = STP_NAMES;
    for (const char *at = begin; stp_field_next(separator, &at, end, &field);) {
        if (columns.count == STP_COLUMNS_MAX) {
            columns.open_end = true;
            break;
        }
        const size_t name = find_name(field);
        const uint32_t place = columns.count++;
        stp_column_copy_name(columns.names[place], sizeof columns.names[place], field);
        if (name == STP_NAMES || name >= names[known_names[name].column])
            continue;
        const stp_column column = known_names[name].column;
        const uint32_t before = stp_columns_find(&columns, column);
        if (before < STP_COLUMNS_MAX)
            columns.targets[before] = STP_COLUMN_NONE;
        columns.targets[place] = (uint8_t)column;
        names[column] = name;
    }
    if (!has_three(&columns, STP_COLUMN_X))
        return false;
    columns.angles = is_angle(names[STP_COLUMN_X]) && is_angle(names[STP_COLUMN_Y]);
    drop_part(&columns, STP_COLUMN_RED);
    drop_part(&columns, STP_COLUMN_NX);
    *out = columns;
    return true;
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
    const size_t name = find_name(field);
    if (name == STP_NAMES && !(others && length > 0 && is_letter(*field.begin)))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--columns %.200s: `%.*s` is no known column: give x, y, z, r, g, b, "
                             "i, nx, ny, nz, class, or _ for one to pass over (%s)",
                             list, length, field.begin,
                             others ? "names of attributes begin with a letter"
                                    : "--attributes keeps columns of other names");
    const stp_column column = name == STP_NAMES ? STP_COLUMN_NONE : known_names[name].column;
    if (column == STP_COLUMN_NONE)
        stp_column_copy_name(columns->names[place], sizeof columns->names[place], field);
    if (is_named_before(columns, place, column))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--columns %.200s: `%.*s` is named twice: give each column once, _ "
                             "for one to pass over",
                             list, length, field.begin);
    columns->targets[place] = (uint8_t)column;
    columns->angles = columns->angles || (name < STP_NAMES && is_angle(name));
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
