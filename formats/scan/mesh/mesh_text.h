/* Mesh files made ready for OpenMesh: checked line by line, and reduced to what its readers get
 * right.
 *
 * OpenMesh 9 reads coordinates through float, skips lines it cannot read (which shifts every later
 * index), believes the counts of OFF without looking at the file's end, stumbles over OFF comments,
 * OBJ line continuations and one-dimensional texture coordinates. So the file is read here first:
 * faults are named with their line, coordinates are kept in full precision, colours are taken, and
 * the text is rewritten in place with nothing but vertices, faces and the normals of OBJ. STL
 * coordinates are floats by definition. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_MESH_MESH_TEXT_H
#define STP_FORMATS_SCAN_MESH_MESH_TEXT_H

#include "base/error.h"
#include "formats/scan/mesh/point_mesh.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_mesh_text {
    char *memory;     /* owns */
    char *data;       /* what OpenMesh shall read, inside memory */
    size_t size;      /* its bytes */
    const char *path; /* borrowed; for messages */
} stp_mesh_text;

/* The whole file into memory. Errors: NOT_FOUND, IO, OUT_OF_MEMORY. */
stp_status stp_mesh_text_load(stp_mesh_text *out, const char *path, stp_error *err);
void stp_mesh_text_free(stp_mesh_text *text);

/* Each adds the points it finds to mesh (STL: none, OpenMesh merges them first) and leaves in
 * text->data what OpenMesh shall read. Errors: CORRUPT (with the line), UNSUPPORTED, OUT_OF_MEMORY,
 * LIMIT. */
stp_status stp_mesh_text_prepare_obj(stp_mesh_text *text, stp_point_mesh *mesh, stp_error *err);
stp_status stp_mesh_text_prepare_off(stp_mesh_text *text, stp_point_mesh *mesh, stp_error *err);
stp_status stp_mesh_text_prepare_stl_ascii(stp_mesh_text *text, stp_error *err);
/* Checks the count against the size and that coordinates are finite. */
stp_status stp_mesh_text_check_stl_binary(const stp_mesh_text *text, stp_error *err);

/* Colours of the first vertices, by their number, until it is known what their values mean. */
typedef struct stp_text_colours {
    float (*values)[3];
    size_t count, capacity;
    double maximum;
} stp_text_colours;

/* Vertices in between without a colour are black; values that are no colours are clamped. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_text_colours_add(stp_text_colours *colours, size_t vertex, const double rgb[3],
                                stp_error *err);
/* Gives the mesh its colours, if there are any: fractions, unless one exceeds 1; then all are
 * 0..255. */
void stp_text_colours_apply(const stp_text_colours *colours, stp_point_mesh *mesh);
void stp_text_colours_free(stp_text_colours *colours);

/* For mesh_text.c and its parts by format: lines one after the other, joined and written in place.
 */
typedef struct stp_text_lines {
    const stp_mesh_text *text;
    char *at, *end;     /* unread */
    char *out;          /* next byte to write, never beyond the line being read */
    uint64_t line;      /* its number */
    const char *cursor; /* rest of the line */
    const char *line_end;
} stp_text_lines;

stp_text_lines stp_text_lines_begin(const stp_mesh_text *text);
/* False at the end. */
bool stp_text_next_line(stp_text_lines *lines);
/* Next token of the line: its begin, and *end behind it; NULL if none is left. */
const char *stp_text_next_token(stp_text_lines *lines, const char **end);
/* The next count numbers of the line. Errors: CORRUPT. `what` names the line in the message. */
stp_status stp_text_numbers(stp_text_lines *lines, const char *what, double *values, size_t count,
                            stp_error *err);
/* Writes a token and the character that follows it. */
void stp_text_put(stp_text_lines *lines, const char *begin, const char *end, char after);

#endif
