/* Prepares mesh files for OpenMesh: loading, lines and tokens; STL. */
#include "formats/scan/mesh/mesh_text.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/scan/number.h"
#include "formats/scan/source.h"
#include "formats/scan/value_range.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

/* Free bytes before the text, for a header longer than the file's, and after the text, for a
 * missing line end. */
#define STP_MESH_TEXT_SLACK 64u
#define STP_STL_HEADER_BYTES 84u
#define STP_STL_FACET_BYTES 50u

stp_status stp_mesh_text_load(stp_mesh_text *out, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    stp_mesh_text text = {.path = path};
    int descriptor = -1;
    uint64_t size;
    STP_TRY(stp_file_open(path, &descriptor, &size, err));
    if (size > SIZE_MAX - 2 * STP_MESH_TEXT_SLACK) {
        status = stp_error_set(err, STP_LIMIT, "%s: %llu bytes are too many for a mesh", path,
                               (unsigned long long)size);
        goto done;
    }
    STP_TRY(stp_alloc(&text.memory, (size_t)size + 2 * STP_MESH_TEXT_SLACK, 1,
                      "bytes of a mesh file", err));
    text.data = text.memory + STP_MESH_TEXT_SLACK;
    text.size = (size_t)size;
    STP_TRY(stp_file_read_at(descriptor, path, 0, text.data, text.size, err));
    *out = text;
    text.memory = NULL;
done:
    if (descriptor >= 0)
        close(descriptor);
    stp_mesh_text_free(&text);
    return status;
}

void stp_mesh_text_free(stp_mesh_text *text)
{
    free(text->memory);
    *text = (stp_mesh_text){0};
}

stp_text_lines stp_text_lines_begin(const stp_mesh_text *text)
{
    return (stp_text_lines){
        .text = text, .at = text->data, .end = text->data + text->size, .out = text->data};
}

bool stp_text_next_line(stp_text_lines *lines)
{
    if (lines->at == lines->end)
        return false;
    char *newline = memchr(lines->at, '\n', (size_t)(lines->end - lines->at));
    const char *stop = newline ? newline : lines->end;
    lines->cursor = lines->at;
    lines->at = newline ? newline + 1 : lines->end;
    lines->line++;
    if (stop > lines->cursor && stop[-1] == '\r')
        stop--;
    lines->line_end = stop;
    return true;
}

const char *stp_text_next_token(stp_text_lines *lines, const char **end)
{
    const char *begin = stp_token(&lines->cursor, lines->line_end);
    *end = lines->cursor;
    return begin;
}

stp_status stp_text_numbers(stp_text_lines *lines, const char *what, double *values, size_t count,
                            stp_error *err)
{
    for (size_t i = 0; i < count; i++) {
        const char *end, *begin = stp_text_next_token(lines, &end);
        if (!begin)
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: line %llu: %s has %zu of %zu numbers: mend the line, or the "
                                 "file was cut",
                                 lines->text->path, (unsigned long long)lines->line, what, i,
                                 count);
        if (!stp_number_parse(begin, end, &values[i]))
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: line %llu: `%.*s` is not a number (%s): mend the line or "
                                 "export the file again",
                                 lines->text->path, (unsigned long long)lines->line,
                                 (int)(end - begin < 40 ? end - begin : 40), begin, what);
    }
    return STP_OK;
}

void stp_text_put(stp_text_lines *lines, const char *begin, const char *end, char after)
{
    const size_t length = (size_t)(end - begin);
    memmove(lines->out, begin, length);
    lines->out[length] = after;
    lines->out += length + 1;
}

stp_status stp_text_colours_add(stp_text_colours *colours, size_t vertex, const double *numbers,
                                size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(stp_grow(&colours->values, &colours->capacity, vertex + 1, sizeof *colours->values,
                     "colours", err));
    for (; colours->count <= vertex; colours->count++)
        memset(colours->values[colours->count], 0, sizeof *colours->values);
    for (size_t k = 0; k < count; k++) /* NaN becomes 0 */
        colours->values[vertex][k] = (float)fmin(fmax(numbers[k], 0.0), 65535.0);
    colours->first_differs = colours->first_differs || (count == 4 && numbers[0] != 1.0);
    colours->fourth_differs = colours->fourth_differs || (count == 4 && numbers[3] != 1.0);
done:
    return status;
}

void stp_text_colours_apply(const stp_text_colours *colours, stp_point_mesh *mesh)
{
    const int red = colours->fourth_differs && !colours->first_differs ? 1 : 0;
    float maximum = 0.0f;
    for (size_t i = 0; i < colours->count; i++)
        for (int k = red; k < red + 3; k++)
            maximum = fmaxf(maximum, colours->values[i][k]);
    const double scale = (double)maximum > STP_COLOUR_OVERSHOOT ? 257.0 : 65535.0;
    if (maximum > 0.0f)
        mesh->attributes |= STP_POINT_HAS_COLOUR;
    for (size_t i = 0; i < colours->count; i++)
        for (int k = 0; k < 3; k++)
            mesh->points[i].rgb[k] =
                (uint16_t)fmin((double)colours->values[i][red + k] * scale + 0.5, 65535.0);
}

