/* Reads back finished pixels of the pyramid, packed as in shaders/reconstruct/pixel.glsl.
 * Threads: functions without GL calls: any; others: the render thread, between stp_gl_state_enter
 * and leave. */
#ifndef STP_RUNTIME_DRAW_PIXEL_READ_H
#define STP_RUNTIME_DRAW_PIXEL_READ_H

#include "base/error.h"
#include "base/vec.h"
#include "runtime/draw/pyramid.h"
#include "runtime/gl/gpu_layout.h"

/* Whether a pixel's tag is that of a tube: its disc faces the eye, its direction is the tangent. */
static inline bool stp_tag_is_tube(int tag)
{
    return tag != 0 && ((tag - 1) & 3) == STP_KIND_TUBE;
}

/* The unit vector that stp_direction_pack of shaders/reconstruct/pixel.glsl packed. */
stp_dvec3 stp_direction_unpack(uint32_t code);
/* The normal of pixel (x, y) as it is seen, from its unpacked direction n. A two-sided normal is
 * turned to the eye; for a tube, n is the tangent and the result is across it. Eye space, unit. */
stp_dvec3 stp_pixel_normal(const stp_gpu_frame *frame, stp_dvec3 n, int tag, int x, int y);
/* Takes a place in eye space to world axes, relative to the eye. */
stp_dvec3 stp_place_to_world(const stp_gpu_frame *frame, stp_dvec3 place);
/* Takes a normal in eye space to world axes; unit. */
stp_dvec3 stp_normal_to_world(const stp_gpu_frame *frame, stp_dvec3 normal);
/* How many times as large a disc with this normal (world axes) is drawn: by its second moment. */
double stp_disc_stretch(const stp_gpu_frame *frame, stp_dvec3 normal);

/* Reads the normals from the paint texture of a level that has the frame's viewport: xyz in world
 * axes, bottom row first, turned to the viewer if two-sided; 0 0 0 where empty. Errors:
 * OUT_OF_MEMORY, GL. */
stp_status stp_pixel_read_normals(GLuint paint, const stp_gpu_frame *frame, float *xyz,
                                  stp_error *err);

#endif
