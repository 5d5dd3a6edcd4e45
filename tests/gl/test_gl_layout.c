/* Tests the packed layouts of shaders/layout.glsl and patch.glsl against the C structs of
 * runtime/gl/gpu_layout.h. The uniform block is compared by the driver's own offsets; patches,
 * chunks and samples are decoded from the textures by a shader. */
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/gl_program.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <stddef.h>
#include <sys/stat.h>

#define FOLDER "layout-shaders"

static const char decode[] =
    "#include \"layout.glsl\"\n"
    "#include \"patch.glsl\"\n"
    "bool stp_sample_left_out(uvec4 texel) { return false; }\n"
    "#include \"square.glsl\"\n"
    "layout(local_size_x = 1) in;\n"
    "layout(std430, binding = 0) buffer result { float found[]; };\n"
    "int at = 0;\n"
    "void put(float v) { found[at++] = v; }\n"
    "void put3(vec3 v) { put(v.x); put(v.y); put(v.z); }\n"
    "void put4(vec4 v) { put3(v.xyz); put(v.w); }\n"
    "void main()\n{\n"
    "    put4(axis_right); put4(axis_up); put4(axis_back); put4(viewport); put4(centre); "
    "put4(frustum[0]);\n"
    "    put4(frustum[1]);\n"
    "    put4(quality); put4(terms); put4(colour_range); put4(light); put4(vec4(modes)); "
    "put4(clip_min); "
    "put4(clip_max); put4(planes[0]); put4(planes[5]);\n"
    "    for (int i = 0; i < 8; i++) put(float(hidden[i >> 2][i & 3]));\n"
    "    put4(openings[0]); put4(openings[127]);\n"
    "    stp_chunk c = stp_chunk_fetch(1u);\n"
    "    put3(c.offset); put(float(c.finest)); put(float(c.id));\n"
    "    put(float(c.depth)); put(float(c.order));\n"
    "    put4(vec4(stp_chunk_openings(1u)));\n"
    "    vec4 lattice = stp_lattice_fetch(2u, c.offset);\n"
    "    put3(lattice.xyz - c.offset); put(lattice.w); put(float(stp_patch_slot(2u)));\n"
    "    c.offset = vec3(0.0);\n"
    "    stp_patch p = stp_patch_fetch(2u, c);\n"
    "    put3(p.origin); put(p.step); put3(p.bound_centre); put(p.bound_radius);\n"
    "    put3(p.cone_axis); put(p.cone_cos); put(p.vertex_error.x); put(p.vertex_error.y);\n"
    "    put(p.radius); put4(vec4(p.first)); put4(vec4(p.count));\n"
    "    put(p.variation * 255.0); put(float(p.flags)); put(float(p.finest)); "
    "put(float(STP_PATCH_STRIP)); "
    "put(float(STP_PATCH_TRIANGLES));\n"
    "    put(float(STP_NAME_SEGMENT)); put(float(STP_NAME_TRIANGLE)); "
    "put(float(STP_NAME_RIBBON));\n"
    "put(float(STP_NAME_SQUARE)); put(float(STP_NAME_SAMPLE)); "
    "put(float(STP_NAME_SQUARE_SHIFT)); put(float(STP_NAME_PLACE_SHIFT));\n"
    "    for (int l = 0; l < 4; l++) {\n"
    "        uint name = stp_name_of(2u, l, l < 3 ? 3u : 0u);\n"
    "        put(float(name)); put(float(stp_name_level(name)));\n"
    "        put(float(stp_name_patch(name | STP_NAME_RIBBON)));\n"
    "        put(float(stp_name_number(name | STP_NAME_RIBBON, stp_patch_count(2u))));\n"
    "    }\n"
    "    stp_square s = stp_square_fetch(1u);\n"
    "    put4(s.lattice); put(float(s.mask.x)); put(float(s.mask.y)); put(float(s.patch_index));\n"
    "    stp_square_axes a = stp_square_axes_fetch(1u);\n"
    "    put3(a.column); put3(a.row); put3(a.up); put(float(stp_square_flags(1u)));\n"
    "    for (int i = 0; i < 9; i++)\n"
    "        if (i != 4) put(float(stp_square_beside(1u, ivec2(i % 3, i / 3) - 1)));\n"
    "    mat2x3 g = stp_square_grid_fetch(1u); put3(g[0]); put3(g[1]);\n"
    "    stp_finer q = stp_finer_fetch(2u, p);\n"
    "    put4(q.error_2); put4(q.tangential_2); put4(q.error_1); put4(q.tangential_1);\n"
    "    put3(q.radius); put3(q.variation * 255.0); put(q.error_0.x); put(q.error_0.y);\n"
    "    put(float(stp_patch_samples(2u)));\n"
    "    uint numbers[7] = uint[](0u, 1u, 4u, 5u, 17u, 18u, 67u);\n"
    "    stp_packing packing = stp_packing_fetch(2u);\n"
    "    for (int i = 0; i < 7; i++) {\n"
    "        uvec4 texel = stp_sample_words(packing, numbers[i]);\n"
    "        stp_disc d = stp_disc_decode(texel, vec3(0.0), 0.5);\n"
    "        put(float(texel.y >> 24)); put(d.intensity * 255.0); put(float(d.class_id));\n"
    "        put3(d.position); put3(d.normal); put(d.radius); put3(d.colour);\n"
    "        put(float(d.kind)); put(d.has_normal ? 1.0 : 0.0); put(d.oriented ? 1.0 : 0.0);\n"
    "    }\n"
    "    put(float(at));\n"
    "}\n";

