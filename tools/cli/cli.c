/* What all commands share: options, help, messages and exit codes. */
#include "tools/cli/cli.h"

#include "tools/cli/cli_value.h"

#include <ctype.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

enum { HELP_COLUMN = 26, HELP_WIDTH = 100, THREADS_MAX = 256, COMMON_COUNT = 4 };

typedef struct parser {
    const cli_command *command;
    const cli_option *options;
    size_t option_count;
    const cli_option *common;
    size_t common_count;
} parser;

/* The command's name after "stipple ", or the program's own name. */
static const char *command_name(const cli_command *command)
{
    return command->program ? command->program : command->name;
}

size_t cli_control_bytes(const char *text, size_t length)
{
    const unsigned char *c = (const unsigned char *)text;
    if (length > 0 && (c[0] < ' ' || c[0] == 0x7f))
        return 1;
    return length > 1 && c[0] == 0xc2 && c[1] >= 0x80 && c[1] <= 0x9f ? 2 : 0;
}

/* Prints one line on stderr. A line break in a file name must not make two messages. */
static void print_line(const cli_command *command, const char *text)
{
    cli_progress_end();
    fprintf(stderr, "%s%s: ", command->program ? "" : "stipple ", command_name(command));
    for (const char *end = text + strlen(text); text < end;) {
        const size_t control = cli_control_bytes(text, (size_t)(end - text));
        fputc(control > 0 ? '?' : *text, stderr);
        text += control > 0 ? control : 1;
    }
    fputc('\n', stderr);
}

int cli_fail(const cli_command *command, const stp_error *err)
{
    bool located = err->message[0] != '\0';
    print_line(command, located ? err->message : stp_status_text(err->status));
    return CLI_FAILED;
}

int cli_usage(const cli_command *command, const char *format, ...)
{
    char text[1024], line[1200];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    snprintf(line, sizeof line, "%s (try %s%s --help)", text, command->program ? "" : "stipple ",
             command_name(command));
    print_line(command, line);
    return CLI_USAGE;
}

/* Prints text from column `column` on. Breaks lines at spaces and, in long words, after '|'. */
static void print_wrapped(const char *text, int column)
{
    int x = column;
    while (*text) {
        size_t length = strcspn(text, " |");
        if (text[length] == '|')
            length++;
        if (x > HELP_COLUMN && x + (int)length > HELP_WIDTH) {
            printf("\n%*s", HELP_COLUMN, "");
            x = HELP_COLUMN;
        }
        printf("%.*s", (int)length, text);
        x += (int)length;
        text += length;
        if (*text == ' ' && *++text) {
            putchar(' ');
            x++;
        }
    }
}

static void print_option(const cli_option *option)
{
    char left[256];
    bool valued = option->kind != CLI_FLAG;
    bool letter_only = strlen(option->name) == 2;
    if (!option->help)
        return;
    int used = option->letter && !letter_only
                   ? snprintf(left, sizeof left, "  -%c, %s", option->letter, option->name)
                   : snprintf(left, sizeof left, "  %s", option->name);
    printf("%s", left);
    if (valued) {
        putchar(' ');
        print_wrapped(option->argument, used + 1);
        used += 1 + (int)strlen(option->argument);
    }
    if (used >= HELP_COLUMN) {
        putchar('\n');
        used = 0;
    }
    printf("%*s", HELP_COLUMN - used, "");
    print_wrapped(option->help, HELP_COLUMN);
    putchar('\n');
}

static void print_help(const parser *p)
{
    const cli_command *command = p->command;
    printf("usage: %s\n\n%c%s.\n", command->usage, toupper((unsigned char)command->summary[0]),
           command->summary + 1);
    if (command->details)
        printf("\n%s\n", command->details);
    if (p->option_count > 0)
        printf("\nOptions:\n");
    for (size_t i = 0; i < p->option_count; i++)
        print_option(&p->options[i]);
    printf("\nCommon options:\n");
    for (size_t i = 0; i < p->common_count; i++)
        print_option(&p->common[i]);
}

static bool option_matches(const cli_option *option, const char *name, size_t length)
{
    if (strlen(option->name) == length && memcmp(option->name, name, length) == 0)
        return true;
    return length == 2 && name[0] == '-' && option->letter != '\0' && name[1] == option->letter;
}

static const cli_option *find_option(const parser *p, const char *name, size_t length)
{
    for (size_t i = 0; i < p->option_count + p->common_count; i++) {
        const cli_option *option =
            i < p->option_count ? &p->options[i] : &p->common[i - p->option_count];
        if (option_matches(option, name, length))
            return option;
    }
    return NULL;
}

