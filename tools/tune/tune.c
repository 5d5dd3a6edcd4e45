/* stipple tune: measures what a level-of-detail threshold costs and buys; finds the threshold for a
 * goal. */
#include "base/memory.h"
#include "base/sort.h"
#include "formats/chunk/byte_source.h"
#include "formats/chunk/convert.h"
#include "runtime/gl/gl_context.h"
#include "tools/draw/draw_options.h"
#include "tools/file/source_options.h"
#include "tools/tune/tune_report.h"

#include <epoxy/gl.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static int run(int argc, char **argv);
const cli_command cli_tune = {
    .name = "tune",
    .summary = "measure quality and cost of thresholds; find the threshold for a goal",
    .usage = "stipple tune M.stipple -o DIR [options]",
    .details =
        "Draws the model at several thresholds from several sides and distances: from --views of\n"
        "78 built-in views, along --path, or from the one camera of --camera or --eye. Each "
        "picture\n"
        "is compared with a reference: every sample, drawn with --reference times as many pixels\n"
        "along each side. The error that the rule predicts is compared with the distance of drawn\n"
        "discs from the surface. DIR gets index.html, tune.csv (one row per view and threshold),\n"
        "tune.json and charts, all or nothing. tune takes some minutes on two cores without a "
        "GPU;\n"
        "fewer --views, a smaller --size and a smaller --repeat take less.\n"
        "Goals: --fps is 1000 over the median of the views' milliseconds, met within 10 %. --psnr\n"
        "is computed from the squared differences of all views together, met within 0.5 dB. "
        "--bytes\n"
        "is the GPU memory of the view that needs most, never exceeded.\n"
        "\n" OPEN_SCAN_HELP,
    .run = run,
};

#define SETTINGS_LIMIT 7
#define SHOWN_LIMIT 4

typedef struct options {
    draw_options draw;
    const char *output, *path, *threshold_list, *compare_list;
    uint64_t views, reference, repeat, discs;
    double fps, psnr;
    uint64_t bytes;
    bool has_fps, has_psnr, has_bytes, has_home, save, force;
    double thresholds[TUNE_THRESHOLDS_LIMIT];
    size_t threshold_count;
    int compared[SETTINGS_LIMIT]; /* stp_reconstruct */
    size_t compared_count;
    bool terms;
} options;

/* Everything between the options and the report. */
typedef struct tuning {
    const options *o;
    stp_model *model;
    stp_gl_context *context;
    stp_renderer *renderer;
    stp_pool *pool;
    tune_views views;
    tune_setting settings[SETTINGS_LIMIT];
    char names[SETTINGS_LIMIT][16];
    size_t shown[SHOWN_LIMIT];
    tune_sweep_params params;
    tune_sweep sweep;
    tune_answer answer;
    tune_row *rows; /* rows of thresholds probed while solving */
} tuning;

/* ---- before the first picture ---- */

static stp_status find_views(tuning *t, stp_error *err)
{
    stp_status status = STP_OK;
    const camera_options *c = &t->o->draw.camera;
    bool one = c->path || c->has_eye || c->has_look || c->has_up || c->has_fovy || t->o->has_home;
    stp_camera camera;
    tune_views_params params = {.model = t->model,
                                .renderer = t->renderer,
                                .drawn = t->settings[0].params,
                                .path = t->o->path,
                                .count = (size_t)t->o->views};
    STP_TRY(draw_options_camera(&t->o->draw, t->model, &camera, params.size, err));
    if (one || t->o->path)
        params.camera = &camera;
    STP_TRY(tune_views_create(&t->views, &params, err));
done:
    return status;
}

/* Settings that show what each term of the error rule buys: the default, none, each alone, all. */
static const struct {
    const char *name;
    uint32_t terms;
} term_settings[] = {
    {"rule", 0},
    {"none", STP_TERM_NONE},
    {"radius", STP_TERM_RADIUS},
    {"colour", STP_TERM_COLOUR},
    {"silhouette", STP_TERM_SILHOUETTE},
    {"all", STP_TERM_RADIUS | STP_TERM_COLOUR | STP_TERM_SILHOUETTE},
};
#define TERM_SETTINGS (sizeof term_settings / sizeof *term_settings)
_Static_assert(TERM_SETTINGS <= SETTINGS_LIMIT, "settings");

