/* Looks bounds up in a pyramid of farthest depths. */
#include "runtime/cut/occlusion.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The part of a depth by which floats on CPU and GPU may differ. */
#define DEPTH_SLACK 2e-5f
/* A bound is looked up on the level where it spans no more cells than this. */
#define SPAN_LIMIT 8

stp_status stp_occlusion_open(stp_occlusion *o, const stp_gpu_frame *frame, stp_dvec3 eye,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const float *const axes[3] = {frame->axis_right, frame->axis_up, frame->axis_back};
    int columns = ((int)frame->viewport[0] + STP_OCCLUSION_CELL_PX - 1) / STP_OCCLUSION_CELL_PX;
    int rows = ((int)frame->viewport[1] + STP_OCCLUSION_CELL_PX - 1) / STP_OCCLUSION_CELL_PX;
    size_t begins[STP_OCCLUSION_LEVELS_LIMIT], count = 0;
    int l = 0;
    o->level_count = 0;
    for (bool more = true; more && l < STP_OCCLUSION_LEVELS_LIMIT; l++) {
        o->levels[l] = (stp_occlusion_level){.columns = columns, .rows = rows};
        begins[l] = count;
        count += (size_t)columns * (size_t)rows;
        more = columns > 1 || rows > 1;
        columns = (columns + 1) / 2;
        rows = (rows + 1) / 2;
    }
    STP_TRY(stp_grow(&o->far, &o->capacity, count, sizeof *o->far, "depths of a picture", err));
    for (int i = 0; i < l; i++)
        o->levels[i].far = o->far + begins[i];
    o->level_count = l;
    for (int i = 0; i < 3; i++)
        memcpy(o->axes[i], axes[i], sizeof o->axes[i]);
    memcpy(o->viewport, frame->viewport, sizeof o->viewport);
    memcpy(o->centre, frame->centre, sizeof o->centre);
    o->orthographic = frame->modes[0] != 0;
    o->eye = eye;
done:
    return status;
}

void stp_occlusion_close(stp_occlusion *o)
{
    for (int l = 1; l < o->level_count; l++) {
        const stp_occlusion_level *from = &o->levels[l - 1], *to = &o->levels[l];
        float *out = o->far + (to->far - o->far);
        for (int y = 0; y < to->rows; y++)
            for (int x = 0; x < to->columns; x++) {
                int x1 = 2 * x + 1 < from->columns ? 2 * x + 1 : 2 * x;
                int y1 = 2 * y + 1 < from->rows ? 2 * y + 1 : 2 * y;
                const float *low = from->far + (ptrdiff_t)2 * y * from->columns;
                const float *high = from->far + (ptrdiff_t)y1 * from->columns;
                out[y * to->columns + x] =
                    fmaxf(fmaxf(low[2 * x], low[x1]), fmaxf(high[2 * x], high[x1]));
            }
    }
}

void stp_occlusion_destroy(stp_occlusion *o)
{
    free(o->far);
    *o = (stp_occlusion){0};
}

bool stp_occlusion_is_of(const stp_occlusion *o, const stp_gpu_frame *frame, stp_dvec3 eye)
{
    const float *const axes[3] = {frame->axis_right, frame->axis_up, frame->axis_back};
    bool same = o->orthographic == (frame->modes[0] != 0) && stp_dvec3_equal(o->eye, eye);
    for (int i = 0; i < 4; i++)
        same = same && o->viewport[i] == frame->viewport[i] &&
               (i >= 2 || o->centre[i] == frame->centre[i]);
    for (int i = 0; i < 9; i++)
        same = same && o->axes[i / 3][i % 3] == axes[i / 3][i % 3];
    return same;
}

void stp_occlusion_aim(stp_occlusion *o, stp_dvec3 eye, float margin_px, bool same)
{
    const stp_dvec3 way = stp_dvec3_sub(eye, o->eye);
    o->shift[0] = (float)way.x;
    o->shift[1] = (float)way.y;
    o->shift[2] = (float)way.z;
    o->margin_px = margin_px;
    o->same = same;
}

/* Parallax is that of the nearest square of so many cells, 2^level a side. */
#define PARALLAX_LEVEL 2

float stp_occlusion_parallax(const stp_occlusion *o, stp_dvec3 eye)
{
    const int l = o->level_count > PARALLAX_LEVEL ? PARALLAX_LEVEL : o->level_count - 1;
    const float way = (float)stp_dvec3_length(stp_dvec3_sub(eye, o->eye));
    float nearest = STP_OCCLUSION_NONE;
    for (int i = 0; l >= 0 && i < o->levels[l].columns * o->levels[l].rows; i++)
        nearest = fminf(nearest, o->levels[l].far[i]);
    return o->orthographic ? 0.0f : o->viewport[2] * way / nearest;
}

