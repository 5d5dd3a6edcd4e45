/* Draws supersampled pictures part by part. */
#include "tools/draw/draw_fine.h"

#include "base/memory.h"

#include <stdlib.h>

/* The side of a part, in pixels of the picture, and its rim, in finer pixels. Times any number of
 * --aa, both are multiples of the side of a pixel on the pyramid's seventh level, so that the parts
 * have the same pyramid as one large picture. */
#define PART_PX 512
#define RIM_PX 128

int draw_aa_times(int aa)
{
    return aa > DRAW_AA_EDGES ? aa : 1;
}

static int least(int a, int b)
{
    return a < b ? a : b;
}

/* The mean of times x times pixels; first: the first pixel of the lowest row. */
static void average(const uint8_t *first, int row_px, int times, uint8_t out[4])
{
    int sum[4] = {0};
    for (int y = 0; y < times; y++)
        for (int x = 0; x < times; x++)
            for (int c = 0; c < 4; c++)
                sum[c] += first[4 * (y * row_px + x) + c];
    int count = times * times;
    for (int c = 0; c < 4; c++)
        out[c] = (uint8_t)((sum[c] + count / 2) / count);
}

static void take_part(const stp_view *view, const uint8_t *part, int side_px, int times, int x0,
                      int y0, uint8_t *rgba)
{
    int width = least(PART_PX, view->width - x0), height = least(PART_PX, view->height - y0);
    for (int y = 0; y < height; y++)
        for (int x = 0; x < width; x++) {
            size_t to = (size_t)(y0 + y) * (size_t)view->width + (size_t)(x0 + x);
            int from = (RIM_PX + y * times) * side_px + RIM_PX + x * times;
            average(part + 4 * (size_t)from, side_px, times, rgba + 4 * to);
        }
}

static void add_stats(stp_draw_stats *sum, const stp_draw_stats *part)
{
    sum->frame_ms += part->frame_ms;
    sum->load_ms += part->load_ms;
    sum->project_ms += part->project_ms;
    sum->pull_push_ms += part->pull_push_ms;
    sum->shade_ms += part->shade_ms;
    for (int i = 0; i < STP_STAGE_COUNT; i++)
        sum->gpu_ms[i] += part->gpu_ms[i];
    sum->points_drawn += part->points_drawn;
    sum->chunks_drawn += part->chunks_drawn;
    sum->chunks_missing += part->chunks_missing;
    sum->passes += part->passes;
    sum->cut_complete &= part->cut_complete;
    sum->every_sample &= part->every_sample;
    if (part->pyramid_levels > sum->pyramid_levels)
        sum->pyramid_levels = part->pyramid_levels;
}

stp_status draw_fine(stp_renderer *renderer, const stp_view *view, const stp_draw_params *params,
                     int times, uint8_t *rgba, stp_draw_stats *stats, stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw_stats sum = {.cut_complete = true, .every_sample = true};
    int side_px = times * PART_PX + 2 * RIM_PX;
    stp_view all = stp_view_scaled(view, times);
    uint8_t *pixels = NULL;
    STP_TRY(stp_alloc(&pixels, (size_t)side_px * (size_t)side_px, 4, "a part of a picture", err));
    for (int y = 0; y < view->height; y += PART_PX)
        for (int x = 0; x < view->width; x += PART_PX) {
            stp_view part =
                stp_view_part(&all, x * times - RIM_PX, y * times - RIM_PX, side_px, side_px);
            stp_draw_stats of_part;
            STP_TRY(stp_renderer_draw(renderer, &part, params, &of_part, err));
            STP_TRY(stp_renderer_read(renderer, pixels, err));
            take_part(view, pixels, side_px, times, x, y, rgba);
            add_stats(&sum, &of_part);
        }
    *stats = sum;
done:
    free(pixels);
    return status;
}

void draw_straighten(stp_image *image)
{
    for (size_t i = 0; i < (size_t)image->width * (size_t)image->height; i++) {
        uint8_t *p = image->rgba + 4 * i;
        for (int c = 0; c < 3 && p[3] > 0 && p[3] < 255; c++) {
            int value = (255 * p[c] + p[3] / 2) / p[3];
            p[c] = (uint8_t)(value < 255 ? value : 255);
        }
    }
}
