/* Reads point sets of surfels as Expe writes them. */
#include "formats/scan/expe/expe.h"

#include "base/memory.h"
#include "formats/attribute/attribute_list.h"
#include "formats/scan/mesh/point_mesh.h"
#include "formats/scan/name_list.h"
#include "formats/scan/number.h"
#include "formats/scan/source.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define HEADER_LINES_LIMIT 1000u
#define RECORD_BYTES_LIMIT 65536u
/* That are read at once. At least a record. */
#define BLOCK_BYTES ((size_t)1 << 20)
#define NAME_CHARS 64u
#define ABSENT UINT32_MAX
#define RADIUS_BYTES 4u

typedef enum property { POSITION, NORMAL, COLOUR, RADIUS, PROPERTY_COUNT } property;

static const struct {
    const char *name;
    uint32_t bytes;
} properties[PROPERTY_COUNT] = {
    [POSITION] = {"position", 12},
    [NORMAL] = {"normal", 12},
    [COLOUR] = {"color", 4},
    [RADIUS] = {"radius", RADIUS_BYTES},
};

typedef struct reader {
    stp_source source;
    uint32_t at[PROPERTY_COUNT]; /* in a record, or ABSENT */
    uint32_t record_bytes;
    uint64_t begin, count, next; /* byte of the first record; records; that is read next */
    bool salvage, keeps_numbers;
    uint64_t lost_count;
    uint8_t *packed; /* radii of the points read last */
    size_t packed_capacity;
    stp_attribute_list list;
    stp_name_list left_out;
    stp_scan_note note;
} reader;

