/* The commands whose calls fail (injection.h), and what they read. */
#ifndef STP_TESTS_INJECTION_COMMANDS_H
#define STP_TESTS_INJECTION_COMMANDS_H

#include "tests/injection.h"

/* Makes the inputs; each writes into in/. */
static const injected injection_makers[] = {
    {.arguments = {"gen", "sphere", "-n", "3000", "-o", "in/a.ply", "-q"}},
    {.arguments = {"gen", "terrain", "-n", "3000", "-o", "in/a.las", "-q"}},
    {.arguments = {"gen", "tree", "-n", "2000", "-o", "in/tree.ply", "--mesh", "in/mesh.ply",
                   "-q"}},
    {.arguments = {"prep", "in/a.ply", "-o", "in/a.stipple", "-q"}},
    {.arguments = {"prep", "in/mesh.ply", "-o", "in/tree.stipple", "--lines", "auto", "-q"}},
    {.arguments = {"render", "in/a.stipple", "-o", "in/a.png", "--size", "32x32", "-q"},
     .draws = true},
    {.arguments = {"render", "in/tree.stipple", "-o", "in/b.png", "--size", "32x32", "-q"},
     .draws = true},
};

static const injected injection_commands[] = {
    {.arguments = {"info", "in/a.stipple"}},
    {.arguments = {"info", "in/a.stipple", "--json"}},
    {.arguments = {"verify", "in/tree.stipple"}},
    {.arguments = {"verify", "in/flip.stipple", "--repair", "-o", "out/r.stipple", "-q"}},
    {.arguments = {"gen", "sphere", "-n", "500", "-o", "out/g.ply", "-q"}},
    {.arguments = {"gen", "torus", "-n", "500", "-o", "out/g.las", "--stations", "3", "-q"}},
    {.arguments = {"prep", "in/a.ply", "-o", "out/m.stipple", "-q", "--outliers", "mark"}},
    {.arguments = {"prep", "in/a.las", "-o", "out/m.stipple", "-q", "--layers", "joined"}},
    {.arguments = {"prep", "in/mesh.ply", "-o", "out/m.stipple", "-q", "--lines", "auto"}},
    {.arguments = {"prep", "in/mesh.ply", "-o", "out/m.stipple", "-q", "--hybrid", "--sample",
                   "2000"}},
    {.arguments = {"convert", "in/a.stipple", "-o", "out/c.stipple", "--codec", "zstd", "-q"}},
    {.arguments = {"export", "in/a.stipple", "-o", "out/e.ply", "-q"}},
    {.arguments = {"export", "in/tree.stipple", "-o", "out/e.ply", "-q"}},
    {.arguments = {"render", "in/a.stipple", "-o", "out/p.jpg", "--size", "32x32", "--depth",
                   "out/d.exr", "-q"},
     .draws = true},
    {.arguments = {"compare", "in/a.png", "in/b.png"}, .draws = true},
    {.arguments = {"info", INJECT_ADDRESS}},
    {.arguments = {"export", INJECT_ADDRESS, "-o", "out/e.ply", "-q"}, .slow = true},
    {.arguments = {"render", INJECT_ADDRESS, "-o", "out/p.png", "--size", "32x32", "--cache",
                   "cache", "-q"},
     .draws = true,
     .slow = true},
    {.arguments = {"fly", "in/a.stipple", "--path", "in/p.json", "-o", "out/f", "--rate", "2",
                   "--size", "16x16", "-q"},
     .draws = true,
     .slow = true},
    {.arguments = {"tune", "in/a.stipple", "-o", "out/t", "--size", "16x16", "--views", "1",
                   "--repeat", "1", "-q"},
     .draws = true,
     .varies = true,
     .slow = true},
    {.arguments = {"view", "in/a.stipple", "--size", "64x64", "-q"},
     .views = true,
     .slow = true,
     .every = 7},
    {.arguments = {"view", INJECT_ADDRESS, "--size", "64x64", "--timeout", "5", "-q"},
     .views = true,
     .slow = true,
     .every = 20},
};

