/* Turns nearest samples into the picture: resolve, pull, push, shade (shaders/README.md).
 * Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_RECONSTRUCT_H
#define STP_RUNTIME_DRAW_RECONSTRUCT_H

#include "runtime/cut/tiles.h"
#include "runtime/draw/pixel_blocks.h"
#include "runtime/draw/pyramid.h"
#include "runtime/draw/stage_clock.h"
#include "runtime/gl/shader.h"

#include <stdbool.h>

typedef struct stp_reconstruct_programs {
    GLuint resolve, pull, push, finish, shade;
    GLuint edl, fade, edge,
        contour; /* 0: not asked for. If fade is there, pictures are marked for it */
    /* Compute shaders, once prepared: */
    GLuint pull_pairs, push_columns, finish_columns;
    int template_px; /* of the variant. With templates and splats, level 0 is always finished */
    bool splat;
} stp_reconstruct_programs;

/* folder: shader files here replace the embedded ones; may be NULL. Errors: GL. */
stp_status stp_reconstruct_create(stp_reconstruct_programs *out, const char *folder,
                                  const stp_variant *variant, stp_error *err);
/* Compiles the compute shaders that pull, push and finish, if they are not there yet. Errors:
 * GL. */
stp_status stp_reconstruct_prepare_compute(stp_reconstruct_programs *programs, const char *folder,
                                           const stp_variant *variant, stp_error *err);
/* Whether a variant pushes pixels at all; if so, compute shaders can push. */
bool stp_reconstruct_pushes(const stp_reconstruct_programs *programs, int levels);
void stp_reconstruct_destroy(stp_reconstruct_programs *programs);

/* Turns nearest samples into level 0 as pulled, by the program `resolve`, or one for squares of
 * grids, which leaves all other pixels. The first pass of a frame empties the pixels that it does
 * not cover; later passes leave them. where: GL_ALWAYS, or only pixels whose rasterised depth is 0
 * (GL_EQUAL) or is not (GL_NOTEQUAL): a software driver then skips the others. Leaves the depth
 * test off. All passes draw tiles only. */
void stp_reconstruct_resolve(GLuint program, const stp_pyramid *pyramid, const stp_tiles *tiles,
                             bool first, GLenum where);
/* Whether level 0 has finished pixels besides the pulled ones. */
bool stp_reconstruct_finishes(const stp_reconstruct_programs *programs, int levels);
/* Fills levels 1..levels as pulled, then levels - 1..1 as finished (with templates none of these).
 * clock: of a timed frame whose stage has begun, or NULL.
 * blocks: of levels 0..levels if the pyramid is finished in place; then compute shaders pull, two
 * levels at once, and push. Otherwise NULL. */
void stp_reconstruct_pull_push(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                               int levels, const stp_tiles *tiles, const stp_pixel_blocks *blocks,
                               stp_stage_clock *clock);
/* Makes the pyramid's picture: finishes level 0 if needed, shades it, and adds contours and
 * eye-dome lighting if the variant has them, and smooth edges if it has them and `smooth` is set.
 * clock: as in stp_reconstruct_pull_push. */
void stp_reconstruct_finish(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                            int levels, const stp_tiles *tiles, const stp_pixel_blocks *blocks,
                            bool smooth, stp_stage_clock *clock);
/* Writes level 0 as finished, for readers of its pixels; the picture does not need it. Call only if
 * stp_reconstruct_finishes. */
void stp_reconstruct_keep_level_0(const stp_reconstruct_programs *programs,
                                  const stp_pyramid *pyramid, int levels, const stp_tiles *tiles);
/* The same for one pixel; leaves the rest of level 0 as it is. Expects the bindings and enables
 * that a frame leaves. */
void stp_reconstruct_keep_pixel(const stp_reconstruct_programs *programs,
                                const stp_pyramid *pyramid, int levels, const stp_tiles *tiles,
                                int x, int y);

#endif
