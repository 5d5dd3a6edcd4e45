/* stipple view: opens a window to fly through models. */
#include "tools/draw/draw_beside.h"
#include "tools/file/source_options.h"
#include "tools/view/panels/view_marks.h"
#include "tools/view/prepare/view_prepare.h"
#include "tools/view/view_draw.h"
#include "tools/view/view_keys.h"
#include "tools/view/view_move.h"
#include "tools/view/view_say.h"
#include "tools/view/view_settings.h"
#include "tools/view/view_watch.h"
#include "tools/view/view_wishes.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static int run(int argc, char **argv);
const cli_command cli_view = {
    .name = "view",
    .summary = "open a window to fly through models",
    .usage = "stipple view M.stipple... [options]",
    .details =
        "The window's title says how long a frame took, how many points it drew, and "
        "how.\nWith --shaders, the viewer reloads shader files when you save them. Pictures "
        "and paths\ngo to the working folder, kept views to "
        "M.stipple.views.json, marks to M.stipple.marks.json.\n\n" OPEN_SCAN_HELP
        " A large\nscan is shown coarsely, all of it, until its model is ready.\n\n" VIEW_KEYS,
    .run = run,
};

/* The time to wait for an event before checking the shader folder and Ctrl-C. */
#define WAIT_S 0.25
/* A window narrower than this (in unscaled pixels) starts without panels. */
#define PANELS_LEAST_WIDTH 720.0
#define FPS_MOST 1000.0

static double depth_under(void *context, int x, int y)
{
    const viewer *v = context;
    float depth = 0.0f; /* stays 0 outside the picture */
    view_drawn_pixel(v, &x, &y);
    stp_renderer_depth_at(v->renderer, x, y, &depth, NULL);
    return (double)depth;
}

/* Finds the highest ground of all models. */
static bool ground_under(void *context, stp_dvec3 position, stp_dvec3 up, double *height)
{
    viewer *v = context;
    const stp_draw_params *p = &v->control.params;
    bool found = false;
    if (p->exaggerate > 0.0 && !(up.z > 0.999)) /* heights are z: no other way is down */
        return false;
    position = stp_unexaggerated(p, position);
    for (size_t i = 0; i < v->scene.count; i++) {
        double here = 0.0;
        const view_ground_params params = {.model = v->scene.models[i].model,
                                           .position = position,
                                           .up = up,
                                           .reach = 0.3 * v->control.eye_height};
        if (v->scene.models[i].hidden || !view_ground_find(&v->ground, &params, &here))
            continue;
        if (p->exaggerate > 0.0)
            here = stp_exaggerated(p, (stp_dvec3){0.0, 0.0, here}).z;
        *height = found ? fmax(*height, here) : here;
        found = true;
    }
    return found;
}

static const char *pasted(void *context)
{
    return stp_window_pasted_text(context);
}

static void copied(void *context, const char *text)
{
    stp_window_copy_text(context, text);
}

static stp_status reload_side(viewer *v, stp_error *err)
{
    return stp_renderer_reload_shaders(v->renderer, err);
}

/* Reloads saved shaders. If they do not compile, shows the error and keeps the old ones; but what
 * changed while it was read is read again first. */
static void reload_shaders(viewer *v)
{
    stp_error err = {0};
    uint64_t state = view_watch_state(v->options->shader_folder);
    if (state == v->shader_state)
        return;
    v->shader_state = state;
    if (view_beside_both(v, reload_side, &err) == STP_OK) {
        v->control.changed = true;
        return;
    }
    if (view_watch_state(v->options->shader_folder) != state)
        return;
    fprintf(stderr, "stipple view: %s\n", err.message);
    view_note(v, "%s", err.message);
}

static void take_dropped(viewer *v)
{
    const char *paths[STP_WINDOW_DROP_LIMIT];
    size_t count = 0;
    while (count < STP_WINDOW_DROP_LIMIT &&
           (paths[count] = stp_window_dropped(v->window, count)) != NULL)
        count++;
    view_add_models(v, paths, count);
}

