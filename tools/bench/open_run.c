/* Keeps a mask of the pixels that each frame covers. */
#include "tools/bench/open_run.h"

#include "base/clock.h"
#include "base/memory.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

#define FRAMES_LIMIT 400
#define PAUSE_NS 2000000

typedef struct frame {
    uint8_t *covered; /* one byte per pixel */
    double time_s;
} frame;

static stp_status keep(stp_renderer *r, const stp_view *view, double begun, frame *out,
                       stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *rgba = NULL;
    size_t pixels = (size_t)view->width * (size_t)view->height;
    out->time_s = stp_clock_seconds() - begun;
    STP_TRY(stp_alloc(&rgba, pixels, 4, "a picture", err));
    STP_TRY(stp_alloc(&out->covered, pixels, 1, "a picture", err));
    STP_TRY(stp_renderer_read(r, rgba, err));
    for (size_t i = 0; i < pixels; i++)
        out->covered[i] = rgba[4 * i + 3] != 0;
done:
    free(rgba);
    return status;
}

static double overlap(const frame *a, const frame *b, size_t pixels)
{
    size_t both = 0, either = 0;
    for (size_t i = 0; i < pixels; i++) {
        both += a->covered[i] && b->covered[i];
        either += a->covered[i] || b->covered[i];
    }
    return either > 0 ? (double)both / (double)either : 1.0;
}

static void wait_for_news(const stp_renderer *r)
{
    while (!stp_renderer_has_news(r) && stp_renderer_trouble(r)[0] == '\0')
        nanosleep(&(struct timespec){0, PAUSE_NS}, NULL);
}

/* Draws and keeps frames until the cut is complete or nothing more arrives. If there are too many
 * frames, the newest replaces the one before. */
static stp_status draw_frames(stp_renderer *r, const stp_view *view, double begun, frame *frames,
                              open_run_result *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw_params params = {.stream = true};
    stp_draw_stats stats = {0};
    do {
        STP_TRY(stp_renderer_draw(r, view, &params, &stats, err));
        if (out->frames == FRAMES_LIMIT)
            free(frames[--out->frames].covered);
        STP_TRY(keep(r, view, begun, &frames[out->frames++], err));
        if (stats.chunks_loading > 0)
            wait_for_news(r);
    } while (!stats.cut_complete && stats.chunks_loading > 0);
    out->complete = stats.cut_complete;
    out->bytes = stp_renderer_bytes_read(r);
done:
    return status;
}

stp_status open_run(stp_renderer *r, const stp_view *view, double begun, open_run_result *out,
                    stp_error *err)
{
    stp_status status = STP_OK;
    frame *frames = NULL;
    size_t pixels = (size_t)view->width * (size_t)view->height;
    *out = (open_run_result){0};
    STP_TRY(stp_alloc(&frames, FRAMES_LIMIT, sizeof *frames, "frames", err));
    out->ready_s = stp_clock_seconds() - begun;
    STP_TRY(draw_frames(r, view, begun, frames, out, err));
    const frame *last = &frames[out->frames - 1];
    out->first_s = frames[0].time_s;
    out->first_overlap = overlap(&frames[0], last, pixels);
    out->complete_s = last->time_s;
    for (unsigned i = out->frames;
         i-- > 0 && overlap(&frames[i], last, pixels) >= OPEN_RUN_OVERLAP;)
        out->alike_s = frames[i].time_s;
done:
    for (unsigned i = 0; frames != NULL && i < out->frames; i++)
        free(frames[i].covered);
    free(frames);
    return status;
}
