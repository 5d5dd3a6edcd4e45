/* Shaders: their texts, compiled into the program or read from a folder, and programs made of them.
 *
 * A text may say #include "name.glsl"; each file is taken once. Compile errors name file and line.
 * Threads: the render thread, with a current context. */
#ifndef STP_RUNTIME_GL_SHADER_H
#define STP_RUNTIME_GL_SHADER_H

#include "base/error.h"

#include <epoxy/gl.h>
#include <stdbool.h>

typedef struct stp_shader_file {
    const char *name;  /* unique among all files */
    const char *place; /* path within shaders/: "splat/splat.comp" */
    const char *text;
} stp_shader_file;

/* The embedded files; the name of the last entry is NULL. */
extern const stp_shader_file stp_shader_files[];

/* What a program is compiled for. */
typedef struct stp_variant {
    bool orthographic, box;
    int template_px;     /* side of the window if templates reconstruct; else 0 */
    bool splat;          /* samples are drawn as splats */
    bool lines;          /* the scene has ribbons or tubes */
    bool triangles;      /* the scene has triangles */
    bool squares;        /* for programs that draw squares of grids as triangles */
    int maps;            /* if maps are drawn as splats: stp_maps_as, else 0 */
    bool openings;       /* closed surfaces have openings */
    bool clip, classes;  /* there is a clip box; there are hidden classes */
    bool chosen;         /* some samples are marked as not drawn */
    int grid;            /* 1: all models are grids of heights; 2: whose holes may only grow */
    int planes;          /* how many planes clip */
    bool overlay;        /* an overlay is mixed into the samples' colours */
    bool contours;       /* lines of equal height */
    bool exaggerated;    /* heights are drawn higher or lower */
    bool edges;          /* smooths edges by a pass with a program of its own; no macro */
    bool edl;            /* eye-dome lighting by a pass with a program of its own; no macro */
    int colour, palette; /* stp_colour, stp_palette but OWN */
    int shade;           /* STP_SHADE_* */
    int geometry_invocations;
    bool fade; /* marks pixels by level, and has the program of fade.frag */
} stp_variant;

#define STP_VARIANT_DEFINES_BYTES 768

/* The variant as lines for stp_program_params.defines. */
void stp_variant_defines(const stp_variant *variant, char out[STP_VARIANT_DEFINES_BYTES]);
bool stp_variant_equal(const stp_variant *a, const stp_variant *b);

typedef struct stp_program_params {
    const char *vertex, *geometry, *fragment, *compute; /* file names; NULL: no such stage */
    const char *defines;  /* lines before the text, if it mentions their names; may be NULL */
    const char *folder;   /* files here replace the embedded ones; may be NULL */
    const char *captured; /* a varying for transform feedback; may be NULL */
} stp_program_params;

/* The text of a file with its includes, as GLSL 4.50 core, without what it does not use
 * (shader_trim.h); release it with free(). Errors: NOT_FOUND (a file, or one that it includes), IO
 * (a file of the folder cannot be read), CORRUPT (it became shorter meanwhile), LIMIT (more than 32
 * files; one of over 1 MiB), OUT_OF_MEMORY. */
stp_status stp_shader_text(char **out, const char *name, const char *defines, const char *folder,
                           stp_error *err);

/* Compiles and links. Errors: those of stp_shader_text; GL (file, line and the driver's
 * message). */
stp_status stp_program_create(GLuint *out, const stp_program_params *params, stp_error *err);

#endif
