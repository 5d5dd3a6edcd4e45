/* stipple-bench-quality: compares every reconstruction with the true mesh and measures its cost. */
#include "base/memory.h"
#include "runtime/gl/gl_context.h"
#include "runtime/stipple.h"
#include "tests/quality/judge.h"
#include "tests/support/views.h"
#include "tools/bench/median.h"
#include "tools/cli/cli.h"
#include "tools/draw/draw_fine.h"
#include "tools/draw/draw_options.h"

#include <stdio.h>
#include <stdlib.h>

static int run(int argc, char **argv);
static const cli_command bench = {
    .name = "bench-quality",
    .program = "stipple-bench-quality",
    .summary = "every reconstruction against the true mesh, and what it costs",
    .usage = "stipple-bench-quality M.stipple MESH [options]",
    .details =
        "Draws the model's points, every one, as lambert of one grey from some of the 26\n"
        "directions, and the mesh as triangles. Prints for each reconstruction the samples that\n"
        "were drawn for each pixel of the mesh, PSNR and SSIM over what either covers, PSNR of "
        "the\n"
        "silhouette's pixels to the mesh's mean over 4 x 4 places of each, coverage, holes and\n"
        "spill as parts of the mesh's pixels, the mean angle between normals, and the\n"
        "milliseconds of a frame (medians, measured in turns). --threshold chooses levels;\n"
        "--maps compares the ways to draw elevation maps instead of reconstructions.",
    .run = run,
};

/* Reconstructions, then ways to draw maps: stp_maps_as from MESH on. */
#define MAPS_BEGIN (STP_RECONSTRUCT_LAST + 1)
#define MODE_COUNT (MAPS_BEGIN + STP_MAPS_POINTS)
static const char *const mode_names[MODE_COUNT] = {
    [STP_RECONSTRUCT_GAUSS] = "gauss",
    [STP_RECONSTRUCT_BOX] = "box",
    [STP_RECONSTRUCT_TEMPLATE3] = "template3",
    [STP_RECONSTRUCT_TEMPLATE5] = "template5",
    [STP_RECONSTRUCT_TEMPLATE7] = "template7",
    [STP_RECONSTRUCT_SPLAT] = "splat",
    [STP_RECONSTRUCT_POINTS] = "points",
    [MAPS_BEGIN + STP_MAPS_MESH - 1] = "mesh",
    [MAPS_BEGIN + STP_MAPS_SPLATS - 1] = "splats",
    [MAPS_BEGIN + STP_MAPS_BLEND - 1] = "blend",
    [MAPS_BEGIN + STP_MAPS_PLAIN - 1] = "plain",
    [MAPS_BEGIN + STP_MAPS_POINTS - 1] = "pull-push",
};
/* Each view takes the direction this many further. */
#define VIEW_STEP 7
#define REPEAT_LIMIT 1000u

typedef struct options {
    int size[2];
    uint64_t views, repeat;
    double threshold_px;
    int aa;
    int only; /* a reconstruction, or -1 for all */
    bool maps;
    double zoom;
    const char *shaders;
} options;

typedef struct state {
    options options;
    stp_model *model;
    stp_mesh *mesh;
    stp_gl_context *context;
    stp_renderer *renderer;
    quality_sums sums[MODE_COUNT];
    double *ms[MODE_COUNT];     /* by view and round */
    uint64_t drawn[MODE_COUNT]; /* samples, of all views */
} state;

static int first_mode(const options *o)
{
    return o->maps ? MAPS_BEGIN : o->only < 0 ? 0 : o->only;
}

static int mode_end(const options *o)
{
    return o->maps ? MODE_COUNT : o->only < 0 ? MAPS_BEGIN : o->only + 1;
}

