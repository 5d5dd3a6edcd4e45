/* The program against bad web servers (servers_modes.h): every command that reads a model, as a
 * process of its own.
 *
 * What must hold: the program ends by itself within the patience that --timeout and byte_source.h
 * promise. With 0 its picture is byte for byte that of the local file, and stderr is empty; with
 * --allow-damage it may be another, and one line says so. With 1 stderr is one line of ours and
 * nothing was written. What a bad server left in the cache never makes a later picture wrong. */
#ifndef STP_TESTS_SERVERS_H
#define STP_TESTS_SERVERS_H

#include "tests/chunk_fixture.h"
#include "tests/servers_modes.h"
#include "tests/support/check.h"
#include "tests/support/display.h"

#include "base/clock.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <sys/wait.h>
#include <time.h>

#define SERVER_BRANCHES 3u
/* As --timeout; and what is waited for a program that hangs. */
#define SERVER_TIMEOUT "1"
#define SERVER_TIMEOUT_S 1.0
#define SERVER_HANG_S 90.0
/* How long a viewer is left alone. */
#define SERVER_VIEW_S 6.0
#define SERVER_WORDS 16

typedef enum server_command {
    SERVER_RENDER,
    SERVER_VERIFY,
    SERVER_CACHE,
    SERVER_DAMAGE,
    SERVER_VIEW,
    SERVER_COMMAND_COUNT
} server_command;

static const char *const server_commands[SERVER_COMMAND_COUNT] = {
    "render", "verify", "render --cache", "render --allow-damage", "view"};

typedef struct server_run {
    int code; /* minus the signal that ended it */
    double seconds;
} server_run;

typedef struct server_state {
    fault_server server;
    uint8_t *picture; /* of the local file */
    size_t picture_bytes;
    double well_s; /* a run with a good server */
    bool draws, views;
    unsigned runs, well, failed, coarser, wrong;
} server_state;

static server_state servers;

/* ---- running ---- */

static void server_empty(const char *name)
{
    char command[600];
    snprintf(command, sizeof command, "rm -rf '%s' && mkdir '%s'", fixture_path(name),
             fixture_path(name));
    assert_int_equal(system(command), 0);
}

/* Entries of a folder; *last: the name of one. */
static unsigned server_entries(const char *name, char last[256])
{
    unsigned count = 0;
    DIR *folder = opendir(fixture_path(name));
    assert_non_null(folder);
    for (struct dirent *e = readdir(folder); e != NULL; e = readdir(folder)) {
        if (strcmp(e->d_name, ".") == 0 || strcmp(e->d_name, "..") == 0)
            continue;
        snprintf(last, 256, "%s", e->d_name);
        count++;
    }
    closedir(folder);
    return count;
}

static void server_become(const char *const *words)
{
    const char *program = getenv("STIPPLE");
    int output = open(fixture_path("stdout"), O_CREAT | O_TRUNC | O_WRONLY, 0666);
    int errors = open(fixture_path("stderr"), O_CREAT | O_TRUNC | O_WRONLY, 0666);
    if (dup2(output, 1) < 0 || dup2(errors, 2) < 0 || chdir(fixture_path("out")) != 0)
        _exit(126);
    setenv("XDG_STATE_HOME", fixture_path("state"), 1);
    execv(program, (char *const *)words);
    _exit(127);
}

/* Starts the program with these words in the folder "out". */
static pid_t server_start(server_command command, const char *model)
{
    char seconds[] = SERVER_TIMEOUT;
    const char *words[SERVER_WORDS] = {"stipple", "render", model, "--timeout", seconds};
    unsigned count = 5;
    if (command == SERVER_VERIFY || command == SERVER_VIEW)
        words[1] = server_commands[command];
    if (command == SERVER_VERIFY)
        words[count++] = "-q";
    else
        for (const char *const *w =
                 (const char *const[]){"--size", "64x64", "--threshold", "0", "-q", NULL};
             *w; w++)
            words[count++] = *w;
    if (command != SERVER_VERIFY && command != SERVER_VIEW) {
        words[count++] = "-o";
        words[count++] = "p.png";
    }
    if (command == SERVER_DAMAGE)
        words[count++] = "--allow-damage";
    if (command == SERVER_CACHE) {
        words[count++] = "--cache";
        words[count++] = "../cache";
    }
    fflush(NULL);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0)
        server_become(words);
    return pid;
}

static void server_sleep(double seconds)
{
    const struct timespec pause = {(time_t)seconds, (long)(fmod(seconds, 1.0) * 1e9)};
    nanosleep(&pause, NULL);
}

