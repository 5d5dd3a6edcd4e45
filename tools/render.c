/* stipple render: one picture without a display. */
#include "base/clock.h"
#include "base/file.h"
#include "base/memory.h"
#include "formats/image/image.h"
#include "runtime/gl_context.h"
#include "tools/draw_options.h"
#include "tools/source_options.h"

#include <cjson/cJSON.h>
#include <epoxy/gl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static int run(int argc, char **argv);
const cli_command cli_render = {
    .name = "render",
    .summary = "one picture of a model, without a display",
    .usage = "stipple render M.stipple -o I.png [options]",
    .details =
        "Without a camera the whole model is seen, filling the smaller side. The picture's alpha\n"
        "says where it is covered. --repeat N draws N times more and --stats says how long each\n"
        "took.",
    .run = run,
};

#define REPEAT_LIMIT 100000u

typedef struct options {
    draw_options draw;
    const char *output, *stats;
    uint64_t repeat;
    bool force;
} options;

typedef struct measured {
    double *frame_ms, *project_ms, *pull_push_ms, *shade_ms; /* count each */
    size_t count;
    stp_draw_stats last;
    stp_cut_measure cut;
} measured;

static int compare_doubles(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Sorts the values; the q-quantile of them. */
static double quantile(double *values, size_t count, double q)
{
    qsort(values, count, sizeof *values, compare_doubles);
    size_t at = (size_t)(q * (double)(count - 1) + 0.5);
    return values[at];
}

static cJSON *stats_json(measured *m, const stp_model *model, uint64_t bytes_read)
{
    cJSON *json = cJSON_CreateObject();
    cJSON *frame = cJSON_AddObjectToObject(json, "frame_ms");
    cJSON_AddNumberToObject(frame, "min", quantile(m->frame_ms, m->count, 0.0));
    cJSON_AddNumberToObject(frame, "median", quantile(m->frame_ms, m->count, 0.5));
    cJSON_AddNumberToObject(frame, "p99", quantile(m->frame_ms, m->count, 0.99));
    cJSON_AddNumberToObject(frame, "max", quantile(m->frame_ms, m->count, 1.0));
    cJSON_AddNumberToObject(json, "project_ms", quantile(m->project_ms, m->count, 0.5));
    cJSON_AddNumberToObject(json, "pull_push_ms", quantile(m->pull_push_ms, m->count, 0.5));
    cJSON_AddNumberToObject(json, "shade_ms", quantile(m->shade_ms, m->count, 0.5));
    cJSON_AddNumberToObject(json, "points_drawn", (double)m->last.points_drawn);
    cJSON_AddNumberToObject(json, "points_chosen", (double)m->cut.points);
    cJSON_AddNumberToObject(json, "patches_drawn", (double)m->cut.patches);
    cJSON_AddNumberToObject(json, "chunks_drawn", m->last.chunks_drawn);
    cJSON_AddNumberToObject(json, "chunks_missing", m->last.chunks_missing);
    cJSON_AddBoolToObject(json, "cut_complete", m->last.cut_complete);
    cJSON_AddNumberToObject(json, "max_error_px", m->cut.max_error_px);
    cJSON_AddNumberToObject(json, "passes", m->last.passes);
    cJSON_AddNumberToObject(json, "pyramid_levels", m->last.pyramid_levels);
    cJSON_AddNumberToObject(json, "bytes_read", (double)bytes_read);
    source_options_stats(json, model->file);
    cJSON_AddStringToObject(json, "gl_renderer", (const char *)glGetString(GL_RENDERER));
    return json;
}

static stp_status measure_create(measured *m, size_t count, stp_error *err)
{
    double **const arrays[4] = {&m->frame_ms, &m->project_ms, &m->pull_push_ms, &m->shade_ms};
    stp_status status = STP_OK;
    for (int i = 0; i < 4; i++)
        STP_TRY(stp_alloc(arrays[i], count, sizeof(double), "times", err));
done:
    return status;
}

/* The picture, and where --repeat asks for it more of the same. The first frame, which loads and
 * warms up, counts only if it is the only one. */
static stp_status draw(const options *o, const stp_draw_params *params, stp_renderer *renderer,
                       const stp_view *view, measured *m, stp_error *err)
{
    stp_status status = STP_OK;
    STP_TRY(measure_create(m, (size_t)o->repeat + 1, err));
    for (uint64_t i = 0; i <= o->repeat; i++) {
        STP_TRY(stp_renderer_draw(renderer, view, params, &m->last, err));
        if (i == 0 && o->repeat > 0)
            continue;
        m->frame_ms[m->count] = m->last.frame_ms;
        m->project_ms[m->count] = m->last.project_ms;
        m->pull_push_ms[m->count] = m->last.pull_push_ms;
        m->shade_ms[m->count++] = m->last.shade_ms;
        if (cli_interrupted()) {
            status = stp_error_set(err, STP_CANCELLED, "interrupted: nothing was written");
            goto done;
        }
    }
    if (o->stats != NULL)
        stp_renderer_measure(renderer, &m->cut);
done:
    return status;
}

/* Bottom row first to top row first. */
static void flip(uint8_t *rgba, int width, int height, uint8_t *row)
{
    size_t bytes = (size_t)width * 4;
    for (int y = 0; y < height / 2; y++) {
        uint8_t *a = rgba + (size_t)y * bytes, *b = rgba + (size_t)(height - 1 - y) * bytes;
        memcpy(row, a, bytes);
        memcpy(a, b, bytes);
        memcpy(b, row, bytes);
    }
}

static stp_status save(const options *o, stp_renderer *renderer, const stp_view *view,
                       stp_error *err)
{
    stp_status status = STP_OK;
    stp_image image = {view->width, view->height, NULL};
    uint8_t *row = NULL;
    STP_TRY(
        stp_alloc(&image.rgba, (size_t)view->width * (size_t)view->height, 4, "a picture", err));
    STP_TRY(stp_alloc(&row, (size_t)view->width, 4, "a picture", err));
    STP_TRY(stp_renderer_read(renderer, image.rgba, err));
    flip(image.rgba, image.width, image.height, row);
    STP_TRY(stp_image_save(&image, o->output, o->force, err));
done:
    free(row);
    stp_image_destroy(&image);
    return status;
}

static stp_status render(const options *o, const cli_common *common, const char *path,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_model *model = NULL;
    stp_gl_context *context = NULL;
    stp_renderer *renderer = NULL;
    stp_camera camera;
    stp_view view;
    stp_draw_params drawn;
    measured m = {0};
    int size[2];
    const char *const outputs[CLI_OUTPUT_LIMIT] = {o->output, o->stats};
    const char *const inputs[] = {path, o->draw.camera.path};
    STP_TRY(cli_check_outputs(outputs, inputs, 2, o->force, err));
    STP_TRY(draw_options_open(&o->draw, path, &model, err));
    STP_TRY(draw_options_camera(&o->draw, model, &camera, size, err));
    STP_TRY(stp_view_create(&view, &camera, &model->ball, size[0], size[1], err));
    STP_TRY(draw_options_params(&o->draw, model, &drawn, err));
    drawn.timed = o->stats != NULL;
    STP_TRY(stp_gl_context_create(&context, err));
    stp_renderer_params params = draw_options_renderer(&o->draw, model, common);
    STP_TRY(stp_renderer_create(&renderer, &params, err));
    STP_TRY(draw(o, &drawn, renderer, &view, &m, err));
    STP_TRY(save(o, renderer, &view, err));
    if (o->stats != NULL)
        STP_TRY(cli_write_json(o->stats, stats_json(&m, model, stp_renderer_bytes_read(renderer)),
                               o->force, err));
    source_options_warn(&cli_render, common, model->file);
    if (stp_renderer_damage(renderer)[0] != '\0' && !common->quiet)
        fprintf(stderr, "stipple render: warning: %s; its parent is drawn instead\n",
                stp_renderer_damage(renderer));
done:
    free(m.frame_ms);
    free(m.project_ms);
    free(m.pull_push_ms);
    free(m.shade_ms);
    stp_renderer_destroy(&renderer);
    stp_gl_context_destroy(&context);
    stp_model_close(&model);
    return status;
}

static int run(int argc, char **argv)
{
    options o = {.draw = draw_options_default()};
    cli_common common = {0};
    const char *path = NULL;
    size_t count = 0;
    stp_error err = {0};
    cli_option list[DRAW_OPTION_COUNT + 4] = {
        [DRAW_OPTION_COUNT] = {"--output", 'o', CLI_STRING, &o.output, "I.png",
                               "the picture to write", NULL},
        {"--stats", 0, CLI_STRING, &o.stats, "F.json", "times and counts to write", NULL},
        {"--repeat", 0, CLI_UINT, &o.repeat, "N", "draw N times more, for the times (0)", NULL},
        {"--force", 'f', CLI_FLAG, &o.force, NULL, "replace existing files", NULL},
    };
    draw_options_fill(&o.draw, list);
    int code = cli_parse(&cli_render, list, sizeof list / sizeof *list, argc, argv, &path, 1, 1,
                         &count, &common);
    if (code != CLI_CONTINUE)
        return code;
    if (o.output == NULL)
        return cli_usage(&cli_render, "-o I.png is missing");
    if (o.repeat > REPEAT_LIMIT)
        return cli_usage(&cli_render, "--repeat is at most %u", REPEAT_LIMIT);
    if (o.draw.threshold_px < 0.0)
        return cli_usage(&cli_render, "--threshold is not negative");
    cli_progress(&common); /* Ctrl-C from here on is asked for between frames */
    return render(&o, &common, path, &err) == STP_OK ? CLI_DONE : cli_fail(&cli_render, &err);
}
