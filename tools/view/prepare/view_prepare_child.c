/* Starts stipple prep, reads what it says, and ends it. */
#include "tools/view/prepare/view_prepare_child.h"

#include "base/memory.h"
#include "tools/view/kept/view_files.h"

#include <cjson/cJSON.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

/* Words before the scans: stipple prep --progress json --threads N --attributes LIST --force -o
 * PATH
 * -- */
#define OWN_WORDS 11
/* The child is a little less important than the window. */
#define CHILD_NICE 5
/* A child that does not end within this time is killed. */
#define END_MS 2000
#define POLL_MS 10

static const char sentence[] = "stipple prep: ";

static void clear(view_prepare *p)
{
    for (size_t i = 0; p->arguments && i < p->count; i++)
        free(p->arguments[i]);
    free(p->arguments);
    open_scan_clear(&p->scan);
    *p = (view_prepare){0};
}

static int spawn(view_prepare *p, char *const *words, int output)
{
    posix_spawn_file_actions_t actions;
    int failed = posix_spawn_file_actions_init(&actions);
    if (failed != 0)
        return failed;
    posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, output, 2);
    failed = posix_spawn(&p->process, "/proc/self/exe", &actions, NULL, words, environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failed == 0)
        (void)setpriority(PRIO_PROCESS, (id_t)p->process, CHILD_NICE);
    return failed;
}

/* If the viewer dies, the child ends when it next says something. */
void view_prepare_start(view_prepare *p, uint64_t threads)
{
    char count[24];
    int ends[2] = {-1, -1};
    char **words = NULL;
    snprintf(count, sizeof count, "%llu", (unsigned long long)threads);
    const char *const own[OWN_WORDS] = {
        "stipple",  "prep",         "--progress",
        "json",     "--threads",    count,
        "--force",  "--attributes", p->scan.params.attributes ? p->scan.params.attributes : "none",
        "--output", p->scan.path};
    p->state = VIEW_PREPARE_FAILED;
    p->line_bytes = 0;
    snprintf(p->why, sizeof p->why, "prep could not be started");
    if (stp_alloc(&words, OWN_WORDS + p->count + 2, sizeof *words, "arguments", NULL) != STP_OK ||
        pipe2(ends, O_CLOEXEC) != 0)
        goto done;
    memcpy(words, own, sizeof own);
    words[OWN_WORDS] = (char *)"--";
    memcpy(words + OWN_WORDS + 1, p->arguments, p->count * sizeof *words);
    (void)fcntl(ends[0], F_SETFL, O_NONBLOCK);
    if (spawn(p, words, ends[1]) == 0) {
        p->pipe = ends[0];
        p->state = VIEW_PREPARE_RUNNING;
        p->why[0] = '\0';
        ends[0] = -1;
    }
done:
    for (int i = 0; i < 2; i++)
        if (ends[i] >= 0)
            close(ends[i]);
    free(words);
}

/* A line of the child: progress as JSON, its sentence, or what it says of an input. */
static void take_line(view_prepare *p, const char *line)
{
    const size_t head = sizeof sentence - 1;
    if (line[0] == '{') {
        cJSON *json = cJSON_Parse(line);
        const double spent = cJSON_GetNumberValue(cJSON_GetObjectItem(json, "seconds"));
        const double left = cJSON_GetNumberValue(cJSON_GetObjectItem(json, "seconds_left"));
        if (spent >= 0.0 && left >= 0.0) { /* false for NaN, which stands for null */
            p->left_s = left;
            p->done = spent + left > 0.0 ? spent / (spent + left) : 0.0;
        }
        cJSON_Delete(json);
    } else if (strncmp(line, sentence, head) == 0) {
        snprintf(p->why, sizeof p->why, "%s", line + head);
    } else if (strncmp(line, "not read: ", 10) == 0) {
        fprintf(stderr, "%s\n", line);
    }
}

bool view_prepare_listen(view_prepare *p)
{
    char bytes[4096];
    ssize_t got = 0;
    while ((got = read(p->pipe, bytes, sizeof bytes)) > 0)
        for (ssize_t i = 0; i < got; i++) {
            const bool ends = bytes[i] == '\n';
            if (!ends && p->line_bytes + 1 < sizeof p->line)
                p->line[p->line_bytes++] = bytes[i];
            if (ends) {
                p->line[p->line_bytes] = '\0';
                take_line(p, p->line);
                p->line_bytes = 0;
            }
        }
    return got < 0 && (errno == EAGAIN || errno == EINTR);
}

void view_prepare_reap(view_prepare *p)
{
    while (waitpid(p->process, NULL, 0) < 0 && errno == EINTR)
        ;
    close(p->pipe);
    p->process = 0;
    p->state = VIEW_PREPARE_NONE;
}

bool view_prepare_text(const view_prepare *p, char out[VIEW_PREPARE_LINE])
{
    const char *name = p->arguments ? view_files_base(p->arguments[0]) : "";
    char left[40] = "";
    if (p->left_s >= 60.0)
        snprintf(left, sizeof left, ", %.0f:%02.0f left", floor(p->left_s / 60.0),
                 floor(fmod(p->left_s, 60.0)));
    else if (p->left_s >= 0.0)
        snprintf(left, sizeof left, ", %.0f s left", p->left_s);
    if (p->state == VIEW_PREPARE_FAILED)
        snprintf(out, VIEW_PREPARE_LINE, "coarse picture: %.1100s", p->why);
    else
        snprintf(out, VIEW_PREPARE_LINE, "coarse picture: preparing %.200s, %.0f %%%s", name,
                 floor(100.0 * p->done), left);
    return p->state != VIEW_PREPARE_NONE;
}

void view_prepare_end(view_prepare *p)
{
    const struct timespec pause = {.tv_nsec = POLL_MS * 1000000L};
    if (p->state == VIEW_PREPARE_RUNNING) {
        kill(p->process, SIGTERM);
        for (int ms = 0; ms < END_MS && view_prepare_listen(p); ms += POLL_MS)
            nanosleep(&pause, NULL);
        kill(p->process, SIGKILL);
        view_prepare_reap(p);
        if (!p->scan.folder)
            (void)unlink(p->scan.path);
    }
    clear(p);
}
