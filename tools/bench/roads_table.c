/* Prints medians of rounds, and the rounds themselves. */
#include "tools/bench/roads_table.h"

#include "base/memory.h"
#include "runtime/draw/road.h"
#include "tools/bench/median.h"
#include "tools/cli/cli_value.h"
#include "tools/draw/draw_options.h"

#include <epoxy/gl.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* GPU and CPU have different clocks. The GPU's time may exceed the waited time by this much. */
#define CLOCK_SLACK 0.02
#define CLOCK_SLACK_MS 0.1

typedef struct spread {
    double least, median, greatest;
} spread;

/* The spread of one figure over a road's rounds. offset: bytes from the begin of road_times. */
static spread spread_of(const roads_run_result *r, size_t road, size_t offset, double *values)
{
    for (unsigned i = 0; i < r->rounds; i++)
        memcpy(&values[i], (const char *)&r->times[road * r->rounds + i] + offset, sizeof *values);
    double median = bench_median(values, r->rounds); /* bench_median also sorts */
    return (spread){values[0], median, values[r->rounds - 1]};
}
#define SPREAD_OF(result, road, field, values)                                                     \
    spread_of(result, road, offsetof(road_times, field), values)

/* The median of the road with this word; 0 if it was not drawn. */
static double median_named(const roads_run_result *r, const char *word, double *values)
{
    for (size_t i = 0; i < r->road_count; i++)
        if (strcmp(r->roads[i].word, word) == 0)
            return SPREAD_OF(r, i, frame_ms, values).median;
    return 0.0;
}

static void print_times(double ms, bool there)
{
    if (there)
        printf(" %9.2f", ms);
    else
        printf(" %9s", "-");
}

static void print_ratio(double ms, double frame_ms)
{
    if (ms > 0.0)
        printf(" %7.2f", ms / frame_ms);
    else
        printf(" %7s", "-");
}

static void print_frames(const roads_run_result *r, double *values)
{
    double full_ms = median_named(r, "full", values);
    double points_ms = median_named(r, "points", values);
    printf("%-25s %9s %8s %8s %9s %9s %9s %11s %7s %7s\n", "ms, medians", "frame", "min", "max",
           "project", "pull-push", "shade", "drawn", "full/", "points/");
    for (size_t i = 0; i < r->road_count; i++) {
        spread frame = SPREAD_OF(r, i, frame_ms, values);
        bool parts = !r->roads[i].bare;
        printf("%-25s %9.2f %8.2f %8.2f", r->roads[i].name, frame.median, frame.least,
               frame.greatest);
        print_times(SPREAD_OF(r, i, project_ms, values).median, parts);
        print_times(SPREAD_OF(r, i, pull_push_ms, values).median, parts);
        print_times(SPREAD_OF(r, i, shade_ms, values).median, parts);
        printf(" %11llu", (unsigned long long)r->times[i * r->rounds].points_drawn);
        print_ratio(full_ms, frame.median);
        print_ratio(points_ms, frame.median);
        printf("\n");
    }
}

static void print_stages(const roads_run_result *r, double *values)
{
    printf("\n%-25s %9s %9s", "GPU's clock, ms", "waited", "all");
    for (int k = 0; k < STP_STAGE_COUNT; k++)
        printf(" %8s", stp_stage_name((stp_stage)k));
    printf("\n");
    for (size_t i = 0; i < r->road_count; i++) {
        printf("%-25s %9.2f %9.2f", r->roads[i].name, SPREAD_OF(r, i, waited_ms, values).median,
               SPREAD_OF(r, i, gpu_all_ms, values).median);
        for (int k = 0; k < STP_STAGE_COUNT; k++)
            printf(" %8.3f", SPREAD_OF(r, i, gpu_ms[k], values).median);
        printf("\n");
    }
}

