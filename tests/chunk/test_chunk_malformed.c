/* Tests invalid chunk files: cut, with flipped bits, hostile, too new. Each must be refused with a
 * message that names the file, and without harm. */
#include "tests/fixtures/chunk_fixture.h"

#include "formats/chunk/metadata_check.h"
#include "formats/chunk/verify/verify.h"
#include "tests/fixtures/chunk_reseal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>

#include <cmocka.h>

/* A small whole file in memory. Tests change it and write it again. */
typedef struct sample_file {
    uint8_t *bytes;
    size_t size;
} sample_file;

static sample_file write_and_read(fixture_tree *tree, stp_codec codec)
{
    sample_file out;
    const char *path = fixture_path("small.stipple");
    assert_int_equal(fixture_write(tree, path, codec, NULL), STP_OK);
    out.bytes = fixture_read_file(path, &out.size);
    fixture_destroy(tree);
    return out;
}

static sample_file small_file(stp_codec codec)
{
    fixture_tree tree;
    fixture_tree_of_seven(&tree, 2, 6);
    return write_and_read(&tree, codec);
}

static sample_file smallest_file(void)
{
    fixture_tree tree;
    fixture_single(&tree, 2, 6);
    return write_and_read(&tree, STP_CODEC_DRACO);
}

/* Opens the file and reads every chunk; returns the first failure. */
static stp_status read_all(const char *path, stp_error *err)
{
    stp_chunk_file *file = NULL;
    stp_status status = stp_chunk_file_open(&file, path, err);
    if (status != STP_OK) {
        assert_null(file);
        return status;
    }
    uint32_t count = stp_chunk_file_get_info(file)->chunk_count;
    for (uint32_t id = 0; status == STP_OK && id < count; id++) {
        stp_chunk *chunk = NULL;
        status = stp_chunk_file_read(file, id, 0, &chunk, err);
        assert_true((status == STP_OK) == (chunk != NULL));
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    return status;
}

static stp_status read_bytes(const uint8_t *bytes, size_t size, stp_error *err)
{
    const char *path = fixture_path("changed.stipple");
    fixture_write_file(path, bytes, size);
    return read_all(path, err);
}

static void test_truncated(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_DRACO);
    for (size_t size = 0; size < f.size; size++) {
        stp_error err = {0};
        stp_status status = read_bytes(f.bytes, size, &err);
        /* The magic ends in a zero byte, so its first seven bytes already tell a chunk file from
         * others. */
        assert_int_equal(status, size < 7 ? STP_FORMAT : STP_CORRUPT);
        assert_non_null(strstr(err.message, "changed.stipple"));
    }
    free(f.bytes);
}

static void test_extended(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_DRACO);
    uint8_t *longer = calloc(f.size + 1, 1);
    assert_non_null(longer);
    memcpy(longer, f.bytes, f.size);
    assert_int_equal(read_bytes(longer, f.size + 1, NULL), STP_CORRUPT);
    free(longer);
    free(f.bytes);
}

/* A checksum covers every byte, so each flipped bit is found. */
static void test_flipped_bits(void **state)
{
    (void)state;
    sample_file f = smallest_file();
    for (size_t bit = 0; bit < f.size * 8; bit++) {
        stp_error err = {0};
        f.bytes[bit / 8] = (uint8_t)(f.bytes[bit / 8] ^ 1u << bit % 8);
        stp_status status = read_bytes(f.bytes, f.size, &err);
        f.bytes[bit / 8] = (uint8_t)(f.bytes[bit / 8] ^ 1u << bit % 8);
        assert_true(status == STP_CORRUPT || (bit < 64 && status == STP_FORMAT) ||
                    (bit >= 64 && bit < 80 && status == STP_VERSION));
        assert_non_null(strstr(err.message, "changed.stipple: "));
    }
    assert_int_equal(read_bytes(f.bytes, f.size, NULL), STP_OK);
    free(f.bytes);
}

static void test_newer_major(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_DRACO);
    stp_error err = {0};
    stp_put_u16(f.bytes + 8, STP_CHUNK_FILE_MAJOR + 1);
    reseal(f.bytes, f.size, false);
    assert_int_equal(read_bytes(f.bytes, f.size, &err), STP_VERSION);
    assert_non_null(strstr(err.message, "version 3.0"));
    assert_non_null(strstr(err.message, "use a newer stipple"));
    free(f.bytes);
}

