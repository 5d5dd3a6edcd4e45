/* Progress on stderr (a bar on a terminal, plain lines elsewhere) and Ctrl-C. */
#include "tools/cli/cli.h"

#include "base/clock.h"

#include <inttypes.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

/* Seconds between two updates of the bar, and between two plain lines. */
#define BAR_INTERVAL_S 0.1
#define LINE_INTERVAL_S 5.0
#define BAR_CELLS 24

typedef struct progress_state {
    pthread_mutex_t mutex; /* guards all members below and the order of writes; the only lock */
    bool terminal;
    bool shown;
    char stage[64];
    uint64_t done;
    double start_s, stage_start_s;
    double printed_s;
    cli_progress_plan plan;
} progress_state;

/* Static, because a process has one terminal and one Ctrl-C, and signal handlers take no context.
 */
static progress_state state = {.mutex = PTHREAD_MUTEX_INITIALIZER};
static atomic_bool interrupted;

static void on_signal(int number)
{
    (void)number;
    atomic_store(&interrupted, true);
}

static bool is_cancelled(void *context)
{
    (void)context;
    return atomic_load(&interrupted);
}

bool cli_interrupted(void)
{
    return atomic_load(&interrupted);
}

/* Formats like "1.25 M". */
static void format_amount(double amount, char *text, size_t size)
{
    static const char *const units[] = {"", " k", " M", " G", " T"};
    size_t unit = 0;
    while (amount >= 999.5 && unit + 1 < sizeof units / sizeof *units) {
        amount /= 1000.0;
        unit++;
    }
    snprintf(text, size, "%.*f%s", amount < 10.0 && unit > 0 ? 2 : 0, amount, units[unit]);
}

static void format_duration(double seconds, char *text, size_t size)
{
    long s = seconds < 359999.0 ? (long)(seconds + 0.5) : 359999;
    if (s < 60)
        snprintf(text, size, "%ld s", s);
    else if (s < 3600)
        snprintf(text, size, "%ld:%02ld", s / 60, s % 60);
    else
        snprintf(text, size, "%ld:%02ld h", s / 3600, s / 60 % 60);
}

/* Seconds left: of the whole run if its stages are known, else of the stage; below 0: unknown. */
static double seconds_left(uint64_t done, uint64_t total, double now_s)
{
    double before = 0.0, sum = 0.0, here = 0.0;
    double part = total > 0 ? (double)done / (double)total : 0.0;
    for (size_t i = 0; i < state.plan.count; i++) {
        if (strcmp(state.plan.stages[i].name, state.stage) == 0) {
            before = sum;
            here = state.plan.stages[i].weight;
        }
        sum += state.plan.stages[i].weight;
    }
    if (here > 0.0) {
        double finished = before + here * part;
        return finished > 0.0 ? (now_s - state.start_s) * (sum - finished) / finished : -1.0;
    }
    return part > 0.0 ? (now_s - state.stage_start_s) * (1.0 - part) / part : -1.0;
}

/* Formats "reading 45 %, 1.25 M/s, 12 s left", without the bar. */
static void format_state(uint64_t done, uint64_t total, double now_s, char *text, size_t size)
{
    double elapsed_s = now_s - state.stage_start_s, left_s = seconds_left(done, total, now_s);
    char amount[32] = "", rate[40] = "", left[48] = "";
    if (total > 0)
        snprintf(amount, sizeof amount, "%3.0f %%", 100.0 * (double)done / (double)total);
    else
        format_amount((double)done, amount, sizeof amount);
    if (elapsed_s >= 0.5 && done > 0) {
        char number[32];
        double per_second = (double)done / elapsed_s;
        format_amount(per_second, number, sizeof number);
        if (per_second < 10.0)
            snprintf(number, sizeof number, "%.2g", per_second);
        snprintf(rate, sizeof rate, ", %s%s/s", number, strchr(number, ' ') ? "" : " ");
    }
    if (elapsed_s >= 0.5 && left_s > 0.0) {
        char number[32];
        format_duration(left_s, number, sizeof number);
        snprintf(left, sizeof left, ", %s left", number);
    }
    snprintf(text, size, "%s%s%s", amount, rate, left);
}

