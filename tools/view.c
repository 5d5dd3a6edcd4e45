/* stipple view: a window to fly through a model. */
#include "base/memory.h"
#include "runtime/window/window.h"
#include "tools/draw_options.h"
#include "tools/source_options.h"
#include "tools/view_control.h"
#include "tools/view_watch.h"

#include <stdio.h>
#include <string.h>

static int run(int argc, char **argv);
const cli_command cli_view = {
    .name = "view",
    .summary = "a window to fly through a model",
    .usage = "stipple view M.stipple [options]",
    .details = "The window's title says how long a frame took, how many points it drew, and how.\n"
               "With --shaders, files saved in the folder show at once.\n" VIEW_KEYS,
    .run = run,
};

/* How long to wait for an event while chunks are on their way. */
#define LOADING_S 0.004
/* How long to wait for an event before looking at the shader folder and for Ctrl-C. */
#define WAIT_S 0.25
#define TITLE_BYTES 512

typedef struct viewer {
    const draw_options *options;
    const char *name; /* of the model, for the title */
    stp_model *model;
    stp_window *window;
    stp_renderer *renderer;
    view_control control;
    stp_draw_stats stats; /* of the last frame */
    bool loading;         /* chunks are on their way */
    bool quiet, said_damage;
    uint64_t shader_state;
} viewer;

static double depth_under(void *context, int x, int y)
{
    const viewer *v = context;
    float depth = 0.0f; /* stays so outside the picture */
    stp_renderer_depth_at(v->renderer, x, y, &depth, NULL);
    return (double)depth;
}

/* The view it began with, for the window's present size. */
static stp_status go_home(viewer *v, stp_error *err)
{
    draw_options o = *v->options;
    int size[2];
    int *wanted = o.camera.size;
    stp_window_size(v->window, &wanted[0], &wanted[1]);
    o.camera.has_size = true;
    if (wanted[0] < 1 || wanted[1] < 1)
        wanted[0] = wanted[1] = 1;
    return draw_options_camera(&o, v->model, &v->control.camera, size, err);
}

/* What --colour-range gives is of the colour it began with. */
static stp_status set_range(viewer *v, stp_error *err)
{
    stp_draw_params *p = &v->control.params, first;
    if ((int)p->colour == v->options->colour) {
        stp_status status = draw_options_params(v->options, v->model, &first, err);
        memcpy(p->colour_range, first.colour_range, sizeof p->colour_range);
        return status;
    }
    if (p->colour == STP_COLOUR_INTENSITY || p->colour == STP_COLOUR_ELEVATION)
        return stp_model_colour_range(v->model, p->colour, p->colour_range, err);
    return STP_OK;
}

static uint32_t colours_of(const stp_model *model)
{
    uint32_t colours = 1u << STP_COLOUR_RGB | 1u << STP_COLOUR_NONE | 1u << STP_COLOUR_ELEVATION;
    colours |= model->info->attributes & STP_HAS_INTENSITY ? 1u << STP_COLOUR_INTENSITY : 0;
    colours |= model->info->attributes & STP_HAS_CLASS ? 1u << STP_COLOUR_CLASS : 0;
    return colours;
}

/* Nothing for the samples' own colours. */
static void colour_words(const stp_draw_params *p, char out[40])
{
    char colour[16], palette[16];
    draw_options_word(DRAW_COLOURS, (int)p->colour, colour);
    draw_options_word(DRAW_PALETTES, (int)p->palette, palette);
    bool graded = p->colour == STP_COLOUR_INTENSITY || p->colour == STP_COLOUR_ELEVATION;
    out[0] = '\0';
    if (p->colour != STP_COLOUR_RGB)
        snprintf(out, 40, ", %s%s%s", colour, graded ? " in " : "", graded ? palette : "");
}

static void show_title(const viewer *v)
{
    const stp_draw_params *p = &v->control.params;
    char title[TITLE_BYTES], lod[16], reconstruct[16], shade[16], threshold[32], colour[40],
        missing[40] = "";
    draw_options_word(DRAW_LODS, (int)p->lod, lod);
    draw_options_word(DRAW_RECONSTRUCTIONS, (int)p->reconstruct, reconstruct);
    draw_options_word(DRAW_SHADES, (int)p->shade, shade);
    colour_words(p, colour);
    snprintf(threshold, sizeof threshold, "threshold %.4g px", p->threshold_px);
    if (p->every_sample || p->lod == STP_LOD_FULL)
        snprintf(threshold, sizeof threshold, "every sample");
    if (v->stats.chunks_missing > 0)
        snprintf(missing, sizeof missing, ", %u chunks missing", v->stats.chunks_missing);
    snprintf(title, sizeof title, "%.200s: %.1f ms, %llu points, %s, %s, %s, %s%s%s", v->name,
             v->stats.frame_ms, (unsigned long long)v->stats.points_drawn, threshold, lod,
             reconstruct, shade, colour, missing);
    stp_window_set_title(v->window, title);
}