/* Opens what was chosen in the dialog. What cannot be opened leaves the scene as it is. */
static void take_chosen(viewer *v)
{
    const char *path = v->dialog.field;
    stp_error err = {0};
    if (v->dialog.choice == VIEW_OPEN_BESIDE) {
        view_add_models(v, &path, 1);
    } else if (v->dialog.choice == VIEW_OPEN_INSTEAD) {
        if (view_prepare_check(v, path, &err) == STP_OK) {
            snprintf(v->next, sizeof v->next, "%s", path);
            v->quits = true;
        } else {
            view_note(v, "%s", err.message);
        }
    }
    v->dialog.choice = VIEW_OPEN_NOTHING;
}

/* Passes an event to the panels. True if only they use it. */
static bool panels_take(viewer *v, const stp_window_event *e)
{
    static const int keys[STP_UI_KEY_COUNT] = {STP_KEY_TAB,
                                               STP_KEY_LEFT,
                                               STP_KEY_RIGHT,
                                               STP_KEY_UP,
                                               STP_KEY_DOWN,
                                               STP_KEY_HOME,
                                               STP_KEY_END,
                                               STP_KEY_DELETE,
                                               STP_KEY_BACKSPACE,
                                               STP_KEY_ENTER,
                                               STP_KEY_ESCAPE,
                                               'A',
                                               'C',
                                               'V',
                                               'X',
                                               'Y',
                                               'Z'};
    bool typing = stp_ui_wants_keys(v->ui);
    bool picture_drags = v->control.drag != VIEW_REST || v->beside.divider.dragged;
    if (e->kind == STP_WINDOW_MOVE || e->kind == STP_WINDOW_PRESS ||
        e->kind == STP_WINDOW_RELEASE || e->kind == STP_WINDOW_WHEEL)
        stp_ui_pointer(v->ui, e->x, v->layout.height - e->y);
    bool over = stp_ui_wants_pointer(v->ui) && !picture_drags;
    switch (e->kind) {
    case STP_WINDOW_CHARACTER:
        stp_ui_character(v->ui, e->character);
        return typing;
    case STP_WINDOW_KEY:
        for (int i = 0; i < STP_UI_KEY_COUNT; i++)
            if (keys[i] == e->key)
                stp_ui_key_down(v->ui, (stp_ui_key)i, e->down, e->shift, e->control);
        return typing && e->down && e->key != STP_KEY_F1 && e->key != STP_KEY_F11 &&
               !(v->dialog.shown && e->key == STP_KEY_ESCAPE);
    case STP_WINDOW_PRESS:
        if (over)
            stp_ui_button_down(v->ui, e->button, true);
        return over;
    case STP_WINDOW_RELEASE:
        stp_ui_button_down(v->ui, e->button, false);
        return over;
    case STP_WINDOW_WHEEL:
        if (over)
            stp_ui_wheel(v->ui, e->wheel);
        return over;
    case STP_WINDOW_MOVE:
        if (over) { /* the cursor is not over the picture */
            v->control.x = v->control.y = -1.0;
        }
        return over;
    case STP_WINDOW_BLUR:
        stp_ui_release_all(v->ui);
        return false;
    default:
        return false;
    }
}

/* Keeps the cursor's place between drags, too. */
static void follow(viewer *v, const stp_window_event *e)
{
    if (e->kind == STP_WINDOW_MOVE && v->control.drag == VIEW_REST) {
        v->control.x = e->x;
        v->control.y = e->y;
    }
}

/* Whether a key may be part of a path. */
static bool is_typing(const stp_window_event *e)
{
    return e->kind == STP_WINDOW_CHARACTER ||
           (e->kind == STP_WINDOW_KEY && e->down && !e->control && e->key != STP_KEY_ESCAPE &&
            e->key != STP_KEY_F1 && e->key != STP_KEY_F11);
}

