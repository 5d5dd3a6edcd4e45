/* Assembles shader texts with includes, and makes programs from them. */
#include "runtime/gl/shader.h"

#include "base/file.h"
#include "base/memory.h"
#include "formats/chunk/sample/sample.h"
#include "runtime/gl/shader_trim.h"
#include "runtime/stipple.h"

#include <ctype.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define FILES_LIMIT 32
#define NAME_LIMIT 64
#define FILE_BYTES_LIMIT (1u << 20)

/* A text being assembled. Its files are numbered for #line and for the driver's messages. */
typedef struct assembly {
    char *text;
    size_t length, capacity;
    char files[FILES_LIMIT][NAME_LIMIT];
    int file_count;
    const char *folder;
} assembly;

static stp_status append(assembly *a, const char *text, size_t length, stp_error *err)
{
    stp_status status =
        stp_grow(&a->text, &a->capacity, a->length + length + 1, 1, "a shader", err);
    if (status != STP_OK)
        return status;
    memcpy(a->text + a->length, text, length);
    a->length += length;
    a->text[a->length] = '\0';
    return STP_OK;
}

static stp_status append_line_mark(assembly *a, int line, int file, stp_error *err)
{
    char mark[48];
    int length = snprintf(mark, sizeof mark, "#line %d %d\n", line, file);
    return append(a, mark, (size_t)length, err);
}

static const stp_shader_file *embedded_file(const char *name)
{
    for (const stp_shader_file *f = stp_shader_files; f->name != NULL; f++)
        if (strcmp(f->name, name) == 0)
            return f;
    return NULL;
}

static bool folder_has(const char *folder, const char *place, char *path, size_t size)
{
    return snprintf(path, size, "%s/%s", folder, place) < (int)size && access(path, R_OK) == 0;
}

/* Reads a file on disk; the caller frees *text. */
static stp_status read_file(char **text, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    int descriptor = -1;
    uint64_t size = 0;
    STP_TRY(stp_file_open(path, &descriptor, &size, err));
    if (size > FILE_BYTES_LIMIT) {
        status = stp_error_set(err, STP_LIMIT, "%s: too large for a shader (over 1 MiB)", path);
        goto done;
    }
    STP_TRY(stp_alloc(text, (size_t)size + 1, 1, "a shader", err));
    STP_TRY(stp_file_read_at(descriptor, path, 0, *text, (size_t)size, err));
done:
    if (descriptor >= 0)
        close(descriptor);
    return status;
}

/* Reads a shader file; the caller frees *text. A file in the folder replaces the embedded one:
 * first a file in the folder itself, then in the sub-folder where shaders/ has it. */
static stp_status read_text(char **text, const char *name, const char *folder, stp_error *err)
{
    const stp_shader_file *embedded = embedded_file(name);
    char path[4096];
    if (folder != NULL && (folder_has(folder, name, path, sizeof path) ||
                           (embedded && folder_has(folder, embedded->place, path, sizeof path))))
        return read_file(text, path, err);
    if (embedded == NULL)
        return stp_error_set(err, STP_NOT_FOUND, "there is no shader file %s", name);
    return stp_text_copy(text, embedded->text, "a shader", err);
}

/* Takes the name from a line #include "name"; false if the line is something else. */
static bool parse_include(const char *line, size_t length, char name[NAME_LIMIT])
{
    char begin[2 * NAME_LIMIT]; /* of this line alone: sscanf reads past a line's end */
    snprintf(begin, sizeof begin, "%.*s", (int)length, line);
    return sscanf(begin, " # include \"%63[^\"\n]\"", name) == 1;
}

