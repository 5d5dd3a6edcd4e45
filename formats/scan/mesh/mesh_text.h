/* Checks mesh files line by line and rewrites them to what OpenMesh reads correctly.
 *
 * OpenMesh 9 reads coordinates through float, skips lines that it cannot read (which shifts every
 * later index), believes the counts of OFF beyond the file's end, and stumbles over OFF comments,
 * OBJ line continuations and one-dimensional texture coordinates. So this code reads the file
 * first. It names faults with their line, keeps coordinates in full precision, takes the colours,
 * and rewrites the text in place with only vertices, faces and the normals of OBJ. STL coordinates
 * are floats by definition. Threads: one at a time. */
#ifndef STP_FORMATS_SCAN_MESH_MESH_TEXT_H
#define STP_FORMATS_SCAN_MESH_MESH_TEXT_H

#include "base/error.h"
#include "formats/scan/mesh/point_mesh.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_mesh_text {
    char *memory;     /* owns */
    char *data;       /* the text for OpenMesh, inside memory */
    size_t size;      /* bytes of data */
    const char *path; /* borrowed; for messages */
} stp_mesh_text;

/* Loads the whole file. Errors: NOT_FOUND, IO, OUT_OF_MEMORY. */
stp_status stp_mesh_text_load(stp_mesh_text *out, const char *path, stp_error *err);
void stp_mesh_text_free(stp_mesh_text *text);

/* Each adds the points that it finds to mesh and leaves the text for OpenMesh in text->data. The
 * STL one adds none: OpenMesh merges STL points first. Errors: CORRUPT (with the line),
 * UNSUPPORTED, OUT_OF_MEMORY, LIMIT. */
stp_status stp_mesh_text_prepare_obj(stp_mesh_text *text, stp_point_mesh *mesh, stp_error *err);
stp_status stp_mesh_text_prepare_off(stp_mesh_text *text, stp_point_mesh *mesh, stp_error *err);
stp_status stp_mesh_text_prepare_stl_ascii(stp_mesh_text *text, stp_error *err);
/* Checks the count against the size and that coordinates are finite. */
stp_status stp_mesh_text_check_stl_binary(const stp_mesh_text *text, stp_error *err);

/* Colours by vertex number, until the range of their values is known. */
typedef struct stp_text_colours {
    float (*values)[4];
    size_t count, capacity;
    bool first_differs, fourth_differs; /* from 1, for some vertex of four numbers */
} stp_text_colours;

/* Takes the 3 or 4 numbers behind a position: r g b, r g b a or w r g b. Skipped vertices become
 * black. Values out of range are clamped. Errors: OUT_OF_MEMORY. */
stp_status stp_text_colours_add(stp_text_colours *colours, size_t vertex, const double *numbers,
                                size_t count, stp_error *err);
/* Gives the mesh its colours, if there are any that are not black. Of four numbers the first is w
 * if it is 1 for all vertices, and the fourth is not. Values are fractions; if one exceeds
 * STP_COLOUR_OVERSHOOT, all are 0..255. */
void stp_text_colours_apply(const stp_text_colours *colours, stp_point_mesh *mesh);
void stp_text_colours_free(stp_text_colours *colours);

/* For mesh_text.c and its parts per format: reads lines one after the other, joins continued ones
 * and rewrites them in place. */
typedef struct stp_text_lines {
    const stp_mesh_text *text;
    char *at, *end;     /* unread */
    char *out;          /* next byte to write, never beyond the line that is being read */
    uint64_t line;      /* its number */
    const char *cursor; /* unread part of the line */
    const char *line_end;
} stp_text_lines;

stp_text_lines stp_text_lines_begin(const stp_mesh_text *text);
/* False at the end. */
bool stp_text_next_line(stp_text_lines *lines);
/* Returns the begin of the line's next token and sets *end to its end; NULL if none is left. */
const char *stp_text_next_token(stp_text_lines *lines, const char **end);
/* Whether a token is the word. */
bool stp_text_token_is(const char *begin, const char *end, const char *word);
/* The unread part of the line, without spaces around it: names may have spaces inside. */
void stp_text_rest(const stp_text_lines *lines, const char **begin, const char **end);
/* Reads the next count numbers of the line. `what` names the line in the message. Errors: CORRUPT.
 */
stp_status stp_text_numbers(stp_text_lines *lines, const char *what, double *values, size_t count,
                            stp_error *err);
/* Writes a token and the character that follows it. */
void stp_text_put(stp_text_lines *lines, const char *begin, const char *end, char after);

#endif
