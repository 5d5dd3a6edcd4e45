/* Programs of hosts' own in tests, from GLSL. Failures end the test. */
#ifndef STP_TESTS_GL_PROGRAM_H
#define STP_TESTS_GL_PROGRAM_H

#include "tests/support/check.h"

#include <epoxy/gl.h>

/* kept: the one output that transform feedback captures, or NULL. */
static inline GLuint gl_program_make(const char *vertex, const char *fragment, const char *kept)
{
    const char *const texts[2] = {vertex, fragment};
    GLuint program = glCreateProgram();
    GLint linked = 0;
    for (int i = 0; i < 2; i++) {
        GLuint shader = glCreateShader(i == 0 ? GL_VERTEX_SHADER : GL_FRAGMENT_SHADER);
        glShaderSource(shader, 1, &texts[i], NULL);
        glCompileShader(shader);
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    if (kept != NULL)
        glTransformFeedbackVaryings(program, 1, &kept, GL_INTERLEAVED_ATTRIBS);
    glLinkProgram(program);
    glGetProgramiv(program, GL_LINK_STATUS, &linked);
    assert_true(linked);
    return program;
}

#endif
