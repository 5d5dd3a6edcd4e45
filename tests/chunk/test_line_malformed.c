/* Tests strips and triangles that contradict themselves under right checksums: each must be
 * refused, with the reason. */
#include "tests/fixtures/chunk_reseal.h"
#include "tests/fixtures/line_fixture.h"
#include "tests/support/new_file.h"

#define OUT "test_line_malformed.stipple"
#define CHANGED "test_line_changed.stipple"

/* A raw file of one leaf: a strip of 3 vertices, then one of 70 in two patches. */
typedef struct raw_file {
    uint8_t *bytes;
    size_t size;
    uint8_t *patches, *samples[STP_LEVEL_COUNT];
    uint32_t count[STP_LEVEL_COUNT];
} raw_file;

static raw_file raw_file_make(void)
{
    stp_line_set set = line_set_make(73, 2);
    const stp_prep_params params = {.codec = STP_CODEC_RAW, .format = 1};
    stp_prep_stats stats;
    stp_error err = {0};
    raw_file out = {0};
    set.strips[0] = (stp_line_strip){0, 3, STP_LINE_RIBBON};
    set.strips[1] = (stp_line_strip){3, 70, STP_LINE_RIBBON};
    for (uint64_t i = 0; i < 73; i++) {
        set.vertices[i].position =
            (stp_dvec3){(double)i, sin(0.4 * (double)i), i < 3 ? -20.0 : 0.0};
        set.vertices[i].radius = 0.3f;
        set.vertices[i].direction = (vec3s){{0.0f, 0.0f, 1.0f}};
    }
    if (line_set_run(&set, NULL, OUT, 1, &params, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_line_set_clear(&set);
    FILE *file = fopen(OUT, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    out.size = (size_t)ftell(file);
    rewind(file);
    out.bytes = malloc(out.size);
    assert_non_null(out.bytes);
    assert_int_equal(fread(out.bytes, 1, out.size, file), out.size);
    fclose(file);
    const uint8_t *entry = out.bytes + stp_get_u64(out.bytes + 32);
    assert_int_equal(stp_get_u32(entry + 56), 3);
    out.patches = out.bytes + STP_HEADER_BYTES;
    uint8_t *at = out.patches + 3 * STP_PATCH_BYTES;
    for (int l = STP_LEVEL_COUNT - 1; l >= 0; l--) {
        out.samples[l] = at;
        out.count[l] = stp_get_u32(entry + 60 + 4 * l);
        at += out.count[l] * STP_SAMPLE_BYTES;
    }
    return out;
}

/* The patch with `count` vertices. */
static uint8_t *patch_of(const raw_file *f, unsigned count)
{
    for (int p = 0; p < 3; p++)
        if (f->patches[p * (int)STP_PATCH_BYTES + 16] == count)
            return f->patches + p * (int)STP_PATCH_BYTES;
    fail();
    return NULL;
}

/* The patch's first sample of the level. */
static uint8_t *first_sample(const raw_file *f, const uint8_t *patch, int level)
{
    uint8_t *at = f->samples[level];
    for (const uint8_t *p = f->patches; p < patch; p += STP_PATCH_BYTES)
        at += p[16 + level] * STP_SAMPLE_BYTES;
    return at;
}

static void write_changed(const raw_file *f)
{
    assert_true(write_new_file(CHANGED, f->bytes, f->size));
}

static void verify_changed(const raw_file *f, stp_error *err)
{
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    write_changed(f);
    assert_int_equal(stp_pool_create(&pool, 1, NULL), STP_OK);
    stp_status status = stp_chunk_file_open(&file, CHANGED, err);
    if (status == STP_OK)
        status = stp_chunk_file_verify(file, pool, NULL, err);
    stp_chunk_file_close(&file);
    stp_pool_destroy(&pool);
    if (status != STP_OK)
        assert_int_equal(status, STP_CORRUPT);
    else
        err->message[0] = '\0';
}

typedef void spoiler(raw_file *f);

static void spoil_both(raw_file *f)
{
    patch_of(f, 3)[46] |= STP_PATCH_TRIANGLES;
}

static void spoil_sides(raw_file *f)
{
    patch_of(f, 3)[46] &= (uint8_t)~STP_PATCH_TWO_SIDED;
}

static void spoil_continues(raw_file *f)
{
    uint8_t *patch = patch_of(f, 3);
    patch[46] = STP_PATCH_TWO_SIDED | STP_PATCH_CONTINUES;
}

static void spoil_reserved(raw_file *f)
{
    patch_of(f, 3)[46] |= 64;
}

static void spoil_child(raw_file *f)
{
    patch_of(f, 3)[14] = 0;
}

static void spoil_corners(raw_file *f)
{
    patch_of(f, 64)[46] = STP_PATCH_TWO_SIDED | STP_PATCH_TRIANGLES;
}

static void spoil_tangential(raw_file *f)
{
    patch_of(f, 3)[24] = 9;
}

static void spoil_quarter(raw_file *f)
{
    uint8_t *patch = patch_of(f, 64);
    patch[48] = (uint8_t)(patch[48] - 8); /* the other quarters keep the level's error */
}

static void spoil_kind(raw_file *f)
{
    uint8_t *patch = patch_of(f, 3);
    for (int i = 0; i < 3; i++)
        first_sample(f, patch, 0)[i * 16 + 7] = STP_SAMPLE_HAS_NORMAL;
}

static void spoil_triangle_kind(raw_file *f)
{
    patch_of(f, 3)[46] = STP_PATCH_TWO_SIDED | STP_PATCH_TRIANGLES;
}

static void spoil_mixed(raw_file *f)
{
    uint8_t *sample = first_sample(f, patch_of(f, 64), 0);
    sample[5 * 16 + 7] = STP_SAMPLE_HAS_NORMAL | STP_KIND_TUBE << STP_SAMPLE_KIND_SHIFT;
}

static void spoil_coarse_kind(raw_file *f)
{
    first_sample(f, patch_of(f, 64), 3)[7] = STP_SAMPLE_HAS_NORMAL;
}

static void spoil_vertex(raw_file *f)
{
    uint8_t *sample = first_sample(f, patch_of(f, 64), 1);
    sample[4 * 16] ^= 1;
}

static void spoil_end(raw_file *f)
{
    uint8_t *sample = first_sample(f, patch_of(f, 64), 2);
    memcpy(sample, first_sample(f, patch_of(f, 64), 0) + 16, 16);
}

static void spoil_disc(raw_file *f)
{
    uint8_t *patch = patch_of(f, 64);
    first_sample(f, patch, 3)[6] = (uint8_t)(first_sample(f, patch, 3)[6] - 8);
}

static void spoil_error(raw_file *f)
{
    uint8_t *patch = patch_of(f, 64);
    patch[21] = patch[20];
    memset(patch + 48, patch[20], 4);
}

static void spoil_joint(raw_file *f)
{
    patch_of(f, 64)[46] ^= STP_PATCH_CONTINUED;
}

static void spoil_attribute(raw_file *f)
{
    f->bytes[72] &= (uint8_t)~STP_HAS_LINES;
}

static void contradictions_are_named(void **state)
{
    (void)state;
    static const struct {
        spoiler *spoil;
        const char *message;
    } cases[] = {
        {spoil_both, "it is a strip and triangles"},
        {spoil_sides, "a strip and not two-sided"},
        {spoil_continues, "continues a strip and is no strip"},
        {spoil_reserved, "a reserved flag"},
        {spoil_child, "the child it names does not exist"},
        {spoil_corners, "corners are not three a triangle"},
        {spoil_tangential, "a strip has a tangential error"},
        {spoil_quarter, "unequal errors"},
        {spoil_kind, "no ribbon and no tube"},
        {spoil_triangle_kind, "no polygon's"},
        {spoil_mixed, "of several kinds"},
        {spoil_coarse_kind, "of several kinds"},
        {spoil_vertex, "none of those that it covers"},
        {spoil_end, "none of those that it covers"},
        {spoil_disc, "does not hold it"},
        {spoil_error, "the error of a strip's level exceeds"},
        {spoil_joint, "does not begin where one ends"},
        {spoil_attribute, "a file that says it has none"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_error err = {0};
        raw_file f = raw_file_make();
        cases[i].spoil(&f);
        reseal(f.bytes, f.size, false);
        verify_changed(&f, &err);
        if (!strstr(err.message, cases[i].message))
            fail_msg("case %zu: \"%s\" without \"%s\"", i, err.message, cases[i].message);
        free(f.bytes);
    }
}

/* Other commands than verify make the same checks. */
static void every_command_refuses_it(void **state)
{
    (void)state;
    static const char *const commands[] = {
        "export " CHANGED " -o test_line_changed.ply",
        "convert " CHANGED " -o test_line_converted.stipple --codec zstd",
    };
    raw_file f = raw_file_make();
    spoil_attribute(&f);
    reseal(f.bytes, f.size, false);
    write_changed(&f);
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        char line[512];
        snprintf(line, sizeof line, "\"$STIPPLE\" %s --force -q 2>test_line_said.txt", commands[i]);
        assert_int_equal(system(line), 1 << 8);
        snprintf(line, sizeof line, "grep -q 'a file that says it has none' test_line_said.txt");
        assert_int_equal(system(line), 0);
    }
    free(f.bytes);
}

static void the_file_itself_is_right(void **state)
{
    (void)state;
    stp_error err = {0};
    raw_file f = raw_file_make();
    assert_int_equal(stp_get_u16(f.bytes + 8), 1);
    assert_int_equal(stp_get_u16(f.bytes + 10), 1);
    verify_changed(&f, &err);
    assert_string_equal(err.message, "");
    free(f.bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_file_itself_is_right),
        cmocka_unit_test(contradictions_are_named),
        cmocka_unit_test(every_command_refuses_it),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
