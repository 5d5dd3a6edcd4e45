/* stipple-bench: how long a frame takes by each road, measured in turns in one run. */
#include "base/clock.h"
#include "base/memory.h"
#include "runtime/gl_context.h"
#include "tools/bench/bare_points.h"
#include "tools/bench/decode_run.h"
#include "tools/bench/first.h"
#include "tools/bench/median.h"
#include "tools/bench/open_run.h"
#include "tools/bench/pace_run.h"
#include "tools/bench/stops_run.h"
#include "tools/cli.h"

#include <epoxy/gl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

static int run(int argc, char **argv);
static const cli_command bench = {
    .name = "bench",
    .program = "stipple-bench",
    .summary = "how long a frame takes by each road",
    .usage = "stipple-bench M.stipple [options]",
    .details =
        "Draws the whole model headless by each road in turns, A B C ... A B C ..., and prints "
        "one\n"
        "table of medians. `points` is the yardstick: every sample as a bare one-pixel point,\n"
        "without a surface. `frame` is of frames drawn at a stretch; project, pull-push and shade\n"
        "are of frames that wait between the stages. Loading is not counted.\n"
        "--first prints, stage by stage, milliseconds by the clock and of processors until the\n"
        "first picture: process (before the program's first line; its clock stands in `begun`,\n"
        "seconds since 1970), context, open, root, and draw, of which frame is not compiling.",
    .run = run,
};

/* One road: how it is drawn and what it took. */
typedef struct road {
    const char *name;
    stp_draw_params params;
    bool bare;           /* the yardstick */
    double *frame_ms;    /* by round */
    double *stage_ms[3]; /* project, pull-push, shade */
    uint64_t points;
} road;

#define FULL_ROAD 1 /* what the others are compared with */
static const road roads_wanted[] = {
    {.name = "points", .bare = true},
    {.name = "full", .params = {.lod = STP_LOD_FULL}},
    {.name = "geometry 0.5 px", .params = {.lod = STP_LOD_GEOMETRY, .threshold_px = 0.5}},
    {.name = "geometry 1 px", .params = {.lod = STP_LOD_GEOMETRY, .threshold_px = 1.0}},
    {.name = "geometry 2 px", .params = {.lod = STP_LOD_GEOMETRY, .threshold_px = 2.0}},
    {.name = "compute 1 px", .params = {.lod = STP_LOD_COMPUTE, .threshold_px = 1.0}},
    {.name = "cpu 0.5 px", .params = {.lod = STP_LOD_CPU, .threshold_px = 0.5}},
    {.name = "cpu 1 px", .params = {.lod = STP_LOD_CPU, .threshold_px = 1.0}},
    {.name = "cpu 2 px", .params = {.lod = STP_LOD_CPU, .threshold_px = 2.0}},
};
#define ROAD_COUNT (sizeof roads_wanted / sizeof *roads_wanted)
#define REPEAT_LIMIT 10000u
#define WARM_UP_ROUNDS 1
#define PACE_SECONDS 6.0

typedef struct measured {
    road roads[ROAD_COUNT];
    double load_before, load_after; /* of the machine, one minute's mean */
} measured;

typedef struct options {
    int size[2];
    uint64_t repeat, gpu_memory, cpu_memory;
    double fps;
    bool open, first, stops;
    const char *decode;
} options;

typedef struct bench_state {
    stp_model *model;
    stp_gl_context *context;
    stp_renderer *renderer;
    bare_points points;
    stp_view view;
} bench_state;

static stp_status draw_once(bench_state *s, const road *r, bool timed, stp_draw_stats *stats,
                            stp_error *err)
{
    if (r->bare) {
        *stats = (stp_draw_stats){.points_drawn = s->points.count};
        return bare_points_draw(&s->points, &stats->frame_ms, err);
    }
    stp_draw_params params = r->params;
    params.timed = timed;
    return stp_renderer_draw(s->renderer, &s->view, &params, stats, err);
}

/* Every road once; round < 0 is warm-up and not kept. */
static stp_status draw_round(bench_state *s, road *roads, int64_t round, stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t i = 0; i < ROAD_COUNT; i++) {
        stp_draw_stats stats;
        STP_TRY(draw_once(s, &roads[i], false, &stats, err));
        if (round >= 0)
            roads[i].frame_ms[round] = stats.frame_ms;
        roads[i].points = stats.points_drawn;
        STP_TRY(draw_once(s, &roads[i], true, &stats, err));
        if (round < 0)
            continue;
        roads[i].stage_ms[0][round] = stats.project_ms;
        roads[i].stage_ms[1][round] = stats.pull_push_ms;
        roads[i].stage_ms[2][round] = stats.shade_ms;
    }
done:
    return status;
}

static double machine_load(void)
{
    double load = 0.0;
    return getloadavg(&load, 1) == 1 ? load : 0.0;
}

