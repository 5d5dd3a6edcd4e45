/* stipple fly: draws a camera path as numbered pictures or as a film, without a display. */
#include "base/clock.h"
#include "base/json.h"
#include "base/memory.h"
#include "runtime/camera/path.h"
#include "runtime/gl/gl_context.h"
#include "tools/draw/draw_measure.h"
#include "tools/draw/draw_options.h"
#include "tools/draw/draw_save.h"
#include "tools/draw/fly_film.h"
#include "tools/draw/fly_folder.h"
#include "tools/draw/fly_job.h"
#include "tools/file/source_options.h"

#include <epoxy/gl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>

static int run(int argc, char **argv);
const cli_command cli_fly = {
    .name = "fly",
    .summary = "draw a camera path as numbered pictures or a film, without a display",
    .usage = "stipple fly M.stipple --path P.json -o F.mp4 [options]",
    .details =
        "A path is JSON: {\"keyframes\": [{\"time\": 0, \"eye\": [x, y, z], \"look\": [x, y, z]}, "
        "...],\n"
        "\"loop\": false}. A keyframe also has \"up\" and \"fovy_deg\" or \"height\" where they "
        "change. Or:\n"
        "{\"turntable\": {\"seconds\": 8, \"degrees\": 360, \"elevation_deg\": 20}} turns the "
        "camera of the\n"
        "options about the point that it looks at.\n"
        "If the output's name ends in .mp4, .mov, .mkv or .webm, it is a film, and an installed\n"
        "ffmpeg makes it. Any other name is a folder, which gets frame_000001.png and so on. If a\n"
        "run into a folder is interrupted, the same command continues there. A film starts anew.\n"
        "\n" OPEN_SCAN_HELP,
    .run = run,
};

typedef struct options {
    draw_options draw;
    const char *output, *stats, *path, *frames;
    double turntable_s, rate;
    const cli_option *list; /* all options, those of drawing first */
    uint64_t first, last;   /* range of frames, counted from 1; last 0: to the end */
    bool has_turntable, depth, normals, force;
} options;

/* The state of a flight. */
typedef struct flight {
    const options *o;
    stp_model *model;
    stp_gl_context *context;
    stp_renderer *renderer;
    stp_path *path;
    fly_folder *folder; /* folder or film is set */
    fly_film *film;
    uint8_t *rgba; /* a frame of the film */
    stp_draw_params params;
    draw_picture picture;
    int size[2];
    uint64_t frame_count, first, last;
    uint64_t done, there; /* number of frames made by this run, and found finished */
    draw_measure measure;
} flight;

/* ---- before the first frame ---- */

static stp_status open_path(flight *f, stp_error *err)
{
    const options *o = f->o;
    stp_camera base;
    stp_status status = draw_options_camera(&o->draw, f->model, &base, f->size, err);
    if (status != STP_OK)
        return status;
    if (o->path != NULL)
        return stp_path_load(&f->path, o->path, &base, err);
    return stp_path_create_turntable(&f->path, &(stp_turntable){.seconds = o->turntable_s}, &base,
                                     err);
}

static stp_status choose_frames(flight *f, stp_error *err)
{
    stp_status status = stp_path_frame_count(f->path, f->o->rate, &f->frame_count, err);
    if (status != STP_OK)
        return status;
    f->first = f->o->first;
    f->last = f->o->last > 0 ? f->o->last : f->frame_count;
    if (f->first > f->frame_count || f->last > f->frame_count)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "--frames %s: the film has frames 1 to %llu", f->o->frames,
                             (unsigned long long)f->frame_count);
    return STP_OK;
}

