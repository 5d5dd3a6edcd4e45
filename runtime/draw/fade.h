/* Fades level changes instead of letting them pop.
 *
 * A picture marks each pixel with the level of its surface. If the last frame showed the surface at
 * another level, the pixel keeps the difference from what was shown, and loses a share of the
 * difference every frame. The rest of the picture stays sharp. shaders/README.md, "Fading".
 * Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_FADE_H
#define STP_RUNTIME_DRAW_FADE_H

#include "runtime/cut/tiles.h"
#include "runtime/draw/pyramid.h"
#include "runtime/gl/gpu_layout.h"

#include "base/vec.h"

#include <stdbool.h>

/* picture, depth, mark, difference */
enum { STP_FADE_TARGETS = 4 };

/* Zero: there is no last frame. */
typedef struct stp_fade {
    int width, height;
    GLuint textures[2][STP_FADE_TARGETS], frames[2];
    int now; /* which of the two belongs to the last frame */
    bool known;
    stp_gpu_frame frame; /* of the last frame */
    stp_dvec3 eye;
    int left; /* frames until no difference is left */
} stp_fade;

void stp_fade_destroy(stp_fade *fade);

/* Forgets the last frame: nothing fades from it. */
void stp_fade_forget(stp_fade *fade);

/* Fades the pyramid's picture. program: of fade.frag; kept: the share of a difference that each
 * frame keeps, in (0, 1); changes: something may be drawn at another level than in the last frame.
 * Errors: GL (no memory). */
stp_status stp_fade_apply(stp_fade *fade, GLuint program, const stp_pyramid *pyramid,
                          const stp_tiles *tiles, const stp_gpu_frame *frame, stp_dvec3 eye,
                          double kept, bool changes, stp_error *err);

#endif
