/* Compares outlines, normals and changes from frame to frame. */
#include "tools/tune/tune_metrics.h"

#include "base/memory.h"
#include "base/sort.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#define HALF 127.5
#define CELL_PX 8

/* ---- outlines ---- */

static uint8_t alpha_at(const stp_image *image, int x, int y)
{
    return image->rgba[4 * ((size_t)y * (size_t)image->width + (size_t)x) + 3];
}

/* Marks the uncovered part around a pixel as seen. Returns its number of pixels, negative if it
 * touches the rim. */
static long flood(uint8_t *alpha, uint32_t *stack, int width, int height, uint32_t first)
{
    long count = 0, touches = 0;
    uint32_t top = 0;
    stack[top++] = first;
    alpha[first] = 1; /* seen; still counts as less than a half */
    while (top > 0) {
        uint32_t at = stack[--top];
        int x = (int)(at % (uint32_t)width), y = (int)(at / (uint32_t)width);
        const int next[4][2] = {{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}};
        count++;
        touches |= x == 0 || y == 0 || x == width - 1 || y == height - 1;
        for (int i = 0; i < 4; i++) {
            if (next[i][0] < 0 || next[i][1] < 0 || next[i][0] >= width || next[i][1] >= height)
                continue;
            uint32_t to = (uint32_t)next[i][1] * (uint32_t)width + (uint32_t)next[i][0];
            if (alpha[to] != 0)
                continue;
            alpha[to] = 1;
            stack[top++] = to;
        }
    }
    return touches ? -count : count;
}

/* Covers the small part around a pixel that flood has marked. */
static void cover(uint8_t *alpha, int width, int height, uint32_t first)
{
    uint32_t stack[4 * TUNE_HOLE_PIXELS];
    uint32_t top = 0;
    stack[top++] = first;
    alpha[first] = 255;
    while (top > 0) {
        uint32_t at = stack[--top];
        int x = (int)(at % (uint32_t)width), y = (int)(at / (uint32_t)width);
        const int next[4][2] = {{x - 1, y}, {x + 1, y}, {x, y - 1}, {x, y + 1}};
        for (int i = 0; i < 4; i++) {
            if (next[i][0] < 0 || next[i][1] < 0 || next[i][0] >= width || next[i][1] >= height)
                continue;
            uint32_t to = (uint32_t)next[i][1] * (uint32_t)width + (uint32_t)next[i][0];
            if (alpha[to] != 1)
                continue;
            alpha[to] = 255;
            stack[top++] = to;
        }
    }
}

/* Gets the picture's alpha without holes, which are small uncovered parts. Alphas below one half
 * become 0, except at outlines. */
static stp_status close_holes(const stp_image *image, uint8_t *alpha, stp_error *err)
{
    size_t pixels = (size_t)image->width * (size_t)image->height;
    uint32_t *stack = NULL;
    stp_status status = stp_alloc(&stack, pixels, sizeof *stack, "an outline", err);
    if (status != STP_OK)
        return status;
    for (size_t i = 0; i < pixels; i++)
        alpha[i] = image->rgba[4 * i + 3] > HALF ? 255 : 0;
    for (size_t i = 0; i < pixels; i++) {
        if (alpha[i] != 0)
            continue;
        long count = flood(alpha, stack, image->width, image->height, (uint32_t)i);
        if (count > 0 && count < TUNE_HOLE_PIXELS)
            cover(alpha, image->width, image->height, (uint32_t)i);
    }
    for (size_t i = 0; i < pixels; i++) { /* restore fractions where nothing was closed */
        uint8_t own = image->rgba[4 * i + 3];
        if (alpha[i] == 1 || own > HALF)
            alpha[i] = own;
    }
    free(stack);
    return STP_OK;
}

typedef struct crossing {
    float x, y;
} crossing;

/* The points of an outline, sorted into cells. */
typedef struct outline {
    crossing *points;
    uint32_t *cell_begin;
    size_t count, capacity;
    int width, height; /* in cells */
} outline;

static stp_status add_crossing(outline *o, int x, int y, int dx, int dy, uint8_t here,
                               uint8_t there, stp_error *err)
{
    if ((here > HALF) == (there > HALF))
        return STP_OK;
    stp_status status =
        stp_grow(&o->points, &o->capacity, o->count + 1, sizeof *o->points, "an outline", err);
    if (status != STP_OK)
        return status;
    double t = (HALF - here) / ((double)there - here);
    o->points[o->count++] = (crossing){(float)(x + t * dx), (float)(y + t * dy)};
    return STP_OK;
}

