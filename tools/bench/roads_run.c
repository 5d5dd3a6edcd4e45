/* Draws frames by each road in turns: A B C ... A B C ... */
#include "tools/bench/roads_run.h"

#include "base/clock.h"
#include "base/memory.h"
#include "runtime/draw/road.h"
#include "runtime/draw/stage_clock.h"
#include "tools/bench/bare_points.h"
#include "tools/cli/cli_value.h"
#include "tools/draw/draw_options.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Every road with a threshold is drawn with each of these; 0 is every sample. */
static const double thresholds_px[] = {0.0, 0.5, 1.0, 2.0};
#define THRESHOLD_COUNT (sizeof thresholds_px / sizeof *thresholds_px)

static const struct {
    const char *word;
    stp_lod lod;
    stp_reconstruct reconstruct;
    bool bare, whole; /* whole: the road has no threshold */
} kinds[] = {
    {.word = "points", .bare = true, .whole = true},
    {.word = "full", .lod = STP_LOD_FULL, .whole = true},
    {.word = "geometry", .lod = STP_LOD_GEOMETRY},
    {.word = "compute", .lod = STP_LOD_COMPUTE},
    {.word = "cpu", .lod = STP_LOD_CPU},
    {.word = "splat", .lod = STP_LOD_COMPUTE, .reconstruct = STP_RECONSTRUCT_SPLAT},
};
#define KIND_COUNT (sizeof kinds / sizeof *kinds)

_Static_assert(KIND_COUNT *THRESHOLD_COUNT <= ROADS_LIMIT, "room for all roads");

/* True if an item of a comma-separated list is the road's word, or its word with its threshold:
 * compute:1. */
static bool item_names(const char *item, size_t length, const bench_road *r)
{
    char full[32];
    snprintf(full, sizeof full, "%s:%g", r->word, r->params.threshold_px);
    return (strlen(r->word) == length && strncmp(item, r->word, length) == 0) ||
           (strlen(full) == length && strncmp(item, full, length) == 0);
}

/* True if the list names the road. Counts the matching items. */
static bool lists(const char *words, const bench_road *r, unsigned named[ROADS_LIMIT])
{
    bool found = false;
    for (size_t i = 0; words != NULL && i < ROADS_LIMIT; i++) {
        size_t length = strcspn(words, ",");
        if (item_names(words, length, r)) {
            named[i]++;
            found = true;
        }
        words = words[length] == ',' ? words + length + 1 : NULL;
    }
    return found;
}

/* True if each item of the list named a road. */
static bool all_named(const char *words, const unsigned named[ROADS_LIMIT])
{
    size_t count = 1;
    for (; *words != '\0'; words++)
        count += *words == ',';
    for (size_t i = 0; i < count; i++)
        if (i >= ROADS_LIMIT || named[i] == 0)
            return false;
    return true;
}

static bench_road make_road(size_t kind, double threshold_px)
{
    bench_road r = {.word = kinds[kind].word, .bare = kinds[kind].bare};
    if (kinds[kind].whole)
        snprintf(r.name, sizeof r.name, "%s", r.word);
    else
        snprintf(r.name, sizeof r.name, "%s %g px", r.word, threshold_px);
    r.params = (stp_draw_params){.lod = kinds[kind].lod,
                                 .reconstruct = kinds[kind].reconstruct,
                                 .threshold_px = threshold_px,
                                 .every_sample = threshold_px <= 0.0};
    return r;
}

stp_status roads_choose(const char *words, bench_road roads[ROADS_LIMIT], size_t *count,
                        stp_error *err)
{
    unsigned named[ROADS_LIMIT] = {0};
    size_t chosen = 0;
    for (size_t i = 0; i < KIND_COUNT; i++) {
        size_t variants = kinds[i].whole ? 1 : THRESHOLD_COUNT;
        for (size_t k = 0; k < variants; k++) {
            roads[chosen] = make_road(i, thresholds_px[k]);
            chosen += words == NULL || lists(words, &roads[chosen], named);
        }
    }
    if (words != NULL && !all_named(words, named))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "'%s' are not all roads: give points, full, geometry, compute, cpu, "
                             "splat with commas between, one threshold of a road as compute:0.5",
                             words);
    *count = chosen;
    return STP_OK;
}

/* The reconstruction of this name; -1 if there is none. */
static int find_reconstruction(const char *name, size_t length)
{
    const char *word;
    size_t word_length;
    for (int i = 0; cli_choice_at(DRAW_RECONSTRUCTIONS, i, &word, &word_length); i++)
        if (word_length == length && strncmp(word, name, length) == 0)
            return i;
    return -1;
}