static stp_status open_folder(flight *f, stp_error *err)
{
    const options *o = f->o;
    cJSON *job =
        fly_job_create(&(fly_job_params){.model = f->model,
                                         .path = f->path,
                                         .rate = o->rate,
                                         .frame_count = f->frame_count,
                                         .size = f->size,
                                         .options = o->list,
                                         .option_count = DRAW_OPTION_COUNT,
                                         .gl_renderer = (const char *)glGetString(GL_RENDERER)});
    stp_status status = fly_folder_open(&f->folder,
                                        &(fly_folder_params){.path = o->output,
                                                             .job = job,
                                                             .depth = o->depth,
                                                             .normals = o->normals,
                                                             .force = o->force},
                                        err);
    cJSON_Delete(job);
    return status;
}

static stp_status open_film(flight *f, stp_error *err)
{
    size_t count = (size_t)f->size[0] * (size_t)f->size[1];
    stp_status status = stp_alloc(&f->rgba, count, 4, "a picture", err);
    if (status != STP_OK)
        return status;
    return fly_film_create(&f->film,
                           &(fly_film_params){.path = f->o->output,
                                              .width = f->size[0],
                                              .height = f->size[1],
                                              .rate = f->o->rate,
                                              .force = f->o->force},
                           err);
}

/* paths: of models or scans; there is room for two more. */
static stp_status open_flight(flight *f, const char **paths, size_t count, const cli_common *common,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const options *o = f->o;
    bool is_film = fly_film_is_name(o->output);
    const char *const outputs[CLI_OUTPUT_LIMIT] = {is_film ? o->output : NULL, o->stats};
    const open_scan_params scan = draw_options_scan(&o->draw, cli_fly.name, common);
    paths[count] = o->draw.camera.path;
    paths[count + 1] = o->path;
    STP_TRY(cli_check_outputs(outputs, paths, count + 2, o->force, err));
    STP_TRY(draw_options_open(&o->draw, &scan, paths, count, &f->model, err));
    STP_TRY(open_path(f, err));
    STP_TRY(choose_frames(f, err));
    STP_TRY(draw_options_params(&o->draw, f->model, &f->params, err));
    f->picture.aa = o->draw.aa;
    f->params.timed = o->stats != NULL;
    f->params.keep_pixels = o->normals;
    STP_TRY(stp_gl_context_create(&f->context, err));
    stp_renderer_params params = draw_options_renderer(&o->draw, f->model, common);
    params.views_follow = f->last > f->first;
    STP_TRY(stp_renderer_create(&f->renderer, &params, err));
    STP_TRY(is_film ? open_film(f, err) : open_folder(f, err));
done:
    return status;
}

/* ---- frames ---- */

static stp_status make_frame(flight *f, uint64_t number, const stp_progress *progress,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_view view;
    stp_draw_stats stats;
    stp_camera camera = stp_path_frame(f->path, f->o->rate, f->frame_count, number - 1);
    const stp_ball ball = draw_options_ball(&f->o->draw, f->model);
    STP_TRY(stp_view_create(&view, &camera, &ball, f->size[0], f->size[1], err));
    bool whole = f->o->stats != NULL || f->o->depth || f->o->normals;
    STP_TRY(draw_picture_draw(&f->picture, f->renderer, &view, &f->params, whole, &stats, err));
    STP_TRY(draw_options_require_whole(&f->o->draw, f->renderer, err));
    if (f->o->stats != NULL) {
        STP_TRY(draw_measure_add(&f->measure, &stats, err));
        draw_measure_cut(&f->measure, f->renderer);
    }
    if (f->film != NULL) {
        STP_TRY(draw_picture_read(&f->picture, f->renderer, &view, f->rgba, err));
        STP_TRY(fly_film_write(f->film, f->rgba, progress, err));
    } else {
        draw_outputs files = fly_folder_files(f->folder, number);
        STP_TRY(draw_save(&f->picture, f->renderer, &view, &camera, &files, true, err));
    }
    f->done++;
done:
    return status;
}

/* The error after Ctrl-C: says how to continue. */
static stp_status interrupted(const flight *f, stp_error *err)
{
    unsigned long long done = f->done + f->there, wanted = f->last - f->first + 1;
    if (f->folder != NULL)
        return stp_error_set(err, STP_CANCELLED,
                             "interrupted with %llu of %llu frames done: the same command goes on "
                             "from there",
                             done, wanted);
    return stp_error_set(err, STP_CANCELLED,
                         "interrupted at frame %llu of %llu: no film was written, and the same "
                         "command begins anew; in a folder (-o DIR) it would go on",
                         done, wanted);
}

