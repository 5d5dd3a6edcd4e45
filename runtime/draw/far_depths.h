/* Finds what a finished picture hides, on the GPU, and reads it back without waiting
 * ("Occlusion" in shaders/README.md). Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_FAR_DEPTHS_H
#define STP_RUNTIME_DRAW_FAR_DEPTHS_H

#include "runtime/cut/occlusion.h"
#include "runtime/draw/pyramid.h"
#include "runtime/gl/shader.h"

/* Zero is none. */
typedef struct stp_far_depths {
    int width, height;   /* of the pictures */
    GLuint level, cells; /* programs */
    /* R32F. [0]: by cell of the picture; [l]: by pixel of level l. */
    GLuint textures[STP_PYRAMID_LEVELS_LIMIT];
    GLuint buffer; /* the cells on their way back */
    GLsync fence;  /* NULL: none are on their way */
    stp_gpu_frame frame;
    stp_dvec3 eye;
} stp_far_depths;

/* Begins to read what the picture in the pyramid hides, in place of what is on its way. levels: as
 * for stp_reconstruct_finish. Errors: GL. */
stp_status stp_far_depths_begin(stp_far_depths *f, const stp_pyramid *p, int levels,
                                const stp_gpu_frame *frame, stp_dvec3 eye,
                                const stp_variant *variant, const char *folder, stp_error *err);
/* Takes what was read; *taken is false if nothing is there yet. waits: until it is. Errors:
 * OUT_OF_MEMORY, GL. */
stp_status stp_far_depths_take(stp_far_depths *f, bool waits, stp_occlusion *out, bool *taken,
                               stp_error *err);
/* Forgets what is on its way. */
void stp_far_depths_forget(stp_far_depths *f);
void stp_far_depths_destroy(stp_far_depths *f);

#endif
