/* Starts ffmpeg, sends frames, reads its messages and waits for it. */
#include "tools/draw/fly_film.h"

#include "base/file.h"
#include "base/memory.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#define ARGUMENT_LIMIT 48
/* Waiting for ffmpeg checks for cancellation this often. */
#define CANCEL_INTERVAL_MS 50
#define WORDS_BYTES 400

/* The name of the output for ffmpeg. "file:" keeps ffmpeg from taking it for a protocol. */
#define FILM "file:/proc/self/fd/3"

struct fly_film {
    stp_output *output;
    char *path;
    size_t frame_bytes;
    uint64_t frame_count;
    int frames;    /* our end of the socket that is ffmpeg's standard input; -1: closed */
    int words;     /* a nameless file for ffmpeg's messages */
    pid_t process; /* 0: none, or already waited for */
};

typedef struct film_format {
    const char *ending, *muxer;
    const char *codec[8]; /* arguments */
} film_format;

#define X264 "-c:v", "libx264", "-crf", "18"

static const film_format formats[] = {
    {".mp4", "mp4", {X264, "-movflags", "+faststart"}},
    {".mov", "mov", {X264, "-movflags", "+faststart"}},
    {".mkv", "matroska", {X264}},
    {".webm", "webm", {"-c:v", "libvpx-vp9", "-crf", "24", "-b:v", "0", "-row-mt", "1"}},
};

static const film_format *find_format(const char *path)
{
    for (size_t i = 0; i < sizeof formats / sizeof *formats; i++)
        if (stp_path_ends_in(path, formats[i].ending))
            return &formats[i];
    return NULL;
}

bool fly_film_is_name(const char *path)
{
    return find_format(path) != NULL;
}

/* Colours of today's films (BT.709, limited range). Without these tags, players guess. */
static const char filters[] =
    "scale=out_color_matrix=bt709:out_range=limited:flags=accurate_rnd+full_chroma_int,"
    "pad=ceil(iw/2)*2:ceil(ih/2)*2,format=yuv420p";

/* Starts ffmpeg. Its descriptor 3 (FILM) is the film; words gets its messages. Returns 0 or an
 * errno. */
static int spawn(fly_film *film, int input, int output, const char *const *arguments)
{
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    int failed = posix_spawn_file_actions_init(&actions);
    if (failed != 0)
        return failed;
    failed = posix_spawnattr_init(&attributes);
    if (failed == 0) {
        /* A process group of its own, because we handle Ctrl-C. */
        posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
        const int descriptors[] = {input, output, film->words, stp_output_descriptor(film->output)};
        for (int i = 0; i < 4; i++) {
            if (descriptors[i] >= 0)
                posix_spawn_file_actions_adddup2(&actions, descriptors[i], i);
            else
                posix_spawn_file_actions_addopen(&actions, i, "/dev/null", O_RDWR, 0);
        }
        pid_t process = 0;
        failed = posix_spawnp(&process, arguments[0], &actions, &attributes,
                              (char *const *)(uintptr_t)arguments, environ);
        film->process = failed == 0 ? process : 0;
        posix_spawnattr_destroy(&attributes);
    }
    posix_spawn_file_actions_destroy(&actions);
    return failed;
}

