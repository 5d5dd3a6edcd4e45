/* Reads normals from packed pixels, some rows at a time. */
#include "runtime/draw/pixel_read.h"

#include "base/memory.h"
#include "runtime/gl/gl_context.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

/* Pixels read at once; one row if a row has more. */
#define BAND_PIXELS (1 << 18)

stp_dvec3 stp_direction_unpack(uint32_t code)
{
    double x = (double)(int16_t)(uint16_t)code / 32767.0;
    double y = (double)(int16_t)(uint16_t)(code >> 16) / 32767.0;
    double z = 1.0 - fabs(x) - fabs(y), fold = fmax(-z, 0.0);
    return stp_dvec3_normalize(
        (stp_dvec3){x + (x >= 0.0 ? -fold : fold), y + (y >= 0.0 ? -fold : fold), z});
}

static stp_dvec3 scale_axis(const float axis[4], double s)
{
    return (stp_dvec3){(double)axis[0] * s, (double)axis[1] * s, (double)axis[2] * s};
}

/* By the transposed axes, whose z is multiplied if heights are exaggerated. */
static stp_dvec3 turn_back(const stp_gpu_frame *frame, stp_dvec3 d)
{
    return stp_dvec3_add(
        scale_axis(frame->axis_right, d.x),
        stp_dvec3_add(scale_axis(frame->axis_up, d.y), scale_axis(frame->axis_back, d.z)));
}

stp_dvec3 stp_place_to_world(const stp_gpu_frame *frame, stp_dvec3 place)
{
    stp_dvec3 world = turn_back(frame, place);
    world.z *= (double)frame->centre[3];
    return world;
}

stp_dvec3 stp_normal_to_world(const stp_gpu_frame *frame, stp_dvec3 normal)
{
    const stp_dvec3 world = turn_back(frame, normal);
    return frame->centre[3] == 1.0f ? world : stp_dvec3_normalize(world);
}

double stp_disc_stretch(const stp_gpu_frame *frame, stp_dvec3 normal)
{
    const double times = (double)frame->centre[2];
    return sqrt(1.0 + 0.5 * (times * times - 1.0) * fmax(0.0, 1.0 - normal.z * normal.z));
}

stp_dvec3 stp_pixel_normal(const stp_gpu_frame *frame, stp_dvec3 n, int tag, int x, int y)
{
    double f = (double)frame->viewport[2];
    stp_dvec3 ray = {0.0, 0.0, -1.0};
    if (frame->modes[0] == 0) {
        ray.x = (x + 0.5 - (double)frame->centre[0]) / f;
        ray.y = (y + 0.5 - (double)frame->centre[1]) / f;
    }
    if (stp_tag_is_tube(tag)) {
        stp_dvec3 to_eye = stp_dvec3_scale(stp_dvec3_normalize(ray), -1.0);
        stp_dvec3 across = stp_dvec3_sub(to_eye, stp_dvec3_scale(n, stp_dvec3_dot(to_eye, n)));
        return stp_dvec3_length(across) > 1e-6 ? stp_dvec3_normalize(across) : to_eye;
    }
    bool away = ((tag - 1) & 8) != 0 && stp_dvec3_dot(n, ray) > 0.0;
    return stp_dvec3_scale(n, away ? -1.0 : 1.0);
}

static void unpack_row(const uint32_t (*paint)[4], const stp_gpu_frame *frame, int width, int y,
                       float *xyz)
{
    for (int x = 0; x < width; x++) {
        int tag = (int)(paint[x][3] >> 16);
        stp_dvec3 n = stp_direction_unpack(paint[x][0]);
        stp_dvec3 world = {0.0, 0.0, 0.0};
        if (tag != 0)
            world = stp_normal_to_world(frame, stp_pixel_normal(frame, n, tag, x, y));
        xyz[3 * x] = (float)world.x;
        xyz[3 * x + 1] = (float)world.y;
        xyz[3 * x + 2] = (float)world.z;
    }
}

stp_status stp_pixel_read_normals(GLuint paint, const stp_gpu_frame *frame, float *xyz,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t(*texels)[4] = NULL;
    int width = (int)frame->viewport[0], height = (int)frame->viewport[1];
    int band = width < BAND_PIXELS ? BAND_PIXELS / width : 1;
    size_t count = (size_t)width * (size_t)band;
    STP_TRY(stp_alloc(&texels, count, sizeof *texels, "pixels to read", err));
    for (int y = 0; y < height; y += band) {
        int rows = height - y < band ? height - y : band;
        glGetTextureSubImage(paint, 0, 0, y, 0, width, rows, 1, GL_RGBA_INTEGER, GL_UNSIGNED_INT,
                             (GLsizei)(count * sizeof *texels), texels);
        STP_TRY(stp_gl_check("reading normals", err));
        for (int k = 0; k < rows; k++)
            unpack_row((const uint32_t(*)[4])texels + (size_t)k * (size_t)width, frame, width,
                       y + k, xyz + 3 * (size_t)(y + k) * (size_t)width);
    }
done:
    free(texels);
    return status;
}
