/* Reads the ept.json of an Entwine Point Tile set. */
#include "formats/scan/octree/ept_header.h"

#include "base/json.h"

#include <ctype.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Whole numbers up to this are exact in JSON. */
#define WHOLE_MOST 9007199254740992.0
/* EPSG's codes of systems of longitude and latitude. Others are of systems in the plane. */
#define ANGLES_FIRST 4000L
#define ANGLES_LAST 4999L
#define MEND "is it an EPT? Copy the whole folder again"

/* Sets *out to a key's whole number from 0 on. */
static stp_status whole(const cJSON *json, const char *key, uint64_t *out, const char *path,
                        stp_error *err)
{
    const cJSON *item = cJSON_GetObjectItemCaseSensitive(json, key);
    const double value = cJSON_IsNumber(item) ? item->valuedouble : -1.0;
    if (!(value >= 0.0 && value <= WHOLE_MOST) || value != floor(value))
        return stp_error_set(err, STP_FORMAT, "%s: \"%s\" is no whole number: " MEND, path, key);
    *out = (uint64_t)value;
    return STP_OK;
}

static const char *text_of(const cJSON *json, const char *key)
{
    const char *text = cJSON_GetStringValue(cJSON_GetObjectItemCaseSensitive(json, key));
    return text ? text : "";
}

/* A text of a file that may be cut to a message: up to 40 printable characters. */
static const char *shown(const char *text, char out[44])
{
    size_t i = 0;
    for (; i < 40 && text[i]; i++)
        out[i] = text[i] >= ' ' && text[i] < 0x7f ? text[i] : '?';
    out[i] = '\0';
    return out;
}

static stp_status read_packing(stp_ept_header *h, const cJSON *json, const char *path,
                               stp_error *err)
{
    static const char *const words[] = {"laszip", "binary", "zstandard"};
    const char *version = text_of(json, "version"), *packing = text_of(json, "dataType");
    const char *hierarchy = text_of(json, "hierarchyType");
    char found[44];
    if (*version && strncmp(version, "1.", 2) != 0)
        return stp_error_set(err, STP_VERSION,
                             "%s: is of version %s of EPT, and 1.0 to 1.x are read: build it again "
                             "with Entwine 2 or 3",
                             path, shown(version, found));
    if (*hierarchy && strcmp(hierarchy, "json") != 0)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: its hierarchy is of type %s, and json is read: build it again "
                             "with Entwine 2 or 3",
                             path, shown(hierarchy, found));
    for (size_t i = 0; i < sizeof words / sizeof *words; i++) {
        if (strcmp(packing, words[i]) == 0) {
            h->packing = (stp_ept_packing)i;
            return STP_OK;
        }
    }
    return stp_error_set(err, *packing ? STP_UNSUPPORTED : STP_FORMAT,
                         "%s: its \"dataType\" is `%s`, and laszip, binary and zstandard are "
                         "read: " MEND,
                         path, shown(packing, found));
}

static stp_status read_octree(stp_ept_header *h, const cJSON *json, const char *path,
                              stp_error *err)
{
    stp_status status = STP_OK;
    double b[6] = {0.0};
    uint64_t span = 0;
    STP_TRY(stp_json_numbers(json, "bounds", b, 6, path, err));
    STP_TRY(whole(json, "span", &span, path, err));
    for (int axis = 0; axis < 3; axis++) {
        const double size = b[axis + 3] - b[axis];
        if (!(size > 0.0) || !isfinite(size) || span == 0)
            return stp_error_set(err, STP_FORMAT,
                                 "%s: \"bounds\" from %g to %g along %c and a \"span\" of %llu are "
                                 "no octree: " MEND,
                                 path, b[axis], b[axis + 3], "xyz"[axis], (unsigned long long)span);
        h->octree.min[axis] = b[axis];
        h->octree.size[axis] = size;
    }
    h->octree.spacing = h->octree.size[0] / (double)span;
done:
    return status;
}

/* ---- the schema ---- */

static stp_ept_role role_of(const char *name)
{
    static const char *const names[STP_EPT_ROLE_COUNT] = {
        "X",    "Y",       "Z",       "Intensity", "Classification", "Red",       "Green",
        "Blue", "NormalX", "NormalY", "NormalZ",   "Withheld",       "ClassFlags"};
    unsigned role = 0;
    while (role < STP_EPT_ROLE_COUNT && strcmp(name, names[role]) != 0)
        role++;
    return (stp_ept_role)role;
}