static stp_status start(fly_film *film, const fly_film_params *params, const film_format *format,
                        stp_error *err)
{
    int ends[2] = {-1, -1};
    char size[32], rate[40];
    const char *arguments[ARGUMENT_LIMIT] = {"ffmpeg",
                                             "-nostdin",
                                             "-hide_banner",
                                             "-loglevel",
                                             "error",
                                             "-f",
                                             "rawvideo",
                                             "-pixel_format",
                                             "rgba",
                                             "-video_size",
                                             size,
                                             "-framerate",
                                             rate,
                                             "-i",
                                             "pipe:0",
                                             "-an",
                                             "-vf",
                                             filters,
                                             "-colorspace",
                                             "bt709",
                                             "-color_primaries",
                                             "bt709",
                                             "-color_trc",
                                             "iec61966-2-1",
                                             "-fflags",
                                             "+bitexact",
                                             "-flags:v",
                                             "+bitexact"};
    size_t count = 0;
    while (arguments[count] != NULL)
        count++;
    for (size_t i = 0; i < 8 && format->codec[i] != NULL; i++)
        arguments[count++] = format->codec[i];
    const char *const last[] = {"-f", format->muxer, "-y", FILM};
    memcpy(arguments + count, last, sizeof last);
    snprintf(size, sizeof size, "%dx%d", params->width, params->height);
    snprintf(rate, sizeof rate, "%.10g", params->rate);
    film->words = memfd_create("messages of ffmpeg", MFD_CLOEXEC);
    if (film->words < 0 || socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
        return stp_error_set(err, STP_IO, "%s: ffmpeg cannot be started: %s", params->path,
                             strerror(errno));
    film->frames = ends[0];
    int failed = spawn(film, ends[1], -1, arguments);
    close(ends[1]);
    if (failed == ENOENT)
        return stp_error_set(err, STP_NOT_FOUND,
                             "%s: films are made by ffmpeg, which is not installed: install it, or "
                             "give -o a folder for numbered PNG files",
                             params->path);
    if (failed != 0)
        return stp_error_set(err, STP_IO, "%s: ffmpeg cannot be started: %s", params->path,
                             strerror(failed));
    return STP_OK;
}

stp_status fly_film_create(fly_film **out, const fly_film_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    fly_film *film = NULL;
    const film_format *format = find_format(params->path);
    if (format == NULL)
        return stp_error_set(err, STP_UNSUPPORTED, "%s: no film has that ending: use .mp4",
                             params->path);
    STP_TRY(stp_alloc(&film, 1, sizeof *film, "a film", err));
    film->frames = film->words = -1;
    film->frame_bytes = (size_t)params->width * (size_t)params->height * 4;
    STP_TRY(stp_text_copy(&film->path, params->path, "a path", err));
    STP_TRY(stp_output_create(&film->output, params->path, params->force, err));
    STP_TRY(start(film, params, format, err));
    *out = film;
    film = NULL;
done:
    fly_film_destroy(&film);
    return status;
}

static bool is_cancelled(const stp_progress *progress)
{
    return progress != NULL && progress->cancelled != NULL &&
           progress->cancelled(progress->context);
}

static stp_status cancelled(const fly_film *film, stp_error *err)
{
    return stp_error_set(err, STP_CANCELLED, "%s: interrupted", film->path);
}

/* Waits for ffmpeg's end. *code is its exit status, or the status that a shell gives for a signal.
 */
static stp_status wait_for(fly_film *film, const stp_progress *progress, int *code, stp_error *err)
{
    int state = 0;
    pid_t ended = 0;
    while ((ended = waitpid(film->process, &state, WNOHANG)) == 0) {
        if (is_cancelled(progress))
            return cancelled(film, err);
        (void)poll(NULL, 0, CANCEL_INTERVAL_MS);
    }
    if (ended < 0)
        return stp_error_set(err, STP_IO, "%s: ffmpeg is lost: %s", film->path, strerror(errno));
    film->process = 0;
    *code = WIFEXITED(state) ? WEXITSTATUS(state) : 128 + WTERMSIG(state);
    return STP_OK;
}

/* Gets the last line with a message, without the prefix of ffmpeg's messages. */
static void last_words(const fly_film *film, char out[WORDS_BYTES])
{
    char text[4096];
    off_t size = lseek(film->words, 0, SEEK_END);
    off_t from = size > (off_t)sizeof text - 1 ? size - (off_t)sizeof text + 1 : 0;
    ssize_t got = size > 0 ? pread(film->words, text, sizeof text - 1, from) : 0;
    text[got > 0 ? got : 0] = '\0';
    snprintf(out, WORDS_BYTES, "it said nothing");
    for (char *rest = text, *line = strsep(&rest, "\n"); line != NULL; line = strsep(&rest, "\n"))
        if (line[0] != '\0' && strcmp(line, "Conversion failed!") != 0)
            snprintf(out, WORDS_BYTES, "%s", line);
}

static stp_status failed(const fly_film *film, int code, stp_error *err)
{
    char words[WORDS_BYTES];
    last_words(film, words);
    return stp_error_set(err, STP_IO,
                         "%s: ffmpeg failed (exit %d): %s: mend that, or give -o a folder for "
                         "numbered PNG files",
                         film->path, code, words);
}

stp_status fly_film_write(fly_film *film, const uint8_t *rgba, const stp_progress *progress,
                          stp_error *err)
{
    size_t left = film->frame_bytes;
    while (left > 0) {
        struct pollfd room = {.fd = film->frames, .events = POLLOUT};
        if (is_cancelled(progress))
            return cancelled(film, err);
        if (poll(&room, 1, CANCEL_INTERVAL_MS) <= 0)
            continue;
        ssize_t sent = send(film->frames, rgba, left, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent < 0 && (errno == EINTR || errno == EAGAIN))
            continue;
        if (sent < 0) { /* ffmpeg has ended and has said why */
            int code = 0;
            stp_status status = wait_for(film, progress, &code, err);
            return status == STP_OK ? failed(film, code, err) : status;
        }
        rgba += sent;
        left -= (size_t)sent;
    }
    film->frame_count++;
    return STP_OK;
}

/* Counts lines that do not begin with '#' in ffmpeg's list of packets. */
static uint64_t count_packets(int list)
{
    char text[4096];
    uint64_t count = 0;
    bool begins = true;
    off_t at = 0;
    for (ssize_t got = 1; got > 0; at += got) {
        got = pread(list, text, sizeof text, at);
        for (ssize_t i = 0; i < got; i++) {
            count += begins && text[i] != '#';
            begins = text[i] == '\n';
        }
    }
    return count;
}

/* Reads the film back, because ffmpeg reports success on a full disk, too. */
static stp_status check(fly_film *film, const stp_progress *progress, stp_error *err)
{
    static const char *const arguments[] = {
        "ffmpeg", "-nostdin", "-hide_banner", "-loglevel", "error", "-xerror", "-i",
        FILM,     "-map",     "0:v:0",        "-c",        "copy",  "-f",      "framecrc",
        "pipe:1", "-map",     "0:v:0",        "-f",        "null",  "-",       NULL};
    stp_status status = STP_OK;
    int code = 0;
    const int list = memfd_create("packets", MFD_CLOEXEC);
    const int failure = list < 0 ? errno : spawn(film, -1, list, arguments);
    if (failure != 0) {
        status = stp_error_set(err, STP_IO, "%s: ffmpeg cannot be started: %s", film->path,
                               strerror(failure));
        goto done;
    }
    STP_TRY(wait_for(film, progress, &code, err));
    const uint64_t count = count_packets(list);
    if (code != 0 || count != film->frame_count)
        status = stp_error_set(err, STP_IO,
                               "%s: the film that ffmpeg wrote cannot be read back (%" PRIu64
                               " of %" PRIu64 " frames): the disk may be full: free some space or "
                               "write elsewhere",
                               film->path, count, film->frame_count);
done:
    if (list >= 0)
        close(list);
    return status;
}

stp_status fly_film_commit(fly_film **film, const stp_progress *progress, stp_error *err)
{
    fly_film *f = *film;
    stp_status status = STP_OK;
    int code = 0;
    close(f->frames);
    f->frames = -1;
    STP_TRY(wait_for(f, progress, &code, err));
    if (code != 0) {
        status = failed(f, code, err);
        goto done;
    }
    STP_TRY(check(f, progress, err));
    STP_TRY(stp_output_commit(&f->output, err));
done:
    fly_film_destroy(film);
    return status;
}

void fly_film_destroy(fly_film **film)
{
    fly_film *f = *film;
    if (f == NULL)
        return;
    if (f->process > 0) {
        kill(f->process, SIGKILL);
        while (waitpid(f->process, NULL, 0) < 0 && errno == EINTR)
            continue;
    }
    if (f->frames >= 0)
        close(f->frames);
    if (f->words >= 0)
        close(f->words);
    stp_output_destroy(&f->output);
    free(f->path);
    free(f);
    *film = NULL;
}
