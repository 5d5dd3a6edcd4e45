/* The image pyramid: what projection writes, pull and push fill, and shading reads.
 *
 * Level 0 has the viewport's size, level l ceil(size / 2^l). Each level has two RGBA32UI targets
 * (shape, paint: shaders/reconstruct/pixel.glsl), once as pulled and once as finished; level 0 is
 * finished only where its pixels are wanted, since the picture is made without. Threads: the
 * render thread. */
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
    int level_count; /* above level 0: all there can be, ceil(log2(max(width, height))) */
    stp_pyramid_level levels[STP_PYRAMID_LEVELS_LIMIT];
    /* The pulled levels from 1 on, of which those of a level are views: mip l - 1 is level l, and
     * may be larger than it. */
    GLuint pulled_above[STP_TARGET_COUNT];
    GLuint nearest, nearest_depth, nearest_frame; /* R32UI, 32-bit float depth */
    GLuint scatter_depth;      /* R32UI: the bits of nearest_depth where compute shaders project */
    GLuint sums[2], sum_frame; /* RGBA32F: what splats add up to (shaders/splat/splat_blend.frag) */
    /* RGBA8, premultiplied; of depths R32F, 0 where nothing is; of marks R8UI: what fade.frag
     * compares. A picture's frames: with depth, with depth and mark, its colour alone. */
    GLuint picture, picture_depth, picture_mark;
    GLuint picture_frames[STP_PICTURE_FRAMES];
    GLuint rough, rough_frames[STP_PICTURE_FRAMES]; /* where edge.frag reads: edges as they come */
    bool in_place; /* levels above 0 are finished in what they were pulled to: `finished` is idle */
} stp_pyramid;

/* What a level of the last frame was finished in, where it was. */
static inline const GLuint *stp_pyramid_finished(const stp_pyramid *pyramid, int l)
{
    const stp_pyramid_level *level = &pyramid->levels[l];
    return l > 0 && pyramid->in_place ? level->pulled : level->finished;
}

/* Makes the textures, or keeps them where the size is the same. Errors: GL (no memory). */
stp_status stp_pyramid_resize(stp_pyramid *pyramid, int width, int height, stp_error *err);
/* Makes what level 0 is finished in, where it is not there yet. Errors: GL (no memory). */
stp_status stp_pyramid_keep_level_0(stp_pyramid *pyramid, stp_error *err);
/* Makes what splats are added up in, where it is not there yet. Errors: GL (no memory). */
stp_status stp_pyramid_keep_sums(stp_pyramid *pyramid, stp_error *err);
/* Makes room for the picture before its edges are smoothed, where it is not there yet. Errors: GL
 * (no memory). */
stp_status stp_pyramid_keep_rough(stp_pyramid *pyramid, stp_error *err);
void stp_pyramid_destroy(stp_pyramid *pyramid);

#endif
