/* What a flight is judged by: a second renderer, with room for all that a stretch of the flight
 * shows, in a process of its own, so that its memory and threads are not the flight's. It draws
 * only when asked, while the flight waits. Failures of the judge are told on its stderr, and end
 * the test. Start it before OpenGL and threads. */
#ifndef STP_TESTS_FLIGHT_JUDGE_H
#define STP_TESTS_FLIGHT_JUDGE_H

#include "base/clock.h"
#include "base/memory.h"
#include "tests/gl_fixture.h"

#include <sys/socket.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

typedef enum judge_task {
    JUDGE_PICTURE, /* waits for the whole cut; the picture's bytes follow the answer */
    JUDGE_LOAD,    /* streams until all is there */
    JUDGE_FRAME    /* streams what is there */
} judge_task;

typedef struct judge_question {
    judge_task task;
    stp_view view;
    double threshold_px;
} judge_question;

/* What a frame took: by the clock, and of a processor on the render thread, which does not count
 * what other programs take meanwhile. */
typedef struct judge_time {
    double ms, processor_ms;
} judge_time;

typedef struct judge_answer {
    judge_time time; /* of the whole call */
    bool complete;
} judge_answer;

typedef struct judge {
    pid_t process;
    int link;
} judge;

static inline judge_time judge_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return (judge_time){1e3 * stp_clock_seconds(),
                        1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec};
}

static inline judge_time judge_since(judge_time begun)
{
    judge_time now = judge_now();
    return (judge_time){now.ms - begun.ms, now.processor_ms - begun.processor_ms};
}

static inline bool judge_send(int link, const void *bytes, size_t count)
{
    const char *at = bytes;
    for (ssize_t sent = 0; count > 0; at += sent, count -= (size_t)sent)
        if ((sent = send(link, at, count, MSG_NOSIGNAL)) <= 0)
            return false;
    return true;
}

static inline bool judge_receive(int link, void *bytes, size_t count)
{
    char *at = bytes;
    for (ssize_t got = 0; count > 0; at += got, count -= (size_t)got)
        if ((got = read(link, at, count)) <= 0)
            return false;
    return true;
}

static inline stp_status judge_reply(stp_renderer *renderer, int link, const judge_question *q,
                                     stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *rgba = NULL;
    size_t bytes = 4 * (size_t)q->view.width * (size_t)q->view.height;
    stp_draw_stats stats;
    stp_draw_params params = {.threshold_px = q->threshold_px, .stream = q->task != JUDGE_PICTURE};
    judge_time begun = judge_now();
    do {
        STP_TRY(stp_renderer_draw(renderer, &q->view, &params, &stats, err));
    } while (q->task == JUDGE_LOAD && !stats.cut_complete);
    judge_answer answer = {judge_since(begun), stats.cut_complete};
    bool sent = judge_send(link, &answer, sizeof answer);
    if (q->task == JUDGE_PICTURE) {
        STP_TRY(stp_alloc(&rgba, bytes, 1, "a picture", err));
        STP_TRY(stp_renderer_read(renderer, rgba, err));
        sent = sent && judge_send(link, rgba, bytes);
    }
    if (!sent)
        status = stp_error_set(err, STP_IO, "the flight no longer listens");
done:
    free(rgba);
    return status;
}

/* The judge's process, until the flight ends its link. */
static inline stp_status judge_serve(int link, const char *path, uint64_t gpu_bytes, stp_error *err)
{
    stp_status status = STP_OK;
    stp_gl_context *context = NULL;
    stp_model *model = NULL;
    stp_renderer *renderer = NULL;
    judge_question question;
    STP_TRY(stp_gl_context_create(&context, err));
    STP_TRY(stp_model_open(&model, path, err));
    STP_TRY(stp_renderer_create(
        &renderer, &(stp_renderer_params){.model = model, .gpu_memory_bytes = gpu_bytes}, err));
    while (judge_receive(link, &question, sizeof question))
        STP_TRY(judge_reply(renderer, link, &question, err));
done:
    stp_renderer_destroy(&renderer);
    stp_model_close(&model);
    stp_gl_context_destroy(&context);
    return status;
}

static inline judge judge_start(const char *path, uint64_t gpu_bytes)
{
    int links[2];
    stp_error err = {0};
    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM, 0, links), 0);
    fflush(stdout);
    judge j = {fork(), links[0]};
    assert_true(j.process >= 0);
    close(links[j.process != 0]); /* the other side's */
    if (j.process != 0)
        return j;
    stp_status status = judge_serve(links[1], path, gpu_bytes, &err);
    if (status != STP_OK)
        fprintf(stderr, "judge: %s\n", err.message);
    _exit(status != STP_OK);
}

static inline judge_answer judge_ask(const judge *j, const judge_question *question, uint8_t *rgba)
{
    judge_answer answer = {0};
    size_t bytes = 4 * (size_t)question->view.width * (size_t)question->view.height;
    assert_true(judge_send(j->link, question, sizeof *question));
    assert_true(judge_receive(j->link, &answer, sizeof answer));
    if (question->task == JUDGE_PICTURE)
        assert_true(judge_receive(j->link, rgba, bytes));
    return answer;
}

static inline void judge_end(judge *j)
{
    int status = 0;
    close(j->link);
    assert_int_equal(waitpid(j->process, &status, 0), j->process);
    assert_int_equal(status, 0);
}

#endif