/* Samples of all levels, by their numbers in the patch, that the shader decodes. */
enum { SAMPLES = 7 };
static const uint32_t numbers[SAMPLES] = {0, 1, 4, 5, 17, 18, 67};
/* Where they are in the Object Texture. */
enum { FIRST = 5, TEXELS = FIRST + STP_TEXELS_OF_PATCH + STP_TEXELS_SPARE };

/* The expected values, in the order in which the shader writes them. */
typedef struct expectation {
    double values[512];
    int count;
} expectation;

static void want(expectation *e, double value)
{
    e->values[e->count++] = value;
}

static void want_floats(expectation *e, const float *values, int count)
{
    for (int i = 0; i < count; i++)
        want(e, (double)values[i]);
}

static stp_gpu_frame make_frame(void)
{
    return (stp_gpu_frame){
        .axis_right = {1, 0, 0, 101},
        .axis_up = {0, 1, 0, 102},
        .axis_back = {0, 0, 1, 103},
        .viewport = {4, 5, 6, 7},
        .centre = {31, 32, 33, 34},
        .frustum = {{8, 9, 10, 11}, {35, 36, 37, 38}},
        .quality = {12, 13, 14, 15},
        .terms = {94, 95, 96, 97},
        .colour_range = {71, 72, 73, 74},
        .light = {104, 105, 106, 107},
        .modes = {16, 17, 18, 19},
        .clip_min = {75, 76, 77, 78},
        .clip_max = {79, 80, 81, 82},
        .planes = {{108, 109, 110, 111}, {0}, {0}, {0}, {0}, {112, 113, 114, 115}},
        .hidden = {83, 84, 85, 86, 87, 88, 89, 90},
        .openings = {[0] = {91, 92, 93, 94}, [STP_OPENINGS_LIMIT - 1] = {95, 96, 97, 98}}};
}

/* The second patch of a block, as the file has it. Its block is resident from patch 1 on. */
static const stp_patch patch = {
    .origin = {21, -22, 1 << 20},
    .exponent = -3,
    .cone_angle = 32,
    .counts = {50, 13, 4, 1},
    .error = {35, 0, 0, 33},
    .tangential_error = {36, 0, 0, 0},
    .colour_error = {98, 99, 100, 255},
    .radius = {41, 42, 43, 44},
    .bound_centre = {25, 65535, 27},
    .bound_radius = 28,
    .cone_axis = {29, 230, 31},
    .flags = STP_PATCH_STRIP | STP_PATCH_CLOSED,
    .quarter_error = {{51, 52, 53, 54}, {55, 56, 57, 58}},
    .quarter_tangential_error = {{59, 60, 61, 62}, {63, 64, 65, 255}},
};
#define SLOT 0x345678u
/* Its number in the Object Texture, one after the block's first patch. */
#define NUMBER 2u
static uint32_t begin[STP_LEVEL_COUNT][3] = {{0, 1, 51}, {0, 1, 14}, {0, 1, 5}, {0, 1, 2}};

