/* Reads the header of a PCD file. */
#include "formats/scan/pcd/pcd_header.h"

#include "base/checked.h"
#include "base/memory.h"
#include "formats/scan/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#define LINES_MAX 1000u
#define FIELDS_MAX 1024u

/* State while the lines of the header are parsed. */
typedef struct parser {
    stp_pcd_header *header;
    const stp_source *source;
    const char *keyword, *at, *end; /* of the line; at: the first unread character */
    bool has_size, has_type, has_width, has_height, has_points, has_data;
    uint64_t width;
} parser;

static stp_status fault(const parser *p, stp_status status, stp_error *err, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

static stp_status fault(const parser *p, stp_status status, stp_error *err, const char *format, ...)
{
    char detail[400];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(detail, sizeof detail, format, arguments);
    va_end(arguments);
    return stp_error_set(err, status, "%s: line %llu of the PCD header %s", p->source->path,
                         (unsigned long long)p->source->line, detail);
}

/* The length of a token as quoted in a message. */
static int quoted(const char *begin, const char *end)
{
    return end - begin < 40 ? (int)(end - begin) : 40;
}

static stp_status parse_count(parser *p, uint64_t *out, stp_error *err)
{
    const char *token = stp_token(&p->at, p->end);
    if (!token)
        return fault(p, STP_CORRUPT, err, "has %s without a number: export the file again",
                     p->keyword);
    if (!stp_number_parse_u64(token, p->at, out))
        return fault(p, STP_CORRUPT, err,
                     "has %s `%.*s`, which is no whole number of 64 bits: export the file again",
                     p->keyword, quoted(token, p->at), token);
    return STP_OK;
}

static stp_status parse_version(parser *p, stp_error *err)
{
    static const char *const known[] = {".5", "0.5", ".6", "0.6", ".7", "0.7"};
    const char *token = stp_token(&p->at, p->end);
    const size_t length = token ? (size_t)(p->at - token) : 0;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (length == strlen(known[i]) && memcmp(token, known[i], length) == 0)
            return STP_OK;
    return fault(p, STP_VERSION, err,
                 "declares version `%.*s`; versions 0.5 to 0.7 are read: export the file again",
                 token ? quoted(token, p->at) : 0, token ? token : "");
}

static bool has_control_character(const char *begin, const char *end)
{
    for (; begin < end; begin++)
        if ((unsigned char)*begin < 32 || *begin == 127)
            return true;
    return false;
}

static stp_status parse_fields(parser *p, stp_error *err)
{
    stp_status status = STP_OK;
    stp_pcd_header *h = p->header;
    const char *token;
    if (h->field_count > 0)
        return fault(p, STP_CORRUPT, err, "names the fields again: export the file again");
    while ((token = stp_token(&p->at, p->end)) != NULL) {
        const size_t length = (size_t)(p->at - token);
        if (length >= STP_PCD_NAME_CHARS || h->field_count == FIELDS_MAX)
            return fault(p, STP_LIMIT, err,
                         "has more than %u fields or a name of more than %d characters: is it the "
                         "right file?",
                         FIELDS_MAX, STP_PCD_NAME_CHARS - 1);
        if (has_control_character(token, p->at))
            return fault(
                p, STP_CORRUPT, err,
                "names field %zu in characters that are no text: the file is damaged; copy "
                "or export it again",
                h->field_count + 1);
        STP_TRY(stp_grow(&h->fields, &h->field_capacity, h->field_count + 1, sizeof *h->fields,
                         "fields", err));
        stp_pcd_field *field = &h->fields[h->field_count++];
        *field = (stp_pcd_field){.count = 1, .target = STP_PCD_TARGET_COUNT};
        memcpy(field->name, token, length);
    }
done:
    return status;
}

/* Parses a line that has one value for each field. */
static stp_status parse_list(parser *p, stp_status (*parse)(parser *, stp_pcd_field *, stp_error *),
                             stp_error *err)
{
    stp_status status = STP_OK;
    const stp_pcd_header *h = p->header;
    for (size_t i = 0; i < h->field_count; i++) {
        const char *ahead = p->at;
        if (!stp_token(&ahead, p->end))
            return fault(p, STP_CORRUPT, err,
                         "has %zu values of %s for %zu fields: export the file again", i,
                         p->keyword, h->field_count);
        STP_TRY(parse(p, &h->fields[i], err));
    }
    if (h->field_count == 0 || stp_token(&p->at, p->end))
        status = fault(p, STP_CORRUPT, err,
                       "has more values of %s than the %zu fields named before it: export the file "
                       "again",
                       p->keyword, h->field_count);
done:
    return status;
}

static stp_status parse_one_size(parser *p, stp_pcd_field *field, stp_error *err)
{
    uint64_t size = 0;
    const stp_status status = parse_count(p, &size, err);
    if (status != STP_OK)
        return status;
    if (size != 1 && size != 2 && size != 4 && size != 8)
        return fault(p, STP_UNSUPPORTED, err,
                     "gives field `%s` %llu bytes, where 1, 2, 4 and 8 are read: export the file "
                     "again",
                     field->name, (unsigned long long)size);
    field->size = (uint32_t)size;
    return STP_OK;
}

static stp_status parse_one_type(parser *p, stp_pcd_field *field, stp_error *err)
{
    const char *token = stp_token(&p->at, p->end);
    if (p->at - token != 1 || !strchr("IUF", *token))
        return fault(p, STP_UNSUPPORTED, err,
                     "gives field `%s` type `%.*s`, where I, U and F are read: export the file "
                     "again",
                     field->name, quoted(token, p->at), token);
    field->type = *token;
    return STP_OK;
}

static stp_status parse_one_count(parser *p, stp_pcd_field *field, stp_error *err)
{
    const stp_status status = parse_count(p, &field->count, err);
    if (status == STP_OK && field->count == 0)
        return fault(p, STP_CORRUPT, err, "gives field `%s` no values: export the file again",
                     field->name);
    return status;
}

static stp_status parse_sizes(parser *p, stp_error *err)
{
    p->has_size = true;
    return parse_list(p, parse_one_size, err);
}

static stp_status parse_types(parser *p, stp_error *err)
{
    p->has_type = true;
    return parse_list(p, parse_one_type, err);
}

static stp_status parse_counts(parser *p, stp_error *err)
{
    return parse_list(p, parse_one_count, err);
}

static stp_status parse_width(parser *p, stp_error *err)
{
    p->has_width = true;
    return parse_count(p, &p->width, err);
}

static stp_status parse_height(parser *p, stp_error *err)
{
    p->has_height = true;
    return parse_count(p, &p->header->height, err);
}

static stp_status parse_points(parser *p, stp_error *err)
{
    p->has_points = true;
    return parse_count(p, &p->header->points, err);
}

/* Parses position and rotation of the sensor; the rotation begins with its real part. */
static stp_status parse_viewpoint(parser *p, stp_error *err)
{
    static const double none[7] = {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0};
    double v[7];
    bool is_default = true;
    for (int i = 0; i < 7; i++) {
        const char *token = stp_token(&p->at, p->end);
        if (!token || !stp_number_parse(token, p->at, &v[i]))
            return fault(p, STP_CORRUPT, err,
                         "has no number as value %d of the 7 of VIEWPOINT: mend the line or export "
                         "the file again",
                         i + 1);
        is_default &= v[i] == none[i];
    }
    p->header->viewpoint = (stp_dvec3){v[0], v[1], v[2]};
    p->header->has_viewpoint = !is_default;
    return STP_OK;
}

static stp_status parse_data(parser *p, stp_error *err)
{
    static const char *const names[] = {
        [STP_PCD_ASCII] = "ascii",
        [STP_PCD_BINARY] = "binary",
        [STP_PCD_COMPRESSED] = "binary_compressed",
    };
    const char *token = stp_token(&p->at, p->end);
    const size_t length = token ? (size_t)(p->at - token) : 0;
    p->has_data = true;
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (length == strlen(names[i]) && strncasecmp(token, names[i], length) == 0) {
            p->header->encoding = (stp_pcd_encoding)i;
            return STP_OK;
        }
    }
    return fault(p, STP_UNSUPPORTED, err,
                 "has DATA `%.*s`, where ascii, binary and binary_compressed are read: export the "
                 "file again",
                 token ? quoted(token, p->at) : 0, token ? token : "");
}