/* Events up to one that ends the turn. */
static void take_events(viewer *v)
{
    stp_window_event event;
    bool again = true;
    while (again && stp_window_next(v->window, &event)) {
        v->ui_turns = VIEW_TURNS_TO_SETTLE;
        again = !view_control_ends_turn(&event);
        if (event.kind == STP_WINDOW_DROP)
            take_dropped(v);
        if (panels_take(v, &event) || (v->dialog.shown && is_typing(&event)))
            continue;
        follow(v, &event);
        if (!view_clip_handle(v, &event) && !view_beside_handle(v, &event))
            view_control_handle(&v->control, &event);
    }
}

/* Hides things that are shown only for a while. */
static void let_fade(viewer *v)
{
    if (v->note[0] != '\0' && v->now_s > v->note_until_s) {
        v->note[0] = '\0';
        v->ui_turns = v->ui_turns > 0 ? v->ui_turns : 1;
    }
    if (v->control.pivot_until_s > 0.0 && v->now_s > v->control.pivot_until_s) {
        v->control.pivot_until_s = 0.0;
        v->ui_turns = v->ui_turns > 0 ? v->ui_turns : 1;
    }
}

static void note_record(viewer *v)
{
    stp_error err = {0};
    if (view_record_note(&v->record, &v->control.camera, v->now_s, &err) == STP_OK)
        return;
    view_toggle_record(v);
    view_note(v, "%s", err.message);
}

static stp_status turn(viewer *v, stp_error *err)
{
    stp_status status = STP_OK;
    bool busy = v->control.changed || v->resting || v->ui_turns > 0 || v->control.wants != 0 ||
                v->shot.state == VIEW_SHOT_DRAWING;
    busy = busy && v->layout.width > 0; /* a minimised window waits */
    stp_window_wait(v->window, busy ? 0.0 : WAIT_S);
    v->now_s = stp_window_seconds(v->window);
    double scale = stp_window_scale(v->window);
    if (scale != stp_ui_scale(v->ui))
        stp_ui_set_scale(v->ui, scale);
    take_events(v);
    take_chosen(v);
    reload_shaders(v);
    view_beside_prepare(v);
    STP_TRY(view_fulfil(v, err));
    if (v->removing >= 0)
        view_remove_model(v, (size_t)v->removing);
    v->removing = -1;
    view_layout_update(v);
    if (view_move_advance(&v->control, v->now_s - v->last_turn_s))
        v->control.changed = true;
    v->last_turn_s = v->now_s;
    note_record(v);
    let_fade(v);
    if (!v->quits)
        STP_TRY(view_draw(v, err));
done:
    return status;
}

static stp_status open_window(viewer *v, stp_error *err)
{
    stp_status status = STP_OK;
    int size[2];
    bool has_size = v->options->camera.has_size;
    STP_TRY(camera_options_size(&v->options->camera, size, err));
    STP_TRY(
        stp_window_create(&v->window, v->scene.models[0].name, size[0], size[1], !has_size, err));
    const stp_ui_clipboard clipboard = {pasted, copied, v->window};
    double scale = stp_window_scale(v->window);
    STP_TRY(stp_ui_create(&v->ui, scale, &clipboard, err));
    stp_window_size(v->window, &v->layout.width, &v->layout.height);
    v->panels = v->panels_wanted && v->layout.width >= PANELS_LEAST_WIDTH * scale;
    view_layout_update(v);
done:
    return status;
}

static stp_status open_side(viewer *v, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(view_prepare_add(v, v->paths, v->path_count, err));
    STP_TRY(draw_options_params(v->options, v->scene.models[0].model, &v->control.params, err));
    if (v->control.params.threshold_px <= 0.0)
        v->control.params.threshold_px = 1.0; /* used if samples are left out again */
done:
    return status;
}

