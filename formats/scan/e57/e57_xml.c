/* Reads the XML section of an E57 file. */
#include "formats/scan/e57/e57_xml.h"

#include "base/memory.h"
#include "formats/scan/e57/e57_prototype.h"
#include "formats/scan/number.h"
#include "formats/scan/scan.h"

#include <expat.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define XML_BYTES_MAX ((uint64_t)64 << 20)
#define TOKEN_BYTES_MAX ((uint64_t)1 << 20)
#define PARTS_MAX ((uint64_t)1 << 20) /* tags and attributes */
#define DEPTH_MAX 64u
#define WKT_BYTES_MAX ((size_t)1 << 20)
#define NUMBER_BYTES_MAX 128u
#define CHUNK_BYTES 32768u

/* The meaning of an element, by its place in the tree. */
typedef enum node {
    NODE_DOCUMENT,
    NODE_OTHER, /* skipped, with everything below */
    NODE_ROOT,
    NODE_WKT,
    NODE_DATA3D,
    NODE_SCAN,
    NODE_POSE,
    NODE_ROTATION,
    NODE_TRANSLATION,
    NODE_INTENSITY_LIMITS,
    NODE_COLOUR_LIMITS,
    NODE_NUMBER,
    NODE_POINTS,
    NODE_PROTOTYPE,
    NODE_FIELD,       /* in the prototype, has a value */
    NODE_FIELD_GROUP, /* in the prototype, has fields in it */
} node;

typedef struct reader {
    XML_Parser parser;
    stp_e57_document *document;
    const char *path;
    stp_error *err;
    stp_status status;
    node stack[DEPTH_MAX];
    uint32_t depth;
    stp_e57_scan *scan;   /* the scan that is being read; NULL outside */
    stp_e57_slot slot;    /* of a NODE_NUMBER */
    double scale, offset; /* of a NODE_NUMBER */
    char number[NUMBER_BYTES_MAX];
    size_t number_bytes;
    size_t wkt_bytes, wkt_capacity;
    uint64_t fed, fed_at_event, parts;
} reader;