static stp_status parse_line(parser *p, stp_error *err)
{
    static const struct {
        const char *keyword;
        stp_status (*parse)(parser *p, stp_error *err);
    } keywords[] = {
        {"VERSION", parse_version},     {"FIELDS", parse_fields}, {"COLUMNS", parse_fields},
        {"SIZE", parse_sizes},          {"TYPE", parse_types},    {"COUNT", parse_counts},
        {"WIDTH", parse_width},         {"HEIGHT", parse_height}, {"POINTS", parse_points},
        {"VIEWPOINT", parse_viewpoint}, {"DATA", parse_data},
    };
    const char *word = stp_token(&p->at, p->end);
    if (!word || *word == '#')
        return STP_OK;
    for (size_t i = 0; i < sizeof keywords / sizeof *keywords; i++) {
        p->keyword = keywords[i].keyword;
        if ((size_t)(p->at - word) == strlen(p->keyword) &&
            memcmp(word, p->keyword, strlen(p->keyword)) == 0)
            return keywords[i].parse(p, err);
    }
    return fault(p, STP_CORRUPT, err,
                 "begins with `%.*s`, which is no keyword of PCD: mend the line or export the file "
                 "again",
                 quoted(word, p->at), word);
}

static stp_status parse_lines(parser *p, stp_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    while (!p->has_data) {
        STP_TRY(stp_source_line(source, &p->at, &p->end, err));
        if (!p->at || source->line > LINES_MAX) {
            status = stp_error_set(err, STP_CORRUPT,
                                   "%s: the PCD header has no line DATA in its first %llu lines: "
                                   "the file was cut or is another; copy or export it again",
                                   source->path, (unsigned long long)source->line);
            goto done;
        }
        STP_TRY(parse_line(p, err));
    }
    p->header->data_offset = source->offset;
    p->header->lines = source->line;
done:
    return status;
}