static void draw_bar(const char *text, uint64_t done, uint64_t total)
{
    char line[256], bar[BAR_CELLS + 1] = "";
    struct winsize window = {0};
    int columns =
        ioctl(STDERR_FILENO, TIOCGWINSZ, &window) == 0 && window.ws_col > 0 ? window.ws_col : 80;
    size_t filled = total > 0 ? (size_t)((double)BAR_CELLS * (double)done / (double)total) : 0;
    if (total > 0) {
        memset(bar, '.', BAR_CELLS);
        memset(bar, '#', filled < BAR_CELLS ? filled : BAR_CELLS);
    }
    if (total > 0 && columns >= 80)
        snprintf(line, sizeof line, "%-20s [%s] %s", state.stage, bar, text);
    else
        snprintf(line, sizeof line, "%s %s", state.stage, text);
    fprintf(stderr, "\r%.*s\033[K", columns - 1, line);
    fflush(stderr);
}

static void print_json(uint64_t done, uint64_t total, double now_s)
{
    double left_s = seconds_left(done, total, now_s);
    fprintf(stderr,
            "{\"stage\": \"%s\", \"done\": %" PRIu64 ", \"total\": %" PRIu64
            ", \"seconds\": %.3f, \"seconds_left\": ",
            state.stage, done, total, now_s - state.start_s);
    if (left_s >= 0.0)
        fprintf(stderr, "%.3f}\n", left_s);
    else
        fputs("null}\n", stderr);
}

static void report(void *context, const char *stage, uint64_t done, uint64_t total)
{
    (void)context;
    char text[128];
    double now_s = stp_clock_seconds();
    pthread_mutex_lock(&state.mutex);
    bool begins = strncmp(state.stage, stage, sizeof state.stage - 1) != 0;
    if (begins) {
        snprintf(state.stage, sizeof state.stage, "%s", stage);
        state.stage_start_s = now_s;
        state.done = 0;
    }
    if (done > state.done) /* threads may report out of order */
        state.done = done;
    if (total > 0 && state.done > total)
        state.done = total;
    bool often = state.terminal || state.plan.json;
    if ((begins && state.plan.json) ||
        now_s - state.printed_s >= (often ? BAR_INTERVAL_S : LINE_INTERVAL_S)) {
        state.printed_s = now_s;
        format_state(state.done, total, now_s, text, sizeof text);
        if (state.plan.json)
            print_json(state.done, total, now_s);
        else if (state.terminal)
            draw_bar(text, state.done, total);
        else
            fprintf(stderr, "%s: %s\n", state.stage, text + strspn(text, " "));
        state.shown = state.terminal && !state.plan.json;
    }
    pthread_mutex_unlock(&state.mutex);
}

static void install_handlers(void)
{
    /* A second Ctrl-C ends the program at once, whatever it is doing. */
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND};
    sigemptyset(&action.sa_mask);
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    /* SIGHUP: the terminal was closed. nohup ignores it; then we ignore it, too. */
    struct sigaction before;
    if (sigaction(SIGHUP, NULL, &before) == 0 && before.sa_handler != SIG_IGN)
        sigaction(SIGHUP, &action, NULL);
}

const stp_progress *cli_progress(const cli_common *common)
{
    static const stp_progress shown = {.report = report, .cancelled = is_cancelled};
    static const stp_progress silent = {.cancelled = is_cancelled};
    const char *term = getenv("TERM");
    install_handlers();
    pthread_mutex_lock(&state.mutex);
    state.terminal = isatty(STDERR_FILENO) && term && strcmp(term, "dumb") != 0;
    state.stage[0] = '\0';
    state.plan = (cli_progress_plan){0};
    state.start_s = stp_clock_seconds();
    /* The first plain line comes after a while, so that short runs print none. */
    state.printed_s = state.terminal ? 0.0 : stp_clock_seconds();
    pthread_mutex_unlock(&state.mutex);
    return common->quiet ? &silent : &shown;
}

void cli_progress_expect(const cli_progress_plan *plan)
{
    pthread_mutex_lock(&state.mutex);
    state.plan = *plan;
    pthread_mutex_unlock(&state.mutex);
}

void cli_progress_end(void)
{
    pthread_mutex_lock(&state.mutex);
    if (state.shown)
        fputs("\r\033[K", stderr);
    fflush(stderr);
    state.shown = false;
    pthread_mutex_unlock(&state.mutex);
}
