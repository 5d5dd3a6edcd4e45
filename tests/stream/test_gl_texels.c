/* Tests how samples become texels of the Object Texture: C and shaders read back what was written,
 * bit for bit, and it takes no more texels than its differences need. */
#include "runtime/stream/cache/object_texture.h"
#include "tests/fixtures/any_chunk.h"
#include "tests/fixtures/gl_fixture.h"
#include "tests/fixtures/gl_program.h"

enum { PATCHES = 200, NUMBERS = STP_TEXELS_PACKED_LIMIT + 1 };

static uint64_t texels[PATCHES * STP_TEXELS_OF_PATCH + STP_TEXELS_SPARE];

/* Random samples, of which each patch keeps other bits: from all to none. */
static stp_chunk *make_chunk(int finest)
{
    stp_chunk *chunk = any_chunk(PATCHES, STP_PATCH_SAMPLES, 7, 0);
    chunk->finest_level = finest;
    for (uint32_t p = 0; p < PATCHES; p++) {
        uint64_t keep[2];
        for (int k = 0; k < 2; k++) {
            const uint64_t r = stp_random_u64(23, 3 * p + (uint64_t)k);
            keep[k] = p % 4 == 0 ? UINT64_MAX : r & (p % 4 == 1 ? r >> 7 : UINT64_MAX);
            keep[k] &= p % 4 == 3 ? stp_random_u64(29, p) : UINT64_MAX;
        }
        keep[0] &= p % 4 == 2 ? ~(UINT64_C(0x10001) * (255 >> p % 8)) : UINT64_MAX;
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            for (uint32_t i = chunk->level_begin[l][p]; i < chunk->level_begin[l][p + 1]; i++) {
                uint64_t words[2];
                memcpy(words, &chunk->samples[l][i], sizeof words);
                words[0] &= keep[0];
                words[1] &= keep[1];
                memcpy(&chunk->samples[l][i], words, sizeof words);
            }
        memcpy(chunk->patches[p].radius, &keep[1], sizeof chunk->patches[p].radius);
        if (p % 3 != 0) /* its bound lies around its vertex */
            memcpy(chunk->patches[p].bound_centre, chunk->samples[3][p].position,
                   sizeof chunk->patches[p].bound_centre);
    }
    return chunk;
}

/* Writes all patches and tells where each begins. Each takes no more than it may. */
static void write_all(const stp_chunk *chunk, uint32_t first[PATCHES + 1])
{
    first[0] = 0;
    for (uint32_t p = 0; p < PATCHES; p++) {
        uint64_t samples = 0;
        const uint32_t count = stp_texels_write(&texels[first[p]], chunk, p);
        for (int l = chunk->finest_level; l < STP_LEVEL_COUNT; l++)
            samples += chunk->level_begin[l][p + 1] - chunk->level_begin[l][p];
        assert_in_range(count, 2, stp_texels_most(samples, 1));
        assert_in_range(count, 2, STP_TEXELS_OF_PATCH);
        if (chunk->finest_level == 3)
            assert_int_equal(count, 2 + (p % 3 == 0)); /* make_chunk */
        first[p + 1] = first[p] + count;
    }
}

/* Compares words of samples, by number, with those of a patch that are there. */
static void compare(const stp_chunk *chunk, uint32_t patch, const stp_sample found[NUMBERS])
{
    for (int l = chunk->finest_level; l < STP_LEVEL_COUNT; l++) {
        const uint32_t begin = chunk->level_begin[l][patch];
        const uint32_t number = stp_level_number(chunk->patches[patch].counts[0], l);
        for (uint32_t i = begin; i < chunk->level_begin[l][patch + 1]; i++)
            assert_memory_equal(&found[number + i - begin], &chunk->samples[l][i],
                                sizeof(stp_sample));
    }
}

