/* Values of the command line: text to numbers, sizes, vectors and choices, and the nearest word.
 *
 * The decimal sign is always a point (setlocale is never called). Threads: any. */
#ifndef STP_TOOLS_CLI_CLI_VALUE_H
#define STP_TOOLS_CLI_CLI_VALUE_H

#include "tools/cli/cli.h"

/* Stores text in option->target and sets *option->given. False (target untouched) when the text is
 * not of the option's kind. */
bool cli_value_store(const cli_option *option, const char *text);
/* Whether the text is a finite number. */
bool cli_value_is_number(const char *text);
/* What the option takes, e.g. "a whole number, like 4M", for messages. */
const char *cli_value_kind_text(cli_kind kind);
/* True if `word` is the index-th of "a|b|c"; its bounds are returned when they are not NULL. */
bool cli_choice_at(const char *choices, int index, const char **begin, size_t *length);
/* Edits (insert, delete, replace, swap neighbours) between two words; words over 63 letters are
 * far. */
unsigned cli_word_distance(const char *a, const char *b);
/* True if `distance` is small enough for `word` to be a misspelling. */
bool cli_word_near(const char *word, unsigned distance);

#endif