/* Checks that the counts agree. HEIGHT and one of WIDTH and POINTS may be missing. */
static stp_status decide_counts(parser *p, stp_error *err)
{
    stp_pcd_header *h = p->header;
    uint64_t product;
    if (!p->has_width && !p->has_points)
        return fault(p, STP_CORRUPT, err, "ends it without WIDTH or POINTS: export the file again");
    if (!p->has_height)
        h->height = 1;
    if (!p->has_width)
        return STP_OK;
    if (!stp_mul_u64(p->width, h->height, &product) || (p->has_points && product != h->points))
        return fault(p, STP_CORRUPT, err,
                     "ends it with WIDTH %llu, HEIGHT %llu and POINTS %llu, which do not agree: "
                     "mend them or export the file again",
                     (unsigned long long)p->width, (unsigned long long)h->height,
                     (unsigned long long)h->points);
    h->points = product;
    return STP_OK;
}

static stp_status decide_layout(parser *p, stp_error *err)
{
    stp_pcd_header *h = p->header;
    uint64_t stride = 0, bytes;
    if (h->field_count == 0 || !p->has_size || !p->has_type)
        return fault(p, STP_CORRUPT, err,
                     "ends it without FIELDS, SIZE and TYPE: export the file again");
    for (size_t i = 0; i < h->field_count; i++) {
        stp_pcd_field *field = &h->fields[i];
        if (field->type == 'F' && field->size < 4)
            return fault(p, STP_UNSUPPORTED, err,
                         "ends it with field `%s` of type F and %u bytes, where 4 and 8 are read: "
                         "export the file again",
                         field->name, field->size);
        field->offset = (size_t)stride;
        if (!stp_mul_u64(field->count, field->size, &bytes) ||
            !stp_add_u64(stride, bytes, &stride) || stride > STP_PCD_STRIDE_MAX)
            return fault(p, STP_LIMIT, err,
                         "ends it with records of more than %zu bytes: is it the right file?",
                         STP_PCD_STRIDE_MAX);
        h->values += field->count;
    }
    h->stride = (size_t)stride;
    return STP_OK;
}