/* Waits so long at most; true once it has ended. */
static bool server_wait(pid_t pid, double seconds, int *code)
{
    const double until_s = stp_clock_seconds() + seconds;
    int status = 0;
    do {
        pid_t ended = waitpid(pid, &status, WNOHANG);
        assert_true(ended >= 0);
        if (ended == pid) {
            *code = WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
            return true;
        }
        server_sleep(0.01);
    } while (stp_clock_seconds() < until_s);
    return false;
}

static void server_kill(pid_t pid, int *code)
{
    kill(pid, SIGKILL);
    assert_int_equal(waitpid(pid, NULL, 0), pid);
    *code = -SIGKILL;
}

/* What byte_source.h promises: --timeout, and a second for each KiB and each answer. */
static double server_patience_s(void)
{
    return SERVER_TIMEOUT_S + (double)fault_server_bytes(&servers.server) / 1024.0 +
           (double)fault_server_requests(&servers.server) + 3.0 + 4.0 * servers.well_s;
}

/* The viewer has no end of its own once its window is there: it is asked to end when its chunks
 * are there, or after a while. */
static void server_watch(pid_t pid, int *code)
{
    const double begin_s = stp_clock_seconds();
    bool open = false;
    for (double s = 0.0; s < (open ? SERVER_VIEW_S : server_patience_s());
         s = stp_clock_seconds() - begin_s) {
        if (server_wait(pid, 0.2, code))
            return;
        open = display_has_title("ms, ");
        if (open && !display_has_title("missing"))
            break;
    }
    if (open)
        kill(pid, SIGTERM);
    if (!open || !server_wait(pid, SERVER_VIEW_S, code))
        server_kill(pid, code);
}

static server_run server_do(server_command command, const char *model)
{
    server_run run = {0};
    const double begin_s = stp_clock_seconds();
    server_empty("out");
    pid_t pid = server_start(command, model);
    if (command == SERVER_VIEW)
        server_watch(pid, &run.code);
    else if (!server_wait(pid, SERVER_HANG_S, &run.code))
        server_kill(pid, &run.code);
    run.seconds = stp_clock_seconds() - begin_s;
    return run;
}

/* ---- judging ---- */

static char *server_said(const char *name)
{
    size_t size = 0;
    char *text = (char *)fixture_read_file(fixture_path(name), &size);
    text[size] = '\0';
    return text;
}

static bool server_is_one_line(const char *text)
{
    const char *end = strchr(text, '\n');
    return strncmp(text, "stipple ", 8) == 0 && end != NULL && end[1] == '\0';
}

static bool server_picture_is_right(void)
{
    size_t size = 0;
    if (access(fixture_path("out/p.png"), F_OK) != 0)
        return false;
    uint8_t *bytes = fixture_read_file(fixture_path("out/p.png"), &size);
    bool right = size == servers.picture_bytes && memcmp(bytes, servers.picture, size) == 0;
    free(bytes);
    return right;
}

/* What is wrong with a run that ended with 0; NULL: nothing. */
static const char *server_judge_well(server_command command, const char *said, const char **came)
{
    bool picture = command != SERVER_VERIFY && command != SERVER_VIEW;
    bool right = !picture || server_picture_is_right();
    char entry[256] = "";
    *came = right ? "well" : "coarser";
    if (server_entries("out", entry) != picture)
        return "litter, or no picture";
    if (command == SERVER_VIEW) /* it goes on, and may tell of what it could not read */
        return *said == '\0' || strncmp(said, "stipple view: ", 14) == 0 ? NULL : "not our words";
    if (command == SERVER_DAMAGE && !right)
        return server_is_one_line(said) && strstr(said, "warning") ? NULL : "silent damage";
    return !right ? "a wrong picture" : *said != '\0' ? "words though all is well" : NULL;
}

static const char *server_judge(server_command command, server_run run, server_end end,
                                const char **came)
{
    char *said = server_said("stderr"), entry[256] = "";
    const char *wrong = NULL;
    *came = "fails";
    if (run.code == 0)
        wrong = server_judge_well(command, said, came);
    else if (run.code != 1)
        wrong = run.code == -SIGKILL ? "no end" : "neither well nor a sentence";
    else if (!server_is_one_line(said))
        wrong = "not one line of ours";
    else if (server_entries("out", entry) != 0)
        wrong = "a file though it failed";
    bool mended = command == SERVER_VIEW || (command == SERVER_DAMAGE && strcmp(*came, "well"));
    if (wrong == NULL && command != SERVER_VIEW && run.seconds > server_patience_s())
        wrong = "too long";
    if (wrong == NULL && end == SERVER_WELL && run.code != 0)
        wrong = "it should have been mended";
    if (wrong == NULL && end == SERVER_FAILS && run.code == 0 && !mended)
        wrong = "it should have failed";
    if (wrong != NULL)
        print_message("WRONG: %s: code %d: %s", wrong, run.code, *said ? said : "(silent)\n");
    free(said);
    return wrong;
}

