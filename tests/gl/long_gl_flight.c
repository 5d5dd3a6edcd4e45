/* Tests a random flight through a model larger than the given memory: legs along smooth curves
 * between near and far places, some after a jump; each leg ends in a stop. At every frame memory
 * stays within its budgets and nothing is waited for. The process, its descriptors and its threads
 * do not grow. Every stop ends with the same bytes as a picture that waited.
 *
 * STIPPLE_FLIGHT_MODEL names a chunk file, flown with 256 MiB each for GPU and CPU. Without it the
 * test makes a small statue and flies it with STATUE_BYTES. STIPPLE_FLIGHT_MINUTES is 30 by
 * default; the judge's time (tests/fixtures/flight_judge.h) does not count. Prints frame times
 * while streaming, next to the times of the same views with all chunks loaded. */
#include "base/random.h"
#include "runtime/camera/path.h"
#include "tests/fixtures/flight_judge.h"
#include "tests/fixtures/flight_watch.h"
#include "tests/fixtures/model_fixture.h"
#include "tests/fixtures/size.h"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define COUNTS_MEMORY 0 /* sanitizers keep some memory for themselves */
#else
#define COUNTS_MEMORY 1
#endif

enum {
    SIZE = TEST_SIZE(512, 128),
    KEYFRAMES = 6,
    REPLAYED = 30,   /* views of a leg that the judge draws again */
    WATCH_FRAMES = 8 /* the process is measured every so many frames */
};

#define BUDGET_BYTES (UINT64_C(256) << 20)
#define STATUE_BYTES (UINT64_C(16) << 20)
#define JUDGE_BYTES (UINT64_C(2) << 30)
/* Memory of a process beside the budgets: programs, a picture's pyramid, temporary memory of
 * drawing. */
#define FIXED_BYTES (UINT64_C(192) << 20)
/* Memory may grow by this much from the first to the last third of a flight. */
#define GROWTH_BYTES (UINT64_C(16) << 20)
#define KEYFRAME_S 4.0
#define THRESHOLD_PX 1.0
/* If a stop takes longer, the test assumes that it never ends. */
#define STOP_S TEST_SIZE(120.0, 1200.0)
#define SEED 20

typedef struct flown_view {
    stp_view view;
    judge_time time;
} flown_view;

typedef struct flight {
    const char *path;
    uint64_t budget_bytes;
    double seconds; /* how long to fly */
    judge judge;
    stp_model *model;
    stp_renderer *renderer;
    uint64_t draw; /* number of random numbers drawn */
    stp_camera camera;
    flown_view *views; /* of the current leg */
    size_t view_count, view_capacity;
    int *finest; /* by block, after the last frame */
    /* measurements */
    double flown_s, judged_s;
    figures ms, stop_s, rss;
    /* times of the views drawn again: streaming, resident, resident again */
    figures replayed_ms[3], replayed_processor_ms[3];
    uint64_t frames, frames_incomplete, replayed_incomplete, loaded, evicted;
    uint64_t baseline_bytes, peak_bytes;
    uint64_t gpu_most, filled_bytes; /* of the budgets, so far */
    unsigned descriptors, threads, legs;
} flight;

/* ---- the route ---- */

static double chance(flight *f)
{
    return stp_random_unit(SEED, f->draw++);
}

/* Looks at a chunk from outside, from near or far. */
static stp_camera random_camera(flight *f)
{
    const stp_chunk_file_info *info = f->model->info;
    stp_dvec3 up = stp_camera_up(&info->box), direction, target;
    do {
        const stp_chunk_entry *e = &f->model->entries[(uint32_t)(chance(f) * info->chunk_count)];
        vec3s half = glms_vec3_scale(glms_vec3_add(e->box_min, e->box_max), 0.5f);
        target = stp_dvec3_add(e->origin, stp_dvec3_from_float(half));
        stp_dvec3 out = stp_dvec3_sub(target, f->model->ball.centre);
        stp_dvec3 any = {chance(f) - 0.5, chance(f) - 0.5, chance(f) - 0.5};
        direction = stp_dvec3_add(stp_dvec3_scale(out, 1.0 / f->model->ball.radius), any);
        direction = stp_dvec3_normalize(direction);
    } while (!(fabs(stp_dvec3_dot(direction, up)) < 0.98));
    double distance = f->model->ball.radius * exp(log(0.03) + chance(f) * (log(2.5) - log(0.03)));
    return (stp_camera){.eye = stp_dvec3_add(target, stp_dvec3_scale(direction, distance)),
                        .look = target,
                        .up = up,
                        .fovy_deg = STP_CAMERA_FOVY_DEG};
}