/* rank: of two fields that mean the same, the one with the lower rank is read. */
static stp_pcd_target target_of(const stp_pcd_field *field, size_t *rank)
{
    *rank = stp_column_find_name(field->name, field->name + strlen(field->name));
    if (field->count != 1)
        return STP_PCD_TARGET_COUNT;
    if (field->size == 4 &&
        (strcasecmp(field->name, "rgb") == 0 || strcasecmp(field->name, "rgba") == 0))
        return STP_PCD_PACKED;
    const stp_column column = stp_column_by_name(*rank);
    return column == STP_COLUMN_NONE ? STP_PCD_TARGET_COUNT : (stp_pcd_target)column;
}

static void drop_targets(stp_pcd_header *h, stp_pcd_target first, stp_pcd_target last)
{
    for (size_t i = 0; i < h->field_count; i++)
        if (h->fields[i].target >= first && h->fields[i].target <= last)
            h->fields[i].target = STP_PCD_TARGET_COUNT;
}

static bool has_all(const stp_pcd_header *h, stp_pcd_target first, stp_pcd_target last)
{
    for (int t = (int)first; t <= (int)last; t++)
        if (!stp_pcd_header_find(h, (stp_pcd_target)t))
            return false;
    return true;
}

static stp_status decide_targets(parser *p, stp_error *err)
{
    static const char *const axes[] = {"x", "y", "z"};
    stp_pcd_header *h = p->header;
    size_t ranks[STP_PCD_TARGET_COUNT + 1];
    stp_pcd_field *read[STP_PCD_TARGET_COUNT + 1] = {NULL};
    for (size_t i = 0; i < h->field_count; i++) {
        size_t rank;
        const stp_pcd_target target = target_of(&h->fields[i], &rank);
        if (read[target] && rank >= ranks[target])
            continue;
        if (read[target])
            read[target]->target = STP_PCD_TARGET_COUNT;
        h->fields[i].target = target;
        read[target] = &h->fields[i];
        ranks[target] = rank;
    }
    for (int i = 0; i < 3; i++)
        if (!stp_pcd_header_find(h, (stp_pcd_target)i))
            return fault(p, STP_CORRUPT, err,
                         "ends it without a field `%s` of COUNT 1: export the file again with x, y "
                         "and z",
                         axes[i]);
    if (!has_all(h, STP_PCD_NX, STP_PCD_NZ))
        drop_targets(h, STP_PCD_NX, STP_PCD_NZ);
    if (!has_all(h, STP_PCD_RED, STP_PCD_BLUE) || stp_pcd_header_find(h, STP_PCD_PACKED))
        drop_targets(h, STP_PCD_RED, STP_PCD_BLUE);
    return STP_OK;
}

stp_status stp_pcd_header_read(stp_pcd_header *header, stp_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    parser p = {.header = header, .source = source};
    *header = (stp_pcd_header){0};
    STP_TRY(parse_lines(&p, source, err));
    STP_TRY(decide_layout(&p, err));
    STP_TRY(decide_counts(&p, err));
    STP_TRY(decide_targets(&p, err));
done:
    if (status != STP_OK)
        stp_pcd_header_free(header);
    return status;
}

void stp_pcd_header_free(stp_pcd_header *header)
{
    free(header->fields);
    *header = (stp_pcd_header){0};
}

const stp_pcd_field *stp_pcd_header_find(const stp_pcd_header *header, stp_pcd_target target)
{
    for (size_t i = 0; i < header->field_count; i++)
        if (header->fields[i].target == target)
            return &header->fields[i];
    return NULL;
}

bool stp_pcd_field_is_padding(const stp_pcd_field *field)
{
    return strcmp(field->name, "_") == 0;
}
