/* Finished pixels of the pyramid read back: packed as in shaders/reconstruct/pixel.glsl.
 * Threads: the render thread, between stp_gl_state_enter and leave; of what calls no GL, any. */
#ifndef STP_RUNTIME_DRAW_PIXEL_READ_H
#define STP_RUNTIME_DRAW_PIXEL_READ_H

#include "base/error.h"
#include "base/vec.h"
#include "runtime/draw/pyramid.h"
#include "runtime/gl/gpu_layout.h"

/* Of a pixel's tag: its disc faces the eye, and its direction is its tangent. */
static inline bool stp_tag_is_tube(int tag)
{
    return tag != 0 && ((tag - 1) & 3) == STP_KIND_TUBE;
}

/* The unit vector that stp_direction_pack of shaders/reconstruct/pixel.glsl packed. */
stp_dvec3 stp_direction_unpack(uint32_t code);
/* The normal of pixel (x, y), whose unpacked direction is n, as it is seen: turned to the eye where
 * two-sided; of a tube, whose direction is its tangent, that across it. Eye space, unit. */
stp_dvec3 stp_pixel_normal(const stp_gpu_frame *frame, stp_dvec3 n, int tag, int x, int y);
/* A direction of eye space in the world. */
stp_dvec3 stp_direction_to_world(const stp_gpu_frame *frame, stp_dvec3 direction);

/* Normals of a level's paint, of the frame's viewport: xyz in the world's axes,
 * bottom row first, turned to the viewer where two-sided; 0 0 0 where nothing is. Errors:
 * OUT_OF_MEMORY, GL. */
stp_status stp_pixel_read_normals(GLuint paint, const stp_gpu_frame *frame, float *xyz,
                                  stp_error *err);

#endif