static stp_status open_viewer(viewer *v, stp_error *err)
{
    stp_status status = STP_OK;
    stp_error why = {0};
    const char *const *paths = v->paths;
    const size_t count = v->path_count;
    if (v->marks_file != NULL)
        STP_TRY(view_marked_load(&v->marked, v->marks_file, paths[0], err));
    STP_TRY(view_beside_both(v, open_side, err));
    STP_TRY(open_window(v, err));
    STP_TRY(view_beside_begin(v, err));
    STP_TRY(view_go_home(v, err));
    view_move_reset(&v->control);
    v->shader_state = view_watch_state(v->options->shader_folder);
    if (view_bookmarks_load(&v->bookmarks, paths[0], &why) != STP_OK)
        view_note(v, "%s", why.message);
    if (v->marks_file == NULL && view_marked_load(&v->marked, NULL, paths[0], &why) != STP_OK)
        view_note(v, "%s", why.message);
    for (size_t i = count < VIEW_RECENT_LIMIT ? count : VIEW_RECENT_LIMIT; i-- > 0;)
        view_recent_note(paths[i]);
done:
    return status;
}

static stp_status warn_side(viewer *v, stp_error *err)
{
    (void)err;
    for (size_t i = 0; i < v->scene.count; i++)
        source_options_warn(&cli_view, v->common, v->scene.models[i].model->file);
    return STP_OK;
}

static stp_status close_side(viewer *v, stp_error *err)
{
    (void)err;
    view_prepare_end(&v->prepare);
    stp_renderer_destroy(&v->renderer);
    view_scene_clear(&v->scene);
    return STP_OK;
}

/* What the viewer has besides the options of drawing. */
typedef struct own_options {
    double fps;
    const char *marks, *beside;
} own_options;

/* What is shown: the command line's files, or one that the user opened. */
typedef struct shown {
    draw_options options;
    own_options own;
    draw_beside beside;       /* if own.beside is given */
    const char *const *paths; /* of the command line; NULL: `path` */
    size_t count;
    char path[VIEW_PATH_BYTES];
    char note[VIEW_NOTE_BYTES]; /* said at first; "": nothing */
} shown;

/* Shows files until the user quits or opens another file, whose path is in `next` then. *opened:
 * whether they could be shown at all. The window's size goes to the options. */
static stp_status view(shown *s, const cli_common *common, char next[VIEW_PATH_BYTES], bool *opened,
                       stp_error *err)
{
    stp_status status = STP_OK;
    const char *path = s->path;
    view_side first = {.options = &s->options,
                       .paths = s->paths ? s->paths : &path,
                       .path_count = s->paths ? s->count : 1};
    view_side second = first;
    second.options = s->own.beside ? &s->beside.options : NULL;
    if (s->beside.path) {
        second.paths = (const char *const *)&s->beside.path;
        second.path_count = 1;
    }
    viewer v = {.side = first,
                .beside = {.other = second, .divider = {.at = 0.5}},
                .common = common,
                .fps = s->own.fps,
                .marks_file = s->own.marks,
                .clip = {.face = -1},
                .removing = -1,
                .control = {.depth = depth_under, .ground = ground_under, .x = -1.0, .y = -1.0}};
    v.control.context = &v;
    view_settings_load(&v);
    STP_TRY(open_viewer(&v, err));
    *opened = true;
    v.ui_turns = VIEW_TURNS_TO_SETTLE;
    v.now_s = stp_window_seconds(v.window);
    if (s->note[0] != '\0')
        view_note(&v, "%s", s->note);
    while (!v.quits && !cli_interrupted())
        STP_TRY(turn(&v, err));
    if (cli_interrupted())
        v.next[0] = '\0';
    if (v.record.on)
        view_toggle_record(&v);
    view_settings_save(&v);
    (void)view_beside_both(&v, warn_side, NULL);
done:
    memcpy(next, v.next, sizeof v.next);
    if (v.layout.width > 0 && next[0] != '\0' && !stp_window_is_full_screen(v.window)) {
        s->options.camera.size[0] = v.layout.width;
        s->options.camera.size[1] = v.layout.height;
        s->options.camera.has_size = true;
    }
    view_open_clear(&v.dialog);
    view_shot_end(&v.shot);
    view_record_destroy(&v.record);
    view_ground_forget(&v.ground, NULL);
    view_profile_forget(&v.profile, NULL);
    (void)view_beside_both(&v, close_side, NULL);
    stp_ui_destroy(&v.ui);
    stp_window_destroy(&v.window);
    return status;
}

