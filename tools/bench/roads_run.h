/* Lists the roads to a picture and draws frames by each in turns. Threads: the render thread. */
#ifndef STP_TOOLS_BENCH_ROADS_RUN_H
#define STP_TOOLS_BENCH_ROADS_RUN_H

#include "runtime/cut/model.h"
#include "runtime/stipple.h"

#define ROADS_LIMIT 32
#define ROADS_WARM_UP_ROUNDS 1

typedef struct bench_road {
    const char *word; /* points, full, geometry, compute, cpu, splat */
    char name[32];    /* the word, with threshold and reconstruction if these were chosen */
    stp_draw_params params;
    bool bare; /* points without a surface: the yardstick */
} bench_road;

/* Times of one round of a road. The first is of a frame drawn without waiting, the others are of a
 * frame that waits between its stages. */
typedef struct road_times {
    double frame_ms;
    double project_ms, pull_push_ms, shade_ms, waited_ms; /* CPU's clock; waited_ms: the sum */
    double gpu_ms[STP_STAGE_COUNT], gpu_all_ms;           /* GPU's clock; gpu_all_ms: the sum */
    uint64_t points_drawn;
} road_times;

typedef struct roads_run_params {
    const stp_model *model;
    const stp_view *view;
    stp_renderer *renderer;
    const char *words;           /* names of roads with commas: compute, or compute:1; NULL: all */
    const char *reconstructions; /* names with commas: gauss,splat; NULL: gauss */
    unsigned rounds;
    bool (*interrupted)(void); /* called between rounds */
} roads_run_params;

typedef struct roads_run_result {
    bench_road roads[ROADS_LIMIT];
    size_t road_count;
    unsigned rounds;
    road_times *times;              /* by road, then by round */
    double load_before, load_after; /* load of the machine, mean over one minute */
} roads_run_result;

/* Finds the roads of these words, in their order. Errors: INVALID_ARGUMENT (no such road). */
stp_status roads_choose(const char *words, bench_road roads[ROADS_LIMIT], size_t *count,
                        stp_error *err);
/* Replaces each road that reconstructs with gauss by one road for each of these reconstructions.
 * Errors: INVALID_ARGUMENT (no such reconstruction, or more than ROADS_LIMIT roads). */
stp_status roads_reconstruct(const char *words, bench_road roads[ROADS_LIMIT], size_t *count,
                             stp_error *err);
/* Free with roads_run_free. Errors: those of roads_choose, of drawing and, for the yardstick, of
 * reading chunks; CANCELLED. */
stp_status roads_run(const roads_run_params *params, roads_run_result *out, stp_error *err);
void roads_run_free(roads_run_result *result);

#endif
