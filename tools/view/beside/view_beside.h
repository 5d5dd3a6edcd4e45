/* Two settings or models beside each other: `stipple view --beside`.
 *
 * The viewer has the members of one side in view_app.h (view_side) and knows no other. This file
 * holds the other side and exchanges the two: everything that draws, picks or changes the viewer's
 * members works on either side. The side in the viewer is the one used last: the side under the
 * cursor at the last press, key or turn of the wheel.
 *
 * One camera, two renderers. Each draws the whole picture, since the reconstruction at the divider
 * needs what lies beyond it; stripes of both pictures are shown. So a divider that moves draws
 * nothing anew. Without a second side every function does what is right for one.
 * Threads: the main thread only. */
#ifndef STP_TOOLS_VIEW_BESIDE_VIEW_BESIDE_H
#define STP_TOOLS_VIEW_BESIDE_VIEW_BESIDE_H

#include "runtime/window/imgui_shim.h"
#include "runtime/window/window.h"
#include "tools/draw/draw_options.h"
#include "tools/view/beside/view_divider.h"
#include "tools/view/panels/view_labels.h"
#include "tools/view/prepare/view_prepare_child.h"
#include "tools/view/view_scene.h"
#include "tools/view/view_shot.h"

struct viewer;

/* What one side has of its own, besides the parameters in view_control. */
#define VIEW_SIDE_MEMBERS                                                                          \
    const draw_options *options;                                                                   \
    const char *const *paths; /* of models and scans to show at first */                           \
    size_t path_count;                                                                             \
    view_scene scene;                                                                              \
    stp_renderer *renderer;                                                                        \
    stp_draw_stats stats; /* of the last frame; zero if it showed the other side alone */          \
    double drawn_px;      /* threshold of the last frame; 0: every sample */                       \
    view_labels labels;                                                                            \
    view_prepare prepare;      /* of scans */                                                      \
    uint32_t model_classes[8]; /* bit set of the scene's classes */                                \
    size_t had_models;         /* number of models that the renderer knows */                      \
    int model_open; /* index of the model whose facts are shown, if there are several */           \
    bool said_damage;

typedef struct view_side {
    VIEW_SIDE_MEMBERS
} view_side;

/* Zero is none. */
typedef struct view_beside {
    view_side other; /* other.options is NULL: there is no second side */
    stp_draw_params params;
    uint32_t colours;       /* as in view_control */
    int here;               /* number of the side in the viewer */
    stp_draw_params linked; /* those of the side in the viewer when view_beside_link ran last */
    bool apart;             /* what is changed is changed on that side alone */
    view_divider divider;
} view_beside;

typedef stp_status view_beside_act(struct viewer *v, stp_error *err);

/* Creates the renderers once both sides have models and parameters. Errors: those of
 * view_scene_changed. */
stp_status view_beside_begin(struct viewer *v, stp_error *err);
/* Does something with the side in the viewer, and with the other one in its place. */
stp_status view_beside_both(struct viewer *v, view_beside_act *act, stp_error *err);
/* Puts side 0 or 1 into the viewer. Returns the number of the one that was there. */
int view_beside_use(struct viewer *v, int side);
/* Gives both sides what was changed on the one in the viewer, where they were alike. */
void view_beside_link(struct viewer *v);
/* Moves the divider and puts the side under the cursor into the viewer. True if only the divider
 * used the event. */
bool view_beside_handle(struct viewer *v, const stp_window_event *event);
/* Prepares scans of both sides, one after the other. */
void view_beside_prepare(struct viewer *v);
/* One colour means one value on both sides, unless --colour-range says otherwise. */
void view_beside_join_ranges(struct viewer *v);

/* The stripes of a picture of this width, from left to right. Returns their number: 1 or 2. */
int view_beside_stripes(const struct viewer *v, int width, view_stripe out[2]);
/* The renderer whose picture is shown at a column of the window. */
stp_renderer *view_beside_renderer(const struct viewer *v, double x);
/* The rectangle of the window where the side in the viewer is shown. False if it is not. */
bool view_beside_rect(const struct viewer *v, stp_ui_rect *out);
/* Whether the side in the viewer is shown, or could be by moving the divider. */
bool view_beside_is_shown(const struct viewer *v);
/* Call it after the divider showed other sides. */
void view_beside_moved(struct viewer *v);
/* The finer threshold of both sides. */
double view_beside_finest_px(const struct viewer *v);
/* Time, samples and chunks of the last frame of all that is shown. */
stp_draw_stats view_beside_stats(const struct viewer *v);
/* The box of the models of both sides. */
stp_dbox view_beside_box(const struct viewer *v);
/* The scene of side 0: heights are exaggerated about its middle, and what is kept is kept with it.
 */
const view_scene *view_beside_first(const struct viewer *v);
/* "left" or "right": where the side in the viewer is; "" if there is no other. */
const char *view_beside_where(const struct viewer *v);

#define VIEW_SIDE_NAME 200
/* Names the side in the viewer by what it has other than the other side: models, settings. */
void view_beside_name(const struct viewer *v, char name[VIEW_SIDE_NAME]);

/* ---- view_beside_show.c ---- */

/* Draws the divider, and the sides' names at the top of the picture. below: the height that is
 * taken there. Returns the height taken so far. */
double view_beside_draw(struct viewer *v, double below);
void view_panel_beside(struct viewer *v);

#endif