/* Continues from the camera's place; every third leg begins elsewhere. */
static stp_path *random_path(flight *f)
{
    stp_keyframe keys[KEYFRAMES];
    stp_path *path = NULL;
    if (f->legs % 3 == 0)
        f->camera = random_camera(f);
    for (int k = 0; k < KEYFRAMES; k++)
        keys[k] = (stp_keyframe){k * KEYFRAME_S, k == 0 ? f->camera : random_camera(f)};
    check_ok(
        stp_path_create(&path, &(stp_path_params){.keyframes = keys, .count = KEYFRAMES}, err));
    f->camera = keys[KEYFRAMES - 1].camera;
    return path;
}

/* ---- checks at every frame ---- */

static void count_blocks(flight *f)
{
    stp_inspection look = stp_renderer_inspect(f->renderer);
    for (uint32_t id = 0; id < look.looked.scene->block_count; id++) {
        int finest = stp_block_cache_finest(look.cache, id);
        f->loaded += finest < f->finest[id];
        f->evicted += finest > f->finest[id];
        f->finest[id] = finest;
    }
}

static void watch(flight *f)
{
    uint64_t rss = watch_rss_bytes();
    stp_memory_use use = stp_renderer_memory(f->renderer);
    const uint64_t read = stp_renderer_bytes_read(f->renderer);
    f->gpu_most = use.gpu_used > f->gpu_most ? use.gpu_used : f->gpu_most;
    f->filled_bytes = f->gpu_most + (read < use.cpu_allotted ? read : use.cpu_allotted);
    figures_add(&f->rss, (double)rss - (double)f->filled_bytes);
    f->peak_bytes = rss > f->peak_bytes ? rss : f->peak_bytes;
    if (COUNTS_MEMORY)
        assert_true(rss <= f->baseline_bytes + use.gpu_allotted + use.cpu_allotted + FIXED_BYTES);
    if (f->legs == 0)
        return;
    assert_int_equal(watch_count("/proc/self/fd"), f->descriptors);
    assert_int_equal(watch_count("/proc/self/task"), f->threads);
}

static judge_time draw(flight *f, const stp_view *view, stp_draw_stats *out)
{
    stp_draw_stats stats;
    stp_draw_params params = {.threshold_px = THRESHOLD_PX, .stream = true};
    judge_time time = judge_now();
    check_ok(stp_renderer_draw(f->renderer, view, &params, &stats, err));
    time = judge_since(time);
    f->flown_s += 1e-3 * time.ms;
    f->frames++;
    stp_memory_use use = stp_renderer_memory(f->renderer);
    assert_true(use.gpu_used <= use.gpu_allotted);
    assert_true(use.gpu_allotted <= f->budget_bytes);
    assert_true(use.cpu_allotted <= f->budget_bytes);
    assert_true(stats.load_ms == 0.0);
    assert_string_equal(stp_renderer_damage(f->renderer), "");
    assert_string_equal(stp_renderer_trouble(f->renderer), "");
    count_blocks(f);
    if (f->frames % WATCH_FRAMES == 0)
        watch(f);
    *out = stats;
    return time;
}

/* ---- legs and stops ---- */

static void keep_view(flight *f, const stp_view *view, judge_time time)
{
    if (f->view_count == f->view_capacity) {
        f->view_capacity = f->view_capacity > 0 ? 2 * f->view_capacity : 1024;
        f->views = realloc(f->views, f->view_capacity * sizeof *f->views);
        assert_non_null(f->views);
    }
    f->views[f->view_count++] = (flown_view){*view, time};
}

static stp_view view_of(const flight *f, const stp_camera *camera)
{
    stp_view view;
    check_ok(stp_view_create(&view, camera, &f->model->ball, SIZE, SIZE, err));
    return view;
}