static void test_other_files(void **state)
{
    (void)state;
    stp_error err = {0};
    assert_int_equal(read_bytes((const uint8_t *)"", 0, &err), STP_FORMAT);
    assert_int_equal(read_bytes((const uint8_t *)"ply\nformat ascii 1.0\n", 21, &err), STP_FORMAT);
    assert_int_equal(read_all(fixture_path("absent.stipple"), &err), STP_NOT_FOUND);
    assert_int_equal(read_all(fixture_path(""), &err), STP_IO);
}

/* ---- wrong numbers under right checksums ---- */

typedef struct wrong_number {
    int place; /* byte in the header, or, from ENTRY on, in the directory entry of chunk 1 */
    int bytes;
    uint64_t value;
} wrong_number;

#define ENTRY 1000
#define NAN32 0x7fc00000u
#define INF64 0x7ff0000000000000u
#define FAR32 0x5ae35fa9u /* 3.2e16 */
#define MINUS_ONE32 0xbf800000u

static const wrong_number wrong_numbers[] = {
    {12, 4, 0},
    {12, 4, 255},
    {12, 4, UINT32_MAX},
    {16, 4, 0},
    {16, 4, 6},
    {16, 4, 8},
    {16, 4, UINT32_MAX},
    {20, 4, 0},
    {20, 4, 65},
    {24, 4, 0},
    {24, 4, 255},
    {24, 4, UINT32_MAX},
    {28, 4, 0},
    {28, 4, 2},
    {28, 4, UINT32_MAX},
    {32, 8, 0},
    {32, 8, UINT64_MAX},
    {40, 8, 0},
    {40, 8, UINT64_MAX - 40},
    {48, 8, 0},
    {48, 8, UINT64_MAX},
    {56, 8, 0},
    {64, 8, 0},
    {64, 8, UINT64_MAX},
    {76, 4, 99},
    {80, 8, 0},
    {80, 8, INF64},
    {88, 8, INF64},
    {112, 8, 0},
    {136, 4, 1},
    {144, 8, 0},
    {144, 8, UINT64_MAX},
    {ENTRY, 8, 0},
    {ENTRY, 8, UINT64_MAX},
    {ENTRY + 8, 4, UINT32_MAX},
    {ENTRY + 12, 4, 0},
    {ENTRY + 16, 4, UINT32_MAX},
    {ENTRY + 20, 4, 1},
    {ENTRY + 20, 4, UINT32_MAX},
    {ENTRY + 48, 4, 0},
    {ENTRY + 48, 4, 6},
    {ENTRY + 48, 4, UINT32_MAX},
    {ENTRY + 52, 4, 0},
    {ENTRY + 52, 4, 65},
    {ENTRY + 52, 4, UINT32_MAX},
    {ENTRY + 56, 4, 0},
    {ENTRY + 56, 4, UINT32_MAX},
    {ENTRY + 60, 4, 0},
    {ENTRY + 60, 4, 65537},
    {ENTRY + 60, 4, 5},
    {ENTRY + 64, 4, 1},
    {ENTRY + 72, 4, 0},
    {ENTRY + 76, 1, 7},
    {ENTRY + 77, 1, 0},
    {ENTRY + 77, 1, 2},
    {ENTRY + 77, 1, 255},
    {ENTRY + 80, 8, 0},
    {ENTRY + 80, 8, UINT64_MAX},
    {ENTRY + 88, 8, INF64},
    {ENTRY + 112, 4, NAN32},
    {ENTRY + 124, 4, 0xff000000u},
    {ENTRY + 136, 4, NAN32},
    {ENTRY + 148, 4, MINUS_ONE32},
    {ENTRY + 152, 4, NAN32},
    {ENTRY + 168, 4, MINUS_ONE32},
    {ENTRY + 184, 4, NAN32},
    {ENTRY + 200, 4, 0x7f000000u},
    {ENTRY + 152, 4, FAR32},
    {ENTRY + 180, 4, FAR32},
    {ENTRY + 204, 4, NAN32},
};

