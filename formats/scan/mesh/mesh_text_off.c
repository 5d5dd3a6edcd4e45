/* Prepares OFF for OpenMesh: removes comments, checks that the file holds the counts, writes one
 * line per vertex and face. */
#include "formats/scan/mesh/mesh_text.h"

#include "formats/scan/number.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct off_parser {
    stp_text_lines lines;
    stp_point_mesh *mesh;
    bool has_normals;
    stp_text_colours colours;
    uint64_t vertex_count, face_count;
    uint64_t triangle_count; /* of the faces so far */
} off_parser;

/* Gets the next line that has more than a comment, cut before the comment. */
static bool next_data_line(stp_text_lines *lines)
{
    while (stp_text_next_line(lines)) {
        const size_t length = (size_t)(lines->line_end - lines->cursor);
        const char *comment = memchr(lines->cursor, '#', length);
        if (comment)
            lines->line_end = comment;
        const char *probe = lines->cursor, *end;
        const char *token = stp_text_next_token(lines, &end);
        lines->cursor = probe;
        if (token)
            return true;
    }
    return false;
}

static stp_status parse_kind(off_parser *p, stp_error *err)
{
    const char *end = NULL, *begin = NULL;
    if (next_data_line(&p->lines))
        begin = stp_text_next_token(&p->lines, &end);
    const size_t length = begin ? (size_t)(end - begin) : 0;
    uint64_t count;
    if (begin && stp_number_parse_u64(begin, end, &count) && count > 0) { /* the word is left out */
        p->lines.cursor = begin;
        return STP_OK;
    }
    const char *digits = begin ? begin + 3 : end;
    if (length > 3 && memcmp(begin, "OFF", 3) == 0 && stp_number_parse_u64(digits, end, &count)) {
        p->lines.cursor = digits; /* `OFF490 518 0`, as ModelNet has it */
        return STP_OK;
    }
    static const char *const kinds[] = {"OFF", "COFF", "NOFF", "CNOFF", "NCOFF"};
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        if (length != strlen(kinds[i]) || memcmp(begin, kinds[i], length) != 0)
            continue;
        p->has_normals = strchr(kinds[i], 'N') != NULL;
        const char *rest = p->lines.cursor, *word_end;
        const char *word = stp_text_next_token(&p->lines, &word_end);
        p->lines.cursor = rest;
        if (word && *word == 'B')
            break;
        return STP_OK;
    }
    return stp_error_set(err, STP_UNSUPPORTED,
                         "%s: line %llu: only ASCII OFF, COFF and NOFF in three dimensions are "
                         "supported: export it as one of these, or as PLY",
                         p->lines.text->path, (unsigned long long)p->lines.line);
}

static stp_status parse_counts(off_parser *p, stp_error *err)
{
    const char *end, *begin = stp_text_next_token(&p->lines, &end);
    if (!begin && next_data_line(&p->lines)) /* the counts are usually on their own line */
        begin = stp_text_next_token(&p->lines, &end);
    bool good = begin && stp_number_parse_u64(begin, end, &p->vertex_count);
    begin = good ? stp_text_next_token(&p->lines, &end) : NULL;
    good = begin && stp_number_parse_u64(begin, end, &p->face_count);
    /* A vertex takes at least 6 bytes, a face 2. So no loop runs to a count that the file cannot
     * hold. */
    const uint64_t left = (uint64_t)(p->lines.end - p->lines.at) + 1;
    if (good && p->vertex_count <= left / 6 && p->face_count <= left / 2)
        return STP_OK;
    return stp_error_set(err, STP_CORRUPT,
                         "%s: line %llu: OFF needs the numbers of vertices and faces, and bytes "
                         "for them; %llu follow: the file was cut or is damaged",
                         p->lines.text->path, (unsigned long long)p->lines.line,
                         (unsigned long long)left - 1);
}

static stp_status off_cut(const off_parser *p, const char *what, uint64_t found, uint64_t expected,
                          stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: ends at line %llu after %llu of %llu %s: the file was cut; copy or "
                         "export it again",
                         p->lines.text->path, (unsigned long long)p->lines.line,
                         (unsigned long long)found, (unsigned long long)expected, what);
}

/* Parses a position, a normal if the kind has them, and a colour of three or four values or none.
 */
