/* Every call fails once: runs commands with inject_shim.cpp preloaded, the n-th call of each name
 * failing, n = 1, 2, ... as often as the command makes that call.
 *
 * What must hold: the command ends by itself with 0 or 1. With 0 all is as if nothing had failed.
 * With 1 every line on stderr is ours, no file of a final name differs from the right one, what
 * was read is as it was, and after a run that nothing disturbs there is no litter. */
#ifndef STP_TESTS_INJECTION_H
#define STP_TESTS_INJECTION_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/support/display.h"
#include "tests/support/fault_server.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define INJECT_ARGUMENTS 16
#define INJECT_FILES 64
#define INJECT_NAMES 80
/* Stands for the address of in/a.stipple on a web server. */
#define INJECT_ADDRESS "@"
/* No command here takes a second. */
#define INJECT_PATIENCE_S 120

/* A program's arguments; inputs lie in in/, what it writes goes to out/,
 * and what it keeps of a server's file to cache/. */
typedef struct injected {
    const char *arguments[INJECT_ARGUMENTS];
    bool draws;     /* needs the renderer */
    bool views;     /* needs a display; ends once it is at rest */
    bool slow;      /* only where all points are tried */
    bool varies;    /* what it writes tells of times: not compared */
    unsigned every; /* where all points are tried, each so many-th; 0: all */
} injected;

/* The files of a folder and its sub-folders by name, and what is in them. */
typedef struct inject_folder {
    unsigned count;
    char names[INJECT_FILES][96];
    char *bytes[INJECT_FILES];
    size_t sizes[INJECT_FILES];
} inject_folder;

typedef struct inject_state {
    const injected *command;
    fault_server server;
    char program[4096], shim[4096];
    char *output; /* of a run that nothing disturbs, */
    inject_folder in, out;
    unsigned names, tried, wrong;
    char name[INJECT_NAMES][32]; /* and its calls */
    unsigned count[INJECT_NAMES];
} inject_state;

static char *inject_read(const char *path, size_t *size)
{
    FILE *f = fopen(path, "rb");
    char *bytes = NULL;
    *size = 0;
    if (!f)
        return calloc(1, 1);
    for (size_t got = 1; got > 0; *size += got) {
        bytes = realloc(bytes, *size + 65537);
        assert_non_null(bytes);
        got = fread(bytes + *size, 1, 65536, f);
    }
    bytes[*size] = '\0';
    fclose(f);
    return bytes;
}

static void inject_list_below(inject_folder *to, const char *path, const char *below)
{
    DIR *folder = opendir(path);
    assert_non_null(folder);
    for (struct dirent *e = readdir(folder); e; e = readdir(folder)) {
        char inner[512], name[400];
        struct stat about;
        if (strcmp(e->d_name, ".") == 0 || strcmp(e->d_name, "..") == 0)
            continue;
        snprintf(inner, sizeof inner, "%s/%s", path, e->d_name);
        snprintf(name, sizeof name, "%s%s", below, e->d_name);
        assert_int_equal(lstat(inner, &about), 0);
        if (S_ISDIR(about.st_mode))
            strcat(name, "/");
        assert_true(to->count < INJECT_FILES && strlen(name) < sizeof to->names[0]);
        strcpy(to->names[to->count], name);
        to->bytes[to->count] = inject_read(inner, &to->sizes[to->count]);
        to->count++;
        if (S_ISDIR(about.st_mode))
            inject_list_below(to, inner, name);
    }
    closedir(folder);
}

static inject_folder inject_list(const char *path)
{
    inject_folder folder = {.count = 0};
    inject_list_below(&folder, path, "");
    return folder;
}

/* What a command writes into out/. */
static inject_folder inject_written(const injected *command)
{
    inject_folder out = inject_list("out");
    for (unsigned i = 0; command->varies && i < out.count; i++)
        out.sizes[i] = 0;
    return out;
}

static void inject_forget(inject_folder *folder)
{
    for (unsigned i = 0; i < folder->count; i++)
        free(folder->bytes[i]);
    folder->count = 0;
}

static void inject_empty(const char *path)
{
    char command[512];
    snprintf(command, sizeof command, "rm -rf '%s' && mkdir '%s'", path, path);
    assert_int_equal(system(command), 0);
}

/* What a run wrote, the cache of a server's file included. */
static void inject_clear(void)
{
    inject_empty("out");
    inject_empty("cache");
}