static void compare_terms(tuning *t, const stp_draw_params *params)
{
    t->params.setting_count = TERM_SETTINGS;
    for (size_t k = 0; k < TERM_SETTINGS; k++) {
        t->settings[k] = (tune_setting){term_settings[k].name, *params};
        t->settings[k].params.terms = term_settings[k].terms;
    }
}

static stp_status choose_settings(tuning *t, stp_error *err)
{
    stp_status status = STP_OK;
    const options *o = t->o;
    stp_draw_params params;
    STP_TRY(draw_options_params(&o->draw, t->model, &params, err));
    params.every_sample = false;
    if (o->terms) {
        compare_terms(t, &params);
        return STP_OK;
    }
    t->params.setting_count = o->compared_count;
    for (size_t k = 0; k < o->compared_count; k++) {
        draw_options_word(DRAW_RECONSTRUCTIONS, o->compared[k], t->names[k]);
        t->settings[k] = (tune_setting){t->names[k], params};
        t->settings[k].params.reconstruct = (stp_reconstruct)o->compared[k];
    }
done:
    return status;
}

/* Chooses the thresholds nearest to some common ones, whose pictures are shown. */
static void choose_shown(tuning *t)
{
    static const double wanted[SHOWN_LIMIT] = {0.5, 1.0, 4.0, 16.0};
    tune_sweep_params *p = &t->params;
    for (size_t i = 0; i < SHOWN_LIMIT; i++) {
        size_t best = SIZE_MAX;
        double least = INFINITY;
        for (size_t k = 0; k < p->threshold_count; k++) {
            double away = fabs(log2(fmax(p->thresholds[k], 1e-3) / wanted[i]));
            if (away < least) {
                least = away;
                best = k;
            }
        }
        bool known = false;
        for (size_t k = 0; k < p->shown_count; k++)
            known |= t->shown[k] == best;
        if (!known)
            t->shown[p->shown_count++] = best;
    }
}

/* --save changes the model, so there must be one on this machine. */
static stp_status check_saving(const char *const *paths, stp_error *err)
{
    bool scan = false;
    if (stp_is_address(paths[0]))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s is on a server: --save cannot change it: leave it out", paths[0]);
    const stp_status status = open_scan_is(&scan, paths[0], err);
    if (status == STP_OK && scan)
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s is a scan: --save changes models: make one with stipple prep",
                             paths[0]);
    return status;
}

static stp_status open_all(tuning *t, const char *const *paths, size_t count,
                           const cli_common *common, stp_error *err)
{
    stp_status status = STP_OK;
    const options *o = t->o;
    const open_scan_params scan = draw_options_scan(&o->draw, cli_tune.name, common);
    if (o->save)
        STP_TRY(check_saving(paths, err));
    STP_TRY(tune_folder_check(o->output, o->force, err));
    STP_TRY(draw_options_open(&o->draw, &scan, paths, count, &t->model, err));
    STP_TRY(choose_settings(t, err));
    STP_TRY(stp_pool_create(&t->pool, (unsigned)common->threads, err));
    STP_TRY(stp_gl_context_create(&t->context, err));
    stp_renderer_params renderer = draw_options_renderer(&o->draw, t->model, common);
    STP_TRY(stp_renderer_create(&t->renderer, &renderer, err));
    STP_TRY(find_views(t, err));
    t->params = (tune_sweep_params){.model = t->model,
                                    .renderer = t->renderer,
                                    .views = &t->views,
                                    .aa = o->draw.aa,
                                    .times = (int)o->reference,
                                    .settings = t->settings,
                                    .setting_count = t->params.setting_count,
                                    .thresholds = o->thresholds,
                                    .threshold_count = o->threshold_count,
                                    .repeat = o->repeat,
                                    .discs = (size_t)o->discs,
                                    .shown = t->shown,
                                    .progress = t->params.progress,
                                    .pool = t->pool};
    choose_shown(t);
done:
    return status;
}

/* ---- solving ---- */

