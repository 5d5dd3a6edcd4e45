/* stipple render: draws one picture without a display. */
#include "base/json.h"
#include "base/memory.h"
#include "formats/image/image.h"
#include "runtime/gl/gl_context.h"
#include "tools/draw/draw_beside.h"
#include "tools/draw/draw_measure.h"
#include "tools/draw/draw_options.h"
#include "tools/draw/draw_save.h"
#include "tools/file/source_options.h"

#include <stdlib.h>

static int run(int argc, char **argv);
const cli_command cli_render = {
    .name = "render",
    .summary = "draw one picture of a model or scan, without a display",
    .usage = "stipple render M.stipple -o I.png [options]",
    .details =
        "If no camera is given and --view is first, the picture shows the model as its scanner "
        "saw\n"
        "it or, if the model is an interior, from inside. For other models, and with --view "
        "whole,\n"
        "the picture shows the whole model, which fills the smaller side. The picture's alpha "
        "says\n"
        "how much of a pixel the model covers; with --aa none, all or nothing. --repeat N draws N\n"
        "more times and --stats says how long each picture took.\n"
        "\n" OPEN_SCAN_HELP,
    .run = run,
};

#define REPEAT_LIMIT 100000u

typedef struct options {
    draw_options draw;
    draw_outputs files;
    const char *stats, *beside;
    draw_beside right; /* if beside is given */
    uint64_t repeat;
    bool force;
} options;

/* One picture: all of it, or with --beside one of two. */
typedef struct side {
    const draw_options *options;
    const char *const *paths; /* of models or scans */
    size_t count;
    stp_model *model;
    stp_draw_params params;
    stp_renderer *renderer;
    stp_view view;
    draw_picture picture;
    draw_measure measure;
} side;

static stp_status open_side(side *s, const cli_common *common, stp_error *err)
{
    stp_status status = STP_OK;
    const open_scan_params scan = draw_options_scan(s->options, cli_render.name, common);
    STP_TRY(draw_options_open(s->options, &scan, s->paths, s->count, &s->model, err));
    STP_TRY(draw_options_params(s->options, s->model, &s->params, err));
done:
    return status;
}

/* Draws the picture, and with --repeat more of the same. The first frame loads and warms up, so it
 * counts only if it is the only one. */
static stp_status draw(const options *o, side *s, stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw_stats stats;
    bool whole = o->stats != NULL || o->files.depth != NULL || o->files.normals != NULL;
    for (uint64_t i = 0; i <= o->repeat; i++) {
        STP_TRY(
            draw_picture_draw(&s->picture, s->renderer, &s->view, &s->params, whole, &stats, err));
        if (i == 0 && o->repeat > 0)
            continue;
        STP_TRY(draw_measure_add(&s->measure, &stats, err));
        if (cli_interrupted()) {
            status = stp_error_set(err, STP_CANCELLED, "interrupted: nothing was written");
            goto done;
        }
    }
    if (o->stats != NULL)
        draw_measure_cut(&s->measure, s->renderer);
done:
    return status;
}

static stp_status draw_side(const options *o, const cli_common *common, const stp_camera *camera,
                            const int size[2], side *s, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_ball ball = draw_options_ball(s->options, s->model);
    const stp_renderer_params params = draw_options_renderer(s->options, s->model, common);
    STP_TRY(stp_view_create(&s->view, camera, &ball, size[0], size[1], err));
    STP_TRY(stp_renderer_create(&s->renderer, &params, err));
    s->picture.aa = s->options->aa;
    s->params.timed = o->stats != NULL;
    s->params.keep_pixels = o->files.normals != NULL;
    STP_TRY(draw(o, s, err));
    STP_TRY(draw_options_require_whole(s->options, s->renderer, err));
    source_options_warn(&cli_render, common, s->model->file);
    draw_options_warn(cli_render.name, s->renderer);
done:
    return status;
}

static void close_side(side *s)
{
    free(s->picture.fine);
    free(s->picture.right);
    draw_measure_clear(&s->measure);
    stp_renderer_destroy(&s->renderer);
}

/* Draws the sides, and puts what the second one shows beside the first. */
static stp_status draw_sides(const options *o, const cli_common *common, side *sides, int count,
                             stp_camera *camera, stp_error *err)
{
    stp_status status = STP_OK;
    int size[2];
    STP_TRY(draw_options_camera(&o->draw, sides[0].model, camera, size, err));
    for (int i = 0; i < count; i++)
        STP_TRY(draw_side(o, common, camera, size, &sides[i], err));
    if (count > 1) {
        STP_TRY(stp_alloc(&sides[0].picture.right, (size_t)size[0] * (size_t)size[1], 4,
                          "a picture", err));
        STP_TRY(draw_picture_read(&sides[1].picture, sides[1].renderer, &sides[1].view,
                                  sides[0].picture.right, err));
    }
done:
    return status;
}