static stp_status append_file(assembly *a, const char *name, stp_error *err)
{
    stp_status status = STP_OK;
    char *text = NULL;
    for (int i = 0; i < a->file_count; i++)
        if (strcmp(a->files[i], name) == 0)
            return STP_OK;
    if (a->file_count == FILES_LIMIT)
        return stp_error_set(err, STP_LIMIT, "%s: more than %d shader files in one program", name,
                             FILES_LIMIT);
    int file = a->file_count++;
    snprintf(a->files[file], NAME_LIMIT, "%s", name);
    STP_TRY(read_text(&text, name, a->folder, err));
    STP_TRY(append_line_mark(a, 1, file, err));
    int number = 1;
    for (const char *line = text; *line != '\0'; number++) {
        const char *end = strchr(line, '\n');
        size_t length = end != NULL ? (size_t)(end - line) + 1 : strlen(line);
        char included[NAME_LIMIT];
        if (parse_include(line, length, included)) {
            STP_TRY(append_file(a, included, err));
            STP_TRY(append_line_mark(a, number + 1, file, err));
        } else {
            STP_TRY(append(a, line, length, err));
        }
        line += length;
    }
    STP_TRY(append(a, "\n", 1, err));
done:
    free(text);
    return status;
}

static bool mentions(const char *text, const char *name)
{
    const char *at = text;
    size_t length = strlen(name);
    while ((at = strstr(at, name)) != NULL) {
        at += length;
        if (!isalnum((unsigned char)*at) && *at != '_')
            return true;
    }
    return false;
}

/* Appends the lines "#define NAME VALUE" that the text mentions. So a text that does not depend on
 * a macro is the same for all its values, and is found in the driver's cache. */
static stp_status append_defines(assembly *a, const char *defines, const char *text, stp_error *err)
{
    stp_status status = STP_OK;
    for (const char *line = defines; *line != '\0' && status == STP_OK;) {
        char name[NAME_LIMIT] = "";
        size_t length = strcspn(line, "\n");
        length += line[length] == '\n';
        if (sscanf(line, "#define %63[A-Za-z0-9_]", name) != 1 || mentions(text, name))
            status = append(a, line, length, err);
        line += length;
    }
    return status;
}

static stp_status assemble(assembly *a, const char *name, const char *defines, stp_error *err)
{
    static const char version[] = "#version 450 core\n";
    stp_status status = STP_OK;
    assembly body = {.folder = a->folder};
    STP_TRY(append_file(&body, name, err));
    stp_shader_trim(body.text);
    body.length = strlen(body.text);
    STP_TRY(append(a, version, sizeof version - 1, err));
    if (defines != NULL)
        STP_TRY(append_defines(a, defines, body.text, err));
    STP_TRY(append(a, body.text, body.length, err));
    memcpy(a->files, body.files, sizeof a->files);
    a->file_count = body.file_count;
done:
    free(body.text);
    return status;
}

stp_status stp_shader_text(char **out, const char *name, const char *defines, const char *folder,
                           stp_error *err)
{
    assembly a = {.folder = folder};
    stp_status status = assemble(&a, name, defines, err);
    if (status == STP_OK)
        *out = a.text;
    else
        free(a.text);
    return status;
}

/* Replaces file numbers by names. Drivers write "2:17(5): error" or "2(17) : error"; the first
 * number is the file's. */
static void name_file(const assembly *a, const char *log, char *out, size_t size)
{
    char *rest = NULL;
    long file = isdigit((unsigned char)*log) ? strtol(log, &rest, 10) : -1;
    const char *first_end = strchr(log, '\n');
    int length = first_end != NULL ? (int)(first_end - log) : (int)strlen(log);
    if (file < 0 || file >= a->file_count)
        snprintf(out, size, "%.*s", length, log);
    else
        snprintf(out, size, "%s%.*s", a->files[file], length - (int)(rest - log), rest);
}

static stp_status compile(GLuint *out, GLenum stage, const char *name,
                          const stp_program_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    assembly a = {.folder = params->folder};
    GLuint shader = 0;
    GLint compiled = 0;
    STP_TRY(assemble(&a, name, params->defines, err));
    shader = glCreateShader(stage);
    glShaderSource(shader, 1, (const GLchar *const *)&a.text, NULL);
    glCompileShader(shader);
    glGetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
    if (!compiled) {
        char log[1024] = "", named[512];
        glGetShaderInfoLog(shader, sizeof log, NULL, log);
        name_file(&a, log, named, sizeof named);
        status = stp_error_set(err, STP_GL, "shader %s does not compile: %s", name, named);
        goto done;
    }
    *out = shader;
    shader = 0;
done:
    glDeleteShader(shader);
    free(a.text);
    return status;
}

