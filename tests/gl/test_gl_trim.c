/* Tests what is left out of a shader: comments and functions that nothing calls, no more, and every
 * line that stays keeps its number. (All other test_gl_* draw with what stays.) */
#include "runtime/gl/shader.h"
#include "runtime/gl/shader_trim.h"
#include "tests/support/check.h"

#include <stdio.h>
#include <string.h>

static void expect(const char *text, const char *trimmed)
{
    char found[2000];
    assert_true((size_t)snprintf(found, sizeof found, "%s", text) < sizeof found);
    stp_shader_trim(found);
    assert_string_equal(found, trimmed);
}

static void unused_functions_go(void **state)
{
    (void)state;
    expect("float a()\n{\n    return 1.0;\n}\n\nvoid main()\n{\n}\n",
           "\n\n\n\n\nvoid main()\n{\n}\n");
    expect("float a() { return 1.0; }\nvoid main() {}\n", "\nvoid main() {}\n");
    /* what only unused functions call, and what calls itself */
    expect(
        "int a() { return 1; }\nint b() { return a(); }\nint c() { return c(); }\nvoid main() {}",
        "\n\n\nvoid main() {}");
    /* a name within another name, a number or a comment is no call */
    expect(
        "int a() { return 1; }\nint b() { return 1; }\nvoid main() { int ab = 0xa; /* a() b() */ }",
        "\n\nvoid main() { int ab = 0xa;   }");
}

static void what_is_named_stays(void **state)
{
    static const char *const texts[] = {
        "int a() { return 1; }\nint b() { return a(); }\nvoid main() { b(); }\n",
        "int a(int x) { return x; }\nint a(float x) { return 1; }\nvoid main() { a(1); }\n",
        "int a() { return 1; }\n#define A a()\nvoid main() { A; }\n",
        "int a();\nvoid main() { a(); }\nint a()\n{\n    if (true) {\n        return 1;\n    "
        "}\n}\n",
        "int a() { return 1; }\nconst int b[2] = int[2](a(), 2);\nvoid main() { b[0]; }\n",
        "int a()\n{\n#if STP_BOX\n    return 1;\n#else\n    return 2;\n#endif\n}\nvoid main() { "
        "a(); }\n",
    };
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        expect(texts[i], texts[i]);
}

/* Other things with parentheses and braces, and functions that are not plain. */
static void what_is_not_understood_stays(void **state)
{
    static const char *const texts[] = {
        "layout(std430, binding = 1) buffer block {\n    int a[];\n};\nvoid main() {}\n",
        "struct s {\n    int a;\n};\nvoid main() {}\n",
        "layout(local_size_x = 8) in;\nvoid main() {}\n",
        "#if STP_BOX\nint a()\n#else\nint a(int x)\n#endif\n{\n    return 1;\n}\nvoid main() {}\n",
        "int a() {\nvoid main() {}\n",
        "",
        "no shader",
    };
    (void)state;
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        expect(texts[i], texts[i]);
}

static void comments_go(void **state)
{
    (void)state;
    expect("int a; // one\nint b; /* two\n   lines */ int c; /**/ int d;\n",
           "int a; \nint b;  \n int c;   int d;\n");
    expect("int a; /* no end\n", "int a;  \n");
    expect("int a = 4 / 2 * 3;", "int a = 4 / 2 * 3;");
}

/* Of our own shaders, most of what is included goes, and main stays. */
static void our_shaders(void **state)
{
    (void)state;
    for (const stp_shader_file *f = stp_shader_files; f->name != NULL; f++) {
        char *text = NULL;
        if (strstr(f->name, ".glsl"))
            continue;
        check_ok(stp_shader_text(&text, f->name, NULL, NULL, err));
        assert_non_null(strstr(text, "void main()"));
        assert_null(strstr(text, "/*"));
        if (strcmp(f->name, "pull.frag") == 0) {
            assert_non_null(strstr(text, "pixel_unpack("));
            assert_null(strstr(text, "stp_disc_decode("));
        }
        free(text);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unused_functions_go),
        cmocka_unit_test(what_is_named_stays),
        cmocka_unit_test(what_is_not_understood_stays),
        cmocka_unit_test(comments_go),
        cmocka_unit_test(our_shaders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