static void put_number(uint8_t *bytes, const wrong_number *wrong)
{
    size_t directory = (size_t)stp_get_u64(bytes + 32);
    size_t place = wrong->place < ENTRY
                       ? (size_t)wrong->place
                       : directory + STP_ENTRY_BYTES + (size_t)(wrong->place - ENTRY);
    for (int i = 0; i < wrong->bytes; i++)
        bytes[place + (size_t)i] = (uint8_t)(wrong->value >> (8 * i));
}

static void test_wrong_numbers(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_DRACO);
    uint8_t *copy = malloc(f.size);
    assert_non_null(copy);
    for (size_t i = 0; i < sizeof wrong_numbers / sizeof *wrong_numbers; i++) {
        stp_error err = {0};
        memcpy(copy, f.bytes, f.size);
        put_number(copy, &wrong_numbers[i]);
        reseal(copy, f.size, false);
        if (wrong_numbers[i].place == 56)
            stp_put_u64(copy + 56, 0), stp_put_u64(copy + 248, stp_hash(copy, 248));
        stp_status status = read_bytes(copy, f.size, &err);
        if (status == STP_OK)
            print_error("accepted: place %d value %llu\n", wrong_numbers[i].place,
                        (unsigned long long)wrong_numbers[i].value);
        assert_int_not_equal(status, STP_OK);
        assert_true(status == STP_CORRUPT || status == STP_UNSUPPORTED);
    }
    free(copy);
    free(f.bytes);
}

/* A chunk with a payload of no byte at all; fuzzing found it. */
static void test_empty_payload(void **state)
{
    (void)state;
    for (int codec = 0; codec <= STP_CODEC_ZSTD; codec++) {
        sample_file f = small_file((stp_codec)codec);
        stp_error err = {0};
        memset(f.bytes + stp_get_u64(f.bytes + 32) + 8, 0, 12);
        reseal(f.bytes, f.size, false);
        assert_int_equal(read_bytes(f.bytes, f.size, &err), STP_CORRUPT);
        assert_non_null(strstr(err.message, "chunk 0: segment 0"));
        free(f.bytes);
    }
}

/* Changes any bytes under right checksums: the result must be an error or another model, never
 * harm. (Run this under the sanitizers. tests/fuzz/fuzz_chunk.c goes further.) */
static void tamper(stp_codec codec)
{
    sample_file f = small_file(codec);
    uint8_t *copy = malloc(f.size);
    assert_non_null(copy);
    for (uint64_t i = 0; i < 3000; i++) {
        memcpy(copy, f.bytes, f.size);
        for (uint64_t k = 0; k <= i % 3; k++) {
            uint64_t r = stp_random_u64(i, k);
            copy[(r >> 8) % f.size] = (uint8_t)r;
        }
        reseal(copy, f.size, true);
        (void)read_bytes(copy, f.size, NULL);
    }
    free(copy);
    free(f.bytes);
}

static void test_tampered(void **state)
{
    (void)state;
    tamper(STP_CODEC_RAW);
    tamper(STP_CODEC_DRACO);
    tamper(STP_CODEC_ZSTD);
}

/* A damaged chunk loses only the damaged segment; every other chunk stays whole. */
static void test_damaged_chunk(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_DRACO);
    const char *path = fixture_path("damaged.stipple");
    stp_chunk_file *file = NULL;
    stp_chunk *chunk = NULL;
    stp_error err = {0};
    const uint8_t *entry = f.bytes + stp_get_u64(f.bytes + 32) + 3 * STP_ENTRY_BYTES;
    uint64_t level_0 = stp_get_u64(entry) + stp_get_u32(entry + 12);
    f.bytes[level_0] ^= 4;
    fixture_write_file(path, f.bytes, f.size);
    assert_int_equal(stp_chunk_file_open(&file, path, &err), STP_OK);
    for (uint32_t id = 0; id < 7; id++) {
        stp_status status = stp_chunk_file_read(file, id, 0, &chunk, &err);
        assert_int_equal(status, id == 3 ? STP_CORRUPT : STP_OK);
        stp_chunk_destroy(&chunk);
    }
    assert_non_null(strstr(err.message, "chunk 3"));
    assert_non_null(strstr(err.message, "segment 2"));
    assert_int_equal(stp_chunk_file_read(file, 3, 1, &chunk, &err), STP_OK);
    stp_chunk_destroy(&chunk);
    stp_chunk_file_close(&file);
    free(f.bytes);
}