static void fly(flight *f)
{
    stp_path *path = random_path(f);
    double begun = stp_clock_seconds(), now = 0.0;
    stp_draw_stats stats;
    f->view_count = 0;
    for (; now < stp_path_duration_s(path); now = stp_clock_seconds() - begun) {
        stp_camera camera = stp_path_camera(path, now);
        stp_view view = view_of(f, &camera);
        judge_time time = draw(f, &view, &stats);
        f->frames_incomplete += !stats.cut_complete;
        figures_add(&f->ms, time.ms);
        keep_view(f, &view, time);
    }
    stp_path_destroy(&path);
}

/* Rests until the picture is complete, and the next frame shows no more: a first frame at rest may
 * leave out what only the frame before hid. It must then equal the judge's picture, and stay so. */
static void stop(flight *f)
{
    static uint8_t found[4 * SIZE * SIZE], expected[4 * SIZE * SIZE];
    stp_view view = view_of(f, &f->camera);
    stp_draw_stats stats = {.more = true};
    double begun = stp_clock_seconds();
    while (!stats.cut_complete || stats.more) {
        draw(f, &view, &stats);
        assert_true(stp_clock_seconds() - begun < STOP_S);
        if (stats.chunks_loading > 0)
            usleep(1000);
    }
    figures_add(&f->stop_s, stp_clock_seconds() - begun);
    for (int i = 0; i < 2; i++, draw(f, &view, &stats)) {
        check_ok(stp_renderer_read(f->renderer, found, err));
        judge_ask(&f->judge, &(judge_question){JUDGE_PICTURE, view, THRESHOLD_PX}, expected);
        assert_memory_equal(found, expected, sizeof found);
    }
}

/* In every fourth leg, the judge draws some views again once all their blocks are loaded. It draws
 * them twice, to show how well such times repeat. A block that is loaded again for a later view may
 * have lost levels that an earlier one asks for: frames that lack some do not count. */
static void replay(flight *f)
{
    size_t count = f->view_count < REPLAYED ? f->view_count : REPLAYED;
    size_t begin = f->legs % 3 == 0 ? 0 : (size_t)(chance(f) * (double)(f->view_count - count));
    if (f->legs % 4 != 0)
        return;
    for (int round = 0; round < 3; round++)
        for (size_t i = begin; i < begin + count; i++) {
            const judge_task task = round == 0 ? JUDGE_LOAD : JUDGE_FRAME;
            const judge_question question = {task, f->views[i].view, THRESHOLD_PX};
            judge_answer answer = judge_ask(&f->judge, &question, NULL);
            judge_time time = round == 0 ? f->views[i].time : answer.time;
            f->replayed_incomplete += !answer.complete;
            if (!answer.complete)
                continue;
            figures_add(&f->replayed_ms[round], time.ms);
            figures_add(&f->replayed_processor_ms[round], time.processor_ms);
        }
}

/* ---- the flight ---- */

static void take_off(flight *f)
{
    check_ok(stp_model_open(&f->model, f->path, err));
    uint32_t block_count = f->model->first_block[f->model->info->chunk_count];
    f->finest = calloc(block_count, sizeof *f->finest);
    assert_non_null(f->finest);
    for (uint32_t id = 0; id < f->model->info->chunk_count; id++)
        f->finest[id] = STP_NOT_RESIDENT;
    f->baseline_bytes = watch_rss_bytes();
    check_ok(stp_renderer_create(&f->renderer,
                                 &(stp_renderer_params){.model = f->model,
                                                        .gpu_memory_bytes = f->budget_bytes,
                                                        .cpu_memory_bytes = f->budget_bytes},
                                 err));
}

static void land(flight *f)
{
    stp_renderer_destroy(&f->renderer);
    stp_model_close(&f->model);
    for (int i = 0; i < 3; i++) {
        free(f->replayed_ms[i].values);
        free(f->replayed_processor_ms[i].values);
    }
    free(f->ms.values);
    free(f->stop_s.values);
    free(f->rss.values);
    free(f->views);
    free(f->finest);
}

static void print_times(const char *name, const figures *ms)
{
    printf("%-28s %9zu %8.1f %8.1f %8.1f\n", name, ms->count, figures_of(ms, 0.5),
           figures_of(ms, 0.99), figures_of(ms, 1.0));
}

/* Prints the times of the views drawn again, and the ratio of their 99th percentiles to the
 * resident ones. */
