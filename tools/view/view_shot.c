/* Makes screenshots part by part. */
#include "tools/view/view_shot.h"

#include "base/memory.h"
#include "tools/draw/draw_fine.h"

#include <stdlib.h>
#include <string.h>

/* Both are multiples of the side of a pixel on the pyramid's seventh level, so that the parts have
 * the same pyramid as one large picture. */
#define PART_PX 1024
#define RIM_PX 128
#define SIDE_PX (PART_PX + 2 * RIM_PX)

static int parts_along(int length)
{
    return (length + PART_PX - 1) / PART_PX;
}

stp_status view_shot_begin(view_shot *shot, const stp_view *view, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    view_shot s = {.state = VIEW_SHOT_DRAWING, .view = *view};
    if (view->width > VIEW_SHOT_LIMIT || view->height > VIEW_SHOT_LIMIT)
        return stp_error_set(err, STP_LIMIT, "a picture of %d x %d is larger than %d pixels a side",
                             view->width, view->height, VIEW_SHOT_LIMIT);
    STP_TRY(stp_alloc(&s.image.rgba, (size_t)view->width * (size_t)view->height, 4, "a screenshot",
                      err));
    STP_TRY(stp_alloc(&s.part, (size_t)SIDE_PX * SIDE_PX, 4, "a screenshot", err));
    s.image.width = view->width;
    s.image.height = view->height;
    s.count = parts_along(view->width) * parts_along(view->height);
    strncpy(s.path, path, sizeof s.path - 1);
    pthread_mutex_init(&s.lock, NULL);
    *shot = s;
    s = (view_shot){0};
done:
    free(s.image.rgba);
    free(s.part);
    return status;
}

static void *write_image(void *context)
{
    view_shot *shot = context;
    draw_straighten(&shot->image);
    shot->written = stp_image_save(&shot->image, shot->path, false, &shot->error);
    pthread_mutex_lock(&shot->lock);
    shot->done = true;
    pthread_mutex_unlock(&shot->lock);
    return NULL;
}

/* Copies the columns from begin up to end of a part and turns its rows from bottom-up to top-down.
 */
static void take_part(view_shot *shot, int x, int y, int begin, int end)
{
    int height = shot->image.height - y < PART_PX ? shot->image.height - y : PART_PX;
    for (int row = 0; row < height; row++) {
        size_t to = (size_t)(shot->image.height - 1 - y - row) * (size_t)shot->image.width;
        size_t from = (size_t)(row + RIM_PX) * SIDE_PX + RIM_PX + (size_t)(begin - x);
        memcpy(shot->image.rgba + 4 * (to + (size_t)begin), shot->part + 4 * from,
               4 * (size_t)(end - begin));
    }
}

static stp_status draw_stripe(view_shot *shot, const view_stripe *stripe, int x, int y,
                              stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw_params waiting = stripe->params;
    stp_view part = stp_view_part(&shot->view, x - RIM_PX, y - RIM_PX, SIDE_PX, SIDE_PX);
    const int begin = stripe->begin > x ? stripe->begin : x;
    const int end = stripe->end < x + PART_PX ? stripe->end : x + PART_PX;
    if (begin >= end)
        return STP_OK;
    waiting.stream = waiting.refine = false;
    STP_TRY(stp_renderer_draw(stripe->renderer, &part, &waiting, NULL, err));
    STP_TRY(stp_renderer_read(stripe->renderer, shot->part, err));
    take_part(shot, x, y, begin, end);
done:
    return status;
}

stp_status view_shot_draw(view_shot *shot, const view_stripe *stripes, int count, stp_error *err)
{
    stp_status status = STP_OK;
    int across = parts_along(shot->view.width);
    int x = shot->next % across * PART_PX, y = shot->next / across * PART_PX;
    shot->state = VIEW_SHOT_FAILED;
    for (int i = 0; i < count; i++)
        STP_TRY(draw_stripe(shot, &stripes[i], x, y, err));
    shot->state = VIEW_SHOT_DRAWING;
    if (++shot->next < shot->count)
        return STP_OK;
    shot->state = VIEW_SHOT_WRITING;
    if (pthread_create(&shot->writer, NULL, write_image, shot) != 0) {
        shot->state = VIEW_SHOT_FAILED;
        status = stp_error_set(err, STP_LIMIT, "no thread to write %s with", shot->path);
    }
done:
    return status;
}

stp_status view_shot_poll(view_shot *shot, stp_error *err)
{
    if (shot->state != VIEW_SHOT_WRITING)
        return STP_OK;
    pthread_mutex_lock(&shot->lock);
    bool done = shot->done;
    pthread_mutex_unlock(&shot->lock);
    if (!done)
        return STP_OK;
    pthread_join(shot->writer, NULL);
    shot->state = shot->written == STP_OK ? VIEW_SHOT_WRITTEN : VIEW_SHOT_FAILED;
    return shot->written == STP_OK ? STP_OK
                                   : stp_error_set(err, shot->written, "%s", shot->error.message);
}

double view_shot_done(const view_shot *shot)
{
    return shot->count > 0 ? (double)shot->next / shot->count : 0.0;
}

void view_shot_end(view_shot *shot)
{
    if (shot->state == VIEW_SHOT_WRITING)
        pthread_join(shot->writer, NULL);
    if (shot->state != VIEW_SHOT_NONE)
        pthread_mutex_destroy(&shot->lock);
    stp_image_destroy(&shot->image);
    free(shot->part);
    *shot = (view_shot){0};
}