static double value_of(const tuning *t, const tune_row *rows)
{
    size_t count = t->views.count;
    return t->answer.kind == TUNE_GOAL_FPS    ? 1e3 / fmax(tune_median_ms(rows, count), 1e-6)
           : t->answer.kind == TUNE_GOAL_PSNR ? tune_pooled_psnr(rows, count)
                                              : tune_greatest_bytes(rows, count);
}

static stp_status probe(void *context, const double *thresholds, size_t count, double *values,
                        stp_error *err)
{
    tuning *t = context;
    bool times = t->answer.kind == TUNE_GOAL_FPS, compares = t->answer.kind == TUNE_GOAL_PSNR;
    stp_status status = tune_sweep_probe(&t->sweep, thresholds, count, compares,
                                         times ? t->o->repeat : 0, t->rows, err);
    for (size_t i = 0; status == STP_OK && i < count; i++)
        values[i] = value_of(t, t->rows + i * t->views.count);
    return status;
}

static stp_status solve(tuning *t, stp_error *err)
{
    stp_status status = STP_OK;
    const options *o = t->o;
    double values[TUNE_THRESHOLDS_LIMIT];
    t->answer.kind = o->has_fps     ? TUNE_GOAL_FPS
                     : o->has_psnr  ? TUNE_GOAL_PSNR
                     : o->has_bytes ? TUNE_GOAL_BYTES
                                    : TUNE_GOAL_NONE;
    if (t->answer.kind == TUNE_GOAL_NONE)
        return STP_OK;
    t->answer.target = o->has_fps ? o->fps : o->has_psnr ? o->psnr : (double)o->bytes;
    for (size_t i = 0; i < o->threshold_count; i++)
        values[i] = value_of(t, tune_sweep_point(&t->sweep, 0, i)->rows);
    STP_TRY(stp_alloc(&t->rows, TUNE_SOLVE_MOST * t->views.count, sizeof *t->rows, "rows", err));
    STP_TRY(tune_solve(&t->answer.found,
                       &(tune_solve_params){.kind = t->answer.kind,
                                            .target = t->answer.target,
                                            .thresholds = o->thresholds,
                                            .values = values,
                                            .count = o->threshold_count,
                                            .measure = probe,
                                            .context = t},
                       err));
done:
    return status;
}

/* ---- all of it ---- */

static stp_status write_report(tuning *t, const char *path, stp_error *err)
{
    stp_status status = STP_OK;
    tune_folder *folder = NULL;
    STP_TRY(tune_folder_create(&folder, t->o->output, t->o->force, err));
    STP_TRY(tune_report_write(&(tune_report){.sweep = &t->sweep,
                                             .answer = &t->answer,
                                             .model_path = path,
                                             .gl_renderer = (const char *)glGetString(GL_RENDERER)},
                              folder, err));
    if (cli_interrupted()) {
        status = stp_error_set(err, STP_CANCELLED, "interrupted: nothing was written");
        goto done;
    }
    STP_TRY(tune_folder_commit(&folder, err));
done:
    tune_folder_destroy(&folder);
    return status;
}

static stp_status tune(const options *o, const cli_common *common, const char *const *paths,
                       size_t count, stp_error *err)
{
    stp_status status = STP_OK;
    tuning t = {.o = o, .params.progress = cli_progress(common)};
    STP_TRY(open_all(&t, paths, count, common, err));
    STP_TRY(tune_sweep_run(&t.sweep, &t.params, err));
    STP_TRY(draw_options_require_whole(&o->draw, t.renderer, err));
    STP_TRY(solve(&t, err));
    cli_progress_end();
    STP_TRY(write_report(&t, paths[0], err));
    if (o->save)
        STP_TRY(stp_chunk_file_set_threshold(paths[0], t.answer.found.threshold_px, err));
    source_options_warn(&cli_tune, common, t.model->file);
    draw_options_warn(cli_tune.name, t.renderer);
    tune_table_print(&t.sweep, &t.answer, stdout);
done:
    cli_progress_end();
    tune_sweep_clear(&t.sweep);
    free(t.rows);
    stp_pool_destroy(&t.pool);
    stp_renderer_destroy(&t.renderer);
    stp_gl_context_destroy(&t.context);
    stp_model_close(&t.model);
    if (status == STP_CANCELLED)
        return stp_error_set(err, STP_CANCELLED, "interrupted: nothing was written");
    return status;
}