static stp_status make_frames(flight *f, const stp_progress *progress, stp_error *err)
{
    stp_status status = STP_OK;
    uint64_t wanted = 0, made = 0;
    for (uint64_t n = f->first; n <= f->last; n++)
        f->there += f->folder != NULL && fly_folder_has(f->folder, n);
    wanted = f->last - f->first + 1 - f->there;
    for (uint64_t n = f->first; n <= f->last; n++) {
        if (f->folder != NULL && fly_folder_has(f->folder, n))
            continue;
        STP_TRY(stp_progress_update(progress, "frames", made, wanted, err));
        STP_TRY(make_frame(f, n, progress, err));
        made++;
    }
    if (f->film != NULL)
        STP_TRY(fly_film_commit(&f->film, progress, err));
done:
    cli_progress_end();
    return status == STP_CANCELLED ? interrupted(f, err) : status;
}

static stp_status write_stats(flight *f, double begun_s, stp_error *err)
{
    cJSON *json = draw_measure_json(&f->measure, f->renderer, f->model);
    cJSON_AddNumberToObject(json, "frames", (double)f->done);
    cJSON_AddNumberToObject(json, "frames_there", (double)f->there);
    cJSON_AddNumberToObject(json, "seconds", stp_clock_seconds() - begun_s);
    return stp_json_save(json, f->o->stats, f->o->force, err);
}

static void say(const flight *f, const cli_common *common)
{
    source_options_warn(&cli_fly, common, f->model->file);
    draw_options_warn(cli_fly.name, f->renderer);
    if (f->there > 0 && !common->quiet)
        fprintf(stderr, "stipple fly: %llu frames were there already, %llu are new\n",
                (unsigned long long)f->there, (unsigned long long)f->done);
}

static stp_status fly(const options *o, const cli_common *common, const char **paths, size_t count,
                      stp_error *err)
{
    stp_status status = STP_OK;
    flight f = {.o = o};
    double begun_s = stp_clock_seconds();
    const stp_progress *progress = cli_progress(common);
    STP_TRY(open_flight(&f, paths, count, common, err));
    STP_TRY(make_frames(&f, progress, err));
    if (o->stats != NULL)
        STP_TRY(write_stats(&f, begun_s, err));
    say(&f, common);
done:
    fly_film_destroy(&f.film);
    fly_folder_close(&f.folder);
    draw_measure_clear(&f.measure);
    free(f.rgba);
    free(f.picture.fine);
    stp_renderer_destroy(&f.renderer);
    stp_gl_context_destroy(&f.context);
    stp_path_destroy(&f.path);
    stp_model_close(&f.model);
    return status;
}

/* ---- the command line ---- */

/* "A:B", "A:", ":B" or "A", counted from 1. */
static bool parse_frames(const char *text, uint64_t *first, uint64_t *last)
{
    unsigned long long a = 1, b = 0;
    int used = 0;
    size_t digits = strspn(text, "0123456789");
    if (strspn(text, "0123456789:") != strlen(text) || digits > 9)
        return false;
    if (digits > 0)
        sscanf(text, "%llu", &a);
    if (text[digits] == '\0')
        b = a;
    else if (text[digits + 1] != '\0' && (strlen(text + digits + 1) > 9 ||
                                          sscanf(text + digits + 1, "%llu%n", &b, &used) != 1 ||
                                          text[digits + 1 + (size_t)used] != '\0' || b == 0))
        return false;
    *first = a;
    *last = b;
    return a > 0 && (b == 0 || a <= b);
}