stp_status roads_reconstruct(const char *words, bench_road roads[ROADS_LIMIT], size_t *count,
                             stp_error *err)
{
    bench_road made[ROADS_LIMIT];
    size_t made_count = 0;
    for (size_t i = 0; i < *count; i++) {
        bool varies = !roads[i].bare && roads[i].params.reconstruct == STP_RECONSTRUCT_GAUSS;
        for (const char *at = varies ? words : ""; at != NULL;) {
            size_t length = strcspn(at, ","), end = strlen(roads[i].name);
            int found = varies ? find_reconstruction(at, length) : (int)roads[i].params.reconstruct;
            if (found < 0 || made_count == ROADS_LIMIT)
                return stp_error_set(err, STP_INVALID_ARGUMENT,
                                     "'%s': give words of %s with commas between, for at most %d "
                                     "roads",
                                     words, DRAW_RECONSTRUCTIONS, ROADS_LIMIT);
            bench_road *r = &made[made_count++];
            *r = roads[i];
            r->params.reconstruct = (stp_reconstruct)found;
            if (varies)
                snprintf(r->name + end, sizeof r->name - end, " %.*s", (int)length, at);
            at = at[length] == ',' ? at + length + 1 : NULL;
        }
    }
    memcpy(roads, made, made_count * sizeof *made);
    *count = made_count;
    return STP_OK;
}

/* What is needed to draw frames. */
typedef struct bench_stage {
    const roads_run_params *params;
    bare_points points;    /* if the road is wanted */
    stp_stage_clock clock; /* clock of bare points */
} bench_stage;

static stp_status draw_bare(bench_stage *s, road_times *out, stp_error *err)
{
    stp_status status = bare_points_draw(&s->points, &out->frame_ms, err);
    if (status != STP_OK)
        return status;
    out->points_drawn = s->points.count;
    double begun = stp_clock_seconds(), drawn_ms = 0.0;
    s->clock.ms = out->gpu_ms;
    stp_stage_begin(&s->clock);
    status = bare_points_draw(&s->points, &drawn_ms, err);
    stp_stage_end(&s->clock, STP_STAGE_PROJECT);
    out->project_ms = 1e3 * (stp_clock_seconds() - begun);
    return status;
}

/* Draws a frame without waiting, and one that waits. The previous road had other programs and
 * another cut, so a frame before these, which is not counted, takes the cost of the change. */
static stp_status draw_road(bench_stage *s, const bench_road *r, road_times *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_draw_stats stats;
    stp_draw_params params = r->params;
    const roads_run_params *p = s->params;
    *out = (road_times){0};
    if (r->bare)
        return draw_bare(s, out, err);
    STP_TRY(stp_renderer_draw(p->renderer, p->view, &params, NULL, err));
    STP_TRY(stp_renderer_draw(p->renderer, p->view, &params, &stats, err));
    out->frame_ms = stats.frame_ms;
    out->points_drawn = stats.points_drawn;
    params.timed = true;
    STP_TRY(stp_renderer_draw(p->renderer, p->view, &params, &stats, err));
    out->project_ms = stats.project_ms;
    out->pull_push_ms = stats.pull_push_ms;
    out->shade_ms = stats.shade_ms;
    memcpy(out->gpu_ms, stats.gpu_ms, sizeof out->gpu_ms);
done:
    return status;
}

static void add_up(road_times *t)
{
    t->waited_ms = t->project_ms + t->pull_push_ms + t->shade_ms;
    for (int i = 0; i < STP_STAGE_COUNT; i++)
        t->gpu_all_ms += t->gpu_ms[i];
}

static double machine_load(void)
{
    double load = 0.0;
    return getloadavg(&load, 1) == 1 ? load : 0.0;
}

/* Draws every road once per round. The results of the warm-up are overwritten. */
static stp_status draw_rounds(bench_stage *s, roads_run_result *out, stp_error *err)
{
    stp_status status = STP_OK;
    for (unsigned i = 0; i < ROADS_WARM_UP_ROUNDS + out->rounds; i++) {
        unsigned round = i < ROADS_WARM_UP_ROUNDS ? 0 : i - ROADS_WARM_UP_ROUNDS;
        for (size_t k = 0; k < out->road_count; k++) {
            road_times *times = &out->times[k * out->rounds + round];
            STP_TRY(draw_road(s, &out->roads[k], times, err));
            add_up(times);
        }
        if (s->params->interrupted()) {
            status = stp_error_set(err, STP_CANCELLED, "interrupted");
            goto done;
        }
    }
done:
    return status;
}

stp_status roads_run(const roads_run_params *params, roads_run_result *out, stp_error *err)
{
    stp_status status = STP_OK;
    bench_stage stage = {.params = params};
    roads_run_result result = {.rounds = params->rounds};
    STP_TRY(roads_choose(params->words, result.roads, &result.road_count, err));
    if (params->reconstructions != NULL)
        STP_TRY(roads_reconstruct(params->reconstructions, result.roads, &result.road_count, err));
    STP_TRY(stp_alloc(&result.times, result.road_count * params->rounds, sizeof *result.times,
                      "times", err));
    stp_stage_clock_create(&stage.clock, stp_road_is_software());
    if (result.roads[0].bare)
        STP_TRY(bare_points_create(&stage.points, params->model, params->view, err));
    result.load_before = machine_load();
    STP_TRY(draw_rounds(&stage, &result, err));
    result.load_after = machine_load();
    *out = result;
    result = (roads_run_result){0};
done:
    if (stage.clock.stamps[0] != 0)
        stp_stage_clock_destroy(&stage.clock);
    bare_points_destroy(&stage.points);
    roads_run_free(&result);
    return status;
}

void roads_run_free(roads_run_result *result)
{
    free(result->times);
    *result = (roads_run_result){0};
}