/* A place relative to the eye that asks, in the eye space of the picture. */
static void to_eye(const stp_occlusion *o, const float place[3], float out[3])
{
    for (int i = 0; i < 3; i++) {
        const float *axis = o->axes[i];
        out[i] = axis[0] * (place[0] + o->shift[0]) + axis[1] * (place[1] + o->shift[1]) +
                 axis[2] * (place[2] + o->shift[2]);
    }
}

/* Whether all of cells x0..x1, y0..y1 of a level are nearer than a depth. */
static bool all_nearer(const stp_occlusion_level *level, int x0, int y0, int x1, int y1,
                       float depth)
{
    for (int y = y0; y <= y1; y++)
        for (int x = x0; x <= x1; x++)
            if (level->far[y * level->columns + x] >= depth)
                return false;
    return true;
}

/* What is left of [*low, *high] within [0, size). What is not a number stays so. */
static void clamp(float *low, float *high, float size)
{
    *low = *low < 0.0f ? 0.0f : *low;
    *high = *high >= size ? size - 1.0f : *high;
}

/* Whether a rectangle of window coordinates and the margin around it hide what is at least so
 * deep. */
static bool hides_rectangle(const stp_occlusion *o, const float low[2], const float high[2],
                            float depth)
{
    float x = low[0] - o->margin_px, y = low[1] - o->margin_px;
    float right = high[0] + o->margin_px, up = high[1] + o->margin_px;
    if (o->same) {
        clamp(&x, &right, o->viewport[0]);
        clamp(&y, &up, o->viewport[1]);
    }
    if (!(x >= 0.0f && y >= 0.0f && x <= right && y <= up && right < o->viewport[0] &&
          up < o->viewport[1]))
        return false;
    int x0 = (int)x / STP_OCCLUSION_CELL_PX, x1 = (int)right / STP_OCCLUSION_CELL_PX;
    int y0 = (int)y / STP_OCCLUSION_CELL_PX, y1 = (int)up / STP_OCCLUSION_CELL_PX;
    int l = 0;
    for (; l + 1 < o->level_count && (x1 - x0 >= SPAN_LIMIT || y1 - y0 >= SPAN_LIMIT); l++) {
        x0 >>= 1;
        x1 >>= 1;
        y0 >>= 1;
        y1 >>= 1;
    }
    return all_nearer(&o->levels[l], x0, y0, x1, y1, depth);
}

bool stp_occlusion_hides(const stp_occlusion *o, const float centre[3], float radius)
{
    float eye[3], low[2], high[2];
    if (o == NULL || o->level_count == 0)
        return false;
    to_eye(o, centre, eye);
    float middle = -eye[2], depth = middle - radius, scale = o->viewport[2];
    depth -= DEPTH_SLACK * (fabsf(depth) + radius);
    if (!(depth > o->viewport[3]))
        return false;
    float reach = radius * scale;
    if (!o->orthographic) {
        const float x = eye[0] / middle, y = eye[1] / middle;
        scale /= middle;
        reach *= sqrtf(1.0f + x * x + y * y) / depth;
    }
    for (int i = 0; i < 2; i++) {
        const float at = o->centre[i] + eye[i] * scale;
        low[i] = at - reach;
        high[i] = at + reach;
    }
    return hides_rectangle(o, low, high, depth);
}

bool stp_occlusion_hides_box(const stp_occlusion *o, const stp_occluded *box)
{
    float low[2] = {INFINITY, INFINITY}, high[2] = {-INFINITY, -INFINITY}, depth = INFINITY;
    if (o == NULL || o->level_count == 0)
        return false;
    for (int corner = 0; corner < 8; corner++) {
        float place[3], eye[3];
        for (int i = 0; i < 3; i++)
            place[i] = corner >> i & 1 ? box->high[i] : box->low[i];
        to_eye(o, place, eye);
        const float near = -eye[2] - DEPTH_SLACK * fabsf(eye[2]);
        if (!(near > o->viewport[3]))
            return false;
        const float scale = o->orthographic ? o->viewport[2] : o->viewport[2] / -eye[2];
        for (int i = 0; i < 2; i++) {
            const float at = o->centre[i] + eye[i] * scale;
            low[i] = at < low[i] ? at : low[i];
            high[i] = at > high[i] ? at : high[i];
        }
        depth = near < depth ? near : depth;
    }
    return hides_rectangle(o, low, high, depth);
}
