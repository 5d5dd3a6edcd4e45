/* Tests the legends of classes and palettes: their colours are the shaders', names and numbers
 * match, and the legend of classes lists exactly the classes that a model has. */
#include "runtime/class_legend.h"
#include "runtime/colour_range.h"
#include "runtime/gl/shader.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <sys/stat.h>

#define FOLDER "legend-shaders"

/* Computes 256 colours; colour: an expression of i. */
static void shader_colours(const char *colour, stp_palette palette, float found[256][4])
{
    char defines[STP_VARIANT_DEFINES_BYTES], text[512];
    const stp_variant variant = {.geometry_invocations = 1, .palette = (int)palette};
    GLuint program = 0, buffer = 0;
    mkdir(FOLDER, 0777);
    snprintf(text, sizeof text,
             "#include \"layout.glsl\"\n"
             "#include \"palette.glsl\"\n"
             "layout(local_size_x = 1) in;\n"
             "layout(std430, binding = 0) buffer result { vec4 found[256]; };\n"
             "void main()\n{\n"
             "    uint i = gl_WorkGroupID.x;\n"
             "    found[i] = vec4(%s, 1.0);\n"
             "}\n",
             colour);
    scan_fixture_text(FOLDER "/note.comp", text);
    stp_variant_defines(&variant, defines);
    check_ok(stp_program_create(
        &program,
        &(stp_program_params){.compute = "note.comp", .defines = defines, .folder = FOLDER}, err));
    glCreateBuffers(1, &buffer);
    glNamedBufferStorage(buffer, 256 * sizeof *found, NULL, 0);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffer);
    glUseProgram(program);
    glDispatchCompute(256, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffer, 0, 256 * sizeof *found, found);
    check_ok(stp_gl_check("reading the palette", err));
    glDeleteBuffers(1, &buffer);
    glDeleteProgram(program);
}

static void colours(void **state)
{
    (void)state;
    static float found[256][4];
    shader_colours("stp_palette_class(i)", STP_PALETTE_GREY, found);
    for (int i = 0; i < 256; i++) {
        float rgb[3];
        stp_class_colour((uint8_t)i, rgb);
        for (int c = 0; c < 3; c++)
            check_near((double)found[i][c], (double)rgb[c], 1e-6);
    }
}

/* From below 0 to above 1. */
static void palettes(void **state)
{
    (void)state;
    static float found[256][4];
    static const stp_palette list[] = {STP_PALETTE_GREY, STP_PALETTE_VIRIDIS, STP_PALETTE_HEAT};
    for (int p = 0; p < 3; p++) {
        shader_colours("stp_palette_ramp((float(i) - 8.0) / 240.0)", list[p], found);
        for (int i = 0; i < 256; i++) {
            float rgb[3];
            stp_palette_colour(list[p], (i - 8.0) / 240.0, rgb);
            for (int c = 0; c < 3; c++)
                check_near((double)found[i][c], (double)rgb[c], 1e-5);
        }
    }
}

static void names(void **state)
{
    (void)state;
    for (int i = 0; i < 256; i++) {
        const char *name = stp_class_name((uint8_t)i);
        assert_int_equal(name != NULL, i <= 22);
        if (name != NULL)
            assert_int_equal(stp_class_find(name, strlen(name)), i);
    }
    assert_string_equal(stp_class_name(2), "ground");
    assert_string_equal(stp_class_name(18), "high noise");
    assert_int_equal(stp_class_find("High-Vegetation", 15), 5);
    assert_int_equal(stp_class_find("high_vegetation,", 15), 5);
    assert_int_equal(stp_class_find("high", 4), -1);
    assert_int_equal(stp_class_find("groundling", 10), -1);
    assert_int_equal(stp_class_find("", 0), -1);
}

static void of_a_model(void **state)
{
    (void)state;
    stp_prep_stats stats;
    stp_model *model = NULL;
    uint32_t classes[8];
    prep_cloud cloud = prep_cloud_wavy(5000, (stp_dvec3){0.0, 0.0, 0.0}, 1.0);
    for (uint32_t i = 0; i < 5000; i++)
        cloud.points[i].class_id = i % 2 ? 2 : 255;
    check_ok(prep_cloud_run(&cloud, "legend.stipple", 1, NULL, &stats, err));
    check_ok(stp_model_open(&model, "legend.stipple", err));
    check_ok(stp_model_classes(model, classes, err));
    for (int w = 0; w < 8; w++)
        assert_int_equal(classes[w], w == 0 ? 1u << 2 : w == 7 ? 1u << 31 : 0u);
    stp_model_close(&model);
    free(cloud.points);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(colours),
        cmocka_unit_test(palettes),
        cmocka_unit_test(names),
        cmocka_unit_test(of_a_model),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}
