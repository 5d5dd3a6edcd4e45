/* The window, by GLFW. */
#include "runtime/window/window.h"

#include "base/memory.h"
#include "runtime/gl/gl_context.h"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <stdlib.h>
#include <string.h>

/* The share of the screen's free area that the window takes, and the share that it may take. */
#define USUAL_SHARE 0.75
#define FIT_SHARE 0.9
/* Where the screen's area is not known. */
#define USUAL_WIDTH 1024
#define USUAL_HEIGHT 768
#define FIT_LEAST 64

struct stp_window {
    GLFWwindow *handle;
    stp_window_event events[STP_WINDOW_EVENTS_LIMIT];
    size_t event_count, event_next;
    double cursor[2]; /* screen coordinates, y down */
    char *dropped[STP_WINDOW_DROP_LIMIT];
    size_t dropped_count;
    int place[4]; /* x, y, width, height before filling the screen */
};

static void forget_dropped(stp_window *w)
{
    for (size_t i = 0; i < w->dropped_count; i++)
        free(w->dropped[i]);
    w->dropped_count = 0;
}

static void add_event(GLFWwindow *handle, stp_window_event event)
{
    stp_window *w = glfwGetWindowUserPointer(handle);
    bool queued = w->event_count > w->event_next;
    stp_window_event *last = queued ? &w->events[w->event_count - 1] : NULL;
    event.at_s = glfwGetTime();
    if (event.kind == STP_WINDOW_MOVE && last != NULL && last->kind == STP_WINDOW_MOVE)
        *last = event;
    else if (w->event_count < STP_WINDOW_EVENTS_LIMIT)
        w->events[w->event_count++] = event;
}

/* Screen coordinates, y down, to pixels of the framebuffer, y up. */
static void place(GLFWwindow *handle, double x, double y, stp_window_event *event)
{
    int size[2] = {0, 0}, pixels[2] = {0, 0};
    glfwGetWindowSize(handle, &size[0], &size[1]);
    glfwGetFramebufferSize(handle, &pixels[0], &pixels[1]);
    if (size[0] < 1 || size[1] < 1)
        return;
    event->x = x * pixels[0] / size[0];
    event->y = pixels[1] - y * pixels[1] / size[1];
}

/* Sets the cursor's place at the event; GLFW would report its place now. */
static void place_at_cursor(GLFWwindow *handle, stp_window_event *event)
{
    const stp_window *w = glfwGetWindowUserPointer(handle);
    place(handle, w->cursor[0], w->cursor[1], event);
}

static void on_character(GLFWwindow *handle, unsigned character)
{
    add_event(handle, (stp_window_event){.kind = STP_WINDOW_CHARACTER, .character = character});
}

static int key_of(int key)
{
    static const struct {
        int glfw, key;
    } keys[] = {
        {GLFW_KEY_SPACE, STP_KEY_SPACE},
        {GLFW_KEY_ESCAPE, STP_KEY_ESCAPE},
        {GLFW_KEY_ENTER, STP_KEY_ENTER},
        {GLFW_KEY_KP_ENTER, STP_KEY_ENTER},
        {GLFW_KEY_TAB, STP_KEY_TAB},
        {GLFW_KEY_BACKSPACE, STP_KEY_BACKSPACE},
        {GLFW_KEY_DELETE, STP_KEY_DELETE},
        {GLFW_KEY_LEFT, STP_KEY_LEFT},
        {GLFW_KEY_RIGHT, STP_KEY_RIGHT},
        {GLFW_KEY_UP, STP_KEY_UP},
        {GLFW_KEY_DOWN, STP_KEY_DOWN},
        {GLFW_KEY_PAGE_UP, STP_KEY_PAGE_UP},
        {GLFW_KEY_PAGE_DOWN, STP_KEY_PAGE_DOWN},
        {GLFW_KEY_HOME, STP_KEY_HOME},
        {GLFW_KEY_END, STP_KEY_END},
        {GLFW_KEY_LEFT_SHIFT, STP_KEY_SHIFT},
        {GLFW_KEY_RIGHT_SHIFT, STP_KEY_SHIFT},
        {GLFW_KEY_F1, STP_KEY_F1},
        {GLFW_KEY_F11, STP_KEY_F11},
    };
    if ((key >= 'A' && key <= 'Z') || (key >= '0' && key <= '9')) /* the same in GLFW */
        return key;
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        if (keys[i].glfw == key)
            return keys[i].key;
    return STP_KEY_NONE;
}

static void on_key(GLFWwindow *handle, int key, int scancode, int action, int modifiers)
{
    (void)scancode;
    stp_window_event event = {.kind = STP_WINDOW_KEY,
                              .key = key_of(key),
                              .down = action != GLFW_RELEASE,
                              .repeated = action == GLFW_REPEAT,
                              .shift = (modifiers & GLFW_MOD_SHIFT) != 0,
                              .control = (modifiers & GLFW_MOD_CONTROL) != 0};
    if (event.key != STP_KEY_NONE)
        add_event(handle, event);
}