void stp_text_colours_free(stp_text_colours *colours)
{
    free(colours->values);
    *colours = (stp_text_colours){0};
}

bool stp_text_token_is(const char *begin, const char *end, const char *word)
{
    const size_t length = strlen(word);
    return (size_t)(end - begin) == length && memcmp(begin, word, length) == 0;
}

void stp_text_rest(const stp_text_lines *lines, const char **begin, const char **end)
{
    *begin = lines->cursor;
    *end = lines->line_end;
    stp_trim(begin, end);
}

/* STL is written in either case. */
static bool token_is(const char *begin, const char *end, const char *word)
{
    const size_t length = strlen(word);
    return (size_t)(end - begin) == length && strncasecmp(begin, word, length) == 0;
}

static stp_status stl_vertex(stp_text_lines *lines, stp_error *err)
{
    static const char keyword[] = "v"; /* OpenMesh skips this word, whatever it is */
    double xyz[3];
    const char *rest = lines->cursor, *end, *begin;
    stp_status status = stp_text_numbers(lines, "vertex", xyz, 3, err);
    if (status != STP_OK)
        return status;
    for (int i = 0; i < 3; i++)
        if (!isfinite((float)xyz[i]))
            return stp_error_set(err, STP_CORRUPT,
                                 "%s: line %llu: a corner that is not finite cannot be merged with "
                                 "its neighbours: mend the mesh",
                                 lines->text->path, (unsigned long long)lines->line);
    lines->cursor = rest;
    stp_text_put(lines, keyword, keyword + 1, ' ');
    for (int i = 0; i < 3; i++) {
        begin = stp_text_next_token(lines, &end);
        stp_text_put(lines, begin, end, i < 2 ? ' ' : '\n');
    }
    return STP_OK;
}

stp_status stp_mesh_text_prepare_stl_ascii(stp_mesh_text *text, stp_error *err)
{
    stp_status status = STP_OK;
    stp_text_lines lines = stp_text_lines_begin(text);
    uint64_t facets = 0;
    int corners = 3;
    bool ended = false;
    while (stp_text_next_line(&lines)) {
        const char *end, *begin = stp_text_next_token(&lines, &end);
        const bool outer = begin && token_is(begin, end, "outer");
        const bool vertex = begin && token_is(begin, end, "vertex");
        ended = begin ? token_is(begin, end, "endsolid") : ended;
        if ((outer && corners < 3) || (vertex && corners == 3) || (ended && corners < 3)) {
            status = stp_error_set(err, STP_CORRUPT,
                                   "%s: line %llu: facet %llu does not have 3 corners: mend the "
                                   "mesh or export it again",
                                   text->path, (unsigned long long)lines.line,
                                   (unsigned long long)facets);
            goto done;
        }
        if (outer) {
            stp_text_put(&lines, begin, end, '\n');
            corners = 0;
            facets++;
        } else if (vertex) {
            STP_TRY(stl_vertex(&lines, err));
            corners++;
        }
    }
    if (!ended) {
        status =
            stp_error_set(err, STP_CORRUPT,
                          "%s: ends at line %llu after %llu facets without `endsolid`: the "
                          "file was cut; copy or export it again, or add that line if nothing "
                          "is missing",
                          text->path, (unsigned long long)lines.line, (unsigned long long)facets);
        goto done;
    }
    text->size = (size_t)(lines.out - text->data);
done:
    return status;
}

stp_status stp_mesh_text_check_stl_binary(const stp_mesh_text *text, stp_error *err)
{
    uint32_t count = 0;
    if (text->size >= STP_STL_HEADER_BYTES)
        memcpy(&count, text->data + STP_STL_HEADER_BYTES - sizeof count, sizeof count);
    const uint64_t needed = STP_STL_HEADER_BYTES + (uint64_t)count * STP_STL_FACET_BYTES;
    if (text->size < needed)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: binary STL of %u facets needs %llu bytes, but has %zu: the file "
                             "was cut; copy or export it again",
                             text->path, count, (unsigned long long)needed, text->size);
    for (uint32_t i = 0; i < count; i++) {
        float values[12];
        const size_t offset = STP_STL_HEADER_BYTES + (size_t)i * STP_STL_FACET_BYTES;
        memcpy(values, text->data + offset, sizeof values);
        for (int k = 3; k < 12; k++)
            if (!isfinite(values[k]))
                return stp_error_set(err, STP_CORRUPT,
                                     "%s: byte %zu: facet %u of %u has a corner that is not "
                                     "finite, which cannot be merged with its neighbours: mend the "
                                     "mesh",
                                     text->path, offset, i, count);
    }
    return STP_OK;
}
