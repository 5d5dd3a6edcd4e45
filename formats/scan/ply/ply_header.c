/* Reads the header of a PLY file. */
#include "formats/scan/ply/ply_header.h"

#include "formats/scan/ply/ply_grid.h"

#include "base/memory.h"
#include "formats/scan/number.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

/* Bounds on the cost of a header. Real headers have fewer than 100 lines. */
#define STP_PLY_HEADER_BYTES_MAX ((uint64_t)1 << 20)
#define STP_PLY_ELEMENTS_MAX 256u
#define STP_PLY_PROPERTIES_MAX 4096u

static const struct {
    const char *old_name, *new_name;
    size_t size;
} types[] = {
    [STP_PLY_INT8] = {"char", "int8", 1},        [STP_PLY_UINT8] = {"uchar", "uint8", 1},
    [STP_PLY_INT16] = {"short", "int16", 2},     [STP_PLY_UINT16] = {"ushort", "uint16", 2},
    [STP_PLY_INT32] = {"int", "int32", 4},       [STP_PLY_UINT32] = {"uint", "uint32", 4},
    [STP_PLY_INT64] = {"int64", "int64", 8},     [STP_PLY_UINT64] = {"uint64", "uint64", 8},
    [STP_PLY_FLOAT32] = {"float", "float32", 4}, [STP_PLY_FLOAT64] = {"double", "float64", 8},
};

size_t stp_ply_type_size(stp_ply_type type)
{
    return types[type].size;
}

/* A word of a header line, cut to the length of a name. */
typedef struct word {
    char text[STP_PLY_NAME_CHARS];
} word;

/* State while a header is parsed. */
typedef struct header_parser {
    stp_ply_header *header;
    stp_source *source;
    const char *at, *end; /* unread part of the line */
    bool has_format;
} header_parser;

/* Returns an empty word if the line has none. Cuts a name that is too long; the cut name still
 * differs from all known names. */
static word next_word(header_parser *parser)
{
    word w = {""};
    const char *begin = stp_token(&parser->at, parser->end);
    if (begin)
        snprintf(w.text, sizeof w.text, "%.*s", (int)(parser->at - begin), begin);
    return w;
}

static stp_status header_corrupt(const header_parser *p, const char *what, const char *found,
                                 const char *advice, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT, "%s: PLY header line %llu: %s%s%s%s: %s",
                         p->source->path, (unsigned long long)p->source->line, what,
                         found ? " `" : "", found ? found : "", found ? "`" : "", advice);
}

static bool find_type(const char *name, stp_ply_type *type)
{
    for (size_t i = 0; i < sizeof types / sizeof *types; i++) {
        if (strcmp(name, types[i].old_name) == 0 || strcmp(name, types[i].new_name) == 0) {
            *type = (stp_ply_type)i;
            return true;
        }
    }
    return false;
}

/* What the name of a vertex property means. rank: of two properties that mean the same, the one
 * with the lower rank is read. */
static stp_ply_target find_target(const char *name, size_t *rank)
{
    static const struct {
        const char *name;
        stp_ply_target target;
    } own[] = {
        {"radius", STP_PLY_RADIUS}, {"station", STP_PLY_STATION},
        {"f_dc_0", STP_PLY_RED},    {"f_dc_1", STP_PLY_GREEN}, /* of Gaussian splats: */
        {"f_dc_2", STP_PLY_BLUE},                              /* stp_ply_is_harmonic */
    };
    *rank = stp_column_find_name(name, name + strlen(name));
    name += strncasecmp(name, "scalar_", 7) == 0 ? 7 : 0;
    for (size_t i = 0; i < sizeof own / sizeof *own; i++)
        if (strcasecmp(name, own[i].name) == 0)
            return own[i].target;
    const stp_column column = stp_column_by_name(*rank);
    return column == STP_COLUMN_NONE ? STP_PLY_TARGET_COUNT : (stp_ply_target)column;
}

