/* Draws the divider, the names of the sides, and their section of the panel. */
#include "tools/view/view_app.h"

#define WHITE 0xffffffffu
#define DIM 0xc8ccd4a0u
#define SHADOW 0x000000a0u
/* Unscaled pixels. */
#define GRIP_PX 8.0

/* Draws the name of the side in the viewer in the middle of its stripe. */
static void draw_name(const viewer *v, double y, uint32_t colour)
{
    char name[VIEW_SIDE_NAME];
    stp_ui_rect stripe;
    if (!view_beside_rect(v, &stripe))
        return;
    view_beside_name(v, name);
    stp_ui_clip_push(&stripe);
    stp_ui_draw_label(stripe.x + 0.5 * stripe.width, y, name, colour, true);
    stp_ui_clip_pop();
}

double view_beside_draw(viewer *v, double below)
{
    const view_layout *l = &v->layout;
    const double s = stp_ui_scale(v->ui);
    const double name_height = stp_ui_text_height() + 14.0 * s, y = below + 0.5 * name_height;
    const double x = view_divider_column(&v->beside.divider, l->picture_width);
    const double top = l->height - l->picture_height, middle = top + 0.5 * l->picture_height;
    if (v->beside.other.options == NULL)
        return below;
    if (v->beside.divider.shows == VIEW_DIVIDER_BOTH) {
        stp_ui_draw_line(x, top, x, l->height, SHADOW, 3.0 * s);
        stp_ui_draw_line(x, top, x, l->height, WHITE, 1.0 * s);
        stp_ui_draw_disc(x, middle, (GRIP_PX + 1.5) * s, SHADOW);
        stp_ui_draw_disc(x, middle, GRIP_PX * s, WHITE);
    }
    draw_name(v, y, WHITE); /* keys and panels change this side */
    const int here = view_beside_use(v, !v->beside.here);
    draw_name(v, y, DIM);
    view_beside_use(v, here);
    return below + name_height;
}

void view_panel_beside(viewer *v)
{
    view_divider *d = &v->beside.divider;
    char name[VIEW_SIDE_NAME];
    int shows = (int)d->shows;
    bool together = !v->beside.apart;
    double percent = 100.0 * d->at;
    view_beside_name(v, name);
    stp_ui_row(view_beside_where(v), name);
    stp_ui_hint("keys and panels change this side: the one that you pressed last");
    if (stp_ui_check("change both where they are alike", &together))
        v->beside.apart = !together;
    if (stp_ui_radio(&shows, VIEW_DIVIDER_WORDS, ~0u)) {
        d->shows = (view_divider_shows)shows;
        view_beside_moved(v);
    }
    if (stp_ui_slider("divider", &percent, 0.0, 100.0, "%.0f %%", false))
        d->at = 0.01 * percent;
    if (stp_ui_button("swap the sides")) {
        d->swapped = !d->swapped;
        view_beside_moved(v);
    }
}
