/* Splatting (Botsch et al. 2005) without the rasteriser. The picture is divided into bins. Each bin
 * lists the splats that may cover one of its pixels, and each pixel looks at the lists of its bins
 * (shaders/splat/splat_bins.glsl). So ellipses may have any size, and sums do not depend on the
 * order of samples. Threads: the render thread. */
#ifndef STP_RUNTIME_DRAW_SPLAT_H
#define STP_RUNTIME_DRAW_SPLAT_H

#include "runtime/cut/tiles.h"
#include "runtime/draw/pyramid.h"
#include "runtime/draw/runs.h"
#include "runtime/stream/cache/range_pool.h"

typedef struct stp_splat_store {
    GLuint buffer, texture;
    GLenum format;
    size_t texel_bytes, bytes;
} stp_splat_store;

/* Zero: none. */
typedef struct stp_splat {
    stp_each list;                      /* of samples in runs */
    GLuint list_squares;                /* of maps */
    GLuint scan, fronts, blends;        /* programs */
    stp_splat_store bins, lists, looks; /* grow and are reused; looks: of each splat */
    GLuint levels_used;                 /* bit set of the bins' levels in use */
} stp_splat;

/* For samples in runs, or for maps. folder, defines: of the variant, as in stp_program_params.
 * Errors: GL. */
stp_status stp_splat_create(stp_splat *out, bool maps, const char *folder, const char *defines,
                            stp_error *err);
void stp_splat_destroy(stp_splat *splat);

/* Lists the samples of `runs` for a picture of the pyramid's size. Waits for the GPU to count them.
 * Errors: GL (no memory), LIMIT (more than buffers hold). */
stp_status stp_splat_list(stp_splat *splat, const stp_runs *runs, const stp_pyramid *pyramid,
                          stp_error *err);
/* The same for squares of maps: numbers among those drawn. */
stp_status stp_splat_list_squares(stp_splat *splat, stp_range squares, const stp_pyramid *pyramid,
                                  stp_error *err);
/* Draw the listed splats into the bound framebuffer. Fronts: the front of each pixel
 * (nearest_frame, depth test on). Blends: the sums of the splats at the front (sum_frame, additive
 * blending). */
void stp_splat_draw_fronts(const stp_splat *splat, const stp_tiles *tiles);
void stp_splat_draw_blends(const stp_splat *splat, const stp_pyramid *pyramid,
                           const stp_tiles *tiles);
/* Makes a program with splat_gather.glsl read the lists. */
void stp_splat_bind(const stp_splat *splat, GLuint program);

#endif
