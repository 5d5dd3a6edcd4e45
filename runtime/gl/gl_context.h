/* An OpenGL 4.5 core context without a window, through EGL.
 *
 * Asks the machine's GPUs first (no display needed), then Mesa's surfaceless platform (llvmpipe).
 * Threads: the context belongs to the thread that created it. */
#ifndef STP_RUNTIME_GL_GL_CONTEXT_H
#define STP_RUNTIME_GL_GL_CONTEXT_H

#include "base/error.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct stp_gl_context stp_gl_context;

/* Creates a context and makes it current. Errors: GL (no EGL library, no device, or a version that
 * is too old; the message says which), OUT_OF_MEMORY. */
stp_status stp_gl_context_create(stp_gl_context **out, stp_error *err);
void stp_gl_context_destroy(stp_gl_context **context);

/* Succeeds if stipple can draw with the current context. Errors: GL (says what was found). */
stp_status stp_gl_context_check(stp_error *err);

/* Turns the first GL error since the last call into an error that names `what`. Errors: GL. */
stp_status stp_gl_check(const char *what, stp_error *err);

#ifdef __cplusplus
}
#endif

#endif
