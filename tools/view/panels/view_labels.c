/* Finds places for the labels of contours. */
#include "tools/view/panels/view_labels.h"

#include "base/memory.h"
#include "runtime/camera/orbit.h"

#include <math.h>
#include <stdlib.h>

/* Each fifth line is wider (shaders/shade/contour.frag). */
#define MARKED 5.0
/* Rows and columns that are searched. */
#define PATHS 9
/* Unscaled pixels: the steps of a search, and how far apart labels are, and from the picture's rim.
 */
#define STEP_PX 4.0
#define APART_X_PX 130.0
#define APART_Y_PX 60.0
#define RIM_PX 45.0
/* At most so many labels of one height. */
#define ALIKE 3

typedef struct search {
    view_labels *labels;
    stp_renderer *renderer;
    const stp_view *view;
    const stp_draw_params *params;
    const float *depth;
    double scale;
} search;

/* The height at a pixel, in wider lines from the base. NaN: nothing is there. */
static double marked_at(const search *s, int x, int y)
{
    const stp_view *view = s->view;
    if (x < 0 || y < 0 || x >= view->width || y >= view->height)
        return NAN;
    const double depth = (double)s->depth[(size_t)y * (size_t)view->width + (size_t)x];
    if (!(depth > 0.0))
        return NAN;
    const stp_dvec3 at =
        stp_unexaggerated(s->params, stp_view_unproject(view, x + 0.5, y + 0.5, depth));
    return (at.z - s->params->contour_base) / (MARKED * s->params->contour_step);
}

static bool is_free(const search *s, double x, double y, double height)
{
    const double rim = RIM_PX * s->scale;
    int alike = 0;
    if (x < rim || y < rim || x > s->view->width - rim || y > s->view->height - rim)
        return false;
    for (int i = 0; i < s->labels->count; i++) {
        const view_label *l = &s->labels->items[i];
        alike += l->height == height;
        if (fabs(l->x - x) < APART_X_PX * s->scale && fabs(l->y - y) < APART_Y_PX * s->scale)
            return false;
    }
    return alike < ALIKE;
}

/* Tries a label between two pixels of a path, (dx, dy) apart. */
static stp_status try_between(search *s, int x, int y, int dx, int dy, stp_error *err)
{
    view_labels *l = s->labels;
    const double a = marked_at(s, x, y), b = marked_at(s, x + dx, y + dy);
    const double before = marked_at(s, x - 2 * dx, y - 2 * dy);
    const double after = marked_at(s, x + 3 * dx, y + 3 * dy);
    const double line = fmax(floor(a), floor(b));
    stp_pick pick = {0};
    if (l->count == VIEW_LABELS_LIMIT || !(floor(a) != floor(b)) || !(fabs(a - b) < 0.5))
        return STP_OK;
    if (!((before < line && after > line) || (before > line && after < line)))
        return STP_OK; /* roughness, or a surface's end */
    const double part = (line - a) / (b - a),
                 height = s->params->contour_base + line * MARKED * s->params->contour_step;
    const int at_x = x + (int)lround(part * dx), at_y = y + (int)lround(part * dy);
    if (!is_free(s, at_x, at_y, height))
        return STP_OK;
    const stp_status status = stp_renderer_pick(s->renderer, at_x, at_y, &pick, err);
    if (status == STP_OK && pick.hit && fabs(pick.position.z - height) < s->params->contour_step)
        l->items[l->count++] = (view_label){pick.position, height, at_x, at_y};
    return status;
}

/* Searches the rows and the columns in turn, those in the middle first. */
static stp_status search_paths(search *s, stp_error *err)
{
    stp_status status = STP_OK;
    const int step = (int)fmax(1.0, STEP_PX * s->scale);
    for (int i = 0; i < PATHS; i++) {
        const int away = (i + 1) / 2; /* from the middle, on both sides in turn */
        const double part = 0.5 + (i % 2 != 0 ? away : -away) / (PATHS + 1.0);
        const int row = (int)(part * s->view->height), column = (int)(part * s->view->width);
        for (int x = 0; x < s->view->width; x += step)
            STP_TRY(try_between(s, x, row, step, 0, err));
        for (int y = 0; y < s->view->height; y += step)
            STP_TRY(try_between(s, column, y, 0, step, err));
    }
done:
    return status;
}

stp_status view_labels_find(view_labels *labels, stp_renderer *renderer, const stp_view *view,
                            const stp_draw_params *params, double scale, stp_error *err)
{
    stp_status status = STP_OK;
    float *depth = NULL;
    *labels =
        (view_labels){.step = params->contour_step, .base = params->contour_base, .fresh = true};
    if (!(params->contour_step > 0.0))
        return STP_OK;
    STP_TRY(stp_alloc(&depth, (size_t)view->width * (size_t)view->height, sizeof *depth, "depths",
                      err));
    STP_TRY(stp_renderer_read_depth(renderer, depth, err));
    search s = {labels, renderer, view, params, depth, scale};
    STP_TRY(search_paths(&s, err));
done:
    free(depth);
    return status;
}