/* Fills in the patch for the GPU and for the CPU, and its samples. */
static void make_patch(stp_gpu_patch *out, stp_mirror_patch *mirror, uint64_t *texels,
                       const stp_sample *samples)
{
    stp_patch patches[2] = {{.counts = {1, 1, 1, 1}}, patch};
    stp_sample levels[STP_LEVEL_COUNT][51] = {{{.radius = 0}}};
    const stp_chunk chunk = {.patches = patches,
                             .patch_count = 2,
                             .level_begin = {begin[0], begin[1], begin[2], begin[3]},
                             .samples = {levels[0], levels[1], levels[2], levels[3]}};
    const stp_placement placement = {.patches = {NUMBER - 1, 2}};
    stp_mirror_patch both[2];
    for (int i = 0; i < SAMPLES; i++) {
        const int level = 3 - (i + 1) / 2;
        levels[level][1 + numbers[i] - stp_level_number(50, level)] = samples[i];
    }
    stp_gpu_patches_fill(out + NUMBER - 1, &chunk, SLOT, STP_PATCH_STRIP);
    stp_mirror_patches_fill(both, &chunk, &placement, STP_PATCH_STRIP);
    assert_in_range(stp_texels_write(texels + FIRST, &chunk, 1), 1, STP_TEXELS_OF_PATCH);
    out[NUMBER].first = FIRST;
    *mirror = both[1];
    assert_int_equal(mirror->number, NUMBER);
}

static void want_sample(expectation *e, const stp_sample *sample)
{
    static const stp_patch lattice = {.exponent = -1};
    stp_dvec3 p = stp_sample_position(sample, &lattice);
    vec3s n = stp_normal_decode(sample->normal);
    want(e, sample->flags);
    want(e, sample->intensity);
    want(e, sample->class_id);
    const unsigned both = STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL;
    want(e, p.x);
    want(e, p.y);
    want(e, p.z);
    want_floats(e, n.raw, 3);
    want(e, stp_sample_radius(sample, &lattice));
    for (int k = 0; k < 3; k++)
        want(e, sample->rgb[k] / 255.0);
    want(e, (sample->flags & STP_SAMPLE_KIND_MASK) >> STP_SAMPLE_KIND_SHIFT);
    want(e, (sample->flags & STP_SAMPLE_HAS_NORMAL) != 0);
    want(e, (sample->flags & both) == both);
}

static const stp_gpu_square square = {.origin = {121, 122, 123},
                                      .step = 124,
                                      .samples = {125, 126},
                                      .patch = 128,
                                      .column = {129, 130},
                                      .row = {131, 132},
                                      .up = {133, 134},
                                      .axis = 1,
                                      .flags = STP_SQUARE_OVERLAPS | STP_SQUARE_OF_MAP,
                                      .beside = {141, 142, 143, 144, 145, 146, 147, 148},
                                      .to_column = {149, 150, 151},
                                      .to_row = {152, 153, 154}};

/* Heights go along y, and the axes that follow it are z and x. */
static void want_across(expectation *e, const float across[2], double up)
{
    want(e, (double)across[1]);
    want(e, up);
    want(e, (double)across[0]);
}

static void want_square(expectation *e)
{
    want_floats(e, square.origin, 3);
    want(e, (double)square.step);
    want(e, square.samples[0]);
    want(e, square.samples[1]);
    want(e, square.patch);
    want_across(e, square.column, 0.0);
    want_across(e, square.row, 0.0);
    want_across(e, square.up, 1.0);
    want(e, square.flags);
    for (int i = 0; i < 8; i++)
        want(e, square.beside[i]);
    want_floats(e, square.to_column, 3);
    want_floats(e, square.to_row, 3);
}

static void want_frame(expectation *e, const stp_gpu_frame *frame)
{
    want_floats(e, frame->axis_right, 4);
    want_floats(e, frame->axis_up, 4);
    want_floats(e, frame->axis_back, 4);
    want_floats(e, frame->viewport, 4);
    want_floats(e, frame->centre, 4);
    want_floats(e, frame->frustum[0], 4);
    want_floats(e, frame->frustum[1], 4);
    want_floats(e, frame->quality, 4);
    want_floats(e, frame->terms, 4);
    want_floats(e, frame->colour_range, 4);
    want_floats(e, frame->light, 4);
    for (int i = 0; i < 4; i++)
        want(e, frame->modes[i]);
    want_floats(e, frame->clip_min, 4);
    want_floats(e, frame->clip_max, 4);
    want_floats(e, frame->planes[0], 4);
    want_floats(e, frame->planes[5], 4);
    for (int i = 0; i < STP_CLASS_WORDS; i++)
        want(e, frame->hidden[i]);
    want_floats(e, frame->openings[0], 4);
    want_floats(e, frame->openings[STP_OPENINGS_LIMIT - 1], 4);
}