static void on_button(GLFWwindow *handle, int button, int action, int modifiers)
{
    stp_window_event event = {.kind = action == GLFW_PRESS ? STP_WINDOW_PRESS : STP_WINDOW_RELEASE,
                              .button = button,
                              .shift = (modifiers & GLFW_MOD_SHIFT) != 0,
                              .control = (modifiers & GLFW_MOD_CONTROL) != 0};
    place_at_cursor(handle, &event);
    add_event(handle, event);
}

static void on_move(GLFWwindow *handle, double x, double y)
{
    stp_window *w = glfwGetWindowUserPointer(handle);
    stp_window_event event = {.kind = STP_WINDOW_MOVE};
    w->cursor[0] = x;
    w->cursor[1] = y;
    place(handle, x, y, &event);
    add_event(handle, event);
}

static void on_wheel(GLFWwindow *handle, double x, double y)
{
    (void)x;
    stp_window_event event = {.kind = STP_WINDOW_WHEEL, .wheel = y};
    place_at_cursor(handle, &event);
    add_event(handle, event);
}

static void on_refresh(GLFWwindow *handle)
{
    add_event(handle, (stp_window_event){.kind = STP_WINDOW_REFRESH});
}

static void on_resize(GLFWwindow *handle, int width, int height)
{
    (void)width;
    (void)height;
    on_refresh(handle);
}

static void on_scale(GLFWwindow *handle, float x, float y)
{
    (void)x;
    (void)y;
    on_refresh(handle);
}

static void on_focus(GLFWwindow *handle, int focused)
{
    if (!focused)
        add_event(handle, (stp_window_event){.kind = STP_WINDOW_BLUR});
}

static void on_drop(GLFWwindow *handle, int count, const char **paths)
{
    stp_window *w = glfwGetWindowUserPointer(handle);
    forget_dropped(w);
    for (int i = 0; i < count && w->dropped_count < STP_WINDOW_DROP_LIMIT; i++) {
        char *path = strdup(paths[i]);
        if (path != NULL)
            w->dropped[w->dropped_count++] = path;
    }
    add_event(handle, (stp_window_event){.kind = STP_WINDOW_DROP});
}

static void on_close(GLFWwindow *handle)
{
    add_event(handle, (stp_window_event){.kind = STP_WINDOW_CLOSE});
}

/* GLFW's own message about its last failure. */
static const char *reason(int *code)
{
    const char *text = NULL;
    *code = glfwGetError(&text);
    return text != NULL ? text : "no reason given";
}

static stp_status fail_to_open(stp_error *err)
{
    int code = GLFW_NO_ERROR;
    const char *text = reason(&code);
    if (code == GLFW_VERSION_UNAVAILABLE || code == GLFW_API_UNAVAILABLE)
        return stp_error_set(
            err, STP_GL,
            "this display has no OpenGL 4.5 (%s): install a newer driver, or make "
            "pictures without a display by stipple render, and films by stipple fly",
            text);
    return stp_error_set(err, STP_GL,
                         "no window can be opened (%s): make pictures without a display by stipple "
                         "render, and films by stipple fly",
                         text);
}

static void fit_to_screen(int *width, int *height)
{
    int x = 0, y = 0, area[2] = {0, 0};
    GLFWmonitor *monitor = glfwGetPrimaryMonitor();
    if (monitor != NULL)
        glfwGetMonitorWorkarea(monitor, &x, &y, &area[0], &area[1]);
    bool known = FIT_SHARE * area[0] >= FIT_LEAST && FIT_SHARE * area[1] >= FIT_LEAST;
    if (*width == 0 || *height == 0) {
        *width = known ? (int)(USUAL_SHARE * area[0]) : USUAL_WIDTH;
        *height = known ? (int)(USUAL_SHARE * area[1]) : USUAL_HEIGHT;
    } else if (known) {
        *width = *width < FIT_SHARE * area[0] ? *width : (int)(FIT_SHARE * area[0]);
        *height = *height < FIT_SHARE * area[1] ? *height : (int)(FIT_SHARE * area[1]);
    }
}

static GLFWwindow *open_window(const char *title, int width, int height)
{
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    return glfwCreateWindow(width, height, title, NULL, NULL);
}

static void set_callbacks(GLFWwindow *handle)
{
    glfwSetCharCallback(handle, on_character);
    glfwSetKeyCallback(handle, on_key);
    glfwSetMouseButtonCallback(handle, on_button);
    glfwSetCursorPosCallback(handle, on_move);
    glfwSetScrollCallback(handle, on_wheel);
    glfwSetFramebufferSizeCallback(handle, on_resize);
    glfwSetWindowContentScaleCallback(handle, on_scale);
    glfwSetWindowFocusCallback(handle, on_focus);
    glfwSetDropCallback(handle, on_drop);
    glfwSetWindowRefreshCallback(handle, on_refresh);
    glfwSetWindowCloseCallback(handle, on_close);
}

