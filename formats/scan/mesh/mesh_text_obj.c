/* Prepares Wavefront OBJ for OpenMesh: checks `v`, `vn` and `f` and writes each on one line.
 * OpenMesh skips `l` lines, so they become edges here. */
#include "formats/scan/mesh/mesh_text.h"

#include "base/memory.h"
#include "formats/scan/number.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct obj_parser {
    stp_text_lines lines;
    stp_point_mesh *mesh;
    stp_text_colours colours;
    uint64_t greatest_index, greatest_line; /* of faces with absolute vertex numbers */
    float (*places)[2];                     /* texture coordinates, if the file has materials */
    size_t place_count, place_capacity;
    uint32_t material; /* of the next faces */
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

/* `v x y z`, `v x y z w`, `v x y z r g b`, `v x y z r g b a` or `v x y z w r g b`. */
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
        STP_TRY(stp_text_colours_add(&p->colours, p->mesh->point_count, rest, rest_count, err));
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

/* `vt u`, `vt u v` or `vt u v w`. A place that is no number is none. */
static stp_status obj_place(obj_parser *p, stp_error *err)
{
    stp_status status = STP_OK;
    double uv[2] = {0.0, 0.0};
    if (p->mesh->materials.count == 0)
        return STP_OK;
    for (int k = 0; k < 2; k++) {
        const char *end, *begin = stp_text_next_token(&p->lines, &end);
        if (begin && !stp_number_parse(begin, end, &uv[k]))
            uv[k] = (double)NAN;
    }
    STP_TRY(stp_grow(&p->places, &p->place_capacity, p->place_count + 1, sizeof *p->places,
                     "texture coordinates", err));
    for (int k = 0; k < 2; k++)
        p->places[p->place_count][k] = stp_texture_place(uv[k]);
    p->place_count++;
done:
    return status;
}

/* The place that `7/1` or `-1/-1/-1` names; NaN if there is none. */
static void corner_place(const obj_parser *p, const char *begin, const char *end, float uv[2])
{
    const char *slash = memchr(begin, '/', (size_t)(end - begin));
    const int64_t index =
        slash && slash + 1 < end ? corner_index(slash + 1, end) : 0; /* up to the next slash */
    const int64_t place = index < 0 ? (int64_t)p->place_count + index : index - 1;
    uv[0] = uv[1] = NAN;
    if (index != 0 && place >= 0 && (uint64_t)place < p->place_count)
        memcpy(uv, p->places[place], sizeof p->places[place]);
}

/* Notes the material of a face's triangles, which form a fan as OpenMesh's faces do later. */
static stp_status face_material(obj_parser *p, stp_error *err)
{
    stp_status status = STP_OK;
    stp_text_lines at = p->lines;
    float corners[3][2];
    const char *end, *begin;
    if (p->mesh->materials.count == 0)
        return STP_OK;
    for (size_t i = 0; (begin = stp_text_next_token(&at, &end)) && *begin != '#'; i++) {
        if (i > 2)
            memcpy(corners[1], corners[2], sizeof corners[1]);
        corner_place(p, begin, end, corners[i < 2 ? i : 2]);
        if (i >= 2)
            STP_TRY(stp_materials_add_triangle(&p->mesh->materials, p->material,
                                               (const float(*)[2])corners, err));
    }
done:
    return status;
}

static stp_status obj_face(obj_parser *p, stp_error *err)
{
    static const char keyword[] = "f";
    const char *end, *begin;
    stp_status status = face_material(p, err);
    if (status != STP_OK)
        return status;
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

/* Reads the libraries of all `mtllib NAME` lines, wherever they stand; names may have spaces. */
static stp_status obj_libraries(obj_parser *p, stp_error *err)
{
    stp_status status = STP_OK;
    stp_text_lines lines = p->lines;
    for (char *at = lines.at; (at = memmem(at, (size_t)(lines.end - at), "mtllib", 6)) != NULL;) {
        char *before = memrchr(p->lines.at, '\n', (size_t)(at - p->lines.at));
        lines.at = before != NULL ? before + 1 : p->lines.at;
        stp_text_next_line(&lines);
        const char *end, *begin = stp_text_next_token(&lines, &end);
        at = lines.at;
        if (!stp_text_token_is(begin, end, "mtllib"))
            continue;
        stp_text_rest(&lines, &begin, &end);
        STP_TRY(stp_materials_read(&p->mesh->materials, lines.text->path, begin, end, err));
    }
done:
    return status;
}

static stp_status obj_statement(obj_parser *p, const char *begin, const char *end, stp_error *err)
{
    if (stp_text_token_is(begin, end, "v"))
        return obj_vertex(p, err);
    if (stp_text_token_is(begin, end, "vn"))
        return obj_normal(p, err);
    if (stp_text_token_is(begin, end, "vt"))
        return obj_place(p, err);
    if (stp_text_token_is(begin, end, "f"))
        return obj_face(p, err);
    if (stp_text_token_is(begin, end, "l"))
        return obj_line(p, err);
    if (stp_text_token_is(begin, end, "usemtl")) {
        stp_text_rest(&p->lines, &begin, &end);
        p->material = stp_materials_find(&p->mesh->materials, begin, end);
    }
    return STP_OK;
}

stp_status stp_mesh_text_prepare_obj(stp_mesh_text *text, stp_point_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    join_continued_lines(text);
    obj_parser p = {.lines = stp_text_lines_begin(text), .mesh = mesh, .material = STP_NO_MATERIAL};
    STP_TRY(obj_libraries(&p, err));
    while (stp_text_next_line(&p.lines)) {
        const char *end, *begin = stp_text_next_token(&p.lines, &end);
        if (begin)
            STP_TRY(obj_statement(&p, begin, end, err));
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
    free(p.places);
    return status;
}