static void fault(reader *r, stp_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Ends parsing with a message. The first message stays. */
static void fault(reader *r, stp_status status, const char *format, ...)
{
    char detail[400];
    va_list arguments;
    if (r->status != STP_OK)
        return;
    va_start(arguments, format);
    vsnprintf(detail, sizeof detail, format, arguments);
    va_end(arguments);
    r->status = stp_error_set(r->err, status, "%s: XML section, line %lu: %s", r->path,
                              (unsigned long)XML_GetCurrentLineNumber(r->parser), detail);
    XML_StopParser(r->parser, XML_FALSE);
}

/* The elements that have a meaning, by parent and name. */
static const struct meaning {
    node parent;
    const char *name;
    node node;
    stp_e57_slot slot; /* of a NODE_NUMBER */
} meanings[] = {
    {NODE_DOCUMENT, "e57Root", NODE_ROOT, 0},
    {NODE_ROOT, "coordinateMetadata", NODE_WKT, 0},
    {NODE_ROOT, "data3D", NODE_DATA3D, 0},
    {NODE_SCAN, "pose", NODE_POSE, 0},
    {NODE_POSE, "rotation", NODE_ROTATION, 0},
    {NODE_ROTATION, "w", NODE_NUMBER, STP_E57_ROTATION_W},
    {NODE_ROTATION, "x", NODE_NUMBER, STP_E57_ROTATION_X},
    {NODE_ROTATION, "y", NODE_NUMBER, STP_E57_ROTATION_Y},
    {NODE_ROTATION, "z", NODE_NUMBER, STP_E57_ROTATION_Z},
    {NODE_POSE, "translation", NODE_TRANSLATION, 0},
    {NODE_TRANSLATION, "x", NODE_NUMBER, STP_E57_TRANSLATION_X},
    {NODE_TRANSLATION, "y", NODE_NUMBER, STP_E57_TRANSLATION_Y},
    {NODE_TRANSLATION, "z", NODE_NUMBER, STP_E57_TRANSLATION_Z},
    {NODE_SCAN, "intensityLimits", NODE_INTENSITY_LIMITS, 0},
    {NODE_INTENSITY_LIMITS, "intensityMinimum", NODE_NUMBER, STP_E57_INTENSITY_MINIMUM},
    {NODE_INTENSITY_LIMITS, "intensityMaximum", NODE_NUMBER, STP_E57_INTENSITY_MAXIMUM},
    {NODE_SCAN, "colorLimits", NODE_COLOUR_LIMITS, 0},
    {NODE_COLOUR_LIMITS, "colorRedMinimum", NODE_NUMBER, STP_E57_RED_MINIMUM},
    {NODE_COLOUR_LIMITS, "colorRedMaximum", NODE_NUMBER, STP_E57_RED_MAXIMUM},
    {NODE_COLOUR_LIMITS, "colorGreenMinimum", NODE_NUMBER, STP_E57_GREEN_MINIMUM},
    {NODE_COLOUR_LIMITS, "colorGreenMaximum", NODE_NUMBER, STP_E57_GREEN_MAXIMUM},
    {NODE_COLOUR_LIMITS, "colorBlueMinimum", NODE_NUMBER, STP_E57_BLUE_MINIMUM},
    {NODE_COLOUR_LIMITS, "colorBlueMaximum", NODE_NUMBER, STP_E57_BLUE_MAXIMUM},
    {NODE_SCAN, "points", NODE_POINTS, 0},
    {NODE_POINTS, "prototype", NODE_PROTOTYPE, 0},
};

static bool holds_fields(const char *type)
{
    return strcmp(type, "Structure") == 0 || strcmp(type, "Vector") == 0;
}

static node node_of(reader *r, node parent, const char *name, const char *type)
{
    if (parent == NODE_DATA3D)
        return NODE_SCAN;
    if (parent == NODE_PROTOTYPE || parent == NODE_FIELD_GROUP)
        return holds_fields(type) ? NODE_FIELD_GROUP : NODE_FIELD;
    for (size_t i = 0; i < sizeof meanings / sizeof *meanings; i++) {
        if (meanings[i].parent == parent && strcmp(meanings[i].name, name) == 0) {
            r->slot = meanings[i].slot;
            return meanings[i].node;
        }
    }
    return NODE_OTHER;
}

static void begin_scan(reader *r)
{
    stp_e57_document *d = r->document;
    stp_error err;
    if (d->scan_count == STP_STATION_LIMIT) {
        fault(r, STP_LIMIT, "more than %u scans: split the file", STP_STATION_LIMIT);
        return;
    }
    if (stp_grow(&d->scans, &d->scan_capacity, d->scan_count + 1, sizeof *d->scans, "scans",
                 &err) != STP_OK) {
        fault(r, STP_OUT_OF_MEMORY, "%s", err.message);
        return;
    }
    r->scan = &d->scans[d->scan_count++];
    *r->scan = (stp_e57_scan){.extra_first = d->extra_count};
}

static bool attribute_u64(const char *const *attributes, const char *name, uint64_t *out)
{
    const char *text = stp_e57_attribute(attributes, name);
    return text && stp_number_parse_u64(text, text + strlen(text), out);
}

static void begin_points(reader *r, const char *const *attributes)
{
    if (r->scan->has_points)
        fault(r, STP_CORRUPT, "a scan has two elements `points`: export the file again");
    else if (!attribute_u64(attributes, "fileOffset", &r->scan->file_offset) ||
             !attribute_u64(attributes, "recordCount", &r->scan->record_count))
        fault(r, STP_CORRUPT,
              "`points` has no whole numbers fileOffset and recordCount: export the file again");
    r->scan->has_points = true;
}

/* Returns the fault of a field, as stp_e57_prototype_add. */
static const char *begin_field(reader *r, const char *name, const char *type,
                               const char *const *attributes, bool top)
{
    stp_e57_document *d = r->document;
    stp_error err;
    if (stp_grow(&d->extras, &d->extra_capacity, d->extra_count + 1, sizeof *d->extras, "fields",
                 &err) != STP_OK) {
        fault(r, STP_OUT_OF_MEMORY, "%s", err.message);
        return NULL;
    }
    return stp_e57_prototype_add(d, r->scan, name, type, attributes, top);
}

static void begin_number(reader *r, const char *type, const char *const *attributes)
{
    const bool is_scaled = strcmp(type, "ScaledInteger") == 0;
    r->number_bytes = 0;
    r->scale = 1.0;
    r->offset = 0.0;
    if (is_scaled && (!stp_e57_attribute_number(attributes, "scale", 1.0, &r->scale) ||
                      !stp_e57_attribute_number(attributes, "offset", 0.0, &r->offset)))
        fault(r, STP_CORRUPT, "a scale or offset is not a number: export the file again");
}

static void begin_element(void *data, const char *name, const char **attributes)
{
    reader *r = data;
    const char *const *list = (const char *const *)attributes;
    const char *type = stp_e57_attribute(list, "type");
    type = type ? type : "";
    r->fed_at_event = r->fed;
    r->parts++;
    for (const char *const *a = list; *a; a += 2)
        r->parts++;
    if (r->depth == DEPTH_MAX || r->parts > PARTS_MAX) {
        fault(r, STP_LIMIT,
              "more than %u levels or %llu tags and attributes: is it the right file?", DEPTH_MAX,
              (unsigned long long)PARTS_MAX);
        return;
    }
    const node parent = r->depth > 0 ? r->stack[r->depth - 1] : NODE_DOCUMENT;
    const node n = node_of(r, parent, name, type);
    r->stack[r->depth++] = n;
    const char *wrong = NULL;
    if (r->depth == 1 && n != NODE_ROOT)
        fault(r, STP_CORRUPT, "the root is `%.40s`, not e57Root: export the file again", name);
    else if (n == NODE_SCAN)
        begin_scan(r);
    else if (n == NODE_POSE)
        r->scan->has_pose = true;
    else if (n == NODE_POINTS)
        begin_points(r, list);
    else if (n == NODE_NUMBER)
        begin_number(r, type, list);
    else if (n == NODE_FIELD)
        wrong = begin_field(r, name, type, list, parent == NODE_PROTOTYPE);
    if (wrong)
        fault(r, STP_CORRUPT, "field `%.40s` %s: export the file again", name, wrong);
}

static void end_number(reader *r)
{
    double value = 0.0; /* the value of an element without text */
    const char *begin = r->number, *end = r->number + r->number_bytes;
    while (begin < end && strchr(" \t\r\n", *begin))
        begin++;
    while (begin < end && strchr(" \t\r\n", end[-1]))
        end--;
    if (begin < end && !stp_number_parse(begin, end, &value))
        fault(r, STP_CORRUPT, "`%.*s` is not a number: export the file again",
              (int)(end - begin < 40 ? end - begin : 40), begin);
    value = value * r->scale + r->offset;
    if (!isfinite(value))
        fault(r, STP_CORRUPT, "a number of a scan is not finite: export the file again");
    r->scan->numbers[r->slot] = value;
    r->scan->given |= 1u << r->slot;
}

static void end_element(void *data, const char *name)
{
    reader *r = data;
    (void)name;
    r->fed_at_event = r->fed;
    if (r->status != STP_OK)
        return;
    const node n = r->stack[--r->depth];
    if (n == NODE_NUMBER)
        end_number(r);
    else if (n == NODE_SCAN)
        r->scan = NULL;
}

static void add_wkt(reader *r, const char *text, size_t size)
{
    stp_error err;
    char **wkt = &r->document->wkt;
    if (size > WKT_BYTES_MAX - r->wkt_bytes)
        fault(r, STP_LIMIT, "coordinateMetadata is longer than %zu bytes: is it the right file?",
              WKT_BYTES_MAX);
    else if (stp_grow(wkt, &r->wkt_capacity, r->wkt_bytes + size + 1, 1, "coordinateMetadata",
                      &err) != STP_OK)
        fault(r, STP_OUT_OF_MEMORY, "%s", err.message);
    else {
        memcpy(*wkt + r->wkt_bytes, text, size);
        r->wkt_bytes += size;
        (*wkt)[r->wkt_bytes] = '\0';
    }
}

static void add_text(void *data, const char *text, int length)
{
    reader *r = data;
    const size_t size = (size_t)length;
    r->fed_at_event = r->fed;
    if (r->status != STP_OK || r->depth == 0)
        return;
    const node n = r->stack[r->depth - 1];
    if (n == NODE_WKT) {
        add_wkt(r, text, size);
    } else if (n == NODE_NUMBER) {
        if (size > sizeof r->number - r->number_bytes) {
            fault(r, STP_CORRUPT, "a number has more than %zu characters: export the file again",
                  sizeof r->number);
            return;
        }
        memcpy(r->number + r->number_bytes, text, size);
        r->number_bytes += size;
    }
}

static void refuse_doctype(void *data, const char *name, const char *system_id,
                           const char *public_id, int has_subset)
{
    (void)name, (void)system_id, (void)public_id, (void)has_subset;
    fault(data, STP_CORRUPT,
          "it declares a document type, which E57 has none of, and may be hostile: export the file "
          "again");
}

static void pass_over(void *data, const char *text, int length)
{
    reader *r = data;
    (void)text, (void)length;
    r->fed_at_event = r->fed;
}

static stp_status parse_chunk(reader *r, const char *bytes, size_t size, bool is_last)
{
    r->fed += size;
    const enum XML_Status parsed = XML_Parse(r->parser, bytes, (int)size, is_last);
    if (r->status != STP_OK)
        return r->status;
    if (parsed != XML_STATUS_OK) {
        const enum XML_Error code = XML_GetErrorCode(r->parser);
        fault(r, code == XML_ERROR_NO_MEMORY ? STP_OUT_OF_MEMORY : STP_CORRUPT,
              "%s: the file is damaged; copy or export it again", XML_ErrorString(code));
    } else if (r->fed - r->fed_at_event > TOKEN_BYTES_MAX) {
        fault(r, STP_LIMIT, "a tag or comment of more than %llu bytes: is it the right file?",
              (unsigned long long)TOKEN_BYTES_MAX);
    }
    return r->status;
}

static stp_status parse_all(reader *r, stp_e57_pages *pages)
{
    stp_status status = STP_OK;
    char chunk[CHUNK_BYTES];
    uint64_t at = pages->xml_begin, left = pages->xml_size;
    do {
        const size_t part = left < sizeof chunk ? (size_t)left : sizeof chunk;
        STP_TRY(stp_e57_pages_read(pages, at, chunk, part, r->err));
        at += part;
        left -= part;
        STP_TRY(parse_chunk(r, chunk, part, left == 0));
    } while (left > 0);
done:
    return status;
}

stp_status stp_e57_xml_read(stp_e57_document *document, stp_e57_pages *pages, stp_error *err)
{
    reader r = {.document = document, .path = pages->path, .err = err};
    if (pages->xml_size > XML_BYTES_MAX)
        return stp_error_set(err, STP_LIMIT,
                             "%s: an XML section of %llu bytes, where %llu are read at most: is it "
                             "the right file?",
                             pages->path, (unsigned long long)pages->xml_size,
                             (unsigned long long)XML_BYTES_MAX);
    r.parser = XML_ParserCreate(NULL);
    if (!r.parser)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "%s: no memory for an XML parser",
                             pages->path);
    XML_SetUserData(r.parser, &r);
    XML_SetElementHandler(r.parser, begin_element, end_element);
    XML_SetCharacterDataHandler(r.parser, add_text);
    XML_SetStartDoctypeDeclHandler(r.parser, refuse_doctype);
    XML_SetDefaultHandler(r.parser, pass_over);
    const stp_status status = parse_all(&r, pages);
    XML_ParserFree(r.parser);
    return status;
}

void stp_e57_document_free(stp_e57_document *document)
{
    free(document->scans);
    free(document->wkt);
    free(document->extras);
    document->scans = NULL;
    document->extras = NULL;
    document->wkt = NULL;
    document->scan_count = document->scan_capacity = 0;
}