/* After a bad server a good one, with what the bad one left in the cache. */
static bool server_cache_is_right(void)
{
    fault_server_order(&servers.server, &(fault_orders){.kind = FAULT_NONE});
    server_run run = server_do(SERVER_CACHE, servers.server.address);
    return run.code == 0 && server_picture_is_right();
}

static void server_try(const server_mode *mode, server_command command)
{
    const char *came = "";
    if (command == SERVER_CACHE)
        server_empty("cache");
    fault_server_order(&servers.server, &mode->orders);
    server_run run = server_do(command, servers.server.address);
    bool wrong = server_judge(command, run, mode->end, &came) != NULL;
    if (command == SERVER_CACHE && !server_cache_is_right()) {
        print_message("WRONG: the picture after the bad server, with its cache\n");
        wrong = true;
    }
    servers.runs++;
    servers.wrong += wrong;
    servers.well += strcmp(came, "well") == 0;
    servers.coarser += strcmp(came, "coarser") == 0;
    servers.failed += strcmp(came, "fails") == 0;
    print_message("%-44s %-22s %-8s %5.1f s\n", mode->name, server_commands[command], came,
                  run.seconds);
}

/* ---- the test ---- */

/* 13 chunks in three depths. */
static void server_write_model(const char *path)
{
    fixture_tree *tree = calloc(1, sizeof *tree);
    uint32_t inner[SERVER_BRANCHES];
    assert_non_null(tree);
    tree->box = stp_dbox_empty();
    for (uint32_t i = 0; i < SERVER_BRANCHES; i++) {
        uint32_t leaf[SERVER_BRANCHES];
        for (uint32_t k = 0; k < SERVER_BRANCHES; k++)
            leaf[k] =
                fixture_add_leaf(tree, 10 * i + k, 3, 20, (stp_dvec3){40.0 * k, 40.0 * i, 0.0});
        inner[i] = fixture_add_parent(tree, leaf, SERVER_BRANCHES);
    }
    fixture_add_parent(tree, inner, SERVER_BRANCHES);
    check_ok(fixture_write(tree, path, STP_CODEC_ZSTD, err));
    fixture_destroy(tree);
    free(tree);
}

/* The picture of the local file, and how long it takes. */
static void server_draw_local(void)
{
    server_run run = server_do(servers.draws ? SERVER_RENDER : SERVER_VERIFY, "../model.stipple");
    assert_int_equal(run.code, 0);
    servers.well_s = run.seconds;
    if (servers.draws)
        servers.picture = fixture_read_file(fixture_path("out/p.png"), &servers.picture_bytes);
}

static int server_set_up(void **state)
{
    char command[5000];
    size_t size = 0;
    (void)state;
    servers = (server_state){0};
    server_write_model(fixture_path("model.stipple"));
    uint8_t *bytes = fixture_read_file(fixture_path("model.stipple"), &size);
    assert_true(fault_server_create(&servers.server, bytes, size));
    free(bytes);
    snprintf(command, sizeof command, "'%s' render --help >/dev/null 2>&1", getenv("STIPPLE"));
    servers.draws = system(command) == 0;
    server_draw_local();
    return 0;
}

static int server_tear_down(void **state)
{
    display_stop();
    fault_server_destroy(&servers.server);
    free(servers.picture);
    return fixture_remove_folder(state);
}

/* Each `step`-th mode, from `first` on, with each command that can be had. */
static void server_run_modes(unsigned first, unsigned step, bool views)
{
    static server_modes modes;
    server_list(&modes);
    servers.views = views && servers.draws && display_start();
    for (unsigned i = first; i < modes.count; i += step)
        for (int c = 0; c < SERVER_COMMAND_COUNT; c++)
            if (c == SERVER_VERIFY || (servers.draws && (c != SERVER_VIEW || servers.views)))
                server_try(&modes.modes[i], (server_command)c);
    print_message("%u modes; %u runs: %u well, %u coarser, %u failed with a sentence; %u wrong\n",
                  modes.count, servers.runs, servers.well, servers.coarser, servers.failed,
                  servers.wrong);
    assert_int_equal(servers.wrong, 0);
}

#endif
