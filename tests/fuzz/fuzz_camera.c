/* Fuzz target for cameras, camera paths and bookmarks: reads any bytes as a JSON file of each of
 * the three kinds. Needs no corpus: an empty input becomes one of the small files below.
 *
 * A failure says why and changes nothing. A camera that was read gives a view or a message. Every
 * camera of a path, at keyframes and between them, gives a view; saved and loaded again, it is the
 * same. */
#include "runtime/camera/path.h"
#include "tests/fuzz/fuzz_memory.h"
#include "tests/fuzz/fuzz_target.h"
#include "tools/view/kept/view_bookmarks.h"

#include "base/vec.h"

#define ENDING ".views.json"

static const char *const seeds[] = {
    "{\"eye\": [1, 2, 3], \"look\": [0, 0, 0], \"up\": [0, 0, 1], \"fovy_deg\": 45}",
    "{\"eye\": [500000.25, 4500000.5, 90], \"look\": [500000, 4500001, 88], \"up\": [0, 0, 1], "
    "\"height\": 12.5, \"size\": [640, 480]}",
    "{\"keyframes\": [{\"time\": 0, \"eye\": [4, 0, 1], \"look\": [0, 0, 0]},\n"
    "{\"time\": 2, \"eye\": [0, 4, 1], \"look\": [0, 0, 0], \"fovy_deg\": 60},\n"
    "{\"time\": 2.5, \"eye\": [-4, 0, 1], \"look\": [0, 0, 0]}]}",
    "{\"keyframes\": [{\"time\": -1, \"eye\": [0, 0, 5], \"look\": [0, 0, 0], \"up\": [0, 1, 0], "
    "\"height\": 3}, {\"time\": 1, \"eye\": [0, 0, -5], \"look\": [0, 0, 0], \"up\": [0, -1, 0], "
    "\"height\": 1}], \"loop\": true, \"loop_seconds\": 9}",
    "{\"turntable\": {\"seconds\": 8, \"degrees\": 360, \"elevation_deg\": 20}}",
    "{\"turntable\": {\"seconds\": 1e-3, \"degrees\": -90}}",
    "{\"views\": [{\"name\": \"a\", \"eye\": [1, 2, 3], \"look\": [0, 0, 0], \"up\": [0, 0, 1]}, "
    "{\"eye\": [3, 2, 1], \"look\": [0, 0, 1], \"up\": [0, 1, 0], \"fovy_deg\": 10}]}",
    "{\"views\": []}",
};

static const char *const words[] = {
    "\"eye\": [0, 0, 0]",
    "\"look\": [1, 1, 1]",
    "\"up\": [0, 0, 1]",
    "\"up\": [1, 0, 0]",
    "\"fovy_deg\": 179.9",
    "\"height\": 1e20",
    "\"size\": [1, 16384]",
    "\"time\": 1e308",
    "\"time\": 3",
    "\"loop\": true",
    "\"loop_seconds\": 1e-300",
    "\"degrees\": 1e300",
    "\"elevation_deg\": 89",
    "\"seconds\": 1e-320",
    "\"name\": \"\\u00e9\\ud83d\\ude00\\u0000\"",
    ", {\"time\": 4, \"eye\": [0, 4, 1], \"look\": [0, 0, 0]}",
    "{",
    "}",
    "[",
    "]",
    ",",
    ":",
    "null",
    "true",
    "nan",
    "-0",
    "1e17",
    "1e-17",
    "-1e17",
    "1e308",
    "4.9e-324",
    "1.7976931348623157e308",
    "0.1",
    "500000",
};

size_t LLVMFuzzerCustomMutator(uint8_t *data, size_t size, size_t capacity, unsigned seed)
{
    const fuzz_words all = {seeds, sizeof seeds / sizeof *seeds, words,
                            sizeof words / sizeof *words};
    return fuzz_mutate_words(data, size, capacity, seed, &all);
}

/* ---- files ---- */

static char folder[] = "fuzz-camera-XXXXXX";

static const char *path_of(const char *name)
{
    static char path[2][128];
    static int turn;
    turn = !turn;
    snprintf(path[turn], sizeof path[turn], "%s/%s", folder, name);
    return path[turn];
}

static void remove_folder(void)
{
    unlink(path_of("model" ENDING));
    unlink(path_of("saved.json"));
    rmdir(folder);
}

/* Makes a folder and works in it, with a file in memory in place of a model's bookmarks. Returns
 * the file's descriptor. */
static int make_folder(void)
{
    static int descriptor = -1;
    char target[64];
    if (descriptor >= 0)
        return descriptor;
    descriptor = fuzz_memory_file(NULL, 0, target);
    fuzz_require(mkdtemp(folder) != NULL && atexit(remove_folder) == 0, "a folder");
    fuzz_require(symlink(target, path_of("model" ENDING)) == 0, "a link");
    /* keeps the user's own bookmarks out */
    fuzz_require(setenv("XDG_STATE_HOME", "/nowhere", 1) == 0, "no folder of states");
    return descriptor;
}

/* ---- what must hold ---- */

static void require_reason(stp_status status, const stp_error *err)
{
    if (status != STP_OK)
        fuzz_require(err->status == status && err->message[0] != '\0', "a failure says why");
}

static void require_unit(stp_dvec3 axis)
{
    fuzz_require(fabs(stp_dvec3_length(axis) - 1.0) < 1e-9, "a view's axes are unit vectors");
}

