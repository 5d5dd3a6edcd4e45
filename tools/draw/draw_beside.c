/* Parses --beside. */
#include "tools/draw/draw_beside.h"

#include "base/memory.h"

#include <stdlib.h>
#include <string.h>

#define WORDS_LIMIT 64

static const cli_command command = {
    .name = "view --beside",
    .summary = "show a second model, or the same with other options, beside the first",
    .usage = "stipple view M.stipple --beside \"[N.stipple] [options]\"",
};

/* Where the options begin. */
static char *options_of(char *text)
{
    char *found = strncmp(text, "--", 2) == 0 ? text : strstr(text, " --");
    return found != NULL ? found : text + strlen(text);
}

/* Parts the text at spaces that are not in quotes, and takes the quotes away. Returns the number of
 * words; -1: a quote is not closed; WORDS_LIMIT: there are too many. */
static int split(char *text, char *words[WORDS_LIMIT])
{
    int count = 0;
    while (*(text += strspn(text, " ")) != '\0' && count < WORDS_LIMIT) {
        char *to = words[count++] = text, quote = '\0';
        for (; *text != '\0' && (quote != '\0' || *text != ' '); text++) {
            if (quote == '\0' && (*text == '\'' || *text == '"'))
                quote = *text;
            else if (quote != '\0' && *text == quote)
                quote = '\0';
            else
                *to++ = *text;
        }
        if (quote != '\0')
            return -1;
        text += *text == ' ';
        *to = '\0';
    }
    return count;
}

static int parse_options(draw_options *o, char *text)
{
    char *words[WORDS_LIMIT + 1] = {NULL};
    const char *none[1];
    size_t none_count = 0;
    cli_common common = {0};
    cli_option list[DRAW_OPTION_COUNT];
    const double exaggerate = o->exaggerate;
    const int count = split(text, words + 1);
    if (count < 0)
        return cli_usage(&command, "a quote is not closed");
    if (count == WORDS_LIMIT)
        return cli_usage(&command, "more than %d words", WORDS_LIMIT - 1);
    draw_options_fill(o, list);
    int code = cli_parse(&command, list + DRAW_LOOK_OPTION, DRAW_LOOK_OPTION_COUNT, 1 + count,
                         words, none, 0, 0, &none_count, &common);
    if (code != CLI_CONTINUE)
        return code;
    if (o->exaggerate != exaggerate)
        return cli_usage(&command, "--exaggerate is for both sides, as the camera is");
    if (draw_aa_times(o->aa) > 1)
        return cli_usage(&command, "--aa is none or edges here");
    o->attribute = NULL; /* that of the first side's --colour */
    return draw_options_check(o, &command);
}

int draw_beside_parse(draw_beside *out, const char *text, const draw_options *first)
{
    draw_beside b = {.options = *first};
    stp_error err = {0};
    if (stp_text_copy(&b.text, text, "--beside", &err) != STP_OK)
        return cli_fail(&command, &err);
    char *options = options_of(b.text), *end = options;
    while (end > b.text && end[-1] == ' ')
        end--;
    b.path = end > b.text ? b.text : NULL;
    if (*options == ' ')
        options++;
    const int code = parse_options(&b.options, options);
    if (b.path != NULL)
        *end = '\0';
    if (code != CLI_CONTINUE)
        draw_beside_clear(&b);
    *out = b;
    return code;
}

void draw_beside_clear(draw_beside *beside)
{
    free(beside->text);
    *beside = (draw_beside){0};
}