stp_status stp_window_create(stp_window **out, const char *title, int width, int height, bool fit,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_window *w = NULL;
    STP_TRY(stp_alloc(&w, 1, sizeof *w, "a window", err));
    if (glfwInit()) {
        if (fit)
            fit_to_screen(&width, &height);
        w->handle = open_window(title, width, height);
    }
    if (w->handle == NULL) {
        status = fail_to_open(err);
        goto done;
    }
    glfwSetWindowUserPointer(w->handle, w);
    glfwMakeContextCurrent(w->handle);
    STP_TRY(stp_gl_context_check(err));
    glfwSwapInterval(1);
    set_callbacks(w->handle);
    *out = w;
    w = NULL;
done:
    stp_window_destroy(&w);
    return status;
}

void stp_window_destroy(stp_window **window)
{
    if (*window == NULL)
        return;
    if ((*window)->handle != NULL)
        glfwDestroyWindow((*window)->handle);
    forget_dropped(*window);
    free(*window);
    *window = NULL;
    glfwTerminate();
}

void stp_window_wait(stp_window *w, double seconds)
{
    size_t left = w->event_count - w->event_next;
    memmove(w->events, w->events + w->event_next, left * sizeof *w->events);
    w->event_count = left;
    w->event_next = 0;
    if (seconds > 0.0 && left == 0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
}

void stp_window_wake(void)
{
    glfwPostEmptyEvent();
}

bool stp_window_next(stp_window *w, stp_window_event *out)
{
    if (w->event_next == w->event_count)
        return false;
    *out = w->events[w->event_next++];
    return true;
}

const char *stp_window_dropped(const stp_window *w, size_t index)
{
    return index < w->dropped_count ? w->dropped[index] : NULL;
}

void stp_window_size(const stp_window *w, int *width, int *height)
{
    glfwGetFramebufferSize(w->handle, width, height);
    if (glfwGetWindowAttrib(w->handle, GLFW_ICONIFIED))
        *width = *height = 0;
}

double stp_window_seconds(const stp_window *w)
{
    (void)w; /* GLFW has one clock, started when GLFW was initialised */
    return glfwGetTime();
}

double stp_window_scale(const stp_window *w)
{
    float x = 1.0f, y = 1.0f;
    glfwGetWindowContentScale(w->handle, &x, &y);
    return x > 0.0f ? (double)x : 1.0;
}

bool stp_window_is_full_screen(const stp_window *w)
{
    return glfwGetWindowMonitor(w->handle) != NULL;
}

/* The monitor that shows most of the window. */
static GLFWmonitor *monitor_of(const stp_window *w)
{
    int count = 0, x = 0, y = 0, size[2] = {0, 0};
    GLFWmonitor **monitors = glfwGetMonitors(&count), *best = NULL;
    long most = -1;
    glfwGetWindowPos(w->handle, &x, &y);
    glfwGetWindowSize(w->handle, &size[0], &size[1]);
    for (int i = 0; i < count; i++) {
        int at[2] = {0, 0};
        const GLFWvidmode *mode = glfwGetVideoMode(monitors[i]);
        glfwGetMonitorPos(monitors[i], &at[0], &at[1]);
        if (mode == NULL)
            continue;
        int right = x + size[0] < at[0] + mode->width ? x + size[0] : at[0] + mode->width;
        int below = y + size[1] < at[1] + mode->height ? y + size[1] : at[1] + mode->height;
        int left = x > at[0] ? x : at[0], above = y > at[1] ? y : at[1];
        long area = right > left && below > above ? (long)(right - left) * (below - above) : 0;
        best = area > most ? monitors[i] : best;
        most = area > most ? area : most;
    }
    return best;
}

void stp_window_set_full_screen(stp_window *w, bool full)
{
    GLFWmonitor *monitor = full ? monitor_of(w) : NULL;
    const GLFWvidmode *mode = monitor != NULL ? glfwGetVideoMode(monitor) : NULL;
    if (full == stp_window_is_full_screen(w) || (full && mode == NULL))
        return;
    if (full) {
        glfwGetWindowPos(w->handle, &w->place[0], &w->place[1]);
        glfwGetWindowSize(w->handle, &w->place[2], &w->place[3]);
        glfwSetWindowMonitor(w->handle, monitor, 0, 0, mode->width, mode->height,
                             mode->refreshRate);
    } else {
        glfwSetWindowMonitor(w->handle, NULL, w->place[0], w->place[1], w->place[2], w->place[3],
                             GLFW_DONT_CARE);
    }
    glfwSwapInterval(1);
}

void stp_window_copy_text(stp_window *w, const char *text)
{
    glfwSetClipboardString(w->handle, text);
}

const char *stp_window_pasted_text(stp_window *w)
{
    const char *text = glfwGetClipboardString(w->handle);
    return text != NULL ? text : "";
}

void stp_window_set_title(stp_window *w, const char *title)
{
    glfwSetWindowTitle(w->handle, title);
}

void stp_window_present(stp_window *w)
{
    glfwSwapBuffers(w->handle);
}