static stp_status read_type(stp_ept_field *field, const cJSON *entry, const char *path,
                            stp_error *err)
{
    stp_status status = STP_OK;
    const char *type = text_of(entry, "type");
    uint64_t size = 0;
    char found[44];
    field->scale = 1.0;
    STP_TRY(whole(entry, "size", &size, path, err));
    STP_TRY(stp_json_numbers(entry, "scale", &field->scale, 1, path, err));
    STP_TRY(stp_json_numbers(entry, "offset", &field->offset, 1, path, err));
    field->type = strcmp(type, "signed") == 0     ? STP_EPT_SIGNED
                  : strcmp(type, "unsigned") == 0 ? STP_EPT_UNSIGNED
                                                  : STP_EPT_FLOAT;
    const bool known =
        field->type != STP_EPT_FLOAT || strcmp(type, "float") == 0 || strcmp(type, "floating") == 0;
    const bool fits =
        size == 4 || size == 8 || (field->type != STP_EPT_FLOAT && (size == 1 || size == 2));
    if (!known || !fits || field->scale == 0.0)
        return stp_error_set(err, STP_FORMAT,
                             "%s: its schema has a field of type `%s`, %llu bytes and scale %g, "
                             "and signed and unsigned of 1, 2, 4 or 8 bytes and float of 4 or 8 "
                             "are read: " MEND,
                             path, shown(type, found), (unsigned long long)size, field->scale);
    field->bytes = (uint8_t)size;
done:
    return status;
}

/* A name like LAS's: "GpsTime" becomes "gps_time". */
static void lower_name(const char *name, char out[STP_ATTRIBUTE_NAME_BYTES])
{
    size_t length = 0;
    for (size_t i = 0; name[i] && length + 2 < STP_ATTRIBUTE_NAME_BYTES; i++) {
        const unsigned char c = (unsigned char)name[i];
        if (i > 0 && isupper(c) && islower((unsigned char)name[i - 1]))
            out[length++] = '_';
        out[length++] = (char)(c > 32 && c < 127 ? tolower(c) : '?');
    }
    out[length] = '\0';
}

/* Positions, normals, classes and what says that a point is none are no attributes. */
static bool is_attribute(const stp_ept_header *h, stp_ept_role role)
{
    const bool flags = role == STP_EPT_WITHHELD || role == STP_EPT_CLASS_FLAGS;
    return (flags && h->keeps_withheld) || role == STP_EPT_INTENSITY || role == STP_EPT_RED ||
           role == STP_EPT_GREEN || role == STP_EPT_BLUE || role == STP_EPT_ROLE_COUNT;
}

static void add_number(stp_ept_header *h, const stp_ept_field *field, const char *name)
{
    static const stp_attribute_type types[3][9] = {
        [STP_EPT_SIGNED] = {[1] = STP_ATTRIBUTE_I8,
                            [2] = STP_ATTRIBUTE_I16,
                            [4] = STP_ATTRIBUTE_I32,
                            [8] = STP_ATTRIBUTE_I64},
        [STP_EPT_UNSIGNED] = {[1] = STP_ATTRIBUTE_U8,
                              [2] = STP_ATTRIBUTE_U16,
                              [4] = STP_ATTRIBUTE_U32,
                              [8] = STP_ATTRIBUTE_U64},
        [STP_EPT_FLOAT] = {[4] = STP_ATTRIBUTE_F32, [8] = STP_ATTRIBUTE_F64}};
    char own[STP_ATTRIBUTE_NAME_BYTES];
    lower_name(strcmp(name, "Infrared") == 0 ? "nir" : name, own);
    stp_attribute *a =
        own[0] ? stp_las_numbers_add(&h->numbers, own, types[field->type][field->bytes],
                                     (stp_las_field){(uint16_t)field->at, 0, 0}, field->scale)
               : NULL;
    if (a)
        a->offset = field->offset;
}