static stp_draw_params params_of(const state *s, int mode)
{
    return (stp_draw_params){
        .lod = s->options.threshold_px > 0.0 ? STP_LOD_GEOMETRY : STP_LOD_FULL,
        .reconstruct = mode < MAPS_BEGIN ? (stp_reconstruct)mode : STP_RECONSTRUCT_GAUSS,
        .maps_as = mode < MAPS_BEGIN ? STP_MAPS_AUTO : (stp_maps_as)(mode - MAPS_BEGIN + 1),
        .shade = STP_SHADE_LAMBERT,
        .colour = STP_COLOUR_NONE,
        .threshold_px = s->options.threshold_px,
        .smooth_edges = s->options.aa == DRAW_AA_EDGES};
}

/* Draws as --aa says; rgba may be NULL. */
static stp_status draw(const state *s, const stp_view *view, const stp_draw_params *params,
                       uint8_t *rgba, stp_draw_stats *stats, stp_error *err)
{
    int times = draw_aa_times(s->options.aa);
    if (times > 1)
        return draw_fine(s->renderer, view, params, times, rgba, stats, err);
    stp_status status = stp_renderer_draw(s->renderer, view, params, stats, err);
    return status == STP_OK ? stp_renderer_read(s->renderer, rgba, err) : status;
}

static stp_status judge_view(state *s, const stp_view *view, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t count = (size_t)view->width * (size_t)view->height;
    quality_truth truth = {0};
    uint8_t *rgba = NULL;
    float *normals = NULL;
    STP_TRY(stp_alloc(&rgba, count, 4, "a picture", err));
    STP_TRY(stp_alloc(&normals, count, 3 * sizeof *normals, "normals", err));
    STP_TRY(quality_truth_draw(&truth, s->mesh, view, err));
    for (int mode = first_mode(&s->options); mode < mode_end(&s->options); mode++) {
        stp_draw_params params = params_of(s, mode);
        stp_draw_stats stats;
        params.keep_pixels = true;
        STP_TRY(draw(s, view, &params, rgba, &stats, err));
        if (draw_aa_times(s->options.aa) > 1)
            STP_TRY(stp_renderer_draw(s->renderer, view, &params, &stats, err));
        STP_TRY(stp_renderer_read_normals(s->renderer, normals, err));
        STP_TRY(quality_add(&s->sums[mode], &truth, rgba, normals, err));
        s->drawn[mode] += stats.points_drawn;
    }
done:
    quality_truth_clear(&truth);
    free(rgba);
    free(normals);
    return status;
}

/* Times all modes in turn. */
static stp_status time_view(state *s, const stp_view *view, uint64_t number, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *rgba = NULL;
    STP_TRY(stp_alloc(&rgba, (size_t)view->width * (size_t)view->height, 4, "a picture", err));
    for (uint64_t round = 0; round < s->options.repeat; round++)
        for (int mode = first_mode(&s->options); mode < mode_end(&s->options); mode++) {
            stp_draw_params params = params_of(s, mode);
            stp_draw_stats stats;
            STP_TRY(draw(s, view, &params, rgba, &stats, err)); /* compiles the programs */
            STP_TRY(draw(s, view, &params, rgba, &stats, err));
            s->ms[mode][number * s->options.repeat + round] = stats.frame_ms;
        }
done:
    free(rgba);
    return status;
}

static void print_table(const state *s)
{
    printf("%-10s %8s %8s %8s %8s %8s %9s %8s %8s %8s %8s\n", "mode", "samples", "psnr", "ssim",
           "inside", "outline", "coverage", "holes", "spill", "normals", "ms");
    for (int mode = first_mode(&s->options); mode < mode_end(&s->options); mode++) {
        const quality_sums *q = &s->sums[mode];
        double pixels = (double)q->true_covered;
        printf("%-10s %8.2f %8.2f %8.4f %8.2f %8.2f %9.4f %8.5f %8.5f %8.2f %8.1f\n",
               mode_names[mode], (double)s->drawn[mode] / pixels,
               quality_psnr_db(q->error, 3 * q->either), q->ssim / (double)q->views,
               quality_psnr_db(q->inside_error, 3 * q->inside),
               quality_psnr_db(q->smooth_error, 3 * q->silhouette), (double)q->covered / pixels,
               (double)q->holes / pixels, (double)q->spill / pixels, q->angle_deg / (double)q->both,
               bench_median(s->ms[mode], s->options.views * s->options.repeat));
    }
}