static void c_reads_what_was_written(void **state)
{
    (void)state;
    for (int finest = 0; finest < STP_LEVEL_COUNT; finest++) {
        stp_chunk *chunk = make_chunk(finest);
        uint32_t first[PATCHES + 1];
        stp_gpu_patch patches[PATCHES];
        write_all(chunk, first);
        stp_gpu_patches_fill(patches, chunk, 0, 0);
        for (uint32_t p = 0; p < PATCHES; p++) {
            const stp_patch *patch = &chunk->patches[p];
            stp_sample found[NUMBERS + 1];
            const uint32_t end = stp_level_number(patch->counts[0], finest) + patch->counts[finest];
            for (uint32_t n = 0; n < end; n++)
                assert_true(stp_texels_read(&texels[first[p]], &patches[p], n, &found[n]));
            if (finest > 0)
                assert_false(stp_texels_read(&texels[first[p]], &patches[p], end, &found[end]));
            compare(chunk, p, found);
        }
        stp_chunk_destroy(&chunk);
    }
}

static const char decode[] =
    "#include \"layout.glsl\"\n"
    "#include \"patch.glsl\"\n"
    "layout(local_size_x = 85) in;\n"
    "layout(std430, binding = 0) buffer result { uvec4 found[]; };\n"
    "void main()\n{\n"
    "    uint number = gl_LocalInvocationID.x;\n"
    "    stp_packing packing = stp_packing_fetch(gl_WorkGroupID.x);\n"
    "    found[gl_GlobalInvocationID.x] = stp_sample_words(packing, number);\n"
    "}\n";

static void shaders_read(GLuint program, int finest)
{
    static stp_sample found[PATCHES][NUMBERS];
    static stp_gpu_patch patches[PATCHES];
    stp_chunk *chunk = make_chunk(finest);
    uint32_t first[PATCHES + 1];
    GLuint buffers[3];
    write_all(chunk, first);
    stp_gpu_patches_fill(patches, chunk, 0, 0);
    for (uint32_t p = 0; p < PATCHES; p++)
        patches[p].first = first[p];
    buffers[0] = gl_program_texture(texels, sizeof texels, STP_UNIT_OBJECT_TEXTURE, GL_RG32UI);
    buffers[1] = gl_program_texture(patches, sizeof patches, STP_UNIT_PATCHES, GL_RGBA32UI);
    glCreateBuffers(1, &buffers[2]);
    glNamedBufferStorage(buffers[2], sizeof found, NULL, 0);
    glBindBufferBase(GL_SHADER_STORAGE_BUFFER, 0, buffers[2]);
    glUseProgram(program);
    glDispatchCompute(PATCHES, 1, 1);
    glMemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT);
    glGetNamedBufferSubData(buffers[2], 0, sizeof found, found);
    check_ok(stp_gl_check("decoding", err));
    for (uint32_t p = 0; p < PATCHES; p++)
        compare(chunk, p, found[p]);
    glDeleteBuffers(3, buffers);
    stp_chunk_destroy(&chunk);
}

static void shaders_read_what_was_written(void **state)
{
    (void)state;
    GLuint program = gl_program_compute(decode, "texels-shaders");
    for (int finest = 0; finest < STP_LEVEL_COUNT; finest++)
        shaders_read(program, finest);
    glDeleteProgram(program);
}

/* A patch of 64 samples like their vertex, each with one field that differs; returns the texels. */
static uint32_t texels_of(const stp_sample *other)
{
    enum { COUNT = STP_PATCH_SAMPLES };
    uint32_t begin[STP_LEVEL_COUNT][2] = {{0, COUNT}, {0, COUNT / 4}, {0, COUNT / 16}, {0, 1}};
    stp_sample samples[COUNT] = {{.radius = 0}}, vertex = {.radius = 0};
    stp_patch patch = {.counts = {COUNT, COUNT / 4, COUNT / 16, 1}};
    const stp_chunk chunk = {.patch_count = 1,
                             .patches = &patch,
                             .level_begin = {begin[0], begin[1], begin[2], begin[3]},
                             .samples = {samples, samples, samples, &vertex}};
    samples[0] = *other;
    return stp_texels_write(texels, &chunk, 0);
}

