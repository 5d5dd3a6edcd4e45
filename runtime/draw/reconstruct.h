/* From the nearest samples to the picture: resolve, pull, push, shade (shaders/README.md).
 * Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_RECONSTRUCT_H
#define STP_RUNTIME_DRAW_RECONSTRUCT_H

#include "runtime/cut/tiles.h"
#include "runtime/draw/blocks.h"
#include "runtime/draw/pyramid.h"
#include "runtime/draw/stage_clock.h"
#include "runtime/gl/shader.h"

#include <stdbool.h>

typedef struct stp_reconstruct_programs {
    GLuint resolve, pull, push, finish, shade;
    GLuint edl, fade, edge; /* 0: not asked for; where fade is, pictures are marked for it */
    /* By compute shaders, once prepared: */
    GLuint pull_pairs, push_columns, finish_columns;
    int template_px; /* of the variant; with it, and with splats, level 0 is always finished */
    bool splat;
} stp_reconstruct_programs;

/* folder: shader files that win over the embedded ones, or NULL. Errors: GL. */
stp_status stp_reconstruct_create(stp_reconstruct_programs *out, const char *folder,
                                  const stp_variant *variant, stp_error *err);
/* Compiles the programs that pull, push and finish by compute shaders, where they are not there
 * yet. Errors: GL. */
stp_status stp_reconstruct_prepare_compute(stp_reconstruct_programs *programs, const char *folder,
                                           const stp_variant *variant, stp_error *err);
/* Whether a variant's pixels are pushed at all, so that compute shaders can do it. */
bool stp_reconstruct_pushes(const stp_reconstruct_programs *programs, int levels);
void stp_reconstruct_destroy(stp_reconstruct_programs *programs);

/* Nearest samples to level 0 as pulled. The first pass of a frame empties what it does not cover;
 * later ones leave it. Ends with the depth test off. All passes draw the tiles alone. */
void stp_reconstruct_resolve(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                             const stp_tiles *tiles, bool first);
/* Whether level 0 has pixels beside the pulled ones. */
bool stp_reconstruct_finishes(const stp_reconstruct_programs *programs, int levels);
/* Fills levels 1..levels as pulled, then levels - 1..1 as finished; with templates none of these.
 * clock: of a frame that is timed, or NULL; its stages have begun.
 * blocks: NULL, or those of levels 0..levels where the pyramid is finished in place: compute
 * shaders pull, two levels at once, and push then. */
void stp_reconstruct_pull_push(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                               int levels, const stp_tiles *tiles, const stp_blocks *blocks,
                               stp_stage_clock *clock);
/* Finishes level 0, where it is to be, shades it, and adds eye-dome lighting where the variant has
 * it: the pyramid's picture. clock: as there. */
void stp_reconstruct_finish(const stp_reconstruct_programs *programs, const stp_pyramid *pyramid,
                            int levels, const stp_tiles *tiles, const stp_blocks *blocks,
                            stp_stage_clock *clock);
/* Level 0 as finished, for who wants its pixels: a picture does without. Only where it is finished
 * at all. */
void stp_reconstruct_keep_level_0(const stp_reconstruct_programs *programs,
                                  const stp_pyramid *pyramid, int levels, const stp_tiles *tiles);
/* The same for one pixel. Takes what is bound and enabled as after a frame; leaves the rest of
 * level 0 as it is. */
void stp_reconstruct_keep_pixel(const stp_reconstruct_programs *programs,
                                const stp_pyramid *pyramid, int levels, const stp_tiles *tiles,
                                int x, int y);

#endif