stp_status stp_program_create(GLuint *out, const stp_program_params *params, stp_error *err)
{
    const char *const names[4] = {params->vertex, params->geometry, params->fragment,
                                  params->compute};
    const GLenum stages[4] = {GL_VERTEX_SHADER, GL_GEOMETRY_SHADER, GL_FRAGMENT_SHADER,
                              GL_COMPUTE_SHADER};
    const char *first = params->compute != NULL ? params->compute : params->vertex;
    const char *last = params->fragment != NULL ? params->fragment : params->geometry;
    stp_status status = STP_OK;
    GLint linked = 0;
    GLuint program = glCreateProgram();
    for (int i = 0; i < 4; i++) {
        GLuint shader = 0;
        if (names[i] == NULL)
            continue;
        STP_TRY(compile(&shader, stages[i], names[i], params, err));
        glAttachShader(program, shader);
        glDeleteShader(shader); /* the shader lives as long as the program */
    }
    if (params->captured != NULL)
        glTransformFeedbackVaryings(program, 1, &params->captured, GL_INTERLEAVED_ATTRIBS);
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    if (!linked) {
        char log[512] = "";
        glGetProgramInfoLog(program, sizeof log, NULL, log);
        log[strcspn(log, "\n")] = '\0';
        status = stp_error_set(err, STP_GL, "shaders %s and %s do not link: %s", first,
                               last != NULL ? last : first, log);
        goto done;
    }
    *out = program;
    program = 0;
done:
    glDeleteProgram(program);
    return status;
}

void stp_variant_defines(const stp_variant *v, char out[STP_VARIANT_DEFINES_BYTES])
{
    snprintf(out, STP_VARIANT_DEFINES_BYTES,
             "#define STP_ORTHOGRAPHIC %d\n#define STP_BOX %d\n"
             "#define STP_COLOUR %d\n#define STP_PALETTE %d\n#define STP_SHADE %d\n"
             "#define STP_INVOCATIONS %d\n#define STP_SHARE %d\n"
             "#define STP_CLIP %d\n#define STP_PLANES %d\n#define STP_HIDE_CLASSES %d\n#define "
             "STP_OVERLAY %d\n#define STP_CHOSEN %d\n#define STP_GRID %d\n"
             "#define STP_CONTOURS %d\n#define STP_HEIGHTS %d\n"
             "#define STP_EXAGGERATED %d\n#define STP_FADE %d\n"
             "#define STP_TEMPLATE %d\n#define STP_SPLAT %d\n"
             "#define STP_LINES %d\n#define STP_TRIANGLES %d\n#define STP_SQUARES %d\n"
             "#define STP_MAPS %d\n#define STP_OPENINGS %d\n",
             v->orthographic, v->box, v->colour, v->palette, v->shade, v->geometry_invocations,
             STP_PATCH_SAMPLES / v->geometry_invocations, v->clip, v->planes, v->classes,
             v->overlay, v->chosen, v->grid, v->contours,
             v->contours || v->colour == STP_COLOUR_ELEVATION, v->exaggerated, v->fade,
             v->template_px, v->splat, v->lines, v->triangles, v->squares, v->maps, v->openings);
}

bool stp_variant_equal(const stp_variant *a, const stp_variant *b)
{
    return a->orthographic == b->orthographic && a->box == b->box &&
           a->template_px == b->template_px && a->splat == b->splat && a->lines == b->lines &&
           a->triangles == b->triangles && a->squares == b->squares && a->maps == b->maps &&
           a->openings == b->openings && a->clip == b->clip && a->planes == b->planes &&
           a->classes == b->classes && a->chosen == b->chosen && a->grid == b->grid &&
           a->overlay == b->overlay && a->edl == b->edl && a->edges == b->edges &&
           a->contours == b->contours && a->exaggerated == b->exaggerated &&
           a->colour == b->colour && a->palette == b->palette && a->shade == b->shade &&
           a->geometry_invocations == b->geometry_invocations && a->fade == b->fade;
}