/* Whether a camera gives a view of a square picture; the view must be finite. */
static bool gives_view(const stp_camera *camera, int size_px)
{
    stp_view view;
    stp_error err = {0};
    const stp_ball ball = {{1.0, 2.0, 3.0}, 10.0};
    const stp_status status = stp_view_create(&view, camera, &ball, size_px, size_px, &err);
    require_reason(status, &err);
    if (status != STP_OK)
        return false;
    require_unit(view.right);
    require_unit(view.up);
    require_unit(view.back);
    fuzz_require(isfinite(view.f) && view.f > 0.0, "a view has a focal length");
    fuzz_require(view.ball_near < view.ball_far, "a ball has a depth");
    const stp_view part = stp_view_part(&view, 3, 5, 7, 9);
    const stp_dvec3 at = stp_view_project(&part, ball.centre);
    fuzz_require(at.z <= view.near_depth || (isfinite(at.x) && isfinite(at.y)),
                 "a place that is drawn has a pixel");
    return true;
}

static void read_camera(const char *file, const stp_camera *base)
{
    stp_error err = {0};
    stp_camera camera = *base;
    const stp_status status = stp_camera_load(&camera, file, &err);
    require_reason(status, &err);
    if (status != STP_OK) {
        fuzz_require(stp_camera_equal(&camera, base), "a failure changes nothing");
        return;
    }
    fuzz_require(stp_dvec3_finite(camera.eye) && stp_dvec3_finite(camera.look) &&
                     stp_dvec3_finite(camera.up) && isfinite(camera.fovy_deg) &&
                     isfinite(camera.height),
                 "a camera is made of numbers");
    fuzz_require(camera.size[0] >= 0 && camera.size[1] <= 16384, "a picture's size is in range");
    if (gives_view(&camera, 48)) {
        const stp_camera wider = stp_camera_widened(&camera, 2.0, 64, 48);
        fuzz_require(wider.fovy_deg >= camera.fovy_deg || wider.height > 0.0, "a wider view");
    }
}

/* Saves three cameras of a path as keyframes; loading must give the same cameras. */
static void save_and_load(const stp_path *path, const stp_camera *base)
{
    stp_path *again = NULL;
    stp_keyframe keys[3];
    const double begin = stp_path_begin_s(path), span = stp_path_duration_s(path);
    for (int i = 0; i < 3; i++)
        keys[i] = (stp_keyframe){i, stp_path_camera(path, begin + span * 0.5 * i)};
    const stp_path_params params = {.keyframes = keys, .count = 3};
    const char *file = path_of("saved.json");
    fuzz_require(stp_path_save(&params, file, true, NULL) == STP_OK, "a path is saved");
    fuzz_require(stp_path_load(&again, file, base, NULL) == STP_OK, "a saved path is read");
    for (int i = 0; i < 3; i++) {
        const stp_camera camera = stp_path_camera(again, i);
        fuzz_require(stp_camera_equal(&camera, &keys[i].camera), "a camera comes back as it was");
    }
    stp_path_destroy(&again);
}

static void read_path(const char *file, const stp_camera *base, bool save)
{
    stp_error err = {0};
    stp_path *path = NULL;
    uint64_t count = 0;
    const stp_status status = stp_path_load(&path, file, base, &err);
    require_reason(status, &err);
    fuzz_require((status == STP_OK) == (path != NULL), "a path exactly where reading succeeds");
    if (status != STP_OK)
        return;
    const double begin = stp_path_begin_s(path), span = stp_path_duration_s(path);
    fuzz_require(span >= 0.0, "a path has a duration");
    for (int i = -3; i <= 35; i++) {
        const stp_camera camera = stp_path_camera(path, begin + span * i / 32.0);
        fuzz_require(gives_view(&camera, 1), "a camera between valid ones is valid");
    }
    if (stp_path_frame_count(path, 25.0, &count, &err) == STP_OK) {
        fuzz_require(count >= 1 && count <= STP_PATH_FRAMES_LIMIT, "a film has frames");
        for (uint64_t i = 0; i < 5; i++) {
            const stp_camera camera = stp_path_frame(path, 25.0, count, (count - 1) * i / 4);
            fuzz_require(gives_view(&camera, 1), "a frame has a view");
        }
    }
    if (save)
        save_and_load(path, base);
    stp_path_destroy(&path);
}

static void read_views(const char *model)
{
    static view_bookmarks views;
    stp_error err = {0};
    const stp_status status = view_bookmarks_load(&views, model, &err);
    require_reason(status, &err);
    fuzz_require(status == STP_OK || views.count == 0, "a failure leaves no views");
    for (size_t i = 0; i < views.count; i++)
        fuzz_require(gives_view(&views.items[i].camera, 1), "a kept view is a view");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const stp_camera base = {
        .eye = {5.0, 1.0, 2.0}, .up = {0.0, 0.0, 1.0}, .fovy_deg = STP_CAMERA_FOVY_DEG};
    const int descriptor = make_folder();
    fuzz_require(ftruncate(descriptor, 0) == 0 &&
                     pwrite(descriptor, data, size, 0) == (ssize_t)size,
                 "memory");
    const char *file = path_of("model" ENDING);
    read_camera(file, &base);
    read_path(file, &base, size % 16 == 0);
    read_views(path_of("model"));
    return 0;
}
