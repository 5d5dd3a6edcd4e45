/* Leaves out of a shader what it does not use: comments, and functions that nothing calls.
 *
 * Drivers compile every function before they see which are used, and a shader includes far more
 * than it calls. Without them a program is compiled in less time, and more variants of a shader are
 * one text, which is found in the driver's cache. Threads: any. */
#ifndef STP_RUNTIME_GL_SHADER_TRIM_H
#define STP_RUNTIME_GL_SHADER_TRIM_H

/* Shortens the text in place; every line that stays keeps its number. A function is kept if main(),
 * a macro or anything else outside functions names it, or a function that is kept. Keeps functions
 * whose text it does not understand. */
void stp_shader_trim(char *text);

#endif