/* True if the ending is that of another kind of file, which fly does not make. */
static bool is_other_file(const char *path)
{
    static const char *const endings[] = {".png", ".jpg", ".jpeg", ".tif", ".tiff", ".exr",
                                          ".gif", ".avi", ".mpg",  ".m4v", ".wmv",  ".ogv"};
    struct stat info;
    const char *dot = strrchr(path, '.');
    bool found = false;
    for (size_t i = 0; dot != NULL && i < sizeof endings / sizeof *endings; i++)
        found |= strcasecmp(dot, endings[i]) == 0;
    return found && !(stat(path, &info) == 0 && S_ISDIR(info.st_mode));
}

/* Returns CLI_CONTINUE if the options make sense. */
static int check(options *o)
{
    if (o->output == NULL)
        return cli_usage(&cli_fly, "-o F.mp4 or -o DIR is missing");
    if ((o->path != NULL) == o->has_turntable)
        return cli_usage(&cli_fly, "give either --path P.json or --turntable SECONDS");
    if (o->has_turntable && !(o->turntable_s > 0.0))
        return cli_usage(&cli_fly, "--turntable takes seconds above 0");
    if (!(o->rate >= 0.01 && o->rate <= 1000.0))
        return cli_usage(&cli_fly, "--rate is from 0.01 to 1000 frames a second");
    o->first = 1;
    if (o->frames != NULL && !parse_frames(o->frames, &o->first, &o->last))
        return cli_usage(&cli_fly, "--frames takes A:B, like 1:100, not '%s'", o->frames);
    int code = draw_options_check(&o->draw, &cli_fly);
    if (code != CLI_CONTINUE)
        return code;
    if (is_other_file(o->output))
        return cli_usage(&cli_fly,
                         "-o %s: films end in .mp4, .mov, .mkv or .webm, and single frames go to a "
                         "folder",
                         o->output);
    if ((o->depth || o->normals) && fly_film_is_name(o->output))
        return cli_usage(&cli_fly, "--depth and --normals are written to a folder: -o DIR");
    return CLI_CONTINUE;
}

static int run(int argc, char **argv)
{
    options o = {.draw = draw_options_default(), .rate = 30.0};
    cli_common common = {0};
    static const char *paths[PREP_PATHS_LIMIT + 2];
    size_t count = 0;
    stp_error err = {0};
    cli_option list[DRAW_OPTION_COUNT + 9] = {
        [DRAW_OPTION_COUNT] = {"--output", 'o', CLI_STRING, &o.output, "F.mp4|DIR",
                               "the film or the folder of frames to write", NULL},
        {"--path", 0, CLI_STRING, &o.path, "P.json", "JSON file with keyframes or a turntable",
         NULL},
        {"--turntable", 0, CLI_NUMBER, &o.turntable_s, "SECONDS",
         "turn once around the model in so many seconds, instead of --path", &o.has_turntable},
        {"--rate", 0, CLI_NUMBER, &o.rate, "N", "frames a second (30)", NULL},
        {"--frames", 0, CLI_STRING, &o.frames, "A:B", "draw only frames A to B, counted from 1",
         NULL},
        {"--depth", 0, CLI_FLAG, &o.depth, NULL,
         "also write frame_000001_depth.exr and so on, like render --depth", NULL},
        {"--normals", 0, CLI_FLAG, &o.normals, NULL,
         "also write frame_000001_normals.exr and so on, like render --normals", NULL},
        {"--stats", 0, CLI_STRING, &o.stats, "F.json", "write times and counts", NULL},
        {"--force", 'f', CLI_FLAG, &o.force, NULL, "replace existing files", NULL},
    };
    draw_options_fill(&o.draw, list);
    int code = cli_parse(&cli_fly, list, sizeof list / sizeof *list, argc, argv, paths, 1,
                         PREP_PATHS_LIMIT, &count, &common);
    if (code == CLI_CONTINUE)
        code = check(&o);
    if (code != CLI_CONTINUE)
        return code;
    o.list = list;
    return fly(&o, &common, paths, count, &err) == STP_OK ? CLI_DONE : cli_fail(&cli_fly, &err);
}