/* ---- what only verify finds ---- */

static stp_status verify(const char *path, stp_error *err)
{
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    assert_int_equal(stp_pool_create(&pool, 2, NULL), STP_OK);
    stp_status status = stp_chunk_file_open(&file, path, err);
    if (status == STP_OK)
        status = stp_chunk_file_verify(file, pool, NULL, err);
    stp_chunk_file_close(&file);
    stp_pool_destroy(&pool);
    return status;
}

typedef void spoil(fixture_tree *tree);

static void spoil_nothing(fixture_tree *tree)
{
    (void)tree;
}

static void spoil_colour(fixture_tree *tree)
{
    tree->chunks[6]->samples[0][1].rgb[2] ^= 1;
}

static void spoil_normal(fixture_tree *tree)
{
    tree->chunks[6]->samples[0][1].normal[0] ^= 1;
}

static void spoil_position(fixture_tree *tree)
{
    tree->chunks[2]->samples[0][1].position[0] ^= 1;
}

static void spoil_radius(fixture_tree *tree)
{
    tree->chunks[2]->samples[0][1].radius--;
}

static void spoil_child(fixture_tree *tree)
{
    tree->chunks[2]->patches[0].child = 1;
}

static void spoil_no_child(fixture_tree *tree)
{
    tree->chunks[2]->patches[0].child = STP_PATCH_NO_CHILD;
}

static void spoil_points(fixture_tree *tree)
{
    tree->entries[6].points_under++;
}

static void spoil_box(fixture_tree *tree)
{
    tree->box.min.x += 0.5;
}

static void spoil_error(fixture_tree *tree)
{
    stp_patch *patch = &tree->chunks[0]->patches[1];
    patch->error[1] = 1;
    memset(patch->quarter_error[0], 0, sizeof patch->quarter_error[0]);
    patch->quarter_error[0][1] = 1;
}

static void spoil_quarter_error(fixture_tree *tree)
{
    tree->chunks[0]->patches[1].quarter_error[1][1] = 1;
}

static void spoil_quarter_overhang(fixture_tree *tree)
{
    stp_patch *patch = &tree->chunks[0]->patches[1];
    patch->quarter_tangential_error[0][1] = 0;
    patch->quarter_tangential_error[1][1] = 0;
}

static void spoil_joint_error(fixture_tree *tree)
{
    tree->chunks[2]->patches[1].error[0]--;
}

static void spoil_link(fixture_tree *tree)
{
    tree->chunks[2]->patches[0].first_below++;
}

static void spoil_side(fixture_tree *tree)
{
    tree->chunks[0]->patches[8].flags |= STP_PATCH_TWO_SIDED;
}

static void spoil_orientation(fixture_tree *tree)
{
    tree->chunks[0]->samples[0][3].flags &= (uint8_t)~STP_SAMPLE_ORIENTED;
}

/* The merged sample says that its normal was fitted wide; the samples that it covers were fitted to
 * the nearest neighbours. */
static void spoil_fit(fixture_tree *tree)
{
    tree->chunks[0]->samples[1][0].flags |= STP_FIT_WIDE << STP_SAMPLE_FIT_SHIFT;
    tree->attributes_more = STP_HAS_FITS;
}

/* Clears the outlier flag of a merged sample that covers outliers only. */
static void spoil_mark(fixture_tree *tree)
{
    tree->chunks[0]->samples[1][0].flags ^= STP_SAMPLE_OUTLIER;
}

/* Marks a sample as closed, in a file that says it has no closed surface. */
static void spoil_closed(fixture_tree *tree)
{
    tree->chunks[0]->samples[0][3].flags |= STP_SAMPLE_CLOSED;
}

static void spoil_closed_patch(fixture_tree *tree)
{
    tree->chunks[0]->patches[0].flags |= STP_PATCH_CLOSED;
}

static void spoil_attribute(fixture_tree *tree)
{
    tree->attributes_denied = STP_HAS_OUTLIERS;
}

static void spoil_bound(fixture_tree *tree)
{
    tree->chunks[0]->patches[0].radius[0] = 3;
}