bool stp_ply_is_packed(const stp_ply_property *property)
{
    const bool named =
        strcasecmp(property->name, "rgb") == 0 || strcasecmp(property->name, "rgba") == 0;
    return named && !property->is_list && stp_ply_type_size(property->type) == 4;
}

/* Coordinates in an image, as MeshLab, Blender and others name them. */
static stp_ply_target find_place(const char *name)
{
    static const char *const names[][2] = {
        {"s", "t"}, {"u", "v"}, {"texture_u", "texture_v"}, {"tu", "tv"}};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        for (unsigned k = 0; k < 2; k++)
            if (strcmp(name, names[i][k]) == 0)
                return (stp_ply_target)(STP_PLY_S + k);
    return STP_PLY_TARGET_COUNT;
}

/* If two properties mean the same, the one whose name is preferred counts; of equal names the
 * first. */
static void set_target(stp_ply_header *h, const stp_ply_element *vertex, stp_ply_property *property)
{
    size_t rank, other;
    property->target = find_target(property->name, &rank);
    if (h->textures.count > 0 && property->target == STP_PLY_TARGET_COUNT)
        property->target = find_place(property->name);
    if (stp_ply_is_packed(property)) {
        property->target = STP_PLY_RED;
        if (property->type == STP_PLY_FLOAT32 && h->encoding != STP_PLY_ASCII)
            property->type = STP_PLY_UINT32; /* the bits: as a number a NaN would lose some */
    }
    for (size_t i = vertex->property_first; i < h->property_count; i++) {
        stp_ply_property *before = &h->properties[i];
        if (property->target == STP_PLY_TARGET_COUNT || before->target != property->target)
            continue;
        find_target(before->name, &other);
        (rank < other ? before : property)->target = STP_PLY_TARGET_COUNT;
    }
}

static stp_status parse_format(header_parser *p, stp_error *err)
{
    static const char *const names[] = {
        [STP_PLY_ASCII] = "ascii",
        [STP_PLY_BINARY_LITTLE_ENDIAN] = "binary_little_endian",
        [STP_PLY_BINARY_BIG_ENDIAN] = "binary_big_endian",
    };
    word encoding = next_word(p), version = next_word(p);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcmp(encoding.text, names[i]) == 0) {
            p->header->encoding = (stp_ply_encoding)i;
            p->has_format = true;
        }
    }
    if (!p->has_format || strncmp(version.text, "1.", 2) != 0)
        return stp_error_set(
            err, STP_UNSUPPORTED,
            "%s: PLY header line %llu: format `%s %s` is not supported: use ascii, "
            "binary_little_endian or binary_big_endian 1.0",
            p->source->path, (unsigned long long)p->source->line, encoding.text, version.text);
    return STP_OK;
}

static stp_status parse_element(header_parser *p, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ply_header *h = p->header;
    stp_ply_element element = {.property_first = h->property_count};
    word name = next_word(p), count = next_word(p);
    if (!name.text[0] ||
        !stp_number_parse_u64(count.text, count.text + strlen(count.text), &element.count))
        return header_corrupt(p, "an element needs a name and a count below 2^64, found",
                              count.text, "export the file again", err);
    if (stp_ply_header_find(h, name.text))
        return header_corrupt(p, "a second element", name.text, "export the file again", err);
    if (h->element_count >= STP_PLY_ELEMENTS_MAX)
        return header_corrupt(p, "too many elements", NULL, "is it the right file?", err);
    memcpy(element.name, name.text, sizeof element.name);
    STP_TRY(stp_grow(&h->elements, &h->element_capacity, h->element_count + 1, sizeof *h->elements,
                     "elements", err));
    h->elements[h->element_count++] = element;
done:
    return status;
}

/* Vertices, as most programs name them, and points, as a few do. */
static const char *const vertices[] = {"vertex", "vertices", "point", "points"};
enum { VERTICES = sizeof vertices / sizeof *vertices };

