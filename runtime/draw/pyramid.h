/* The image pyramid: projection writes level 0, pull and push fill the levels, shading reads them.
 *
 * Level 0 has the size of the viewport, level l ceil(size / 2^l). Each level has two RGBA32UI
 * textures (shape, paint: shaders/reconstruct/pixel.glsl) for pulled pixels and two for finished
 * ones. Level 0 is finished only if its pixels are wanted: the picture does not need them. Threads:
 * the render thread. */
#ifndef STP_RUNTIME_DRAW_PYRAMID_H
#define STP_RUNTIME_DRAW_PYRAMID_H

#include "base/error.h"

#include <epoxy/gl.h>
#include <stdbool.h>

#define STP_PYRAMID_LEVELS_LIMIT 16
enum { STP_PICTURE_WITH_DEPTH, STP_PICTURE_WITH_MARK, STP_PICTURE_ALONE, STP_PICTURE_FRAMES };
enum { STP_TARGET_SHAPE, STP_TARGET_PAINT, STP_TARGET_COUNT };

typedef struct stp_pyramid_level {
    int width, height;
    GLuint pulled[STP_TARGET_COUNT], finished[STP_TARGET_COUNT]; /* textures */
    GLuint pulled_frame, finished_frame;                         /* framebuffers */
} stp_pyramid_level;

/* Zero is an empty pyramid. */
typedef struct stp_pyramid {
    int width, height;
    int level_count; /* greatest level above level 0: ceil(log2(max(width, height))) */
    stp_pyramid_level levels[STP_PYRAMID_LEVELS_LIMIT];
    /* The pulled levels from 1 on; the `pulled` textures of a level are views of these. Mip l - 1
     * is level l, and may be larger than the level. */
    GLuint pulled_above[STP_TARGET_COUNT];
    GLuint nearest, nearest_depth, nearest_frame; /* R32UI, 32-bit float depth */
    GLuint scatter_depth;      /* R32UI: the bits of nearest_depth if compute shaders project */
    GLuint sums[2], sum_frame; /* RGBA32F: the sums of splats (shaders/splat/splat_blend.frag) */
    /* picture: RGBA8, premultiplied. picture_depth: R32F, 0 where empty. picture_mark: R8UI, which
     * fade.frag compares. picture_frames: with depth; with depth and mark; colour alone. */
    GLuint picture, picture_depth, picture_mark;
    GLuint picture_frames[STP_PICTURE_FRAMES];
    GLuint rough, rough_frames[STP_PICTURE_FRAMES]; /* unsmoothed picture, read by edge.frag */
    GLuint picture_steps;                           /* RGBA32F: heights for contour.frag */
    bool in_place;   /* levels above 0 are finished in `pulled`; `finished` is unused */
    bool incomplete; /* the picture lacks blocks: coarser samples stand for them */
} stp_pyramid;

/* The textures that hold level l of the last frame as finished, if it was finished. */
static inline const GLuint *stp_pyramid_finished(const stp_pyramid *pyramid, int l)
{
    const stp_pyramid_level *level = &pyramid->levels[l];
    return l > 0 && pyramid->in_place ? level->pulled : level->finished;
}

/* Makes the textures, or keeps them if the size is unchanged. Errors: GL (no memory). */
stp_status stp_pyramid_resize(stp_pyramid *pyramid, int width, int height, stp_error *err);
/* Makes the textures of level 0 as finished, if missing. Errors: GL (no memory). */
stp_status stp_pyramid_keep_level_0(stp_pyramid *pyramid, stp_error *err);
/* Makes the textures of splats' sums, if missing. Errors: GL (no memory). */
stp_status stp_pyramid_keep_sums(stp_pyramid *pyramid, stp_error *err);
/* Makes the texture of the picture before its edges are smoothed, if missing. Errors: GL (no
 * memory). */
stp_status stp_pyramid_keep_rough(stp_pyramid *pyramid, stp_error *err);
/* Makes the texture of heights that contours are drawn from, if missing. Errors: GL (no memory). */
stp_status stp_pyramid_keep_steps(stp_pyramid *pyramid, stp_error *err);
void stp_pyramid_destroy(stp_pyramid *pyramid);

#endif