/* Counts frames for which the GPU's clock gives nothing, or more than the frame took. */
static size_t count_odd(const roads_run_result *r)
{
    size_t odd = 0;
    for (size_t i = 0; i < r->road_count * r->rounds; i++) {
        double gpu = r->times[i].gpu_all_ms, waited = r->times[i].waited_ms;
        odd += gpu <= 0.0 || gpu > waited * (1.0 + CLOCK_SLACK) + CLOCK_SLACK_MS;
    }
    return odd;
}

static void print_trust(const roads_run_result *r)
{
    size_t odd = count_odd(r);
    if (stp_road_is_software())
        printf("a software driver: stages are stamped by the processors that draw them, waits of "
               "theirs included\n");
    if (odd > 0)
        printf("of %zu of %zu frames the GPU's clock says 0, or more than they took: its columns "
               "are not to be trusted\n",
               odd, r->road_count * r->rounds);
}

stp_status roads_table_print(const roads_run_result *r, const stp_model *model,
                             const stp_view *view, stp_error *err)
{
    double *values = NULL;
    stp_status status = stp_alloc(&values, r->rounds, sizeof *values, "times", err);
    if (status != STP_OK)
        return status;
    printf("%s: %llu points, %u chunks, %dx%d, %u rounds after %d of warm-up\n",
           stp_chunk_file_path(model->file), (unsigned long long)model->info->point_count,
           model->info->chunk_count, view->width, view->height, r->rounds, ROADS_WARM_UP_ROUNDS);
    printf("%s: %s, %ld processors, load %.2f before and %.2f after\n",
           (const char *)glGetString(GL_VENDOR), (const char *)glGetString(GL_RENDERER),
           sysconf(_SC_NPROCESSORS_ONLN), r->load_before, r->load_after);
    print_frames(r, values);
    print_stages(r, values);
    print_trust(r);
    free(values);
    return STP_OK;
}

static void print_quoted(const char *text)
{
    printf(",\"");
    for (; *text != '\0'; text++)
        printf("%s%c", *text == '"' ? "\"" : "", *text);
    printf("\"");
}

static void print_csv_row(const roads_run_result *r, size_t i, unsigned round)
{
    const bench_road *road = &r->roads[i];
    const road_times *t = &r->times[i * r->rounds + round];
    printf("%u,%s,%g,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f", round, road->word, road->params.threshold_px,
           t->frame_ms, t->project_ms, t->pull_push_ms, t->shade_ms, t->waited_ms, t->gpu_all_ms);
    for (int k = 0; k < STP_STAGE_COUNT; k++)
        printf(",%.4f", t->gpu_ms[k]);
    const char *word = "-"; /* of bare points, which have no surface */
    size_t length = 1;
    if (!road->bare)
        cli_choice_at(DRAW_RECONSTRUCTIONS, (int)road->params.reconstruct, &word, &length);
    printf(",%llu,%.*s", (unsigned long long)t->points_drawn, (int)length, word);
}

void roads_table_csv_run(const stp_model *model, const stp_view *view)
{
    printf(",%llu,%d,%d", (unsigned long long)model->info->point_count, view->width, view->height);
    print_quoted(stp_chunk_file_path(model->file));
    print_quoted((const char *)glGetString(GL_VENDOR));
    print_quoted((const char *)glGetString(GL_RENDERER));
    print_quoted((const char *)glGetString(GL_VERSION));
    printf("\n");
}

void roads_table_csv(const roads_run_result *r, const stp_model *model, const stp_view *view)
{
    printf(
        "round,road,threshold_px,frame_ms,project_ms,pull_push_ms,shade_ms,waited_ms,gpu_all_ms");
    for (int k = 0; k < STP_STAGE_COUNT; k++)
        printf(",gpu_%s_ms", stp_stage_name((stp_stage)k));
    printf(",points_drawn,reconstruct" ROADS_TABLE_RUN "\n");
    for (unsigned round = 0; round < r->rounds; round++)
        for (size_t i = 0; i < r->road_count; i++) {
            print_csv_row(r, i, round);
            roads_table_csv_run(model, view);
        }
}
