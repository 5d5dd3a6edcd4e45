/* Draws the exact picture of the bumpy sphere: rays against the analytic surface.
 *
 * Lambert shading: colour * (0.05 + 0.85 max(0, n.d)), d pointing back along the camera's axis, no
 * gamma. Pixels that hit nothing are black with alpha 0. One ray through each pixel's middle. */
#ifndef STP_TOOLS_GEN_TRUTH_H
#define STP_TOOLS_GEN_TRUTH_H

#include "base/vec.h"
#include "formats/image/image.h"
#include "runtime/camera/camera.h"
#include "tools/gen/surface.h"

/* A camera that sees the whole ball of the surface from +z, up +y. */
stp_camera gen_truth_camera(const gen_surface *surface, const int size[2]);
/* Errors: OUT_OF_MEMORY. Destroy *image with stp_image_destroy. */
stp_status gen_truth_render(stp_image *image, const gen_surface *surface, const stp_view *view,
                            stp_pool *pool, stp_error *err);

#endif
