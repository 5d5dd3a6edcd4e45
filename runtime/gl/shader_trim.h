/* Leaves out of a shader what it does not use: comments, and functions that nothing calls.
 *
 * A shader includes far more than it calls. If two variants of a shader differ only in what neither
 * calls, both have one text without it (stp_shader_text), so the driver compiles and caches one
 * program. Threads: any. */
#ifndef STP_RUNTIME_GL_SHADER_TRIM_H
#define STP_RUNTIME_GL_SHADER_TRIM_H

/* Shortens the text in place; every line that stays keeps its number. A function is kept if main(),
 * a macro or anything else outside functions names it, or a function that is kept. Keeps functions
 * whose text it does not understand. */
void stp_shader_trim(char *text);

#endif