static int unknown_option(const parser *p, const char *argument)
{
    char name[64];
    const char *nearest = NULL;
    unsigned distance = ~0u;
    snprintf(name, sizeof name, "%.*s", (int)strcspn(argument, "="), argument);
    if (argument[1] != '-' && find_option(p, argument, 2))
        return cli_usage(p->command, "%s is not an option: write -%c %s", argument, argument[1],
                         argument + 2);
    for (size_t i = 0; i < p->option_count + p->common_count; i++) {
        const cli_option *option =
            i < p->option_count ? &p->options[i] : &p->common[i - p->option_count];
        unsigned d = cli_word_distance(name, option->name);
        if (option->help && d < distance) {
            nearest = option->name;
            distance = d;
        }
    }
    if (nearest && cli_word_near(name, distance))
        return cli_usage(p->command, "%s is not an option: did you mean %s?", name, nearest);
    return cli_usage(p->command, "%s is not an option", name);
}

static int wrong_value(const parser *p, const cli_option *option, const char *value)
{
    if (option->kind == CLI_CHOICE)
        return cli_usage(p->command, "%s takes one of %s, not '%s'", option->name, option->argument,
                         value);
    return cli_usage(p->command, "%s takes %s, not '%s'", option->name,
                     cli_value_kind_text(option->kind), value);
}

/* Parses the option at argv[*index] and its value; moves *index to the last argument used. */
static int take_option(const parser *p, int argc, char **argv, int *index)
{
    const char *argument = argv[*index];
    size_t length = strcspn(argument, "=");
    const cli_option *option = find_option(p, argument, length);
    const char *value = argument[length] == '=' ? argument + length + 1 : NULL;
    if (!option)
        return unknown_option(p, argument);
    if (option->kind == CLI_FLAG) {
        if (value)
            return wrong_value(p, option, value);
        value = "";
    } else if (!value && option->kind == CLI_AMOUNT) {
        bool next = *index + 1 < argc && cli_value_is_number(argv[*index + 1]);
        value = next ? argv[++*index] : "1";
    } else if (!value) {
        /* `-o --force` means a forgotten value. Values that begin with -- are written --name=value.
         */
        if (*index + 1 >= argc ||
            (option->kind != CLI_OPTIONS && strncmp(argv[*index + 1], "--", 2) == 0))
            return cli_usage(p->command, "%s needs a value: %s %s", argument, argument,
                             option->argument);
        value = argv[++*index];
    }
    return cli_value_store(option, value) ? CLI_CONTINUE : wrong_value(p, option, value);
}

static int check_count(const cli_command *command, size_t count, size_t least, size_t most,
                       const char *extra)
{
    if (count < least && count == 0)
        return cli_usage(command, "nothing to work on: %s", command->usage);
    if (count < least)
        return cli_usage(command, "an argument is missing: %s", command->usage);
    if (count > most)
        return cli_usage(command, "'%s' is one argument too many", extra);
    return CLI_CONTINUE;
}

int cli_parse(const cli_command *command, const cli_option *options, size_t option_count, int argc,
              char **argv, const char **positional, size_t positional_min, size_t positional_max,
              size_t *positional_count, cli_common *common)
{
    bool help = false, version = false, options_end = false;
    size_t count = 0;
    const char *extra = NULL;
    const cli_option shared[COMMON_COUNT] = {
        {"--threads", 0, CLI_UINT, &common->threads, "N",
         "threads to use, at most 256 (default: one per processor)", NULL},
        {"--quiet", 'q', CLI_FLAG, &common->quiet, NULL, "print no progress and no remarks", NULL},
        {"--help", 'h', CLI_FLAG, &help, NULL, "print this help and exit", NULL},
        {"--version", 0, CLI_FLAG, &version, NULL, "print the version and exit", NULL},
    };
    const parser p = {command, options, option_count, shared, COMMON_COUNT};
    for (int i = 1; i < argc; i++) {
        if (!options_end && strcmp(argv[i], "--") == 0) {
            options_end = true;
        } else if (!options_end && argv[i][0] == '-' && argv[i][1] != '\0') {
            int code = take_option(&p, argc, argv, &i);
            if (code != CLI_CONTINUE)
                return code;
        } else {
            if (count < positional_max)
                positional[count] = argv[i];
            else if (!extra)
                extra = argv[i];
            count++;
        }
        if (help) {
            print_help(&p);
            return CLI_DONE;
        }
        if (version) {
            printf("stipple %s\n", STIPPLE_VERSION);
            return CLI_DONE;
        }
    }
    if (common->threads > THREADS_MAX)
        return cli_usage(command, "--threads takes a number up to %d", THREADS_MAX);
    *positional_count = count;
    return check_count(command, count, positional_min, positional_max, extra);
}
