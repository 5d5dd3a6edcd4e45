/* Exchanges the two sides; says which is where. */
#include "tools/view/beside/view_beside.h"

#include "tools/draw/draw_beside.h"
#include "tools/view/view_app.h"

#include <math.h>

/* The divider can be taken within so many unscaled pixels; a key moves it by this share. */
#define REACH_PX 6.0
#define KEY_STEP 0.05

static bool has_other(const viewer *v)
{
    return v->beside.other.options != NULL;
}

/* Where a side is: 0 left, 1 right. */
static int place_of(const viewer *v, int side)
{
    return side ^ (int)v->beside.divider.swapped;
}

static void exchange(viewer *v)
{
    view_beside *b = &v->beside;
    const view_side side = v->side;
    const stp_draw_params params = v->control.params;
    const uint32_t colours = v->control.colours;
    v->side = b->other;
    v->control.params = b->params;
    v->control.colours = b->colours;
    b->other = side;
    b->params = params;
    b->colours = colours;
    b->here ^= 1;
}

stp_status view_beside_both(viewer *v, view_beside_act *act, stp_error *err)
{
    stp_status status = act(v, err);
    if (status != STP_OK || !has_other(v))
        return status;
    exchange(v);
    status = act(v, err);
    exchange(v);
    return status;
}

int view_beside_use(viewer *v, int side)
{
    const int before = v->beside.here;
    view_beside_link(v);
    if (side != before && has_other(v)) {
        exchange(v);
        v->beside.linked = v->control.params;
    }
    return before;
}

void view_beside_join_ranges(viewer *v)
{
    view_beside *b = &v->beside;
    if (has_other(v))
        draw_beside_join_ranges(&v->control.params, v->options, &b->params, b->other.options,
                                v->scene.attributes & b->other.scene.attributes);
}

/* ---- the divider ---- */

void view_beside_moved(viewer *v)
{
    const view_divider *d = &v->beside.divider;
    if (d->shows != VIEW_DIVIDER_BOTH) /* keys and panels change what is seen */
        view_beside_use(v, view_divider_side(d, v->layout.picture_width, 0.0));
    v->control.changed = true; /* a side that was hidden is not drawn yet */
}

static void use_at(viewer *v, double x)
{
    const int width = v->layout.picture_width;
    if (x >= 0.0 && x < width && v->control.drag == VIEW_REST)
        view_beside_use(v, view_divider_side(&v->beside.divider, width, x));
}

static bool handle_character(viewer *v, uint32_t character)
{
    view_divider *d = &v->beside.divider;
    if (character == 'v' || character == 'V')
        d->shows = (view_divider_shows)((d->shows + (character == 'v' ? 1 : 2)) % 3);
    else if (character == 'y' || character == 'Y')
        d->swapped = !d->swapped;
    else if (character == ',' || character == '.')
        view_divider_step(d, character == ',' ? -KEY_STEP : KEY_STEP);
    else
        return false;
    view_beside_moved(v);
    return true;
}

bool view_beside_handle(viewer *v, const stp_window_event *e)
{
    view_divider *d = &v->beside.divider;
    const int width = v->layout.picture_width;
    if (!has_other(v))
        return false;
    if (d->dragged) {
        d->dragged = e->kind != STP_WINDOW_RELEASE && e->kind != STP_WINDOW_BLUR;
        if (e->kind == STP_WINDOW_MOVE)
            view_divider_drag(d, width, e->x);
        return e->kind == STP_WINDOW_MOVE || e->kind == STP_WINDOW_RELEASE;
    }
    if (e->kind == STP_WINDOW_PRESS && e->button == STP_WINDOW_LEFT &&
        v->control.drag == VIEW_REST &&
        view_divider_take(d, width, e->x, REACH_PX * stp_ui_scale(v->ui)))
        return true;
    if (e->kind == STP_WINDOW_PRESS || e->kind == STP_WINDOW_WHEEL)
        use_at(v, e->x);
    else if (e->kind == STP_WINDOW_CHARACTER || (e->kind == STP_WINDOW_KEY && e->down))
        use_at(v, v->control.x);
    return e->kind == STP_WINDOW_CHARACTER && handle_character(v, e->character);
}

/* ---- what is shown where ---- */

bool view_beside_is_shown(const viewer *v)
{
    const view_divider_shows shows = v->beside.divider.shows;
    return shows == VIEW_DIVIDER_BOTH ||
           (shows == VIEW_DIVIDER_RIGHT) == (place_of(v, v->beside.here) == 1);
}

/* The columns of a side. False if there are none. */
static bool columns_of(const viewer *v, int side, int width, int *begin, int *end)
{
    const int column = has_other(v) ? view_divider_column(&v->beside.divider, width) : width;
    const bool right = place_of(v, side) == 1;
    *begin = right ? column : 0;
    *end = right ? width : column;
    return *begin < *end;
}

bool view_beside_rect(const viewer *v, stp_ui_rect *out)
{
    const view_layout *l = &v->layout;
    int begin = 0, end = 0;
    const bool shown = columns_of(v, v->beside.here, l->picture_width, &begin, &end);
    *out = (stp_ui_rect){begin, l->height - l->picture_height, end - begin, l->picture_height};
    return shown;
}

int view_beside_stripes(const viewer *v, int width, view_stripe out[2])
{
    int count = 0;
    for (int place = 0; place < 2; place++) {
        const int side = place_of(v, place);
        const bool here = side == v->beside.here;
        const view_scene *scene = here ? &v->scene : &v->beside.other.scene;
        view_stripe s = {.renderer = here ? v->renderer : v->beside.other.renderer,
                         .params = here ? v->control.params : v->beside.params};
        s.params.hidden_models = view_scene_hidden(scene);
        if (columns_of(v, side, width, &s.begin, &s.end))
            out[count++] = s;
    }
    return count;
}

stp_renderer *view_beside_renderer(const viewer *v, double x)
{
    const int width = v->layout.picture_width;
    const int side = has_other(v) ? view_divider_side(&v->beside.divider, width, x) : 0;
    return side == v->beside.here ? v->renderer : v->beside.other.renderer;
}

double view_beside_finest_px(const viewer *v)
{
    const double px = v->control.params.threshold_px;
    return has_other(v) ? fmin(px, v->beside.params.threshold_px) : px;
}

stp_draw_stats view_beside_stats(const viewer *v)
{
    const stp_draw_stats *other = &v->beside.other.stats;
    stp_draw_stats sum = v->stats;
    sum.frame_ms += other->frame_ms;
    sum.points_drawn += other->points_drawn;
    sum.chunks_drawn += other->chunks_drawn;
    sum.chunks_missing += other->chunks_missing;
    return sum;
}

stp_dbox view_beside_box(const viewer *v)
{
    stp_dbox box = v->scene.box;
    if (has_other(v))
        stp_dbox_join(&box, &v->beside.other.scene.box);
    return box;
}

const view_scene *view_beside_first(const viewer *v)
{
    return v->beside.here == 0 ? &v->scene : &v->beside.other.scene;
}

const char *view_beside_where(const viewer *v)
{
    static const char *const places[] = {"left", "right"};
    return has_other(v) ? places[place_of(v, v->beside.here)] : "";
}