static stp_status measure(state *s, const char *model, const char *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    const options *o = &s->options;
    STP_TRY(stp_model_open(&s->model, model, err));
    STP_TRY(stp_mesh_load(&s->mesh, mesh, err));
    STP_TRY(stp_gl_context_create(&s->context, err));
    STP_TRY(stp_renderer_create(
        &s->renderer, &(stp_renderer_params){.model = s->model, .shader_folder = o->shaders}, err));
    for (int mode = 0; mode < MODE_COUNT; mode++)
        STP_TRY(stp_alloc(&s->ms[mode], o->views * o->repeat, sizeof(double), "times", err));
    stp_ball ball = stp_model_ball(s->model);
    for (uint64_t i = 0; i < o->views; i++) {
        int direction = (int)(i * VIEW_STEP % VIEWS_DIRECTIONS);
        stp_view view = views_get(direction, &ball, NULL, 0, o->size[0], o->size[1]);
        view.f *= o->zoom;
        STP_TRY(judge_view(s, &view, err));
        STP_TRY(time_view(s, &view, i, err));
    }
    print_table(s);
done:
    return status;
}

static void clear(state *s)
{
    stp_renderer_destroy(&s->renderer);
    stp_gl_context_destroy(&s->context);
    stp_mesh_destroy(&s->mesh);
    stp_model_close(&s->model);
    for (int mode = 0; mode < MODE_COUNT; mode++)
        free(s->ms[mode]);
}

static int run(int argc, char **argv)
{
    cli_common common = {0};
    const char *files[2];
    size_t count = 0;
    stp_error err = {0};
    state s = {.options = {.size = {1024, 1024}, .views = 6, .repeat = 3, .only = -1, .zoom = 1.0}};
    const cli_option list[] = {
        {"--aa", 0, CLI_CHOICE, &s.options.aa, DRAW_AA, "how edges are smoothed (none)", NULL},
        {"--reconstruct", 0, CLI_CHOICE, &s.options.only, DRAW_RECONSTRUCTIONS, "this one only",
         NULL},
        {"--maps", 0, CLI_FLAG, &s.options.maps, NULL, "the ways to draw maps", NULL},
        {"--zoom", 0, CLI_NUMBER, &s.options.zoom, "Z",
         "show the middle of each view Z times as large (1)", NULL},
        {"--size", 0, CLI_EXTENT, s.options.size, "WxH", "of the pictures (1024x1024)", NULL},
        {"--views", 0, CLI_UINT, &s.options.views, "N", "1 to 26 (6)", NULL},
        {"--repeat", 0, CLI_UINT, &s.options.repeat, "N", "frames timed of each view (3)", NULL},
        {"--threshold", 0, CLI_NUMBER, &s.options.threshold_px, "PX",
         "greatest error; 0: every sample (0)", NULL},
        {"--shaders", 0, CLI_STRING, &s.options.shaders, "DIR",
         "shader files that win over the program's own", NULL},
    };
    int code = cli_parse(&bench, list, sizeof list / sizeof *list, argc, argv, files, 2, 2, &count,
                         &common);
    if (code != CLI_CONTINUE)
        return code;
    if (s.options.views < 1 || s.options.views > VIEWS_DIRECTIONS)
        return cli_usage(&bench, "--views: give 1 to %d", VIEWS_DIRECTIONS);
    if (s.options.repeat < 1 || s.options.repeat > REPEAT_LIMIT)
        return cli_usage(&bench, "--repeat: give 1 to %u", REPEAT_LIMIT);
    if (!(s.options.zoom >= 1.0))
        return cli_usage(&bench, "--zoom: give 1 or more");
    stp_status status = measure(&s, files[0], files[1], &err);
    clear(&s);
    return status == STP_OK ? CLI_DONE : cli_fail(&bench, &err);
}

int main(int argc, char **argv)
{
    return run(argc, argv);
}