/* Becomes the program, with the shim where it has a use. */
static void inject_become(const inject_state *s, const char *failing, const char *counts)
{
    char *arguments[INJECT_ARGUMENTS + 2] = {(char *)s->program};
    for (int i = 0; i < INJECT_ARGUMENTS && s->command->arguments[i]; i++)
        arguments[i + 1] = strcmp(s->command->arguments[i], INJECT_ADDRESS) == 0
                               ? (char *)s->server.address
                               : (char *)s->command->arguments[i];
    int output = open("stdout", O_CREAT | O_TRUNC | O_WRONLY, 0666);
    int errors = open("stderr", O_CREAT | O_TRUNC | O_WRONLY, 0666);
    dup2(output, 1);
    dup2(errors, 2);
    if (counts)
        setenv("STIPPLE_INJECT_COUNTS", counts, 1);
    if (failing)
        setenv("STIPPLE_INJECT", failing, 1);
    if (s->command->views)
        setenv("STIPPLE_INJECT_REST", "1", 1);
    if (failing || counts || s->command->views)
        setenv("LD_PRELOAD", s->shim, 1);
    alarm(INJECT_PATIENCE_S);
    execv(s->program, arguments);
    _exit(127);
}

/* Runs the command; `failing` is for the shim, NULL for a run without it. Its exit code, or minus
 * the signal that ended it. */
static int inject_run(const inject_state *s, const char *failing, const char *counts)
{
    int status = 0;
    fflush(NULL);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0)
        inject_become(s, failing, counts);
    assert_int_equal(waitpid(pid, &status, 0), pid);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
}

static int inject_find(const inject_folder *folder, const char *name)
{
    for (unsigned i = 0; i < folder->count; i++)
        if (strcmp(folder->names[i], name) == 0)
            return (int)i;
    return -1;
}

/* What of `now` is not as in `right`, of files that both have; NULL: nothing. */
static const char *inject_changed(const inject_folder *now, const inject_folder *right)
{
    for (unsigned i = 0; i < now->count; i++) {
        int at = inject_find(right, now->names[i]);
        if (at >= 0 && (now->sizes[i] != right->sizes[at] ||
                        memcmp(now->bytes[i], right->bytes[at], now->sizes[i]) != 0))
            return now->names[i];
    }
    return NULL;
}

/* Likewise, or what `now` lacks. */
static const char *inject_lacks(const inject_folder *now, const inject_folder *right)
{
    for (unsigned i = 0; i < right->count; i++)
        if (inject_find(now, right->names[i]) < 0)
            return right->names[i];
    return inject_changed(now, right);
}

/* Likewise, or what is in `now` alone. */
static const char *inject_differs(const inject_folder *now, const inject_folder *right)
{
    for (unsigned i = 0; i < now->count; i++)
        if (inject_find(right, now->names[i]) < 0)
            return now->names[i];
    return inject_lacks(now, right);
}

/* Whether all that a program says is its own: lines that begin with its name. */
static bool inject_is_ours(const char *text)
{
    for (const char *line = text; *line; line = strchr(line, '\n') + 1)
        if (strncmp(line, "stipple", 7) != 0 || !strchr(line, '\n'))
            return false;
    return *text != '\0';
}

static void inject_say(inject_state *s, const char *failing, int code, const char *what,
                       const char *detail)
{
    s->wrong++;
    print_message("WRONG:");
    for (int i = 0; i < INJECT_ARGUMENTS && s->command->arguments[i]; i++)
        print_message(" %s", s->command->arguments[i]);
    print_message(" [%s] ends with %d: %s %s\n", failing, code, what, detail);
}

/* Removes what has these names; what is in a folder comes after it. */
static void inject_remove(const inject_folder *folder)
{
    for (unsigned i = folder->count; i-- > 0;) {
        char path[128];
        snprintf(path, sizeof path, "out/%s", folder->names[i]);
        (void)remove(path);
    }
}

static void inject_check(inject_state *s, const char *failing)
{
    int code = inject_run(s, failing, NULL);
    size_t size;
    char *said = inject_read("stderr", &size), *output = inject_read("stdout", &size);
    inject_folder out = inject_written(s->command), in = inject_list("in");
    const char *differs = inject_differs(&in, &s->in);
    s->tried++;
    if (differs)
        inject_say(s, failing, code, "an input changed:", differs);
    if (code != 0 && code != 1)
        inject_say(s, failing, code, "neither well nor with a sentence:", said);
    else if (code == 0 && !s->command->varies && strcmp(output, s->output) != 0)
        inject_say(s, failing, code, "other words on stdout", "");
    else if (code == 0 && (differs = inject_lacks(&out, &s->out)))
        inject_say(s, failing, code, "as if well, but not the same:", differs);
    else if (code == 1 && !inject_is_ours(said))
        inject_say(s, failing, code, "not our words:", said);
    else if (code == 1 && (differs = inject_changed(&out, &s->out)))
        inject_say(s, failing, code, "a wrong file:", differs);
    bool litter = inject_differs(&out, &s->out) != NULL;
    inject_forget(&out);
    if (litter) { /* has only until the next run */
        inject_remove(&s->out);
        int again = inject_run(s, NULL, NULL);
        out = inject_written(s->command);
        if (again != 0 || (differs = inject_differs(&out, &s->out)))
            inject_say(s, failing, again, "after the next run:", differs ? differs : "");
        inject_forget(&out);
    }
    inject_clear();
    inject_forget(&in);
    free(said);
    free(output);
}

