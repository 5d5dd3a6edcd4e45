/* What was drawn, as files: pictures, and depths and normals as EXR. Threads: the main thread only.
 */
#ifndef STP_TOOLS_DRAW_SAVE_H
#define STP_TOOLS_DRAW_SAVE_H

#include "runtime/stipple.h"

/* What is wanted of a frame; NULL: not. */
typedef struct draw_outputs {
    const char *picture, *depth, *normals;
} draw_outputs;

/* The last picture of a view, top row first, width * height * 4 bytes. Errors: GL, OUT_OF_MEMORY.
 */
stp_status draw_read_picture(stp_renderer *renderer, const stp_view *view, uint8_t *rgba,
                             stp_error *err);

/* Writes what is wanted of the last picture, the picture last; normals ask for one drawn with
 * keep_pixels. Depth: channel Z, along the camera's axis in world units, +inf where nothing is, so
 * that merging layers by the nearest needs no mask. Normals: channels N.X N.Y N.Z in the world's
 * axes, 0 0 0 where nothing is. Both note the camera as --camera reads it. Errors: those of
 * stp_image_save and stp_image_save_floats, GL, OUT_OF_MEMORY. */
stp_status draw_save(stp_renderer *renderer, const stp_view *view, const stp_camera *camera,
                     const draw_outputs *outputs, bool force, stp_error *err);

#endif