static void show_damage(viewer *v)
{
    const char *damage = stp_renderer_damage(v->renderer);
    if (v->said_damage || v->quiet || damage[0] == '\0')
        return;
    fprintf(stderr, "stipple view: warning: %s; its parent is drawn instead\n", damage);
    v->said_damage = true;
}

static stp_status draw_frame(viewer *v, int width, int height, stp_error *err)
{
    stp_status status = STP_OK;
    view_control *c = &v->control;
    c->params.stream = true;
    STP_TRY(stp_view_create(&c->view, &c->camera, &c->ball, width, height, err));
    STP_TRY(stp_renderer_draw(v->renderer, &c->view, &c->params, &v->stats, err));
    stp_renderer_present(v->renderer, 0, width, height);
    stp_window_present(v->window);
    v->loading = v->stats.chunks_loading > 0;
    show_title(v);
    show_damage(v);
done:
    return status;
}

/* Shaders that were saved; those that do not compile are told of, and the old ones go on. */
static void reload_shaders(viewer *v)
{
    stp_error err = {0};
    uint64_t state = view_watch_state(v->options->shader_folder);
    if (state == v->shader_state)
        return;
    v->shader_state = state;
    if (stp_renderer_reload_shaders(v->renderer, &err) == STP_OK)
        v->control.changed = true;
    else
        fprintf(stderr, "stipple view: %s\n", err.message);
}

static stp_status loop(viewer *v, stp_error *err)
{
    stp_status status = STP_OK;
    view_control *c = &v->control;
    c->changed = true;
    while (!c->wants_quit && !cli_interrupted()) {
        stp_window_event event;
        int width = 0, height = 0;
        stp_window_wait(v->window, c->changed ? 0.0 : v->loading ? LOADING_S : WAIT_S);
        while (stp_window_next(v->window, &event))
            view_control_handle(c, &event);
        reload_shaders(v);
        if (c->wants_home)
            STP_TRY(go_home(v, err));
        c->wants_home = false;
        if (c->wants_range)
            STP_TRY(set_range(v, err));
        c->wants_range = false;
        stp_window_size(v->window, &width, &height);
        bool seen = width > 0 && height > 0;
        c->changed = c->changed || (v->loading && stp_renderer_has_news(v->renderer));
        if (seen && !c->wants_quit && c->changed)
            STP_TRY(draw_frame(v, width, height, err));
        c->changed = false;
    }
done:
    return status;
}

static stp_status open_viewer(viewer *v, const char *path, const cli_common *common, stp_error *err)
{
    stp_status status = STP_OK;
    int size[2];
    STP_TRY(draw_options_open(v->options, path, &v->model, err));
    const char *name = stp_chunk_file_path(v->model->file), *slash = strrchr(name, '/');
    v->name = slash != NULL && slash[1] != '\0' ? slash + 1 : name;
    v->control.ball = v->model->ball;
    v->control.colours = colours_of(v->model);
    STP_TRY(draw_options_camera(v->options, v->model, &v->control.camera, size, err));
    STP_TRY(draw_options_params(v->options, v->model, &v->control.params, err));
    bool has_size = v->options->camera.has_size;
    STP_TRY(stp_window_create(&v->window, v->name, size[0], size[1], !has_size, err));
    stp_renderer_params params = draw_options_renderer(v->options, v->model, common);
    STP_TRY(stp_renderer_create(&v->renderer, &params, err));
    STP_TRY(go_home(v, err));
    v->shader_state = view_watch_state(v->options->shader_folder);
done:
    return status;
}

static stp_status view(const draw_options *o, const cli_common *common, const char *path,
                       stp_error *err)
{
    stp_status status = STP_OK;
    viewer v = {.options = o, .quiet = common->quiet, .control = {.depth = depth_under}};
    v.control.context = &v;
    STP_TRY(open_viewer(&v, path, common, err));
    STP_TRY(loop(&v, err));
    source_options_warn(&cli_view, common, v.model->file);
done:
    stp_renderer_destroy(&v.renderer);
    stp_window_destroy(&v.window);
    stp_model_close(&v.model);
    return status;
}

static int run(int argc, char **argv)
{
    draw_options o = draw_options_default();
    cli_common common = {0};
    const char *path = NULL;
    size_t count = 0;
    stp_error err = {0};
    cli_option list[DRAW_OPTION_COUNT];
    draw_options_fill(&o, list);
    int code =
        cli_parse(&cli_view, list, DRAW_OPTION_COUNT, argc, argv, &path, 1, 1, &count, &common);
    if (code != CLI_CONTINUE)
        return code;
    if (o.threshold_px < 0.0)
        return cli_usage(&cli_view, "--threshold is not negative");
    cli_progress(&common); /* Ctrl-C from here on is asked for between frames */
    return view(&o, &common, path, &err) == STP_OK ? CLI_DONE : cli_fail(&cli_view, &err);
}