static bool is_vertices(const char *name)
{
    size_t i = 0;
    while (i < VERTICES && strcmp(name, vertices[i]) != 0)
        i++;
    return i < VERTICES;
}

static stp_status parse_property(header_parser *p, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ply_header *h = p->header;
    stp_ply_property property = {.target = STP_PLY_TARGET_COUNT};
    word type = next_word(p);
    if (h->element_count == 0)
        return header_corrupt(p, "a property before any element", NULL, "export the file again",
                              err);
    if (h->property_count >= STP_PLY_PROPERTIES_MAX)
        return header_corrupt(p, "too many properties", NULL, "is it the right file?", err);
    stp_ply_element *element = &h->elements[h->element_count - 1];
    property.is_list = strcmp(type.text, "list") == 0;
    if (property.is_list) {
        word count_type = next_word(p);
        if (!find_type(count_type.text, &property.count_type) ||
            property.count_type >= STP_PLY_FLOAT32)
            return header_corrupt(p, "a list's length cannot be of type", count_type.text,
                                  "export the file again", err);
        type = next_word(p);
    }
    if (!find_type(type.text, &property.type))
        return header_corrupt(p, "unknown type", type.text, "export the file again", err);
    word name = next_word(p);
    if (!name.text[0])
        return header_corrupt(p, "a property without a name", NULL, "export the file again", err);
    memcpy(property.name, name.text, sizeof property.name);
    if (!property.is_list && is_vertices(element->name))
        set_target(h, element, &property);
    property.offset = element->stride;
    element->stride += stp_ply_type_size(property.is_list ? property.count_type : property.type);
    element->has_lists |= property.is_list;
    STP_TRY(stp_grow(&h->properties, &h->property_capacity, h->property_count + 1,
                     sizeof *h->properties, "properties", err));
    h->properties[h->property_count++] = property;
    element->property_count++;
done:
    return status;
}

/* A line of the kind "num_cols 512": the size of the range image. */
static void parse_grid_line(uint64_t size[2], const char *begin, const char *end)
{
    static const char *const names[2] = {"num_cols", "num_rows"};
    const char *name = stp_token(&begin, end);
    const size_t length = name ? (size_t)(begin - name) : 0;
    const char *number = stp_token(&begin, end);
    for (int i = 0; number && i < 2; i++)
        if (length == strlen(names[i]) && memcmp(name, names[i], length) == 0 &&
            !stp_number_parse_u64(number, begin, &size[i]))
            size[i] = 0;
}

/* `TextureFile NAME`, as MeshLab and its like write; else perhaps a station. */
static stp_status parse_comment(header_parser *p, stp_error *err)
{
    static const char tag[] = "TextureFile";
    const char *at = p->at, *begin = stp_token(&at, p->end), *end = p->end;
    if (!begin || (size_t)(at - begin) != sizeof tag - 1 || memcmp(begin, tag, sizeof tag - 1) != 0)
        return stp_ply_stations_add(&p->header->stations, p->at, p->end, err);
    stp_trim(&at, &end);
    return at < end ? stp_materials_add_image(&p->header->textures, at, end, err) : STP_OK;
}

static stp_status parse_line(header_parser *p, bool *done_reading, stp_error *err)
{
    word keyword = next_word(p);
    const char *k = keyword.text;
    if (strcmp(k, "format") == 0)
        return parse_format(p, err);
    if (strcmp(k, "element") == 0)
        return parse_element(p, err);
    if (strcmp(k, "property") == 0)
        return parse_property(p, err);
    if (strcmp(k, "comment") == 0)
        return parse_comment(p, err);
    if (strcmp(k, "obj_info") == 0)
        parse_grid_line(p->header->grid_size, p->at, p->end);
    *done_reading = strcmp(k, "end_header") == 0;
    if (*done_reading || k[0] == '\0' || strcmp(k, "obj_info") == 0)
        return STP_OK;
    return header_corrupt(p, "unknown keyword", k, "export the file again", err);
}