/* paths: of models or scans; there is room for two more. */
static stp_status render(const options *o, const cli_common *common, const char **paths,
                         size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_gl_context *context = NULL;
    stp_camera camera;
    const draw_beside *beside = &o->right;
    side sides[2] = {{.options = &o->draw, .paths = paths, .count = count},
                     {.options = &beside->options, .paths = paths, .count = count}};
    const int side_count = o->beside ? 2 : 1;
    const draw_outputs *files = &o->files;
    const char *const outputs[CLI_OUTPUT_LIMIT] = {files->picture, files->depth, files->normals,
                                                   o->stats};
    paths[count] = o->draw.camera.path;
    paths[count + 1] = beside->path;
    STP_TRY(cli_check_outputs(outputs, paths, count + 2, o->force, err));
    if (beside->path) {
        sides[1].paths = &paths[count + 1];
        sides[1].count = 1;
    }
    for (int i = 0; i < side_count; i++)
        STP_TRY(open_side(&sides[i], common, err));
    if (side_count > 1)
        draw_beside_join_ranges(&sides[0].params, &o->draw, &sides[1].params, &beside->options,
                                sides[0].model->info->attributes &
                                    sides[1].model->info->attributes);
    STP_TRY(stp_gl_context_create(&context, err));
    STP_TRY(draw_sides(o, common, sides, side_count, &camera, err));
    STP_TRY(draw_save(&sides[0].picture, sides[0].renderer, &sides[0].view, &camera, files,
                      o->force, err));
    if (o->stats != NULL)
        STP_TRY(
            stp_json_save(draw_measure_json(&sides[0].measure, sides[0].renderer, sides[0].model),
                          o->stats, o->force, err));
done:
    close_side(&sides[0]);
    close_side(&sides[1]);
    stp_gl_context_destroy(&context);
    stp_model_close(&sides[0].model);
    stp_model_close(&sides[1].model);
    return status;
}

static int run(int argc, char **argv)
{
    options o = {.draw = draw_options_default()};
    cli_common common = {0};
    static const char *paths[PREP_PATHS_LIMIT + 2];
    size_t count = 0;
    stp_error err = {0};
    cli_option list[DRAW_OPTION_COUNT + 7] = {
        [DRAW_OPTION_COUNT] = {"--output", 'o', CLI_STRING, &o.files.picture, "I.png",
                               "the picture to write", NULL},
        {"--depth", 0, CLI_STRING, &o.files.depth, "F.exr",
         "write depths along the camera's axis; inf where nothing is drawn", NULL},
        {"--normals", 0, CLI_STRING, &o.files.normals, "F.exr",
         "write normals in the world's axes; 0 0 0 where nothing is drawn", NULL},
        {"--stats", 0, CLI_STRING, &o.stats, "F.json", "write times and counts", NULL},
        {"--repeat", 0, CLI_UINT, &o.repeat, "N", "draw N more times, to measure time (0)", NULL},
        {"--beside", 0, CLI_OPTIONS, &o.beside, "[N.stipple][OPTIONS]",
         "the right half shows another model, or the same with other options, like \"--threshold 4 "
         "--lod cpu\": --beside --help",
         NULL},
        {"--force", 'f', CLI_FLAG, &o.force, NULL, "replace existing files", NULL},
    };
    draw_options_fill(&o.draw, list);
    int code = cli_parse(&cli_render, list, sizeof list / sizeof *list, argc, argv, paths, 1,
                         PREP_PATHS_LIMIT, &count, &common);
    if (code != CLI_CONTINUE)
        return code;
    if (o.files.picture == NULL)
        return cli_usage(&cli_render, "-o I.png is missing");
    if ((o.files.depth && !stp_image_keeps_floats(o.files.depth)) ||
        (o.files.normals && !stp_image_keeps_floats(o.files.normals)))
        return cli_usage(&cli_render, "--depth and --normals take names that end in .exr");
    if (o.repeat > REPEAT_LIMIT)
        return cli_usage(&cli_render, "--repeat is at most %u", REPEAT_LIMIT);
    if (o.beside && (o.files.depth || o.files.normals || o.stats || o.repeat > 0))
        return cli_usage(&cli_render, "--beside is for one picture: leave out --depth, --normals, "
                                      "--stats and --repeat");
    if (o.beside) {
        code = draw_beside_parse(&o.right, o.beside, &o.draw, false);
        if (code != CLI_CONTINUE)
            return code;
    }
    code = draw_options_check(&o.draw, &cli_render);
    if (code != CLI_CONTINUE)
        goto done;
    cli_progress(&common); /* from here on, Ctrl-C is checked between frames */
    code =
        render(&o, &common, paths, count, &err) == STP_OK ? CLI_DONE : cli_fail(&cli_render, &err);
done:
    draw_beside_clear(&o.right);
    return code;
}
