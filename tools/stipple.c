/* stipple: finds the command named on the command line and runs it. */
#include "tools/commands.h"

#include "tools/cli/cli_value.h"

#include <stdio.h>
#include <string.h>

static const cli_command *const commands[] = {
#define X(name) &cli_##name,
#include "command_list.h"
#undef X
};

static const size_t command_count = sizeof commands / sizeof *commands;

static void print_help(FILE *stream)
{
    fprintf(stream, "usage: stipple COMMAND [arguments]\n\n"
                    "Turns scanned point clouds into continuous surfaces on the screen, without "
                    "meshing them.\n\nCommands:\n");
    for (size_t i = 0; i < command_count; i++)
        fprintf(stream, "  %-9s %s\n", commands[i]->name, commands[i]->summary);
    fprintf(stream, "\nstipple COMMAND --help describes a command; stipple --version prints the "
                    "version.\n");
}

static const cli_command *find_command(const char *name)
{
    for (size_t i = 0; i < command_count; i++) {
        if (strcmp(commands[i]->name, name) == 0)
            return commands[i];
    }
    return NULL;
}

/* Commands that draw, which a build with STIPPLE_RUNTIME=OFF leaves out. */
static bool needs_runtime(const char *name)
{
    static const char *const names[] = {"render", "fly", "view"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (strcmp(names[i], name) == 0)
            return true;
    }
    return false;
}

static int unknown_command(const char *name)
{
    const char *nearest = NULL;
    unsigned distance = ~0u;
    if (needs_runtime(name)) {
        fprintf(stderr,
                "stipple: this build has no %s: build with -DSTIPPLE_RUNTIME=ON on a machine that "
                "has OpenGL\n",
                name);
        return CLI_FAILED;
    }
    for (size_t i = 0; i < command_count; i++) {
        unsigned d = cli_word_distance(name, commands[i]->name);
        if (d < distance) {
            nearest = commands[i]->name;
            distance = d;
        }
    }
    if (nearest && cli_word_near(name, distance))
        fprintf(stderr, "stipple: '%s' is not a command: did you mean %s? (try stipple --help)\n",
                name, nearest);
    else
        fprintf(stderr, "stipple: '%s' is not a command (try stipple --help)\n", name);
    return CLI_USAGE;
}

static int run_command(const char *name, int argc, char **argv)
{
    const cli_command *command = find_command(name);
    return command ? command->run(argc, argv) : unknown_command(name);
}

static int run(int argc, char **argv)
{
    if (argc < 2) {
        print_help(stderr);
        return CLI_USAGE;
    }
    const char *first = argv[1];
    if (strcmp(first, "--version") == 0) {
        printf("stipple %s\n", STIPPLE_VERSION);
        return CLI_DONE;
    }
    bool help = strcmp(first, "help") == 0;
    if (strcmp(first, "--help") == 0 || strcmp(first, "-h") == 0 || (help && argc == 2)) {
        print_help(stdout);
        return CLI_DONE;
    }
    if (help) {
        char option[] = "--help";
        char *arguments[] = {argv[2], option, NULL};
        return run_command(argv[2], 2, arguments);
    }
    return run_command(first, argc - 1, argv + 1);
}

int main(int argc, char **argv)
{
    int code = run(argc, argv);
    if ((fflush(stdout) != 0 || ferror(stdout)) && code == CLI_DONE) {
        fprintf(stderr, "stipple: standard output could not be written: is the disk full?\n");
        return CLI_FAILED;
    }
    return code;
}