static bool injection_draws(const inject_state *s)
{
    static const injected version = {.arguments = {"render", "--help"}};
    inject_state asked = *s;
    asked.command = &version;
    return inject_run(&asked, NULL, NULL) == 0;
}

/* A copy with one bit flipped in a chunk, which repair puts back. */
static void injection_flip(const char *from, const char *to)
{
    size_t size;
    char *bytes = inject_read(from, &size);
    FILE *f = fopen(to, "wb");
    assert_true(f && size > 4000);
    bytes[3000] ^= 1;
    assert_int_equal(fwrite(bytes, 1, size, f), size);
    assert_int_equal(fclose(f), 0);
    free(bytes);
}

/* Where the shim and the program lie, and a folder of the test's own to work in. */
static void injection_prepare(inject_state *s)
{
    char folder[] = "injection-XXXXXX";
    assert_non_null(realpath(getenv("STIPPLE"), s->program));
    assert_non_null(realpath(getenv("STIPPLE_INJECT_SHIM"), s->shim));
    assert_non_null(mkdtemp(folder));
    assert_int_equal(chdir(folder), 0);
    inject_empty("in");
    inject_empty("out");
    bool draws = injection_draws(s);
    for (size_t i = 0; i < sizeof injection_makers / sizeof *injection_makers; i++) {
        s->command = &injection_makers[i];
        if (!s->command->draws || draws)
            assert_int_equal(inject_run(s, NULL, NULL), 0);
    }
    FILE *path = fopen("in/p.json", "w");
    assert_true(path && fputs("{\"turntable\": {\"seconds\": 1, \"degrees\": 90}}", path) >= 0);
    assert_int_equal(fclose(path), 0);
    injection_flip("in/a.stipple", "in/flip.stipple");
}

/* A server of in/a.stipple, and folders of the viewer's and the cache's own. */
static void injection_serve(inject_state *s)
{
    size_t size;
    char *bytes = inject_read("in/a.stipple", &size), state[4096];
    assert_true(fault_server_create(&s->server, bytes, size));
    free(bytes);
    assert_non_null(getcwd(state, sizeof state - 8));
    strcat(state, "/state");
    assert_int_equal(setenv("XDG_STATE_HOME", state, 1), 0);
}

static bool injection_all;

static void calls_fail_once(void **state)
{
    inject_state s = {.tried = 0};
    (void)state;
    injection_prepare(&s);
    injection_serve(&s);
    bool draws = injection_draws(&s), views = draws && injection_all && display_start();
    for (size_t i = 0; i < sizeof injection_commands / sizeof *injection_commands; i++) {
        if ((injection_commands[i].draws && !draws) || (injection_commands[i].views && !views) ||
            (injection_commands[i].slow && !injection_all))
            continue;
        unsigned tried = s.tried, wrong = s.wrong;
        inject_command(&s, &injection_commands[i], injection_all);
        print_message("%6u tried, %u wrong: %s %s\n", s.tried - tried, s.wrong - wrong,
                      injection_commands[i].arguments[0], injection_commands[i].arguments[1]);
    }
    print_message("%6u tried, %u wrong\n", s.tried, s.wrong);
    display_stop();
    fault_server_destroy(&s.server);
    assert_true(s.tried > 300);
    assert_int_equal(s.wrong, 0);
    char folder[4096], command[4200];
    assert_non_null(getcwd(folder, sizeof folder));
    snprintf(command, sizeof command, "cd .. && rm -rf '%s'", folder);
    assert_int_equal(system(command), 0);
}

/* all: each call, else one of each name. */
static int injection_main(bool all)
{
    if (!getenv("STIPPLE_INJECT_SHIM"))
        return 77;
    const struct CMUnitTest tests[] = {cmocka_unit_test(calls_fail_once)};
    injection_all = all;
    return cmocka_run_group_tests(tests, NULL, NULL);
}

#endif