static stp_status measure(bench_state *s, const options *o, measured *m, stp_error *err)
{
    stp_status status = STP_OK;
    for (size_t i = 0; i < ROAD_COUNT; i++) {
        road *r = &m->roads[i];
        *r = roads_wanted[i];
        STP_TRY(stp_alloc(&r->frame_ms, (size_t)o->repeat, sizeof(double), "times", err));
        for (int k = 0; k < 3; k++)
            STP_TRY(stp_alloc(&r->stage_ms[k], (size_t)o->repeat, sizeof(double), "times", err));
    }
    m->load_before = machine_load();
    for (int64_t round = -WARM_UP_ROUNDS; round < (int64_t)o->repeat; round++) {
        STP_TRY(draw_round(s, m->roads, round, err));
        if (cli_interrupted()) {
            status = stp_error_set(err, STP_CANCELLED, "interrupted");
            goto done;
        }
    }
    m->load_after = machine_load();
done:
    return status;
}

static void print_road(road *r, size_t count, double full_ms, double points_ms)
{
    double frame = bench_median(r->frame_ms, count); /* now sorted */
    printf("%-16s %9.1f %8.1f %8.1f", r->name, frame, r->frame_ms[0], r->frame_ms[count - 1]);
    if (r->bare)
        printf(" %9s %9s %9s", "-", "-", "-");
    else
        printf(" %9.1f %9.1f %9.1f", bench_median(r->stage_ms[0], count),
               bench_median(r->stage_ms[1], count), bench_median(r->stage_ms[2], count));
    printf(" %11llu %7.2f %7.2f\n", (unsigned long long)r->points, full_ms / frame,
           points_ms / frame);
}

static void print_table(const bench_state *s, const options *o, measured *m)
{
    size_t count = (size_t)o->repeat;
    double points_ms = bench_median(m->roads[0].frame_ms, count);
    double full_ms = bench_median(m->roads[FULL_ROAD].frame_ms, count);
    printf("%s: %llu points, %u chunks, %dx%d, %zu rounds after %d of warm-up\n",
           stp_chunk_file_path(s->model->file), (unsigned long long)s->model->info->point_count,
           s->model->info->chunk_count, s->view.width, s->view.height, count, WARM_UP_ROUNDS);
    printf("%s, %ld processors, load %.2f before and %.2f after\n",
           (const char *)glGetString(GL_RENDERER), sysconf(_SC_NPROCESSORS_ONLN), m->load_before,
           m->load_after);
    printf("%-16s %9s %8s %8s %9s %9s %9s %11s %7s %7s\n", "ms, medians", "frame", "min", "max",
           "project", "pull-push", "shade", "drawn", "full/", "points/");
    for (size_t i = 0; i < ROAD_COUNT; i++)
        print_road(&m->roads[i], count, full_ms, points_ms);
}

/* The rate that is held, in one line. */
static stp_status bench_pace(const bench_state *s, const options *o, stp_error *err)
{
    pace_run_result r;
    stp_status status = pace_run(&(pace_run_params){.model = s->model,
                                                    .renderer = s->renderer,
                                                    .fps = o->fps,
                                                    .seconds = PACE_SECONDS,
                                                    .width = o->size[0],
                                                    .height = o->size[1]},
                                 &r, err);
    if (status == STP_OK)
        printf("%s: %.1f fps wanted, %.2f held (%+.0f %%) at %.3g px, %.1f ms a frame; %.1f ms "
               "without a choice%s\n",
               stp_chunk_file_path(s->model->file), o->fps, r.fps, 100.0 * (r.fps / o->fps - 1.0),
               r.threshold_px, r.frame_ms, r.bare_ms, r.holds ? "" : "; cannot be held");
    return status;
}

/* How soon the model looks like itself, in one line. */
static stp_status bench_open(const bench_state *s, double begun, stp_error *err)
{
    open_run_result r;
    stp_status status = open_run(s->renderer, &s->view, begun, &r, err);
    double share = 100.0 * (double)r.bytes / (double)s->model->info->file_bytes;
    if (status == STP_OK)
        printf(
            "%s: first picture after %.2f s (covers %.1f %% of what the last does), %.0f %% after "
            "%.2f s, %s after %.2f s, %u frames, %.2f MB of payloads: %.1f %% of the file\n",
            stp_chunk_file_path(s->model->file), r.first_s, 100.0 * r.first_overlap,
            100.0 * OPEN_RUN_OVERLAP, r.alike_s, r.complete ? "complete" : "memory full",
            r.complete_s, r.frames, 1e-6 * (double)r.bytes, share);
    return status;
}

/* One line: the sum over the stops of what chunks cost, then each stop's two frames. */
static stp_status bench_stops(const bench_state *s, const options *o, stp_error *err)
{
    stops_run_result r;
    double sum = 0.0;
    stp_status status = stops_run(s->renderer, s->model, o->size, &r, err);
    if (status != STP_OK)
        return status;
    for (int i = 0; i < STOPS_RUN_COUNT; i++)
        sum += fmax(0.0, r.cold_ms[i] - r.warm_ms[i]);
    printf("stops %.1f ms:", sum);
    for (int i = 0; i < STOPS_RUN_COUNT; i++)
        printf(" %.1f-%.1f", r.cold_ms[i], r.warm_ms[i]);
    printf("\n");
    return STP_OK;
}