static void test_verify(void **state)
{
    (void)state;
    static const struct {
        spoil *spoil;
        const char *message;
        bool refused; /* whether every reader of the chunk refuses it, not just verify */
    } cases[] = {
        {spoil_nothing, NULL, false},
        {spoil_colour, "colour", false},
        {spoil_normal, "normal", false},
        {spoil_position, "position", false},
        {spoil_radius, "radius", false},
        {spoil_child, "another number of samples", false},
        {spoil_no_child, "patch 0: it names a child in a leaf, or none", true},
        {spoil_points, "points_under", false},
        {spoil_box, "file's box", false},
        {spoil_error, "patch 1: its error shrinks", false},
        {spoil_quarter_error, "patch 1: the perpendicular error of a merged sample exceeds", false},
        {spoil_quarter_overhang, "patch 1: the tangential error of a merged sample exceeds", false},
        {spoil_joint_error, "patch 1: its error at level 0", false},
        {spoil_link, "patch 0: it is linked to other patches", false},
        {spoil_side, "patch 1: it is not two-sided", false},
        {spoil_orientation, "orientation", false},
        {spoil_fit, "or its fit", false},
        {spoil_mark, "mark as outlier", false},
        {spoil_closed, "no closed surface", true},
        {spoil_closed_patch, "a sample is not closed in a patch that is", false},
        {spoil_attribute, "says it has no marks", true},
        {spoil_bound, "radius exceeds", false},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const char *path = fixture_path("spoilt.stipple");
        fixture_tree tree;
        stp_error err = {0};
        fixture_tree_of_seven(&tree, 9, 40);
        cases[i].spoil(&tree);
        assert_int_equal(fixture_write(&tree, path, STP_CODEC_DRACO, &err), STP_OK);
        assert_int_equal(read_all(path, NULL), cases[i].refused ? STP_CORRUPT : STP_OK);
        stp_status status = verify(path, &err);
        if (status != STP_OK && (!cases[i].message || !strstr(err.message, cases[i].message)))
            print_error("case %zu: %s\n", i, err.message);
        assert_int_equal(status, cases[i].message ? STP_CORRUPT : STP_OK);
        if (cases[i].message)
            assert_non_null(strstr(err.message, cases[i].message));
        fixture_destroy(&tree);
    }
}

/* ---- metadata ---- */

static void test_metadata(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        const char *message; /* in a file of 300 points */
    } cases[] = {
        {"{\"repaired\":[{\"points_lost\":9,\"stand_ins\":300,\"lost\":[]}]}", NULL},
        {"{\"repaired\":[{\"points_lost\":9,\"stand_ins\":99999999999,\"lost\":[]}]}",
         "no more than the file's points"},
        {"{\"repaired\":[{\"points_lost\":-1,\"stand_ins\":3,\"lost\":[]}]}", "how many points"},
        {"{\"repaired\":[3]}", "how many points"},
        {"{\"repaired\":{}}", "no list"},
        {"[]", "not a JSON object"},
        {"{} {}", "not a JSON object"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_error err = {0};
        stp_status status = stp_metadata_check(cases[i].text, strlen(cases[i].text), 300, &err);
        assert_int_equal(status, cases[i].message ? STP_CORRUPT : STP_OK);
        if (cases[i].message)
            assert_non_null(strstr(err.message, cases[i].message));
    }
}

/* A zero byte would end the text for one reader and not for another. */
static void test_metadata_zero(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_ZSTD);
    stp_error err = {0};
    f.bytes[stp_get_u64(f.bytes + 40) + stp_get_u64(f.bytes + 48) - 1] = 0;
    reseal(f.bytes, f.size, false);
    assert_int_equal(read_bytes(f.bytes, f.size, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "a zero byte"));
    free(f.bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_metadata),      cmocka_unit_test(test_metadata_zero),
        cmocka_unit_test(test_truncated),     cmocka_unit_test(test_extended),
        cmocka_unit_test(test_flipped_bits),  cmocka_unit_test(test_newer_major),
        cmocka_unit_test(test_other_files),   cmocka_unit_test(test_wrong_numbers),
        cmocka_unit_test(test_empty_payload), cmocka_unit_test(test_tampered),
        cmocka_unit_test(test_damaged_chunk), cmocka_unit_test(test_verify),
    };
    return cmocka_run_group_tests_name("malformed chunk files", tests, NULL, fixture_remove_folder);
}
