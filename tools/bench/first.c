/* Draws the first picture and reads a clock at each stage. */
#include "tools/bench/first.h"

#include "base/memory.h"
#include "runtime/cut/model.h"
#include "runtime/gl/gl_context.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

/* The stages in their order. Shaders and frame are one call; the frame's own clock separates them.
 */
typedef enum first_stage {
    FIRST_PROCESS, /* before the program's first line: loading it and its libraries */
    FIRST_CONTEXT,
    FIRST_OPEN,
    FIRST_ROOT, /* the renderer: its memory and the root chunk */
    FIRST_DRAW,
    FIRST_STAGES
} first_stage;

typedef struct first_clock {
    double wall_s[FIRST_STAGES], cpu_s[FIRST_STAGES]; /* at the end of each stage */
} first_clock;

static double seconds_of(clockid_t id)
{
    struct timespec t;
    clock_gettime(id, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void stamp(first_clock *clock, first_stage stage)
{
    clock->wall_s[stage] = seconds_of(CLOCK_REALTIME);
    clock->cpu_s[stage] = seconds_of(CLOCK_PROCESS_CPUTIME_ID);
}

static void print_stages(const first_clock *clock, const stp_draw_stats *stats, size_t covered)
{
    static const char *const names[FIRST_STAGES] = {"process", "context", "open", "root", "draw"};
    printf("begun %.6f\n", clock->wall_s[FIRST_PROCESS]);
    for (int i = 0; i < FIRST_STAGES; i++) {
        double before = i > 0 ? clock->wall_s[i - 1] : clock->wall_s[i];
        double cpu_before = i > 0 ? clock->cpu_s[i - 1] : 0.0;
        printf("%s %.1f %.1f\n", names[i], 1e3 * (clock->wall_s[i] - before),
               1e3 * (clock->cpu_s[i] - cpu_before));
    }
    printf("frame %.1f\npoints %llu\ncovered %zu\n", stats->frame_ms,
           (unsigned long long)stats->points_drawn, covered);
}

static stp_status count_covered(stp_renderer *renderer, const int size[2], size_t *count,
                                stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *rgba = NULL;
    size_t pixels = (size_t)size[0] * (size_t)size[1];
    STP_TRY(stp_alloc(&rgba, pixels, 4, "a picture", err));
    STP_TRY(stp_renderer_read(renderer, rgba, err));
    *count = 0;
    for (size_t i = 0; i < pixels; i++)
        *count += rgba[4 * i + 3] != 0;
    if (*count == 0)
        status = stp_error_set(err, STP_FORMAT, "the first picture is empty");
done:
    free(rgba);
    return status;
}

stp_status first_run(const first_params *p, stp_error *err)
{
    stp_status status = STP_OK;
    first_clock clock;
    stp_gl_context *context = NULL;
    stp_model *model = NULL;
    stp_renderer *renderer = NULL;
    stp_draw_stats stats;
    stp_view view;
    size_t covered = 0;
    stamp(&clock, FIRST_PROCESS);
    STP_TRY(stp_gl_context_create(&context, err));
    stamp(&clock, FIRST_CONTEXT);
    STP_TRY(stp_model_open(&model, p->path, err));
    stamp(&clock, FIRST_OPEN);
    STP_TRY(stp_renderer_create(&renderer,
                                &(stp_renderer_params){.model = model,
                                                       .gpu_memory_bytes = p->gpu_memory,
                                                       .cpu_memory_bytes = p->cpu_memory,
                                                       .thread_count = p->threads},
                                err));
    stamp(&clock, FIRST_ROOT);
    stp_camera camera = stp_camera_default(&model->info->box, &model->ball, p->size[0], p->size[1]);
    STP_TRY(stp_view_create(&view, &camera, &model->ball, p->size[0], p->size[1], err));
    STP_TRY(stp_renderer_draw(renderer, &view, &(stp_draw_params){.stream = true}, &stats, err));
    stamp(&clock, FIRST_DRAW);
    STP_TRY(count_covered(renderer, p->size, &covered, err));
    print_stages(&clock, &stats, covered);
done:
    stp_renderer_destroy(&renderer);
    stp_model_close(&model);
    stp_gl_context_destroy(&context);
    return status;
}