/* ---- the command line ---- */

/* Parses numbers of 0 or more and sorts them. */
static bool parse_thresholds(options *o)
{
    const char *text = o->threshold_list;
    for (o->threshold_count = 0; o->threshold_count < TUNE_THRESHOLDS_LIMIT;) {
        char *end;
        double value = strtod(text, &end);
        if (end == text || !(value >= 0.0 && value <= 1000.0) || (*end != ',' && *end != '\0'))
            return false;
        o->thresholds[o->threshold_count++] = value;
        if (*end == '\0')
            break;
        text = end + 1;
        if (o->threshold_count == TUNE_THRESHOLDS_LIMIT)
            return false;
    }
    stp_sort_doubles(o->thresholds, o->threshold_count);
    for (size_t i = 0; i + 1 < o->threshold_count; i++)
        if (o->thresholds[i] == o->thresholds[i + 1])
            return false;
    return true;
}

/* Parses words of DRAW_RECONSTRUCTIONS, each at most once. */
static bool parse_compared(options *o)
{
    const char *text = o->compare_list;
    o->compared[0] = o->draw.reconstruct;
    o->compared_count = 1;
    if (text == NULL)
        return true;
    for (o->compared_count = 0; o->compared_count < SETTINGS_LIMIT;) {
        size_t length = strcspn(text, ",");
        int found = -1;
        char word[16];
        for (int i = 0; i <= STP_RECONSTRUCT_LAST; i++) {
            draw_options_word(DRAW_RECONSTRUCTIONS, i, word);
            if (strlen(word) == length && strncmp(word, text, length) == 0)
                found = i;
        }
        for (size_t k = 0; k < o->compared_count; k++)
            if (o->compared[k] == found)
                return false;
        if (found < 0)
            return false;
        o->compared[o->compared_count++] = found;
        text += length;
        if (*text == '\0')
            return true;
        text++;
    }
    return false;
}

static int check_solver(const options *o)
{
    int goals = o->has_fps + o->has_psnr + o->has_bytes;
    if (goals > 1)
        return cli_usage(&cli_tune, "give one of --fps, --psnr and --bytes");
    if ((o->has_fps && !(o->fps > 0.0)) || (o->has_psnr && !(o->psnr > 0.0)) ||
        (o->has_bytes && o->bytes == 0))
        return cli_usage(&cli_tune, "--fps, --psnr and --bytes are above 0");
    if (o->save && goals == 0)
        return cli_usage(&cli_tune, "--save keeps what --fps, --psnr or --bytes finds: give one");
    if (o->has_fps && o->repeat == 0)
        return cli_usage(&cli_tune, "--fps needs times: give --repeat 1 or more");
    return CLI_CONTINUE;
}

/* Returns CLI_CONTINUE if the options make sense. */
static int check(options *o)
{
    if (o->output == NULL)
        return cli_usage(&cli_tune, "-o DIR is missing");
    if (o->draw.exaggerate != 1.0)
        return cli_usage(&cli_tune, "--exaggerate: thresholds are for heights as they are");
    if (o->draw.has_threshold)
        return cli_usage(&cli_tune, "--thresholds LIST says which are measured, not --threshold");
    if (o->draw.lod == STP_LOD_FULL)
        return cli_usage(&cli_tune, "--lod full draws every sample at any threshold: it is the "
                                    "reference");
    if (!parse_thresholds(o))
        return cli_usage(&cli_tune,
                         "--thresholds %s: give up to %d different numbers from 0 to 1000, like "
                         "0,0.5,1,2",
                         o->threshold_list, TUNE_THRESHOLDS_LIMIT);
    if (o->terms && (o->compare_list != NULL || o->draw.terms != NULL))
        return cli_usage(&cli_tune, "--terms compares them all: without --compare, --error-terms");
    if (!parse_compared(o))
        return cli_usage(&cli_tune, "--compare %s: give different words of %s, like gauss,splat",
                         o->compare_list, DRAW_RECONSTRUCTIONS);
    if (o->views < 1 || o->views > TUNE_VIEWS_LIMIT)
        return cli_usage(&cli_tune, "--views is from 1 to %d", TUNE_VIEWS_LIMIT);
    if (o->reference < 1 || o->reference > 4)
        return cli_usage(&cli_tune, "--reference is from 1 to 4");
    if (o->repeat > 1000 || o->discs > 100000)
        return cli_usage(&cli_tune, "--repeat is at most 1000, --discs at most 100000");
    int code = check_solver(o);
    return code == CLI_CONTINUE ? draw_options_check(&o->draw, &cli_tune) : code;
}