static size_t cell_of(const outline *o, crossing p)
{
    return (size_t)(p.y / CELL_PX) * (size_t)o->width + (size_t)(p.x / CELL_PX);
}

static stp_status sort_into_cells(outline *o, stp_error *err)
{
    stp_status status = STP_OK;
    crossing *sorted = NULL;
    size_t cells = (size_t)o->width * (size_t)o->height;
    STP_TRY(stp_alloc(&sorted, o->count, sizeof *sorted, "an outline", err));
    STP_TRY(stp_alloc(&o->cell_begin, cells + 2, sizeof *o->cell_begin, "an outline", err));
    for (size_t i = 0; i < o->count; i++)
        o->cell_begin[cell_of(o, o->points[i]) + 2]++;
    for (size_t c = 2; c < cells + 2; c++)
        o->cell_begin[c] += o->cell_begin[c - 1];
    for (size_t i = 0; i < o->count; i++)
        sorted[o->cell_begin[cell_of(o, o->points[i]) + 1]++] = o->points[i];
    free(o->points);
    o->points = sorted;
    sorted = NULL;
done:
    free(sorted);
    return status;
}

static void outline_clear(outline *o)
{
    free(o->points);
    free(o->cell_begin);
}

static stp_status outline_find(outline *o, const stp_image *image, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *alpha = NULL;
    int width = image->width, height = image->height;
    o->width = width / CELL_PX + 1;
    o->height = height / CELL_PX + 1;
    STP_TRY(stp_alloc(&alpha, (size_t)width * (size_t)height, 1, "an outline", err));
    STP_TRY(close_holes(image, alpha, err));
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            const uint8_t *at = alpha + (size_t)y * (size_t)width + (size_t)x;
            if (x + 1 < width)
                STP_TRY(add_crossing(o, x, y, 1, 0, at[0], at[1], err));
            if (y + 1 < height)
                STP_TRY(add_crossing(o, x, y, 0, 1, at[0], at[width], err));
        }
    STP_TRY(sort_into_cells(o, err));
done:
    free(alpha);
    return status;
}

/* The distance to the nearest point of an outline, at most the limit. */
static double nearest_px(const outline *o, crossing p)
{
    double best = TUNE_OUTLINE_LIMIT_PX * TUNE_OUTLINE_LIMIT_PX;
    int cx = (int)p.x / CELL_PX, cy = (int)p.y / CELL_PX;
    for (int ring = 0; (ring - 1) * CELL_PX < TUNE_OUTLINE_LIMIT_PX; ring++) {
        double beyond = fmax(0.0, (double)(ring - 1) * CELL_PX);
        if (beyond * beyond > best)
            break;
        for (int y = cy - ring; y <= cy + ring; y++)
            for (int x = cx - ring; x <= cx + ring; x += abs(y - cy) == ring ? 1 : 2 * ring) {
                if (x < 0 || y < 0 || x >= o->width || y >= o->height)
                    continue;
                size_t cell = (size_t)y * (size_t)o->width + (size_t)x;
                for (uint32_t i = o->cell_begin[cell]; i < o->cell_begin[cell + 1]; i++) {
                    double dx = (double)(o->points[i].x - p.x), dy = (double)(o->points[i].y - p.y);
                    best = fmin(best, dx * dx + dy * dy);
                }
            }
    }
    return sqrt(best);
}

static void summarise(double *values, size_t count, double *mean, double *median, double *p95,
                      double *most)
{
    double sum = 0.0;
    stp_sort_doubles(values, count);
    for (size_t i = 0; i < count; i++)
        sum += values[i];
    *mean = count > 0 ? sum / (double)count : 0.0;
    *median = count > 0 ? values[count / 2] : 0.0;
    *p95 = count > 0 ? values[(size_t)(0.95 * (double)(count - 1) + 0.5)] : 0.0;
    *most = count > 0 ? values[count - 1] : 0.0;
}

