/* Splatting (Botsch et al. 2005) without the rasteriser: bins of the picture have lists of the
 * splats that may cover a pixel of theirs, and each pixel looks at those
 * (shaders/splat/splat_bins.glsl). So ellipses may be as large as they like, and no sum depends on
 * the order of samples. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_SPLAT_H
#define STP_RUNTIME_DRAW_SPLAT_H

#include "runtime/cut/tiles.h"
#include "runtime/draw/pyramid.h"
#include "runtime/draw/runs.h"

typedef struct stp_splat_store {
    GLuint buffer, texture;
    GLenum format;
    size_t texel_bytes, bytes;
} stp_splat_store;

/* Zero is none. */
typedef struct stp_splat {
    GLuint list, scan, fronts, blends;  /* programs */
    stp_splat_store bins, lists, looks; /* grow, and are kept; looks: of each splat */
    GLuint levels_used;                 /* of the bins: bit set */
} stp_splat;

/* folder, defines: of the variant, as of stp_program_params. Errors: GL. */
stp_status stp_splat_create(stp_splat *out, const char *folder, const char *defines,
                            stp_error *err);
void stp_splat_destroy(stp_splat *splat);

/* Lists these samples for a picture of the pyramid's size; waits for the GPU to count them. Errors:
 * GL (no memory), LIMIT (more than buffers hold). */
stp_status stp_splat_list(stp_splat *splat, const stp_runs *runs, const stp_pyramid *pyramid,
                          stp_error *err);
/* Draw what was listed into the bound framebuffer: which are in front of each pixel (nearest_frame,
 * depth test on); what those in front add up to (sum_frame, adding). */
void stp_splat_draw_fronts(const stp_splat *splat, const stp_tiles *tiles);
void stp_splat_draw_blends(const stp_splat *splat, const stp_pyramid *pyramid,
                           const stp_tiles *tiles);

#endif