/* Shows the file in `next`. If that fails although it could be opened, the files of before come
 * back, and a note says why. */
static stp_status view_another(shown *s, const cli_common *common, char next[VIEW_PATH_BYTES],
                               stp_error *err)
{
    bool opened = false;
    const shown before = *s;
    s->options.camera = camera_options_default();
    s->options.camera.has_size = before.options.camera.has_size;
    memcpy(s->options.camera.size, before.options.camera.size, sizeof before.options.camera.size);
    s->own.marks = NULL;
    s->paths = NULL;
    s->note[0] = '\0';
    memcpy(s->path, next, sizeof s->path);
    stp_status status = view(s, common, next, &opened, err);
    if (status == STP_OK || opened || cli_interrupted())
        return status;
    fprintf(stderr, "stipple view: %s\n", err->message);
    *s = before;
    snprintf(s->note, sizeof s->note, "%s", err->message);
    return view(s, common, next, &opened, err);
}

/* Half of a budget: two renderers share it. */
static uint64_t half(uint64_t bytes)
{
    return bytes > 1 ? bytes / 2 : bytes;
}

static int run(int argc, char **argv)
{
    shown s = {.options = draw_options_default()};
    draw_options *o = &s.options;
    own_options *own = &s.own;
    cli_common common = {0};
    static const char *paths[PREP_PATHS_LIMIT];
    size_t count = 0;
    stp_error err = {0};
    bool opened = false;
    char next[VIEW_PATH_BYTES];
    cli_option list[DRAW_OPTION_COUNT + 3] = {
        [DRAW_OPTION_COUNT] =
            {"--fps", 0, CLI_NUMBER, &own->fps, "N",
             "hold N frames a second while the camera moves, by a coarser threshold "
             "and fewer pixels; finer at rest",
             NULL},
        [DRAW_OPTION_COUNT + 1] = {"--marks", 0, CLI_STRING, &own->marks, "F.json",
                                   "file of marks, made with the first one (M.stipple.marks.json)",
                                   NULL},
        [DRAW_OPTION_COUNT + 2] = {"--beside", 0, CLI_OPTIONS, &own->beside, "[N.stipple][OPTIONS]",
                                   "show beside it another model, or the same with other options, "
                                   "like \"--threshold 4 --lod cpu\": --beside --help",
                                   NULL},
    };
    draw_options_fill(o, list);
    o->camera.size[0] = o->camera.size[1] = 0; /* by the screen */
    o->timeout_s = INFINITY;                   /* the viewer waits until the server answers again */
    int code = cli_parse(&cli_view, list, DRAW_OPTION_COUNT + 3, argc, argv, paths, 1,
                         PREP_PATHS_LIMIT, &count, &common);
    if (code != CLI_CONTINUE)
        return code;
    code = draw_options_check(o, &cli_view);
    if (code != CLI_CONTINUE)
        return code;
    if (draw_aa_times(o->aa) > 1)
        return cli_usage(&cli_view,
                         "--aa is none or edges here: render and fly draw finer pictures");
    if (own->fps < 0.0 || own->fps > FPS_MOST)
        return cli_usage(&cli_view, "--fps is a number up to %g", FPS_MOST);
    if (own->beside) {
        o->gpu_memory = half(o->gpu_memory);
        o->cpu_memory = half(o->cpu_memory);
        code = draw_beside_parse(&s.beside, own->beside, o, true);
    }
    if (code != CLI_CONTINUE)
        return code;
    cli_progress(&common); /* from here on, Ctrl-C is checked between frames */
    s.paths = paths;
    s.count = count;
    stp_status status = view(&s, &common, next, &opened, &err);
    while (status == STP_OK && next[0] != '\0')
        status = view_another(&s, &common, next, &err);
    draw_beside_clear(&s.beside);
    return status == STP_OK ? CLI_DONE : cli_fail(&cli_view, &err);
}
