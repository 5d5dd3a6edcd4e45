/* stipple-bench: measures how long a frame takes by each road, in turns in one run. */
#include "base/clock.h"
#include "runtime/gl/gl_context.h"
#include "tools/bench/decode_run.h"
#include "tools/bench/first.h"
#include "tools/bench/open_run.h"
#include "tools/bench/pace_run.h"
#include "tools/bench/roads_run.h"
#include "tools/bench/roads_table.h"
#include "tools/bench/stops_run.h"
#include "tools/cli/cli.h"

#include <math.h>
#include <stdio.h>

static int run(int argc, char **argv);
static const cli_command bench = {
    .name = "bench",
    .program = "stipple-bench",
    .summary = "measure how long a frame takes by each road",
    .usage = "stipple-bench M.stipple [options]",
    .details =
        "Draws the whole model headless by each road in turns, A B C ... A B C ..., and prints "
        "one\n"
        "table of medians. `points` is the yardstick: every sample as a bare one-pixel point,\n"
        "without a surface. `splat` draws an ellipse for each sample with compute shaders. At 0 "
        "px\n"
        "every sample is drawn. The column frame times frames drawn without waiting in between.\n"
        "The columns project, pull-push and shade time frames that wait between stages; the "
        "second\n"
        "table shows the same frames by the GPU's own clock (timestamps). Loading is not counted.\n"
        "--first prints, stage by stage, the milliseconds of the clock and of the processors "
        "until\n"
        "the first picture: process (before the program's first line; `begun` is its time in\n"
        "seconds since 1970), context, open, root and draw. `frame` is the part of draw that does\n"
        "not compile shaders.",
    .run = run,
};

#define REPEAT_LIMIT 10000u
#define PACE_SECONDS 6.0

typedef struct options {
    int size[2];
    uint64_t repeat, gpu_memory, cpu_memory;
    double fps;
    bool open, first, stops, csv;
    const char *decode, *roads, *reconstructions;
} options;

typedef struct bench_state {
    stp_model *model;
    stp_gl_context *context;
    stp_renderer *renderer;
    stp_view view;
} bench_state;

/* Prints the table of roads. */
static stp_status bench_roads(const bench_state *s, const options *o, stp_error *err)
{
    stp_status status = STP_OK;
    roads_run_result r = {.road_count = 0};
    STP_TRY(roads_run(&(roads_run_params){.model = s->model,
                                          .view = &s->view,
                                          .renderer = s->renderer,
                                          .words = o->roads,
                                          .reconstructions = o->reconstructions,
                                          .rounds = (unsigned)o->repeat,
                                          .interrupted = cli_interrupted},
                      &r, err));
    if (o->csv)
        roads_table_csv(&r, s->model, &s->view);
    else
        STP_TRY(roads_table_print(&r, s->model, &s->view, err));
done:
    roads_run_free(&r);
    return status;
}

/* Prints the rate that is held, in one line. */
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
        printf("%s: %.1f fps wanted, %.2f held (%+.0f %%) at %.3g px and %.0f %% of the width, "
               "%.1f ms a frame; %.1f ms without a choice%s\n",
               stp_chunk_file_path(s->model->file), o->fps, r.fps, 100.0 * (r.fps / o->fps - 1.0),
               r.threshold_px, 100.0 * r.scale, r.frame_ms, r.bare_ms,
               r.holds ? "" : "; cannot be held");
    return status;
}

