/* The exact picture of the bumpy sphere: rays against the analytic surface.
 *
 * Lambert shading: colour * (0.05 + 0.85 max(0, n.d)) with d pointing back along the camera's axis,
 * no gamma; black with alpha 0 where nothing is hit. One ray through each pixel's middle. */
#ifndef STP_TOOLS_GEN_TRUTH_H
#define STP_TOOLS_GEN_TRUTH_H

#include "formats/image/image.h"
#include "tools/gen/surface.h"

typedef struct gen_camera {
    double eye[3], look[3], up[3];
    double fovy_deg;
    int size[2]; /* width, height */
} gen_camera;

/* All of the surface's ball in view from +z, up +y, 45 degrees, 1024 x 1024. */
void gen_camera_default(gen_camera *camera, const gen_surface *surface);
/* Replaces what a JSON file gives: eye, look, up, fovy_deg, size. Errors: NOT_FOUND, IO, CORRUPT.
 */
stp_status gen_camera_load(gen_camera *camera, const char *path, stp_error *err);
/* Errors: INVALID_ARGUMENT (eye at look, up along the view, angle out of range), OUT_OF_MEMORY.
 * *image is to be destroyed with stp_image_destroy. */
stp_status gen_truth_render(stp_image *image, const gen_surface *surface, const gen_camera *camera,
                            stp_pool *pool, stp_error *err);

#endif