static stp_status read_field(stp_ept_header *h, const cJSON *entry, const char *path,
                             stp_error *err)
{
    stp_status status = STP_OK;
    const char *name = text_of(entry, "name");
    const stp_ept_role role = role_of(name);
    stp_ept_field field = {.at = h->record_bytes};
    char found[44];
    STP_TRY(read_type(&field, entry, path, err));
    h->record_bytes += field.bytes;
    if (h->record_bytes > STP_EPT_RECORD_MOST ||
        (role < STP_EPT_ROLE_COUNT && stp_ept_has(h, role)))
        return stp_error_set(err, STP_FORMAT,
                             "%s: its schema has the field `%s` twice, or points of more than %u "
                             "bytes: " MEND,
                             path, shown(name, found), STP_EPT_RECORD_MOST);
    if (is_attribute(h, role) && h->packing != STP_EPT_LASZIP)
        add_number(h, &field, name);
    if (role < STP_EPT_ROLE_COUNT) {
        h->fields[role] = field;
        return STP_OK;
    }
    STP_TRY(stp_las_text_add(&h->left_out, err, "%s", h->left_out.length > 0 ? ", " : ""));
    STP_TRY(stp_las_text_add_bytes(&h->left_out, (const unsigned char *)name, strlen(name), err));
done:
    return status;
}

/* How far coordinates along an axis may be off where no scale says it. */
static double rounding_of(const stp_ept_header *h, unsigned axis)
{
    const double low = h->octree.min[axis], size = h->octree.size[axis];
    const stp_ept_field *f = &h->fields[axis];
    const bool narrow = f->type == STP_EPT_FLOAT && f->bytes == 4;
    return (narrow ? FLT_EPSILON : 4.0 * DBL_EPSILON) * (fabs(low) + size);
}

static stp_status read_schema(stp_ept_header *h, const cJSON *json, const char *path,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const cJSON *schema = cJSON_GetObjectItemCaseSensitive(json, "schema"), *entry = NULL;
    if (!cJSON_IsArray(schema))
        return stp_error_set(err, STP_FORMAT, "%s: has no \"schema\" of its points: " MEND, path);
    cJSON_ArrayForEach(entry, schema) STP_TRY(read_field(h, entry, path, err));
    for (unsigned role = STP_EPT_X; role <= STP_EPT_Z; role++) {
        const stp_ept_field *f = &h->fields[role];
        if (f->bytes == 0)
            return stp_error_set(err, STP_FORMAT, "%s: its schema has no %c: " MEND, path,
                                 "XYZ"[role]);
        const bool whole_steps = f->type != STP_EPT_FLOAT || f->scale != 1.0;
        const double step = whole_steps ? fabs(f->scale) : 0.0;
        h->step = role == STP_EPT_X ? step : fmin(h->step, step);
        h->octree.slack = fmax(h->octree.slack, fmax(step, rounding_of(h, role)));
    }
done:
    return status;
}

/* ---- the coordinate system ---- */

static stp_status read_system(stp_ept_header *h, const cJSON *json, stp_error *err)
{
    const cJSON *system = cJSON_GetObjectItemCaseSensitive(json, "srs");
    const char *wkt = text_of(system, "wkt"), *code = text_of(system, "horizontal");
    const long number =
        strcmp(text_of(system, "authority"), "EPSG") == 0 ? strtol(code, NULL, 10) : 0;
    if (*wkt)
        return stp_las_text_add_bytes(&h->wkt, (const unsigned char *)wkt, strlen(wkt), err);
    if (number <= 0 || number > 99999)
        return STP_OK;
    if (number >= ANGLES_FIRST && number <= ANGLES_LAST)
        return stp_las_text_add(&h->keys, err, "GTModelTypeGeoKey=2\nGeographicTypeGeoKey=%ld",
                                number);
    return stp_las_text_add(&h->keys, err, "GTModelTypeGeoKey=1\nProjectedCSTypeGeoKey=%ld",
                            number);
}

stp_status stp_ept_header_read(stp_ept_header *out, const cJSON *json, const char *path,
                               stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(read_packing(out, json, path, err));
    STP_TRY(read_octree(out, json, path, err));
    STP_TRY(whole(json, "points", &out->point_count, path, err));
    STP_TRY(read_schema(out, json, path, err));
    STP_TRY(read_system(out, json, err));
done:
    return status;
}

void stp_ept_header_free(stp_ept_header *header)
{
    stp_las_text_free(&header->wkt);
    stp_las_text_free(&header->keys);
    stp_las_text_free(&header->left_out);
    *header = (stp_ept_header){0};
}