static stp_status bench_decode(const options *o, const char *path, stp_error *err)
{
    decode_run_result r;
    const char *const paths[2] = {path, o->decode};
    stp_status status = decode_run(paths, (unsigned)o->repeat, &r, err);
    if (status == STP_OK)
        printf("size %.3f  million points a second %.2f %.2f  ratio %.2f (%.2f to %.2f), %u "
               "chunks\n",
               (double)r.file_bytes[1] / (double)r.file_bytes[0], 1e-6 * r.points_per_s[0],
               1e-6 * r.points_per_s[1], r.ratio[1], r.ratio[0], r.ratio[2], r.chunks);
    return status;
}

static stp_status run_bench(const options *o, const cli_common *common, const char *path,
                            stp_error *err)
{
    stp_status status = STP_OK;
    bench_state s = {0};
    measured m = {0};
    double begun = stp_clock_seconds();
    STP_TRY(stp_model_open(&s.model, path, err));
    stp_camera camera =
        stp_camera_default(&s.model->info->box, &s.model->ball, o->size[0], o->size[1]);
    STP_TRY(stp_view_create(&s.view, &camera, &s.model->ball, o->size[0], o->size[1], err));
    STP_TRY(stp_gl_context_create(&s.context, err));
    STP_TRY(stp_renderer_create(&s.renderer,
                                &(stp_renderer_params){.model = s.model,
                                                       .gpu_memory_bytes = o->gpu_memory,
                                                       .cpu_memory_bytes = o->cpu_memory,
                                                       .thread_count = (unsigned)common->threads},
                                err));
    if (o->open) {
        STP_TRY(bench_open(&s, begun, err));
        goto done;
    }
    if (o->stops) {
        STP_TRY(bench_stops(&s, o, err));
        goto done;
    }
    if (o->fps > 0.0) {
        STP_TRY(bench_pace(&s, o, err));
        goto done;
    }
    STP_TRY(bare_points_create(&s.points, s.model, &s.view, err));
    STP_TRY(measure(&s, o, &m, err));
    print_table(&s, o, &m);
done:
    for (size_t i = 0; i < ROAD_COUNT; i++) {
        free(m.roads[i].frame_ms);
        for (int k = 0; k < 3; k++)
            free(m.roads[i].stage_ms[k]);
    }
    bare_points_destroy(&s.points);
    stp_renderer_destroy(&s.renderer);
    stp_gl_context_destroy(&s.context);
    stp_model_close(&s.model);
    return status;
}

static int run(int argc, char **argv)
{
    options o = {.size = {1024, 1024}, .repeat = 9, .gpu_memory = UINT64_C(2) << 30};
    cli_common common = {0};
    const char *path = NULL;
    size_t count = 0;
    stp_error err = {0};
    const cli_option list[] = {
        {"--size", 0, CLI_EXTENT, o.size, "WxH", "of the picture in pixels (1024x1024)", NULL},
        {"--repeat", 0, CLI_UINT, &o.repeat, "N", "rounds to measure (9)", NULL},
        {"--gpu-memory", 0, CLI_BYTES, &o.gpu_memory, "SIZE", "for samples on the GPU (2G)", NULL},
        {"--cpu-memory", 0, CLI_BYTES, &o.cpu_memory, "SIZE", "for chunks (1G)", NULL},
        {"--first", 0, CLI_FLAG, &o.first, NULL, "time this process's first picture instead", NULL},
        {"--open", 0, CLI_FLAG, &o.open, NULL, "how soon it looks like itself, instead", NULL},
        {"--stops", 0, CLI_FLAG, &o.stops, NULL, "a cold flight with six stops, instead", NULL},
        {"--decode", 0, CLI_STRING, &o.decode, "N.stipple",
         "decode it and M in turns, one thread, instead", NULL},
        {"--fps", 0, CLI_NUMBER, &o.fps, "N", "how well N frames a second are held, instead", NULL},
    };
    int code = cli_parse(&bench, list, sizeof list / sizeof *list, argc, argv, &path, 1, 1, &count,
                         &common);
    if (code != CLI_CONTINUE)
        return code;
    if (o.repeat < 1 || o.repeat > REPEAT_LIMIT)
        return cli_usage(&bench, "--repeat takes 1 to %u", REPEAT_LIMIT);
    if (o.first) {
        first_params first = {.path = path,
                              .size = {o.size[0], o.size[1]},
                              .gpu_memory = o.gpu_memory,
                              .cpu_memory = o.cpu_memory,
                              .threads = (unsigned)common.threads};
        return first_run(&first, &err) == STP_OK ? CLI_DONE : cli_fail(&bench, &err);
    }
    if (o.decode)
        return bench_decode(&o, path, &err) == STP_OK ? CLI_DONE : cli_fail(&bench, &err);
    cli_progress(&common); /* Ctrl-C from here on is asked for between rounds */
    return run_bench(&o, &common, path, &err) == STP_OK ? CLI_DONE : cli_fail(&bench, &err);
}

int main(int argc, char **argv)
{
    return bench.run(argc, argv);
}