stp_status tune_shift_compute(const stp_image *a, const stp_image *b, tune_shift *out,
                              stp_error *err)
{
    stp_status status = STP_OK;
    outline of_a = {0}, of_b = {0};
    double *distances = NULL, median;
    if (a->width != b->width || a->height != b->height)
        return stp_error_set(err, STP_INVALID_ARGUMENT, "the pictures have different sizes");
    STP_TRY(outline_find(&of_a, a, err));
    STP_TRY(outline_find(&of_b, b, err));
    size_t count = of_a.count + of_b.count;
    STP_TRY(stp_alloc(&distances, count, sizeof *distances, "an outline", err));
    for (size_t i = 0; i < of_a.count; i++)
        distances[i] = nearest_px(&of_b, of_a.points[i]);
    for (size_t i = 0; i < of_b.count; i++)
        distances[of_a.count + i] = nearest_px(&of_a, of_b.points[i]);
    out->points = count;
    summarise(distances, count, &out->mean_px, &median, &out->p95_px, &out->max_px);
done:
    free(distances);
    outline_clear(&of_a);
    outline_clear(&of_b);
    return status;
}

/* ---- normals ---- */

stp_status tune_angles_compute(const float *a, const float *b, size_t pixel_count, tune_angles *out,
                               stp_error *err)
{
    double *angles = NULL, most;
    size_t count = 0;
    stp_status status = stp_alloc(&angles, pixel_count, sizeof *angles, "angles", err);
    if (status != STP_OK)
        return status;
    for (size_t i = 0; i < pixel_count; i++) {
        const float *p = a + 3 * i, *q = b + 3 * i;
        if ((p[0] == 0.0f && p[1] == 0.0f && p[2] == 0.0f) ||
            (q[0] == 0.0f && q[1] == 0.0f && q[2] == 0.0f))
            continue;
        /* from the chord: the cosine of a small angle has no digits left */
        double chord =
            sqrt(pow((double)p[0] - (double)q[0], 2) + pow((double)p[1] - (double)q[1], 2) +
                 pow((double)p[2] - (double)q[2], 2));
        angles[count++] = 360.0 / M_PI * asin(fmin(1.0, 0.5 * chord));
    }
    out->pixels = count;
    summarise(angles, count, &out->mean_deg, &out->median_deg, &out->p95_deg, &most);
    free(angles);
    return STP_OK;
}

/* ---- changes ---- */

static const uint8_t *pixel(const stp_image *image, size_t i)
{
    return image->rgba + 4 * i;
}

static int over_black(const uint8_t *p, int component)
{
    return (p[component] * p[3] + 127) / 255;
}

/* True if B covers the pixel and all its neighbours, but A does not cover the pixel. */
static bool is_hole(const stp_image *a, const stp_image *b, int x, int y)
{
    if (alpha_at(a, x, y) > 0)
        return false;
    for (int v = y > 0 ? y - 1 : 0; v <= y + 1 && v < b->height; v++)
        for (int u = x > 0 ? x - 1 : 0; u <= x + 1 && u < b->width; u++)
            if (alpha_at(b, u, v) == 0)
                return false;
    return true;
}

void tune_change_add(tune_change *change, const stp_image *a_before, const stp_image *a_after,
                     const stp_image *b_before, const stp_image *b_after)
{
    change->steps++;
    for (int y = 0; y < a_before->height; y++)
        for (int x = 0; x < a_before->width; x++) {
            size_t i = (size_t)y * (size_t)a_before->width + (size_t)x;
            const uint8_t *p = pixel(a_before, i), *q = pixel(a_after, i);
            const uint8_t *r = pixel(b_before, i), *s = pixel(b_after, i);
            if (p[3] == 0 && q[3] == 0 && r[3] == 0 && s[3] == 0)
                continue;
            change->pixels++;
            for (int k = 0; k < 3; k++) {
                int of_a = over_black(q, k) - over_black(p, k);
                int of_b = over_black(s, k) - over_black(r, k), extra = of_a - of_b;
                change->squares_a += (uint64_t)(of_a * of_a);
                change->squares_b += (uint64_t)(of_b * of_b);
                change->squares_extra += (uint64_t)(extra * extra);
            }
            bool before = is_hole(a_before, b_before, x, y),
                 after = is_hole(a_after, b_after, x, y);
            change->opened += !before && after;
            change->closed += before && !after;
        }
}

double tune_change_level(const tune_change *change, uint64_t squares)
{
    return change->pixels > 0 ? sqrt((double)squares / (3.0 * (double)change->pixels)) : 0.0;
}