/* Prints how soon the model looks like itself, in one line or as CSV. */
static stp_status bench_open(const bench_state *s, bool csv, double begun, stp_error *err)
{
    open_run_result r;
    stp_status status = open_run(s->renderer, &s->view, begun, &r, err);
    if (status == STP_OK && csv) {
        printf("ready_s,first_s,alike_s,complete_s,complete,frames,bytes,file_bytes" ROADS_TABLE_RUN
               "\n"
               "%.6f,%.6f,%.6f,%.6f,%d,%u,%llu,%llu",
               r.ready_s, r.first_s, r.alike_s, r.complete_s, r.complete, r.frames,
               (unsigned long long)r.bytes, (unsigned long long)s->model->info->file_bytes);
        roads_table_csv_run(s->model, &s->view);
        return STP_OK;
    }
    double share = 100.0 * (double)r.bytes / (double)s->model->info->file_bytes;
    if (status == STP_OK)
        printf(
            "%s: first picture after %.3f s (covers %.1f %% of what the last does), %.0f %% after "
            "%.3f s, %s after %.3f s, %u frames, %.2f MB of payloads: %.1f %% of the file\n",
            stp_chunk_file_path(s->model->file), r.first_s, 100.0 * r.first_overlap,
            100.0 * OPEN_RUN_OVERLAP, r.alike_s, r.complete ? "complete" : "memory full",
            r.complete_s, r.frames, 1e-6 * (double)r.bytes, share);
    return status;
}

/* Prints one line: the cost of chunks, summed over the stops, then the times of each stop's two
 * frames. */
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
        printf("size %.3f  million points a second %.4g %.4g  ratio %.4g (%.4g to %.4g), %u "
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
    if (o->open)
        STP_TRY(bench_open(&s, o->csv, begun, err));
    else if (o->stops)
        STP_TRY(bench_stops(&s, o, err));
    else if (o->fps > 0.0)
        STP_TRY(bench_pace(&s, o, err));
    else
        STP_TRY(bench_roads(&s, o, err));
done:
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
        {"--size", 0, CLI_EXTENT, o.size, "WxH", "size of the picture in pixels (1024x1024)", NULL},
        {"--repeat", 0, CLI_UINT, &o.repeat, "N", "number of rounds to measure (9)", NULL},
        {"--gpu-memory", 0, CLI_BYTES, &o.gpu_memory, "SIZE", "memory for samples on the GPU (2G)",
         NULL},
        {"--cpu-memory", 0, CLI_BYTES, &o.cpu_memory, "SIZE", "memory for chunks (1G)", NULL},
        {"--roads", 0, CLI_STRING, &o.roads, "LIST",
         "some of points,full,geometry,compute,cpu,splat, or with a threshold: compute:1 (all)",
         NULL},
        {"--reconstruct", 0, CLI_STRING, &o.reconstructions, "LIST",
         "draw each road with each of these reconstructions, like gauss,box (gauss)", NULL},
        {"--csv", 0, CLI_FLAG, &o.csv, NULL,
         "print every round's times as CSV instead of a table; with --open, one row", NULL},
        {"--first", 0, CLI_FLAG, &o.first, NULL, "instead, time this process's first picture",
         NULL},
        {"--open", 0, CLI_FLAG, &o.open, NULL, "instead, time how soon the model looks like itself",
         NULL},
        {"--stops", 0, CLI_FLAG, &o.stops, NULL, "instead, time a cold flight with six stops",
         NULL},
        {"--decode", 0, CLI_STRING, &o.decode, "N.stipple",
         "instead, decode N and M in turns on one thread", NULL},
        {"--fps", 0, CLI_NUMBER, &o.fps, "N",
         "instead, measure how well N frames a second are held", NULL},
    };
    int code = cli_parse(&bench, list, sizeof list / sizeof *list, argc, argv, &path, 1, 1, &count,
                         &common);
    if (code != CLI_CONTINUE)
        return code;
    if (o.repeat < 1 || o.repeat > REPEAT_LIMIT)
        return cli_usage(&bench, "--repeat takes 1 to %u", REPEAT_LIMIT);
    bench_road roads[ROADS_LIMIT];
    if (roads_choose(o.roads, roads, &count, &err) != STP_OK)
        return cli_usage(&bench, "--roads: %s", err.message);
    if (o.reconstructions && roads_reconstruct(o.reconstructions, roads, &count, &err) != STP_OK)
        return cli_usage(&bench, "--reconstruct: %s", err.message);
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
    cli_progress(&common); /* from here on, Ctrl-C is checked between rounds */
    return run_bench(&o, &common, path, &err) == STP_OK ? CLI_DONE : cli_fail(&bench, &err);
}

int main(int argc, char **argv)
{
    return bench.run(argc, argv);
}