static void print_replayed(const char *what, const figures times[3])
{
    static const char *const names[3] = {"streaming", "resident", "resident again"};
    double resident = figures_of(&times[1], 0.99);
    for (int i = 0; i < 3; i++) {
        char name[64];
        snprintf(name, sizeof name, "%s, %s", what, names[i]);
        print_times(name, &times[i]);
    }
    printf("p99 streaming / resident %.2f; resident again / resident %.2f\n",
           figures_of(&times[0], 0.99) / resident, figures_of(&times[2], 0.99) / resident);
}

static void print_summary(const flight *f, const double load[2])
{
    double mib = 1.0 / 1048576.0;
    printf("%-28s %9s %8s %8s %8s\n", "frames, ms", "count", "p50", "p99", "max");
    print_times("in flight", &f->ms);
    print_replayed("clock", f->replayed_ms);
    print_replayed("render thread", f->replayed_processor_ms);
    printf("%llu frames drawn again lacked a level\n", (unsigned long long)f->replayed_incomplete);
    printf("flown %.0f s in %u legs (the judge %.0f s), load %.1f to %.1f, %ld processors, %s\n",
           f->flown_s, f->legs, f->judged_s, load[0], load[1], sysconf(_SC_NPROCESSORS_ONLN),
           (const char *)glGetString(GL_RENDERER));
    printf("stops converge within %.2f s, half of them within %.2f s; %llu frames in flight "
           "incomplete\n",
           figures_of(&f->stop_s, 1.0), figures_of(&f->stop_s, 0.5),
           (unsigned long long)f->frames_incomplete);
    printf("read %.1f MiB, %llu chunks loaded, %llu evicted\n",
           (double)stp_renderer_bytes_read(f->renderer) * mib, (unsigned long long)f->loaded,
           (unsigned long long)f->evicted);
    printf("resident set %.0f MiB before, %.0f MiB at most, budgets %.0f + %.0f MiB; %u "
           "descriptors, %u threads\n",
           (double)f->baseline_bytes * mib, (double)f->peak_bytes * mib,
           (double)f->budget_bytes * mib, (double)f->budget_bytes * mib, f->descriptors,
           f->threads);
}

/* Beside what has filled the budgets so far, the median of the last third must equal that of the
 * first, within GROWTH_BYTES; the first third of the flight does not count. */
static void check_growth(const flight *f)
{
    size_t warm = f->rss.count / 3, third = (f->rss.count - warm) / 3;
    double first = figures_quantile(&f->rss, warm, warm + third, 0.5);
    double last = figures_quantile(&f->rss, f->rss.count - third, f->rss.count, 0.5);
    printf("resident set beside the budgets, after warm-up: median %.1f MiB in the first third, "
           "%.1f in the last\n",
           first / 1048576.0, last / 1048576.0);
    if (COUNTS_MEMORY)
        assert_true(last <= first + (double)GROWTH_BYTES);
}

static void flies(void **state)
{
    flight *f = *state;
    double load[2] = {0.0, 0.0};
    take_off(f);
    getloadavg(&load[0], 1);
    while (f->flown_s < f->seconds) {
        fly(f);
        stop(f);
        f->descriptors = f->legs == 0 ? watch_count("/proc/self/fd") : f->descriptors;
        f->threads = f->legs == 0 ? watch_count("/proc/self/task") : f->threads;
        double begun = stp_clock_seconds();
        replay(f);
        f->judged_s += stp_clock_seconds() - begun;
        f->legs++;
    }
    getloadavg(&load[1], 1);
    print_summary(f, load);
    assert_true(f->replayed_ms[1].count > f->replayed_incomplete);
    check_growth(f);
    land(f);
}

int main(void)
{
    const char *minutes = getenv("STIPPLE_FLIGHT_MINUTES");
    flight f = {.path = getenv("STIPPLE_FLIGHT_MODEL"), .budget_bytes = BUDGET_BYTES};
    f.seconds = 60.0 * (minutes != NULL ? strtod(minutes, NULL) : 30.0);
    if (f.path == NULL) {
        f.path = "flight.stipple";
        f.budget_bytes = STATUE_BYTES;
        model_fixture_build(f.path, &(model_recipe){.shape = GEN_STATUE,
                                                    .point_count = TEST_SIZE(1000000, 250000)});
    }
    f.judge = judge_start(f.path, JUDGE_BYTES);
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {cmocka_unit_test_prestate(flies, &f)};
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    judge_end(&f.judge);
    stp_gl_context_destroy(&context);
    return failed;
}
