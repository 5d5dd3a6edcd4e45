/* Saves what was drawn: pictures, and depths and normals as EXR. Threads: the main thread only. */
#ifndef STP_TOOLS_DRAW_DRAW_SAVE_H
#define STP_TOOLS_DRAW_DRAW_SAVE_H

#include "runtime/stipple.h"

/* The files to write for a frame; NULL: not wanted. */
typedef struct draw_outputs {
    const char *picture, *depth, *normals;
} draw_outputs;

/* A picture as --aa asks for it. If --aa draws finer pictures (draw_aa_times), the pixels are here
 * and must be freed; else the renderer has them. */
typedef struct draw_picture {
    int aa;
    uint8_t *fine;
    uint8_t *right; /* another picture, of which the right half is shown (draw_beside_put); NULL */
} draw_picture;

/* Draws a view. whole: the renderer's own last picture must be the whole view, too. Errors: those
 * of stp_renderer_draw and draw_fine. */
stp_status draw_picture_draw(draw_picture *picture, stp_renderer *renderer, const stp_view *view,
                             const stp_draw_params *params, bool whole, stp_draw_stats *stats,
                             stp_error *err);
/* Reads what was drawn: top row first, premultiplied, width * height * 4 bytes. Errors: GL,
 * OUT_OF_MEMORY. */
stp_status draw_picture_read(const draw_picture *picture, stp_renderer *renderer,
                             const stp_view *view, uint8_t *rgba, stp_error *err);

/* Writes the wanted files, the picture last. Depths and normals come from the renderer's last
 * picture; for normals it must have been drawn with keep_pixels. Depth: channel Z, along the
 * camera's axis in world units, +inf where nothing is, so that merging layers by the nearest needs
 * no mask. Normals: channels N.X N.Y N.Z in the world's axes, 0 0 0 where nothing is. Both files
 * store the camera as --camera reads it. Errors: those of stp_image_save and stp_image_save_floats,
 * GL, OUT_OF_MEMORY. */
stp_status draw_save(const draw_picture *picture, stp_renderer *renderer, const stp_view *view,
                     const stp_camera *camera, const draw_outputs *outputs, bool force,
                     stp_error *err);

#endif
