/* Prepares Wavefront OBJ for OpenMesh: checks `v`, `vn` and `f` and writes each on one line.
 * OpenMesh skips `l` lines, so they become edges here. */
#include "formats/scan/mesh/mesh_text.h"

#include "formats/scan/number.h"

#include <stdio.h>
#include <string.h>

typedef struct obj_parser {
    stp_text_lines lines;
    stp_point_mesh *mesh;
    stp_text_colours colours;
    uint64_t greatest_index, greatest_line; /* of faces with absolute vertex numbers */
} obj_parser;

/* Joins lines in place: a backslash at a line's end continues the line. Later messages count joined
 * lines as one. */
static void join_continued_lines(stp_mesh_text *text)
{
    char *end = text->data + text->size;
    for (char *at = text->data; (at = memchr(at, '\\', (size_t)(end - at))); at++) {
        char *next = at + 1;
        if (next < end && *next == '\r')
            next++;
        if (next < end && *next == '\n')
            memset(at, ' ', (size_t)(next + 1 - at));
    }
}

/* `v x y z`, `v x y z w`, `v x y z r g b` or `v x y z r g b a`. */
static stp_status obj_vertex(obj_parser *p, stp_error *err)
{
    stp_status status = STP_OK;
    static const char zeros[] = "v 0 0 0";
    double xyz[3], rest[4];
    size_t rest_count = 0;
    const char *end, *begin;
    STP_TRY(stp_text_numbers(&p->lines, "vertex", xyz, 3, err));
    while (rest_count < 4 && (begin = stp_text_next_token(&p->lines, &end)) &&
           stp_number_parse(begin, end, &rest[rest_count]))
        rest_count++;
    if (rest_count >= 3)
        STP_TRY(stp_text_colours_add(&p->colours, p->mesh->point_count, rest, err));
    STP_TRY(stp_point_mesh_reserve(p->mesh, p->lines.text->path, 1, err));
    p->mesh->points[p->mesh->point_count++] = (stp_point){.position = {xyz[0], xyz[1], xyz[2]}};
    stp_text_put(&p->lines, zeros, zeros + sizeof zeros - 1, '\n');
done:
    return status;
}

static stp_status obj_normal(obj_parser *p, stp_error *err)
{
    static const char keyword[] = "vn";
    double n[3];
    const char *rest = p->lines.cursor, *end;
    stp_status status = stp_text_numbers(&p->lines, "normal", n, 3, err);
    if (status != STP_OK)
        return status;
    p->lines.cursor = rest;
    stp_text_put(&p->lines, keyword, keyword + 2, ' ');
    for (int k = 0; k < 3; k++) {
        const char *begin = stp_text_next_token(&p->lines, &end);
        stp_text_put(&p->lines, begin, end, k < 2 ? ' ' : '\n');
    }
    return STP_OK;
}

static stp_status bad_corner(const obj_parser *p, uint64_t line, const char *what, stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: line %llu: a face names vertex `%s`, where there are %zu: mend the "
                         "face or export the file again",
                         p->lines.text->path, (unsigned long long)line, what, p->mesh->point_count);
}

/* The vertex number of `7`, `7/1`, `7//3` or `-1/-1/-1`; 0 if there is none. */
static int64_t corner_index(const char *begin, const char *end)
{
    const char *slash = memchr(begin, '/', (size_t)(end - begin));
    const bool negative = *begin == '-';
    uint64_t value;
    if (!stp_number_parse_u64(begin + (negative ? 1 : 0), slash ? slash : end, &value) ||
        value > INT32_MAX)
        return 0;
    return negative ? -(int64_t)value : (int64_t)value;
}

static stp_status obj_face(obj_parser *p, stp_error *err)
{
    static const char keyword[] = "f";
    const char *end, *begin;
    stp_text_put(&p->lines, keyword, keyword + 1, ' ');
    while ((begin = stp_text_next_token(&p->lines, &end)) && *begin != '#') {
        const int64_t index = corner_index(begin, end);
        if (index == 0 || (index < 0 && (uint64_t)-index > p->mesh->point_count)) {
            char found[32] = {0};
            memcpy(found, begin, (size_t)(end - begin < 31 ? end - begin : 31));
            return bad_corner(p, p->lines.line, found, err);
        }
        if (index > 0 && (uint64_t)index > p->greatest_index) {
            p->greatest_index = (uint64_t)index;
            p->greatest_line = p->lines.line;
        }
        stp_text_put(&p->lines, begin, end, ' ');
    }
    p->lines.out[-1] = '\n';
    return STP_OK;
}

/* `l 1 2 3`, `l 1/1 2/2`: adds an edge from each vertex to the next. A token that is no number, or
 * names no vertex, becomes an end that does not exist. */
static stp_status obj_line(obj_parser *p, stp_error *err)
{
    stp_status status = STP_OK;
    stp_mesh_edge edge = {{0, 0}, {0, 0, 0}};
    const char *end, *begin;
    for (size_t i = 0; (begin = stp_text_next_token(&p->lines, &end)) && *begin != '#'; i++) {
        const int64_t index = corner_index(begin, end);
        const int64_t vertex = index < 0 ? (int64_t)p->mesh->point_count + index : index - 1;
        edge.vertices[0] = edge.vertices[1];
        edge.vertices[1] = index == 0 || vertex < 0 ? STP_MESH_NO_VERTEX : (uint32_t)vertex;
        if (i > 0)
            STP_TRY(stp_point_mesh_add_edge(p->mesh, &edge, err));
    }
done:
    return status;
}

static bool word_is(const char *begin, const char *end, const char *word)
{
    return (size_t)(end - begin) == strlen(word) && memcmp(begin, word, strlen(word)) == 0;
}

stp_status stp_mesh_text_prepare_obj(stp_mesh_text *text, stp_point_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    join_continued_lines(text);
    obj_parser p = {.lines = stp_text_lines_begin(text), .mesh = mesh};
    while (stp_text_next_line(&p.lines)) {
        const char *end, *begin = stp_text_next_token(&p.lines, &end);
        if (!begin)
            continue;
        if (word_is(begin, end, "v"))
            STP_TRY(obj_vertex(&p, err));
        else if (word_is(begin, end, "vn"))
            STP_TRY(obj_normal(&p, err));
        else if (word_is(begin, end, "f"))
            STP_TRY(obj_face(&p, err));
        else if (word_is(begin, end, "l"))
            STP_TRY(obj_line(&p, err));
    }
    if (p.greatest_index > mesh->point_count) {
        char found[32];
        snprintf(found, sizeof found, "%llu", (unsigned long long)p.greatest_index);
        status = bad_corner(&p, p.greatest_line, found, err);
        goto done;
    }
    stp_text_colours_apply(&p.colours, mesh);
    text->size = (size_t)(p.lines.out - text->data);
done:
    stp_text_colours_free(&p.colours);
    return status;
}