static stp_status next_line(header_parser *p, stp_error *err)
{
    stp_status status = STP_OK;
    p->at = NULL;
    if (p->source->offset < STP_PLY_HEADER_BYTES_MAX)
        STP_TRY(stp_source_line(p->source, &p->at, &p->end, err));
    if (p->at && p->source->cr_lines && memchr(p->at, '\n', (size_t)(p->end - p->at)))
        status = header_corrupt(p, "some lines end in CR, others in LF", NULL,
                                "export the file again", err);
    if (!p->at)
        status = stp_error_set(err, STP_CORRUPT,
                               "%s: the PLY header ends at byte %llu, line %llu, without "
                               "end_header: the file was cut; copy or export it again",
                               p->source->path, (unsigned long long)p->source->offset,
                               (unsigned long long)p->source->line);
done:
    return status;
}

/* Whether lines end in CR alone, as Rhinoceros writes them. */
static stp_status look_for_cr(stp_source *source, stp_error *err)
{
    const unsigned char *bytes;
    size_t available = 0;
    const stp_status status = stp_source_peek(source, 5, &bytes, &available, err);
    source->cr_lines = status == STP_OK && available == 5 && bytes[3] == '\r' && bytes[4] != '\n';
    return status;
}

stp_status stp_ply_header_read(stp_ply_header *out, stp_source *source, stp_error *err)
{
    stp_status status = STP_OK;
    stp_ply_header header = {0};
    header_parser parser = {.header = &header, .source = source};
    bool ended = false;
    stp_source_seek(source, 0, 0);
    STP_TRY(look_for_cr(source, err));
    STP_TRY(next_line(&parser, err));
    if (strcmp(next_word(&parser).text, "ply") != 0) {
        status = header_corrupt(&parser, "the first line is not `ply`", NULL,
                                "is it the right file?", err);
        goto done;
    }
    while (!ended) {
        STP_TRY(next_line(&parser, err));
        STP_TRY(parse_line(&parser, &ended, err));
    }
    if (!parser.has_format) {
        status = header_corrupt(&parser, "the header has no format line", NULL,
                                "export the file again", err);
        goto done;
    }
    header.data_offset = source->offset;
    header.header_lines = source->line;
    stp_ply_stations_sort(&header.stations);
    *out = header;
    header = (stp_ply_header){0};
done:
    stp_ply_header_free(&header);
    return status;
}

void stp_ply_header_free(stp_ply_header *header)
{
    free(header->elements);
    free(header->properties);
    stp_ply_stations_free(&header->stations);
    stp_materials_clear(&header->textures);
    *header = (stp_ply_header){0};
}

const stp_ply_element *stp_ply_header_find(const stp_ply_header *header, const char *name)
{
    for (size_t i = 0; i < header->element_count; i++)
        if (strcmp(header->elements[i].name, name) == 0)
            return &header->elements[i];
    return NULL;
}

const stp_ply_element *stp_ply_header_find_vertices(const stp_ply_header *header)
{
    const stp_ply_element *found = NULL;
    for (size_t i = 0; i < VERTICES && !found; i++)
        found = stp_ply_header_find(header, vertices[i]);
    return found;
}

const stp_ply_property *stp_ply_number_property(const stp_ply_header *header,
                                                const stp_ply_element *element, const char *name)
{
    for (size_t i = 0; i < element->property_count; i++) {
        const stp_ply_property *p = &header->properties[element->property_first + i];
        if (!p->is_list && strcasecmp(p->name, name) == 0)
            return p;
    }
    return NULL;
}

const stp_ply_property *stp_ply_index_list(const stp_ply_header *header,
                                           const stp_ply_element *element)
{
    for (size_t i = 0; i < element->property_count; i++) {
        const stp_ply_property *p = &header->properties[element->property_first + i];
        if (p->is_list && p->type < STP_PLY_FLOAT32 &&
            (strcmp(p->name, "vertex_indices") == 0 || strcmp(p->name, "vertex_index") == 0))
            return p;
    }
    return NULL;
}