static void want_chunk(expectation *e, const stp_gpu_chunk *chunk)
{
    want_floats(e, chunk->offset, 3);
    want(e, chunk->finest);
    want(e, chunk->id);
    want(e, chunk->depth);
    want(e, chunk->order);
    for (int i = 0; i < 4; i++)
        want(e, chunk->openings[i]);
}

static void want_patch(expectation *e, const stp_mirror_patch *mirror)
{
    want_floats(e, mirror->origin, 3); /* of the lattice */
    want(e, (double)mirror->step);
    want(e, SLOT);
    want_floats(e, mirror->origin, 3);
    want(e, (double)mirror->step);
    want_floats(e, mirror->bound_centre, 3);
    want(e, (double)mirror->bound_radius);
    want_floats(e, mirror->cone_axis, 3);
    want(e, (double)mirror->cone_cos);
    want_floats(e, mirror->vertex_error, 2);
    want(e, (double)mirror->radius[3]);
    for (int i = 0; i < 4; i++)
        want(e, stp_level_number(50, i));
    for (int i = 0; i < 4; i++)
        want(e, mirror->count[i]);
    want(e, mirror->colour_error[3]);
    want(e, mirror->flags | STP_GPU_PATCH_APART);
    want(e, mirror->finest);
}

/* The fourth sample of levels 0 to 2, and that of level 3. */
static void want_names(expectation *e)
{
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        const uint32_t i = l < 3 ? 3 : 0, name = stp_name_of(NUMBER, l, i);
        assert_int_equal(stp_name_level(name), l);
        want(e, name);
        want(e, l);
        want(e, NUMBER);
        want(e, stp_level_number(50, l) + i);
    }
}

static expectation expect_all(const stp_gpu_frame *frame, const stp_gpu_chunk *chunk,
                              const stp_mirror_patch *mirror, const stp_sample *samples)
{
    expectation e = {.count = 0};
    want_frame(&e, frame);
    want_chunk(&e, chunk);
    want_patch(&e, mirror);
    want(&e, STP_PATCH_STRIP);
    want(&e, STP_PATCH_TRIANGLES);
    want(&e, STP_NAME_SEGMENT);
    want(&e, STP_NAME_TRIANGLE);
    want(&e, STP_NAME_RIBBON);
    want(&e, STP_NAME_SQUARE);
    want(&e, STP_NAME_SAMPLE);
    want(&e, STP_NAME_SQUARE_SHIFT);
    want(&e, STP_NAME_PLACE_SHIFT);
    want_names(&e);
    want_square(&e);
    want_floats(&e, mirror->quarter_error[0][0], 16);
    want_floats(&e, mirror->radius, 3);
    for (int l = 0; l < 3; l++)
        want(&e, mirror->colour_error[l]);
    want_floats(&e, mirror->finest_error, 2);
    want(&e, FIRST);
    for (int i = 0; i < SAMPLES; i++)
        want_sample(&e, &samples[i]);
    want(&e, e.count);
    return e;
}

static const stp_gpu_chunk chunks[2] = {{.finest = 9},
                                        {.offset = {51, 52, 53},
                                         .finest = 2,
                                         .id = 56,
                                         .depth = 57,
                                         .order = 58,
                                         .openings = {1, 2, 4, 8}}};

static const stp_sample samples[SAMPLES] = {
    {{1, 65535, 3},
     200,
     STP_SAMPLE_HAS_NORMAL | 2u << STP_SAMPLE_KIND_SHIFT,
     {1, 2, 3},
     5,
     {255, 1, 128},
     7},
    {{65535, 2, 40000},
     0,
     STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL,
     {250, 240, 230},
     255,
     {0, 200, 3},
     255},
    {{9, 8, 7},
     255,
     STP_SAMPLE_ORIENTED | 1u << STP_SAMPLE_KIND_SHIFT,
     {0, 255, 15},
     0,
     {9, 8, 7},
     0},
    {{4095, 1, 2050},
     200,
     STP_SAMPLE_HAS_NORMAL | STP_FIT_GIVEN << STP_SAMPLE_FIT_SHIFT,
     {0xab, 0xcd, 0xef},
     0,
     {255, 1, 128},
     0},
    {{2, 4094, 4093},
     1,
     STP_SAMPLE_HAS_NORMAL | STP_SAMPLE_ORIENTED | STP_SAMPLE_CLOSED |
         STP_FIT_WIDE << STP_SAMPLE_FIT_SHIFT,
     {0x5a, 0x3c, 0x21},
     0,
     {3, 254, 77},
     0},
    {{0, 0, 65535}, 0, 0xff, {255, 255, 255}, 255, {255, 255, 255}, 255},
    {{32768, 32767, 1}, 1, 0, {0, 8, 128}, 128, {127, 128, 129}, 128}};