static void inject_learn(inject_state *s, const injected *command)
{
    size_t size;
    s->command = command;
    s->names = 0;
    s->in = inject_list("in");
    inject_clear();
    assert_int_equal(inject_run(s, NULL, "counts"), 0);
    s->output = inject_read("stdout", &size);
    s->out = inject_written(command);
    inject_clear();
    FILE *f = fopen("counts", "r");
    assert_non_null(f);
    while (s->names < INJECT_NAMES &&
           fscanf(f, "%31s %u", s->name[s->names], &s->count[s->names]) == 2)
        s->names++;
    fclose(f);
}

static bool inject_is(const char *name, const char *list)
{
    const char *at = strstr(list, name);
    return at && (at == list || at[-1] == ' ') && strchr(" ", at[strlen(name)]) != NULL;
}

/* How calls of a name fail: errno and mode. */
static unsigned inject_ways(const char *name, int errors[4], const char *modes[4])
{
    unsigned count = 0;
#define WAY(e, m) (errors[count] = (e), modes[count] = (m), count++)
    if (inject_is(name, "malloc calloc realloc strdup _Znwm _Znam"))
        return WAY(ENOMEM, ""), WAY(ENOMEM, "on"), count;
    if (inject_is(name, "pthread_create pthread_mutex_init pthread_cond_init"))
        return WAY(EAGAIN, ""), WAY(EAGAIN, "on"), count;
    if (inject_is(name, "open openat __openat_2 fopen opendir mkostemp memfd_create socket"))
        return WAY(EMFILE, ""), WAY(EACCES, ""), count;
    if (inject_is(name, "read pread"))
        return WAY(EIO, ""), WAY(EINTR, ""), WAY(0, "short"), count;
    if (inject_is(name, "write pwrite"))
        return WAY(ENOSPC, ""), WAY(EIO, "on"), WAY(EINTR, ""), WAY(0, "short"), count;
    if (inject_is(name, "connect"))
        return WAY(ECONNREFUSED, ""), WAY(ENETUNREACH, "on"), count;
    if (inject_is(name, "recv"))
        return WAY(ECONNRESET, ""), WAY(ECONNRESET, "on"), WAY(EINTR, ""), WAY(0, "short"), count;
    if (inject_is(name, "send"))
        return WAY(EPIPE, ""), WAY(ECONNRESET, "on"), WAY(EINTR, ""), WAY(0, "short"), count;
    if (inject_is(name, "getaddrinfo"))
        return WAY(EAGAIN, ""), WAY(EAGAIN, "on"), count;
    if (inject_is(name, "poll"))
        return WAY(EINTR, ""), count;
    if (inject_is(name, "fwrite fputc fflush fclose posix_fallocate"))
        return WAY(ENOSPC, ""), count;
    return WAY(EIO, ""), count;
#undef WAY
}

/* The one call of a name that is tried where not all are: any, but always the same. */
static unsigned inject_one(const char *name, unsigned count)
{
    uint64_t hash = 14695981039346656037u; /* FNV-1a */
    for (const char *c = name; *c; c++)
        hash = (hash ^ (unsigned char)*c) * 1099511628211u;
    return 1 + (unsigned)((hash >> 20) % count);
}

/* all: each call of each name fails once in each way, else one of them. */
static void inject_command(inject_state *s, const injected *command, bool all)
{
    inject_learn(s, command);
    for (unsigned i = 0; i < s->names; i++) {
        int errors[4];
        const char *modes[4];
        unsigned ways = inject_ways(s->name[i], errors, modes), count = s->count[i];
        if (count == 0)
            continue;
        unsigned first = all ? 1 : inject_one(s->name[i], count), last = all ? count : first,
                 step = command->every != 0 ? command->every : 1;
        for (unsigned way = 0; way < ways; way++) {
            for (unsigned n = first; n <= last; n += step) {
                char failing[96];
                snprintf(failing, sizeof failing, "%s %u %d %s", s->name[i], n, errors[way],
                         modes[way]);
                inject_check(s, failing);
            }
        }
    }
    inject_forget(&s->in);
    inject_forget(&s->out);
    free(s->output);
}

#endif
