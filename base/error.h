/* Status codes and located error messages: what every fallible function of stipple returns.
 *
 * A fallible function returns stp_status and takes stp_error *err last; NULL is allowed. On failure
 * err->message is one sentence that says what went wrong, where, and what to do; outputs are left
 * untouched. The message carries no newline and no "error:" prefix: the program adds those.
 * Does not print, does not allocate, never exits. Threads: any, one stp_error per caller. */
#ifndef STP_BASE_ERROR_H
#define STP_BASE_ERROR_H

#include <stdarg.h>

#ifdef __cplusplus
extern "C" { /* the shims include this header */
#endif

/* name, text */
#define STP_STATUS_LIST(X)                                                                         \
    X(OK, "done")                                                                                  \
    X(INVALID_ARGUMENT, "an argument is out of range")                                             \
    X(OUT_OF_MEMORY, "memory is exhausted")                                                        \
    X(IO, "reading or writing failed")                                                             \
    X(NOT_FOUND, "no such file")                                                                   \
    X(EXISTS, "the output exists already")                                                         \
    X(FORMAT, "the file is not of a known format")                                                 \
    X(VERSION, "the file's version is not supported")                                              \
    X(CORRUPT, "the file is damaged")                                                              \
    X(EMPTY, "there is nothing to work on")                                                        \
    X(LIMIT, "a limit is exceeded")                                                                \
    X(UNSUPPORTED, "this is not supported")                                                        \
    X(GL, "OpenGL failed or is not available")                                                     \
    X(CANCELLED, "interrupted")                                                                    \
    X(INTERNAL, "an invariant of the program is broken")

typedef enum stp_status {
#define X(name, text) STP_##name,
    STP_STATUS_LIST(X)
#undef X
} stp_status;

typedef struct stp_error {
    stp_status status;
    char message[1024];
} stp_error;

/* A status's constant without its prefix: "CORRUPT" for STP_CORRUPT. */
const char *stp_status_name(stp_status status);
/* One general sentence about a status. Used if there is no located message. */
const char *stp_status_text(stp_status status);

/* Fills err (if not NULL) and returns status, so that `return stp_error_set(...)` fails with it. */
stp_status stp_error_set(stp_error *err, stp_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
#ifdef __clang_analyzer__ /* tells the analyzer, which skips error.c, that the call fails */
#define stp_error_set(err, status, ...) ((void)stp_error_set(err, status, __VA_ARGS__), (status))
#endif

/* Forwards a failure to the label `done`; needs `stp_status status` in scope. */
#define STP_TRY(call)                                                                              \
    do {                                                                                           \
        status = (call);                                                                           \
        if (status != STP_OK)                                                                      \
            goto done;                                                                             \
    } while (0)

#ifdef __cplusplus
}
#endif

#endif