static float get_float(const unsigned char *bytes)
{
    const uint32_t bits = (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
                          (uint32_t)bytes[3] << 24;
    float value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

static stp_dvec3 get_vector(const unsigned char *bytes)
{
    return (stp_dvec3){(double)get_float(bytes), (double)get_float(bytes + 4),
                       (double)get_float(bytes + 8)};
}

static stp_status fail(const reader *r, stp_status status, const char *what, stp_error *err)
{
    return stp_error_set(err, status, "%s line %" PRIu64 ": %s: export it again", r->source.path,
                         r->source.line, what);
}

/* Takes a line `property NAME BYTES`. */
static stp_status take_property(reader *r, const char *at, const char *end, stp_error *err)
{
    uint64_t bytes = 0;
    char text[NAME_CHARS];
    const char *name = stp_token(&at, end), *name_end = at;
    const char *size = stp_token(&at, end);
    if (!name || !size || !stp_number_parse_u64(size, at, &bytes) || bytes == 0 ||
        bytes > RECORD_BYTES_LIMIT - r->record_bytes)
        return fail(r, STP_FORMAT, "a property needs a name and its bytes, 65536 in all", err);
    snprintf(text, sizeof text, "%.*s", (int)(name_end - name < 60 ? name_end - name : 60), name);
    property p = 0;
    while (p < PROPERTY_COUNT && strcmp(text, properties[p].name) != 0)
        p++;
    if (p == PROPERTY_COUNT)
        stp_name_list_add(&r->left_out, text);
    else if (bytes != properties[p].bytes || r->at[p] != ABSENT)
        return fail(r, STP_FORMAT, "a known property has another size, or is there twice", err);
    else
        r->at[p] = r->record_bytes;
    r->record_bytes += (uint32_t)bytes;
    return STP_OK;
}

/* Takes a line of the header. *ends: it is the last one. */
static stp_status take_line(reader *r, const char *at, const char *end, bool *ends, stp_error *err)
{
    const char *word = stp_token(&at, end);
    const size_t length = word ? (size_t)(at - word) : 0;
    const char *count = NULL;
    *ends = length == 4 && memcmp(word, "data", 4) == 0;
    if (length == 0 || *ends)
        return STP_OK;
    if (length == 8 && memcmp(word, "property", 8) == 0)
        return take_property(r, at, end, err);
    if (length == 9 && memcmp(word, "nofpoints", 9) == 0 && (count = stp_token(&at, end)) &&
        stp_number_parse_u64(count, at, &r->count))
        return STP_OK;
    return fail(r, STP_FORMAT, "expected `property NAME BYTES`, `nofpoints N` or `data`", err);
}

static stp_status read_header(reader *r, stp_error *err)
{
    static const char magic[] = "[Expe/PointSet/Binary/";
    stp_status status = STP_OK;
    const char *begin = NULL, *end = NULL;
    bool ends = false;
    STP_TRY(stp_source_line(&r->source, &begin, &end, err));
    if (!begin || (size_t)(end - begin) < sizeof magic - 1 ||
        memcmp(begin, magic, sizeof magic - 1) != 0)
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s is an Expe point set, but not of the binary kind: save it as "
                             "binary, or as PLY",
                             r->source.path);
    for (unsigned i = 0; !ends; i++) {
        STP_TRY(stp_source_line(&r->source, &begin, &end, err));
        if (!begin || i == HEADER_LINES_LIMIT)
            return fail(r, STP_CORRUPT, "the header has no end", err);
        STP_TRY(take_line(r, begin, end, &ends, err));
    }
    if (r->at[POSITION] == ABSENT)
        return fail(r, STP_FORMAT, "surfels have no position", err);
    r->begin = r->source.offset;
    const uint64_t left = r->source.size - r->begin, fit = left / r->record_bytes;
    if (r->count > fit && !(r->salvage && stp_salvage_count(&r->count, fit, &r->lost_count)))
        return stp_error_set(err, STP_CORRUPT,
                             "%s: %" PRIu64 " surfels of %u bytes do not fit behind byte %" PRIu64
                             " of %" PRIu64 ": the file is cut off; copy it again",
                             r->source.path, r->count, r->record_bytes, r->begin, r->source.size);
done:
    return status;
}

static void fill_info(reader *r, stp_scan_info *info)
{
    info->format = "Expe point set";
    info->point_count = r->count;
    info->lost_count = r->lost_count;
    info->attributes = (r->at[NORMAL] != ABSENT ? (uint32_t)STP_POINT_HAS_NORMAL : 0u) |
                       (r->at[COLOUR] != ABSENT ? (uint32_t)STP_POINT_HAS_COLOUR : 0u);
    info->seek_points = 1;
    if (r->at[RADIUS] != ABSENT)
        (void)stp_attribute_list_add(&r->list, properties[RADIUS].name, STP_ATTRIBUTE_F32);
    info->extra = r->list.count > 0 ? &r->list : NULL;
    r->note = (stp_scan_note){"left_out", r->left_out.text};
    info->notes = &r->note;
    info->note_count = r->left_out.text[0] ? 1 : 0;
}

static stp_status open_reader(void *state, stp_scan_info *info, const char *path,
                              const stp_scan_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    r->source.descriptor = -1;
    r->salvage = params->salvage;
    for (int p = 0; p < PROPERTY_COUNT; p++)
        r->at[p] = ABSENT;
    STP_TRY(stp_source_open(&r->source, path, err));
    STP_TRY(read_header(r, err));
    fill_info(r, info);
    r->keeps_numbers = params->numbers && r->list.count > 0;
done:
    return status;
}

static stp_point point_of(const reader *r, const unsigned char *record)
{
    stp_point point = {.position = get_vector(record + r->at[POSITION])};
    if (r->at[NORMAL] != ABSENT)
        point.normal = stp_unit_normal(get_vector(record + r->at[NORMAL]));
    for (int c = 0; c < 3 && r->at[COLOUR] != ABSENT; c++)
        point.rgb[c] = (uint16_t)(257u * record[r->at[COLOUR] + (uint32_t)c]);
    return point;
}

static stp_status read_points(void *state, stp_point *points, size_t capacity, size_t *count,
                              stp_error *err)
{
    stp_status status = STP_OK;
    reader *r = state;
    const uint64_t left = r->count - r->next;
    const unsigned char *records = NULL;
    size_t available = 0, part = BLOCK_BYTES / r->record_bytes;
    part = capacity < part ? capacity : part;
    part = left < part ? (size_t)left : part;
    const size_t size = part * r->record_bytes;
    if (r->keeps_numbers)
        STP_TRY(
            stp_grow(&r->packed, &r->packed_capacity, part * RADIUS_BYTES, 1, "attributes", err));
    STP_TRY(stp_source_peek(&r->source, size, &records, &available, err));
    if (available < size)
        return stp_error_set(err, STP_CORRUPT, "%s: cut off at byte %" PRIu64 ": copy it again",
                             r->source.path, r->source.offset + available);
    for (size_t i = 0; i < part; i++) {
        const unsigned char *record = records + i * r->record_bytes;
        points[i] = point_of(r, record);
        if (r->keeps_numbers)
            memcpy(r->packed + i * RADIUS_BYTES, record + r->at[RADIUS], RADIUS_BYTES);
    }
    stp_source_consume(&r->source, size);
    r->next += part;
    *count = part;
done:
    return status;
}

static stp_status seek_reader(void *state, uint64_t point, stp_error *err)
{
    reader *r = state;
    (void)err;
    r->source.narrow = true;
    stp_source_seek(&r->source, r->begin + point * r->record_bytes, 0);
    r->next = point;
    return STP_OK;
}

static const uint8_t *numbers_read(const void *state)
{
    return ((const reader *)state)->packed;
}

static void close_reader(void *state)
{
    reader *r = state;
    stp_source_close(&r->source);
    free(r->packed);
}

const stp_scan_reader stp_expe_reader = {sizeof(reader), open_reader, read_points,
                                         close_reader,   seek_reader, numbers_read};
