/* Parses --beside, and joins two sides. */
#include "tools/draw/draw_beside.h"

#include "base/memory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define WORDS_LIMIT 64

#define SUMMARY "show a second model, or the same with other options, beside the first"
#define REST " M.stipple --beside \"[N.stipple] [options]\""

static const cli_command of_render = {
    .name = "render --beside", .summary = SUMMARY, .usage = "stipple render" REST};
static const cli_command of_view = {
    .name = "view --beside", .summary = SUMMARY, .usage = "stipple view" REST};

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

static int parse_options(draw_options *o, char *text, const cli_command *command)
{
    char *words[WORDS_LIMIT + 1] = {NULL};
    const char *none[1];
    size_t none_count = 0;
    cli_common common = {0};
    cli_option list[DRAW_OPTION_COUNT];
    const double exaggerate = o->exaggerate;
    const int count = split(text, words + 1);
    if (count < 0)
        return cli_usage(command, "a quote is not closed");
    if (count == WORDS_LIMIT)
        return cli_usage(command, "more than %d words", WORDS_LIMIT - 1);
    draw_options_fill(o, list);
    int code = cli_parse(command, list + DRAW_LOOK_OPTION, DRAW_LOOK_OPTION_COUNT, 1 + count, words,
                         none, 0, 0, &none_count, &common);
    if (code != CLI_CONTINUE)
        return code;
    if (o->exaggerate != exaggerate)
        return cli_usage(command, "--exaggerate is for both sides, as the camera is");
    if (command == &of_view && draw_aa_times(o->aa) > 1)
        return cli_usage(command, "--aa is none or edges here");
    o->attribute = NULL; /* that of the first side's --colour */
    return draw_options_check(o, command);
}

int draw_beside_parse(draw_beside *out, const char *text, const draw_options *first, bool in_view)
{
    const cli_command *command = in_view ? &of_view : &of_render;
    draw_beside b = {.options = *first};
    stp_error err = {0};
    if (stp_text_copy(&b.text, text, "--beside", &err) != STP_OK)
        return cli_fail(command, &err);
    char *options = options_of(b.text), *end = options;
    while (end > b.text && end[-1] == ' ')
        end--;
    b.path = end > b.text ? b.text : NULL;
    if (*options == ' ')
        options++;
    const int code = parse_options(&b.options, options, command);
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

void draw_beside_join_ranges(stp_draw_params *first, const draw_options *first_options,
                             stp_draw_params *second, const draw_options *second_options,
                             uint32_t attributes)
{
    double *range = first->colour_range;
    if (first->colour != second->colour || first_options->attribute || second_options->attribute ||
        first_options->colour_range || second_options->colour_range ||
        (first->colour == STP_COLOUR_INTENSITY && !(attributes & STP_HAS_INTENSITY)))
        return;
    range[0] = fmin(range[0], second->colour_range[0]);
    range[1] = fmax(range[1], second->colour_range[1]);
    memcpy(second->colour_range, range, sizeof second->colour_range);
}

void draw_beside_put(uint8_t *rgba, const uint8_t *right, int width, int height)
{
    static const uint8_t divider[8] = {0, 0, 0, 255, 255, 255, 255, 255};
    const size_t w = (size_t)width, middle = w / 2;
    for (size_t y = 0; y < (size_t)height; y++) {
        uint8_t *row = rgba + 4 * w * y;
        memcpy(row + 4 * middle, right + 4 * (w * y + middle), 4 * (w - middle));
        if (middle > 0)
            memcpy(row + 4 * (middle - 1), divider, sizeof divider);
    }
}
