/* Parses values of the command line: numbers, sizes, vectors and choices; finds the nearest word.
 */
#include "tools/cli/cli_value.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { WORD_LENGTH_MAX = 63, EXTENT_MAX = 16384 };

/* Parses a finite number; *end is its end. Refuses hexadecimal, spaces and names. */
static bool parse_number(const char *text, double *out, const char **end)
{
    const char *digits = text + (*text == '-' || *text == '+');
    char *stop = NULL;
    if (!isdigit((unsigned char)*digits) && *digits != '.')
        return false;
    if (digits[0] == '0' && (digits[1] == 'x' || digits[1] == 'X'))
        return false;
    double value = strtod(text, &stop);
    if (stop == text || !isfinite(value))
        return false;
    *out = value;
    *end = stop;
    return true;
}

/* The power of the suffix K, M, G or T (1..4); 0: end of the text; -1: anything else. */
static int suffix_power(const char *suffix, bool bytes)
{
    static const char letters[] = "KMGT";
    if (*suffix == '\0')
        return 0;
    const char *found = strchr(letters, toupper((unsigned char)*suffix));
    if (!found)
        return bytes && strcasecmp(suffix, "B") == 0 ? 0 : -1;
    const char *rest = suffix + 1;
    if (*rest == '\0' || (bytes && (strcasecmp(rest, "B") == 0 || strcasecmp(rest, "iB") == 0)))
        return (int)(found - letters) + 1;
    return -1;
}

static bool parse_uint(const char *text, bool bytes, uint64_t *out)
{
    const char *end = NULL;
    double number = 0.0;
    size_t digits = strspn(text, "0123456789");
    if (digits > 0 && text[digits] == '\0') { /* exact where a double is not */
        errno = 0;
        unsigned long long value = strtoull(text, NULL, 10);
        if (errno != 0)
            return false;
        *out = value;
        return true;
    }
    if (!parse_number(text, &number, &end) || *text == '-')
        return false;
    int power = suffix_power(end, bytes);
    if (power < 0)
        return false;
    for (int i = 0; i < power; i++)
        number *= bytes ? 1024.0 : 1000.0;
    if (bytes)
        number = floor(number);
    if (number >= 0x1p63 || number != floor(number))
        return false;
    *out = (uint64_t)number;
    return true;
}

static bool parse_vec3(const char *text, double out[3])
{
    double value[3];
    for (int i = 0; i < 3; i++) {
        const char *end = NULL;
        if (!parse_number(text, &value[i], &end) || *end != (i < 2 ? ',' : '\0'))
            return false;
        text = end + 1;
    }
    memcpy(out, value, sizeof value);
    return true;
}

static bool parse_extent(const char *text, int out[2])
{
    long value[2];
    for (int i = 0; i < 2; i++) {
        char *end = NULL;
        if (!isdigit((unsigned char)*text))
            return false;
        value[i] = strtol(text, &end, 10);
        if (value[i] < 1 || value[i] > EXTENT_MAX)
            return false;
        if (i == 0 ? (*end != 'x' && *end != 'X') : *end != '\0')
            return false;
        text = end + 1;
    }
    out[0] = (int)value[0];
    out[1] = (int)value[1];
    return true;
}

bool cli_choice_at(const char *choices, int index, const char **begin, size_t *length)
{
    for (int i = 0; i < index; i++) {
        choices = strchr(choices, '|');
        if (!choices)
            return false;
        choices++;
    }
    *begin = choices;
    *length = strcspn(choices, "|");
    return true;
}

static bool parse_choice(const char *text, const char *choices, int *out)
{
    const char *begin = NULL;
    size_t length = 0;
    for (int i = 0; cli_choice_at(choices, i, &begin, &length); i++) {
        if (strlen(text) == length && memcmp(text, begin, length) == 0) {
            *out = i;
            return true;
        }
    }
    return false;
}

static bool parse_finite(const char *text, double *out)
{
    const char *end = NULL;
    double value = 0.0;
    if (!parse_number(text, &value, &end) || *end != '\0')
        return false;
    *out = value;
    return true;
}

static bool parse_seconds(const char *text, double *out)
{
    double value = 0.0;
    if (!parse_finite(text, &value) || value < 0.0 || value > CLI_SECONDS_MOST)
        return false;
    *out = value;
    return true;
}