static stp_status off_vertex(off_parser *p, stp_error *err)
{
    stp_status status = STP_OK;
    static const char zeros[] = "0 0 0";
    double values[10];
    const char *end, *rest = p->lines.cursor;
    size_t count = 0;
    while (stp_text_next_token(&p->lines, &end))
        count++;
    p->lines.cursor = rest;
    const size_t fixed = p->has_normals ? 6 : 3;
    if (count > fixed && count != fixed + 3 && count != fixed + 4)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: line %llu: a vertex of %zu values, where position, %sthen a "
                             "colour of 3 or 4 or nothing are supported: mend the line",
                             p->lines.text->path, (unsigned long long)p->lines.line, count,
                             p->has_normals ? "normal, " : "");
    STP_TRY(stp_text_numbers(&p->lines, "vertex", values, count > fixed ? count : fixed, err));
    if (count > fixed)
        STP_TRY(stp_text_colours_add(&p->colours, p->mesh->point_count, values + fixed, 3, err));
    STP_TRY(stp_point_mesh_reserve(p->mesh, p->lines.text->path, 1, err));
    stp_point *point = &p->mesh->points[p->mesh->point_count++];
    *point = (stp_point){.position = {values[0], values[1], values[2]}};
    if (p->has_normals)
        point->normal = stp_unit_normal((stp_dvec3){values[3], values[4], values[5]});
    stp_text_put(&p->lines, zeros, zeros + sizeof zeros - 1, '\n');
done:
    return status;
}

/* Says that the last triangles before number `end` have no colour. */
static stp_status add_colourless(stp_materials *m, uint64_t end, stp_error *err)
{
    return stp_materials_add_plain(m, NULL, end - m->triangle_count, err);
}

/* Takes a face's colour: three or four numbers, whole ones up to 255, others up to 1. Anything else
 * is none. Vertices with colours need none of faces. */
static stp_status off_face_colour(off_parser *p, uint64_t triangles, stp_error *err)
{
    stp_status status = STP_OK;
    stp_materials *m = &p->mesh->materials;
    uint16_t rgb[3];
    const char *end, *begin;
    size_t count = 0;
    for (; (begin = stp_text_next_token(&p->lines, &end)) != NULL; count++) {
        double value = 0.0;
        const double full = memchr(begin, '.', (size_t)(end - begin)) ? 1.0 : 255.0;
        if (!stp_number_parse(begin, end, &value))
            value = 0.0;
        if (count < 3)
            rgb[count] = (uint16_t)lrint(fmin(fmax(value / full, 0.0), 1.0) * 65535.0);
    }
    const bool coloured = (count == 3 || count == 4) && p->colours.count == 0;
    if (coloured) {
        STP_TRY(add_colourless(m, p->triangle_count, err));
        STP_TRY(stp_materials_add_plain(m, rgb, triangles, err));
    }
    p->triangle_count += triangles;
done:
    return status;
}

static stp_status off_face(off_parser *p, stp_error *err)
{
    uint64_t corners = 0, index;
    const char *end, *begin = stp_text_next_token(&p->lines, &end);
    bool good = begin && stp_number_parse_u64(begin, end, &corners) &&
                corners <= (uint64_t)(p->lines.line_end - end) / 2;
    if (good)
        stp_text_put(&p->lines, begin, end, ' ');
    for (uint64_t i = 0; i < corners && good; i++) {
        begin = stp_text_next_token(&p->lines, &end);
        good = begin && stp_number_parse_u64(begin, end, &index) && index < p->vertex_count;
        if (good)
            stp_text_put(&p->lines, begin, end, ' ');
    }
    if (!good)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: line %llu: a face must be its number of corners and as many "
                             "vertex numbers below %llu: mend the line or export the file again",
                             p->lines.text->path, (unsigned long long)p->lines.line,
                             (unsigned long long)p->vertex_count);
    p->lines.out[-1] = '\n';
    return off_face_colour(p, corners > 2 ? corners - 2 : 0, err);
}

/* Writes the header into the free bytes before the lines. */
static void put_header(const off_parser *p, stp_mesh_text *text, const char *body)
{
    char header[64];
    const int length =
        snprintf(header, sizeof header, "OFF\n%llu %llu 0\n", (unsigned long long)p->vertex_count,
                 (unsigned long long)p->face_count);
    text->data += body - text->data - length;
    memcpy(text->data, header, (size_t)length);
    text->size = (size_t)(p->lines.out - text->data);
}

stp_status stp_mesh_text_prepare_off(stp_mesh_text *text, stp_point_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    off_parser p = {.lines = stp_text_lines_begin(text), .mesh = mesh};
    const char *body = p.lines.out;
    STP_TRY(parse_kind(&p, err));
    STP_TRY(parse_counts(&p, err));
    for (uint64_t i = 0; i < p.vertex_count; i++) {
        if (!next_data_line(&p.lines))
            STP_TRY(off_cut(&p, "vertices", i, p.vertex_count, err));
        STP_TRY(off_vertex(&p, err));
    }
    for (uint64_t i = 0; i < p.face_count; i++) {
        if (!next_data_line(&p.lines))
            STP_TRY(off_cut(&p, "faces", i, p.face_count, err));
        STP_TRY(off_face(&p, err));
    }
    put_header(&p, text, body);
    if (mesh->materials.count > 0) /* the last faces may have none */
        STP_TRY(add_colourless(&mesh->materials, p.triangle_count, err));
    stp_text_colours_apply(&p.colours, mesh);
    if (p.has_normals)
        mesh->attributes |= STP_POINT_HAS_NORMAL;
done:
    stp_text_colours_free(&p.colours);
    return status;
}