static int run(int argc, char **argv)
{
    options o = {.draw = draw_options_default(),
                 .threshold_list = "0,0.25,0.5,1,2,4,8,16",
                 .views = 26,
                 .reference = 3,
                 .repeat = 3,
                 .discs = 64};
    cli_common common = {0};
    static const char *paths[PREP_PATHS_LIMIT];
    size_t count = 0;
    stp_error err = {0};
    cli_option list[DRAW_OPTION_COUNT + 14] = {
        [DRAW_OPTION_COUNT] = {"--output", 'o', CLI_STRING, &o.output, "DIR",
                               "the folder to write the report to", NULL},
        {"--thresholds", 0, CLI_STRING, &o.threshold_list, "LIST",
         "thresholds to measure, in pixels (0,0.25,0.5,1,2,4,8,16)", NULL},
        {"--path", 0, CLI_STRING, &o.path, "P.json", "take the views along a path of fly", NULL},
        {"--views", 0, CLI_UINT, &o.views, "N", "number of views, at most 78 (26)", NULL},
        {"--reference", 0, CLI_UINT, &o.reference, "N",
         "average N x N pixels in the reference, 1 to 4 (3)", NULL},
        {"--repeat", 0, CLI_UINT, &o.repeat, "N", "timed pictures per view (3)", NULL},
        {"--discs", 0, CLI_UINT, &o.discs, "N",
         "number of drawn discs per picture whose error is measured (64)", NULL},
        {"--compare", 0, CLI_STRING, &o.compare_list, "LIST",
         "compare these reconstructions at equal points, like gauss,splat", NULL},
        {"--terms", 0, CLI_FLAG, &o.terms, NULL,
         "compare what each term of the error rule gains at equal points", NULL},
        {"--fps", 0, CLI_NUMBER, &o.fps, "N", "find the threshold that reaches N frames a second",
         &o.has_fps},
        {"--psnr", 0, CLI_NUMBER, &o.psnr, "DB", "find the threshold that reaches this quality",
         &o.has_psnr},
        {"--bytes", 0, CLI_BYTES, &o.bytes, "SIZE",
         "find the threshold that fits samples into this GPU memory", &o.has_bytes},
        {"--save", 0, CLI_FLAG, &o.save, NULL, "store the threshold found in the model", NULL},
        {"--force", 'f', CLI_FLAG, &o.force, NULL, "replace an existing report", NULL},
    };
    draw_options_fill(&o.draw, list);
    o.draw.camera.size[0] = o.draw.camera.size[1] = 512;
    o.draw.home = STP_HOME_WHOLE;
    o.draw.aa = DRAW_AA_NONE; /* smooth edges would hide what a threshold does to outlines */
    for (size_t i = 0; i < DRAW_OPTION_COUNT; i++) {
        if (strcmp(list[i].name, "--size") == 0)
            list[i].help = "size of the pictures in pixels (512x512)";
        if (strcmp(list[i].name, "--aa") == 0)
            list[i].help =
                "as render draws edges: none, smooth, or the mean of N x N pixels (none)";
        if (strcmp(list[i].name, "--threshold") == 0 || strcmp(list[i].name, "--exaggerate") == 0)
            list[i].help = NULL; /* parsed, so that check() can refuse it with a message */
        if (strcmp(list[i].name, "--view") == 0) {
            list[i].help = "use one view: the model's first one, or the whole model (26 views)";
            list[i].given = &o.has_home;
        }
    }
    int code = cli_parse(&cli_tune, list, sizeof list / sizeof *list, argc, argv, paths, 1,
                         PREP_PATHS_LIMIT, &count, &common);
    if (code == CLI_CONTINUE)
        code = check(&o);
    if (code != CLI_CONTINUE)
        return code;
    return tune(&o, &common, paths, count, &err) == STP_OK ? CLI_DONE : cli_fail(&cli_tune, &err);
}