static void shaders_read_what_c_writes(void **state)
{
    (void)state;
    stp_gpu_frame frame = make_frame();
    stp_gpu_patch patches[3] = {{.step = 9}};
    stp_mirror_patch mirror;
    stp_gpu_code codes[STP_GPU_CODES];
    uint64_t texels[TEXELS] = {0};
    make_patch(patches, &mirror, texels, samples);
    stp_gpu_codes_fill(codes);
    const stp_gpu_square squares[2] = {{.step = 9}, square};
    GLuint buffers[7];
    float found[512];
    GLuint program = gl_program_compute(decode, FOLDER);
    buffers[0] = gl_program_texture(texels, sizeof texels, STP_UNIT_OBJECT_TEXTURE, GL_RG32UI);
    buffers[1] = gl_program_texture(patches, sizeof patches, STP_UNIT_PATCHES, GL_RGBA32UI);
    buffers[2] = gl_program_texture(chunks, sizeof chunks, STP_UNIT_CHUNKS, GL_RGBA32UI);
    buffers[5] = gl_program_texture(squares, sizeof squares, STP_UNIT_SQUARES, GL_RGBA32UI);
    buffers[6] = gl_program_texture(codes, sizeof codes, STP_UNIT_CODES, GL_RGBA32F);
    glCreateBuffers(2, buffers + 3);
    glNamedBufferStorage(buffers[3], sizeof frame, &frame, 0);
    glNamedBufferStorage(buffers[4], sizeof found, NULL, 0);
    glBindBufferBase(GL_UNIFORM_BUFFER, 0, buffers[3]);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffers[4]);
    glUseProgram(program);
    glDispatchCompute(1, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffers[4], 0, sizeof found, found);
    check_ok(stp_gl_check("decoding", err));
    expectation e = expect_all(&frame, &chunks[1], &mirror, samples);
    for (int i = 0; i < e.count; i++)
        if (!(fabs((double)found[i] - e.values[i]) <= 1e-6 * fmax(1.0, fabs(e.values[i]))))
            fail_msg("value %d is %.9g, expected %.9g", i, (double)found[i], e.values[i]);
    glDeleteBuffers(7, buffers);
    glDeleteProgram(program);
}

/* An include stands on one line: nothing of the lines before or after it belongs to it. */
static void includes_are_lines(void **state)
{
    char *text = NULL;
    (void)state;
    mkdir(FOLDER, 0777);
    scan_fixture_text(FOLDER "/inner.glsl", "inner\n");
    scan_fixture_text(FOLDER "/outer.glsl",
                      "first\n\n#include \"inner.glsl\"\n#\ninclude \"none.glsl\"\nlast");
    check_ok(stp_shader_text(&text, "outer.glsl", NULL, FOLDER, err));
    assert_string_equal(text, "#version 450 core\n#line 1 0\nfirst\n\n#line 1 1\ninner\n\n"
                              "#line 4 0\n#\ninclude \"none.glsl\"\nlast\n");
    free(text);
}

/* A driver's cache finds a program by its text: one text for all values of a macro it does not use.
 */
static void texts_have_only_macros_they_mention(void **state)
{
    static const struct {
        const char *name;
        bool differs;
    } files[] = {{"screen.vert", false}, {"id.frag", false}, {"pull.frag", true}};
    (void)state;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char *texts[2];
        for (int k = 0; k < 2; k++) {
            const stp_variant one = {.geometry_invocations = 1, .orthographic = k};
            char defines[STP_VARIANT_DEFINES_BYTES];
            stp_variant_defines(&one, defines);
            check_ok(stp_shader_text(&texts[k], files[i].name, defines, NULL, err));
        }
        assert_int_equal(strcmp(texts[0], texts[1]) != 0, files[i].differs);
        free(texts[0]);
        free(texts[1]);
    }
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(texts_have_only_macros_they_mention),
        cmocka_unit_test(shaders_read_what_c_writes),
        cmocka_unit_test(includes_are_lines),
    };
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}
