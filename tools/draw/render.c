/* stipple render: draws one picture without a display. */
#include "base/json.h"
#include "formats/image/image.h"
#include "runtime/gl/gl_context.h"
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
    const char *stats;
    uint64_t repeat;
    bool force;
} options;

/* Draws the picture, and with --repeat more of the same. The first frame loads and warms up, so it
 * counts only if it is the only one. */
static stp_status draw(const options *o, const stp_draw_params *params, stp_renderer *renderer,
                       const stp_view *view, draw_picture *picture, draw_measure *m, stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw_stats stats;
    bool whole = o->stats != NULL || o->files.depth != NULL || o->files.normals != NULL;
    for (uint64_t i = 0; i <= o->repeat; i++) {
        STP_TRY(draw_picture_draw(picture, renderer, view, params, whole, &stats, err));
        if (i == 0 && o->repeat > 0)
            continue;
        STP_TRY(draw_measure_add(m, &stats, err));
        if (cli_interrupted()) {
            status = stp_error_set(err, STP_CANCELLED, "interrupted: nothing was written");
            goto done;
        }
    }
    if (o->stats != NULL)
        draw_measure_cut(m, renderer);
done:
    return status;
}

/* paths: of models or scans; there is room for one more. */
static stp_status render(const options *o, const cli_common *common, const char **paths,
                         size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    stp_model *model = NULL;
    stp_gl_context *context = NULL;
    stp_renderer *renderer = NULL;
    stp_camera camera;
    stp_view view;
    stp_draw_params drawn;
    draw_measure m = {0};
    draw_picture picture = {.aa = o->draw.aa};
    int size[2];
    const draw_outputs *files = &o->files;
    const char *const outputs[CLI_OUTPUT_LIMIT] = {files->picture, files->depth, files->normals,
                                                   o->stats};
    const open_scan_params scan = draw_options_scan(&o->draw, cli_render.name, common);
    paths[count] = o->draw.camera.path;
    STP_TRY(cli_check_outputs(outputs, paths, count + 1, o->force, err));
    STP_TRY(draw_options_open(&o->draw, &scan, paths, count, &model, err));
    STP_TRY(draw_options_camera(&o->draw, model, &camera, size, err));
    const stp_ball ball = draw_options_ball(&o->draw, model);
    STP_TRY(stp_view_create(&view, &camera, &ball, size[0], size[1], err));
    STP_TRY(draw_options_params(&o->draw, model, &drawn, err));
    drawn.timed = o->stats != NULL;
    drawn.keep_pixels = files->normals != NULL;
    STP_TRY(stp_gl_context_create(&context, err));
    stp_renderer_params params = draw_options_renderer(&o->draw, model, common);
    STP_TRY(stp_renderer_create(&renderer, &params, err));
    STP_TRY(draw(o, &drawn, renderer, &view, &picture, &m, err));
    STP_TRY(draw_options_require_whole(&o->draw, renderer, err));
    STP_TRY(draw_save(&picture, renderer, &view, &camera, files, o->force, err));
    if (o->stats != NULL)
        STP_TRY(stp_json_save(draw_measure_json(&m, renderer, model), o->stats, o->force, err));
    source_options_warn(&cli_render, common, model->file);
    draw_options_warn(cli_render.name, renderer);
done:
    free(picture.fine);
    draw_measure_clear(&m);
    stp_renderer_destroy(&renderer);
    stp_gl_context_destroy(&context);
    stp_model_close(&model);
    return status;
}

static int run(int argc, char **argv)
{
    options o = {.draw = draw_options_default()};
    cli_common common = {0};
    static const char *paths[PREP_PATHS_LIMIT + 1];
    size_t count = 0;
    stp_error err = {0};
    cli_option list[DRAW_OPTION_COUNT + 6] = {
        [DRAW_OPTION_COUNT] = {"--output", 'o', CLI_STRING, &o.files.picture, "I.png",
                               "the picture to write", NULL},
        {"--depth", 0, CLI_STRING, &o.files.depth, "F.exr",
         "write depths along the camera's axis; inf where nothing is drawn", NULL},
        {"--normals", 0, CLI_STRING, &o.files.normals, "F.exr",
         "write normals in the world's axes; 0 0 0 where nothing is drawn", NULL},
        {"--stats", 0, CLI_STRING, &o.stats, "F.json", "write times and counts", NULL},
        {"--repeat", 0, CLI_UINT, &o.repeat, "N", "draw N more times, to measure time (0)", NULL},
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
    code = draw_options_check(&o.draw, &cli_render);
    if (code != CLI_CONTINUE)
        return code;
    cli_progress(&common); /* from here on, Ctrl-C is checked between frames */
    return render(&o, &common, paths, count, &err) == STP_OK ? CLI_DONE
                                                             : cli_fail(&cli_render, &err);
}