static bool store(const cli_option *option, const char *text)
{
    switch (option->kind) {
    case CLI_FLAG:
        *(bool *)option->target = true;
        return true;
    case CLI_STRING:
    case CLI_OPTIONS:
        if (*text == '\0')
            return false;
        *(const char **)option->target = text;
        return true;
    case CLI_CHOICE:
        return parse_choice(text, option->argument, option->target);
    case CLI_UINT:
    case CLI_BYTES:
        return parse_uint(text, option->kind == CLI_BYTES, option->target);
    case CLI_NUMBER:
    case CLI_AMOUNT:
        return parse_finite(text, option->target);
    case CLI_SECONDS:
        return parse_seconds(text, option->target);
    case CLI_VEC3:
        return parse_vec3(text, option->target);
    case CLI_EXTENT:
        return parse_extent(text, option->target);
    }
    return false;
}

bool cli_value_is_number(const char *text)
{
    double number = 0.0;
    return parse_finite(text, &number);
}

bool cli_value_store(const cli_option *option, const char *text)
{
    if (!store(option, text))
        return false;
    if (option->given)
        *option->given = true;
    return true;
}

const char *cli_value_kind_text(cli_kind kind)
{
    static const char *const texts[] = {
        [CLI_FLAG] = "no value",
        [CLI_STRING] = "a text",
        [CLI_OPTIONS] = "a text",
        [CLI_CHOICE] = "one of its words",
        [CLI_UINT] = "a whole number, like 500, 1e6 or 4M",
        [CLI_BYTES] = "a size in bytes, like 512M or 2G",
        [CLI_NUMBER] = "a number",
        [CLI_AMOUNT] = "a number or nothing",
        [CLI_SECONDS] = "seconds from 0 to 86400 (a day)",
        [CLI_VEC3] = "three numbers, like 1,0,-2.5",
        [CLI_EXTENT] = "width x height from 1x1 to 16384x16384, like 1024x768",
    };
    return texts[kind];
}

static unsigned least(unsigned a, unsigned b)
{
    return a < b ? a : b;
}

unsigned cli_word_distance(const char *a, const char *b)
{
    /* Rows i-2, i-1 and i of the table of optimal string alignment, used in turn. */
    unsigned rows[3][WORD_LENGTH_MAX + 1];
    size_t la = strlen(a), lb = strlen(b);
    if (la > WORD_LENGTH_MAX || lb > WORD_LENGTH_MAX)
        return WORD_LENGTH_MAX + 1;
    for (size_t j = 0; j <= lb; j++)
        rows[0][j] = (unsigned)j;
    for (size_t i = 1; i <= la; i++) {
        unsigned *now = rows[i % 3], *last = rows[(i + 2) % 3], *before = rows[(i + 1) % 3];
        now[0] = (unsigned)i;
        for (size_t j = 1; j <= lb; j++) {
            unsigned replaced = last[j - 1] + (a[i - 1] != b[j - 1]);
            now[j] = least(replaced, least(last[j], now[j - 1]) + 1);
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                now[j] = least(now[j], before[j - 2] + 1);
        }
    }
    return rows[la % 3][lb];
}

bool cli_word_near(const char *word, unsigned distance)
{
    size_t length = strlen(word);
    while (length > 0 && *word == '-') {
        word++;
        length--;
    }
    return distance <= 1 + length / 4 && distance < length;
}

stp_status cli_value_box(const char *option, const char *text, const stp_dbox *model, stp_dbox *out,
                         stp_error *err)
{
    stp_dbox box = {{0.0, 0.0, 0.0}, {0.0, 0.0, 0.0}};
    stp_dvec3 *a = &box.min, *b = &box.max;
    int used = 0;
    if (sscanf(text, "%lf,%lf,%lf,%lf,%lf,%lf%n", &a->x, &a->y, &a->z, &b->x, &b->y, &b->z,
               &used) != 6 ||
        text[used] != '\0' || !stp_dvec3_finite(*a) || !stp_dvec3_finite(*b))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s %s: give six numbers, x0,y0,z0,x1,y1,z1", option, text);
    if (stp_dbox_is_empty(&box))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s %s: the box is inverted: give the least corner first", option,
                             text);
    if (!stp_dbox_meet(&box, model))
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s %s: nothing of the model is there: it reaches from "
                             "%.9g,%.9g,%.9g to %.9g,%.9g,%.9g",
                             option, text, model->min.x, model->min.y, model->min.z, model->max.x,
                             model->max.y, model->max.z);
    *out = box;
    return STP_OK;
}
