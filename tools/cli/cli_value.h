/* Parses values of the command line: numbers, sizes, vectors and choices; finds the nearest word.
 *
 * The decimal sign is always a point (setlocale is never called). Threads: any. */
#ifndef STP_TOOLS_CLI_CLI_VALUE_H
#define STP_TOOLS_CLI_CLI_VALUE_H

#include "base/vec.h"
#include "tools/cli/cli.h"

/* Stores text in option->target and sets *option->given. Returns false and leaves target untouched
 * if the text is not of the option's kind. */
bool cli_value_store(const cli_option *option, const char *text);
/* True if the text is a finite number. */
bool cli_value_is_number(const char *text);
/* What an option of this kind takes, e.g. "a whole number, like 4M", for messages. */
const char *cli_value_kind_text(cli_kind kind);
/* Finds the index-th word of "a|b|c" and returns its bounds, if begin and length are not NULL.
 * False if there is none. */
bool cli_choice_at(const char *choices, int index, const char **begin, size_t *length);
/* Parses "x0,y0,z0,x1,y1,z1", an option's value. Errors: INVALID_ARGUMENT (not six finite numbers,
 * an inverted box, or a box that does not meet the model's). */
stp_status cli_value_box(const char *option, const char *text, const stp_dbox *model, stp_dbox *out,
                         stp_error *err);
/* The number of edits (insert, delete, replace, swap neighbours) between two words. Words over 63
 * letters are far from all others. */
unsigned cli_word_distance(const char *a, const char *b);
/* True if `distance` is small enough for `word` to be a misspelling. */
bool cli_word_near(const char *word, unsigned distance);

#endif