/* The texels of 84 samples of so many bits each, behind the head of a patch whose bound lies around
 * its vertex. */
static uint32_t texels_of_bits(unsigned bits)
{
    return STP_TEXELS_HEAD - 1 + (84 * bits + 63) / 64;
}

static void samples_take_the_bits_that_they_need(void **state)
{
    (void)state;
    assert_int_equal(texels_of(&(stp_sample){.radius = 0}), texels_of_bits(0));
    for (int bits = 1; bits <= 16; bits++) {
        const uint16_t least = (uint16_t) - (1 << (bits - 1)), most = (uint16_t)~least;
        assert_int_equal(texels_of(&(stp_sample){.position = {0, 0, least}}),
                         texels_of_bits((unsigned)bits));
        /* zero lies at an end of the range of z */
        if (bits > 1)
            assert_int_equal(texels_of(&(stp_sample){.position = {0, 0, most}}),
                             texels_of_bits((unsigned)bits - 1));
    }
    /* steps along x and y are shifted together, those of normals, too; flags and classes are
     * compared bit by bit */
    assert_int_equal(texels_of(&(stp_sample){.position = {256, 0, 0}}), texels_of_bits(2));
    assert_int_equal(texels_of(&(stp_sample){.position = {128, 64, 0}}), texels_of_bits(5));
    assert_int_equal(texels_of(&(stp_sample){.normal = {0, 0, 4}}), texels_of_bits(2));
    assert_int_equal(texels_of(&(stp_sample){.normal = {0, 0, 12}}), texels_of_bits(3));
    /* that of u, too */
    assert_int_equal(texels_of(&(stp_sample){.normal = {0, 4, 0}}), texels_of_bits(1));
    assert_int_equal(texels_of(&(stp_sample){.normal = {192, 0, 0}}), texels_of_bits(2));
    assert_int_equal(texels_of(&(stp_sample){.flags = STP_SAMPLE_FIT_MASK}), texels_of_bits(2));
    assert_int_equal(texels_of(&(stp_sample){.class_id = 6}), texels_of_bits(3));
    assert_int_equal(texels_of(&(stp_sample){.radius = 255}), texels_of_bits(1));
    /* radii are shifted by two, or not at all */
    assert_int_equal(texels_of(&(stp_sample){.radius = 252}), texels_of_bits(1));
    assert_int_equal(texels_of(&(stp_sample){.radius = 248}), texels_of_bits(2));
    assert_int_equal(texels_of(&(stp_sample){.radius = 254}), texels_of_bits(2));
    assert_int_equal(texels_of(&(stp_sample){.rgb = {0, 255, 0}}), texels_of_bits(1));
}

/* What is left of a patch after another took its place may be any bits. */
static void other_bits_are_refused_or_read(void **state)
{
    (void)state;
    uint64_t bits[STP_TEXELS_OF_PATCH + STP_TEXELS_SPARE];
    int refused = 0;
    for (uint64_t i = 0; i < 2000; i++) {
        stp_sample s;
        const stp_gpu_patch patch = {.flags = (uint8_t)i, .count = (uint8_t)(i * 31)};
        for (size_t k = 0; k < sizeof bits / sizeof *bits; k++)
            bits[k] = stp_random_u64(i, k);
        refused += !stp_texels_read(bits, &patch, (uint32_t)i % 150, &s);
    }
    assert_in_range(refused, 1000, 1999);
}

int main(void)
{
    stp_gl_context *context = gl_fixture_context();
    const struct CMUnitTest tests[] = {cmocka_unit_test(c_reads_what_was_written),
                                       cmocka_unit_test(shaders_read_what_was_written),
                                       cmocka_unit_test(samples_take_the_bits_that_they_need),
                                       cmocka_unit_test(other_bits_are_refused_or_read)};
    int failed = cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
    stp_gl_context_destroy(&context);
    return failed;
}
