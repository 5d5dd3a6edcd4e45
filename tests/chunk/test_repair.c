/* Tests the repair of damaged chunk files of both versions: sound parts stay, parts that can be
 * rebuilt are rebuilt, and exactly the lost points are named. The points that must come back are
 * those of the fixture.
 */
#include "formats/chunk/repair/repair_note.h"
#include "formats/chunk/verify/verify.h"
#include "tests/fixtures/repair_fixture.h"

#include <cjson/cJSON.h>

/* A sample of level 0 in the world. */
typedef struct point {
    double at[3];
    uint8_t rest[10]; /* radius, flags, normal, class, colour, intensity */
} point;

/* ---- the output ---- */

static stp_chunk_file *open_sound(bench *b)
{
    stp_chunk_file *file = NULL;
    stp_status status = stp_chunk_file_open(&file, output_path(), &b->err);
    if (status == STP_OK)
        status = stp_chunk_file_verify(file, b->pool, NULL, &b->err);
    if (status != STP_OK)
        print_error("%s\n", b->err.message);
    assert_int_equal(status, STP_OK);
    return file;
}

static void assert_original(bench *b)
{
    size_t size = 0;
    uint8_t *bytes = fixture_read_file(output_path(), &size);
    assert_true(b->result.whole && !b->result.sound);
    assert_int_equal(size, b->size);
    assert_memory_equal(bytes, b->bytes, size);
    free(bytes);
}

static int compare_points(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(point));
}

static uint32_t take_points(const stp_chunk *chunk, stp_dvec3 origin, point *out)
{
    uint32_t count = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p++)
        for (uint32_t i = chunk->level_begin[0][p]; i < chunk->level_begin[0][p + 1]; i++) {
            const stp_sample *s = &chunk->samples[0][i];
            stp_dvec3 at = stp_dvec3_add(origin, stp_sample_position(s, &chunk->patches[p]));
            point *to = &out[count++];
            memset(to, 0, sizeof *to);
            memcpy(to->at, (double[3]){at.x, at.y, at.z}, sizeof to->at);
            memcpy(to->rest, &s->radius, sizeof to->rest);
        }
    return count;
}

#define POINTS 65536

/* Lists the points of the fixture's leaves, except the leaves whose bit in `lost` is set. */
static uint32_t expected_points(const bench *b, uint32_t lost, point *out)
{
    uint32_t count = 0;
    for (uint32_t id = FIRST_LEAF; id < CHUNKS; id++)
        if (!(lost >> id & 1))
            count += take_points(b->tree.chunks[leaf_handle[id]],
                                 b->tree.entries[leaf_handle[id]].origin, out + count);
    return count;
}

static uint32_t found_points(stp_chunk_file *file, uint64_t *stand_ins, point *out)
{
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    bool marks[64] = {false};
    uint32_t count = 0;
    assert_true(info->chunk_count <= 64);
    stp_repair_note_stand_ins(info->metadata_json, marks, info->chunk_count);
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        stp_chunk_entry e;
        stp_chunk *chunk = NULL;
        assert_int_equal(stp_chunk_file_entry(file, id, &e, NULL), STP_OK);
        if (e.child_count > 0)
            continue;
        assert_int_equal(stp_chunk_file_read(file, id, 0, &chunk, NULL), STP_OK);
        if (marks[id])
            *stand_ins += e.sample_count[0];
        else
            count += take_points(chunk, e.origin, out + count);
        stp_chunk_destroy(&chunk);
    }
    return count;
}

/* The output is sound and holds the fixture's points, except those of the lost leaves; the result
 * counts these. Returns the number of stand-ins. */
static uint64_t assert_points(bench *b, uint32_t lost)
{
    static point expected[POINTS], found[POINTS];
    uint64_t stand_ins = 0;
    stp_chunk_file *file = open_sound(b);
    uint32_t all = expected_points(b, 0, expected), count = expected_points(b, lost, expected);
    assert_int_equal(found_points(file, &stand_ins, found), count);
    qsort(expected, count, sizeof *expected, compare_points);
    qsort(found, count, sizeof *found, compare_points);
    assert_memory_equal(expected, found, count * sizeof *expected);
    assert_int_equal(b->result.points_lost, all - count);
    assert_int_equal(b->result.stand_ins, stand_ins);
    assert_int_equal(b->result.whole, lost == 0);
    assert_int_equal(stp_chunk_file_get_info(file)->point_count, count + stand_ins);
    stp_chunk_file_close(&file);
    return stand_ins;
}

/* ---- without loss ---- */

static void flip(bench *b, size_t bit)
{
    b->damaged[bit / 8] = (uint8_t)(b->damaged[bit / 8] ^ 1u << bit % 8);
}

static void test_flipped_bits(void **state)
{
    (void)state;
    bench *b = setup_bench();
    size_t metadata = stp_get_u64(b->bytes + 40), directory = stp_get_u64(b->bytes + 32);
    const size_t places[] = {3,
                             9,
                             100,
                             200,
                             250,
                             256,
                             5000,
                             header_size() * header_copies() - 1,
                             metadata - 1,
                             metadata - 100,
                             metadata + 3,
                             directory,
                             directory + 300,
                             directory + 470,
                             b->size - 1};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        char where[64];
        snprintf(where, sizeof where, "byte %zu: bit %zu was flipped", places[i], i % 8);
        flip(b, 8 * places[i] + i % 8);
        repair(b);
        assert_original(b);
        assert_non_null(strstr(b->report, where));
        flip(b, 8 * places[i] + i % 8);
    }
    free_bench(b);
}

/* Flips one bit in each checked part at once. */
static void test_many_bits(void **state)
{
    (void)state;
    bench *b = setup_bench();
    size_t size = 0;
    for (uint32_t id = 0; id < CHUNKS; id++)
        for (int s = 0; s < STP_SEGMENT_COUNT; s++)
            *segment(b, id, s, &size) ^= 16;
    for (size_t i = 0; i < header_copies(); i++)
        b->damaged[i * header_size() + 100] ^= 1;
    b->damaged[stp_get_u64(b->bytes + 40)] ^= 128;
    b->damaged[b->size - 100] ^= 2;
    repair(b);
    assert_original(b);
    free_bench(b);
}

static void test_header(void **state)
{
    (void)state;
    bench *b = setup_bench();
    for (size_t i = 0; i < header_copies(); i++)
        memset(b->damaged + i * header_size(), 0xff, 240);
    repair(b);
    assert_original(b);
    assert_non_null(strstr(b->report, "its checksum proves it"));
    memset(b->damaged, 0, header_copies() * header_size()); /* wipes the checksum too */
    repair(b);
    assert_non_null(strstr(b->report, "told from"));
    assert_int_equal(assert_points(b, 0), 0);
    stp_chunk_file *file = open_sound(b);
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    assert_memory_equal(&info->box, &b->tree.box, sizeof info->box);
    assert_true(info->lambda == 1.7);
    assert_true(info->attributes & STP_HAS_COLOUR);
    assert_non_null(strstr(info->metadata_json, "header_told"));
    stp_chunk_file_close(&file);
    free_bench(b);
}

/* Of version 2, either copy of the header does. */
static void test_copies(void **state)
{
    (void)state;
    for (size_t at = 0; at < 2 * STP_HEADER_BYTES_2; at += STP_HEADER_BYTES_2) {
        char line[64];
        bench *b = setup_bench();
        memset(b->damaged + at, 0, STP_HEADER_BYTES_2);
        repair(b);
        assert_original(b);
        snprintf(line, sizeof line, "byte %zu: this copy of the header is damaged", at);
        assert_non_null(strstr(b->report, line));
        flip(b, 8 * (STP_HEADER_BYTES_2 - at + 64)); /* the other copy is damaged less */
        repair(b);
        assert_original(b);
        assert_non_null(strstr(b->report, line));
        free_bench(b);
    }
}

/* Flips a bit in each of two blocks of a segment: their checksums find both. Wipes the records of
 * all blocks: the payloads bring them back. If a payload is lost, too, they are written anew. */
static void test_records(void **state)
{
    (void)state;
    bench *b = setup_bench();
    const size_t table = stp_get_u64(b->bytes + 176), metadata = stp_get_u64(b->bytes + 40);
    size_t size = 0;
    uint8_t *bytes = segment(b, 5, 2, &size);
    assert_true(metadata - table > 14 * STP_BLOCK_BYTES);
    bytes[100] ^= 1;
    bytes[size - 1] ^= 1;
    repair(b);
    assert_original(b);
    assert_non_null(strstr(b->report, "in block 2 of segment 2 of chunk 5: put back"));
    memcpy(b->damaged, b->bytes, b->size);
    memset(b->damaged + table, 0, metadata - table);
    repair(b);
    assert_original(b);
    assert_non_null(strstr(b->report, "the records of blocks of chunk 6 are made anew"));
    destroy_segment(b, 4, 2);
    repair(b);
    assert_true(assert_points(b, 1u << 4) > 0);
    free_bench(b);
}

/* If a chunk is rebuilt, those under it become one block each; all others keep their blocks. */
static void test_joined(void **state)
{
    (void)state;
    bench *b = setup_bench();
    stp_chunk_entry e;
    destroy_segment(b, 1, 0);
    repair(b);
    assert_int_equal(assert_points(b, 0), 0);
    assert_non_null(strstr(b->report, "2 chunks: one block now"));
    stp_chunk_file *file = open_sound(b);
    assert_int_equal(stp_chunk_file_get_info(file)->version_major, 2);
    for (uint32_t id = FIRST_LEAF; id < CHUNKS; id++) {
        assert_int_equal(stp_chunk_file_entry(file, id, &e, NULL), STP_OK);
        assert_int_equal(e.block_count, id < FIRST_LEAF + 2 ? 1 : 3);
    }
    stp_chunk_file_close(&file);
    free_bench(b);
}

/* Version 1 must end where its header says; version 2 may have more. */
static void test_appended(void **state)
{
    (void)state;
    bench *b = setup_bench();
    memcpy(b->damaged + b->size, "0123456789", 10);
    unlink(output_path());
    assert_int_equal(repair_size(b, b->size + 10, output_path(), false), STP_OK);
    if (header_copies() == 1)
        assert_original(b);
    assert_true(b->result.sound == (header_copies() == 2));
    b->damaged[b->size - 1] ^= 1;
    unlink(output_path());
    assert_int_equal(repair_size(b, b->size + 10, output_path(), false), STP_OK);
    assert_original(b);
    free_bench(b);
}

static void test_inner(void **state)
{
    (void)state;
    for (uint32_t id = 0; id < FIRST_LEAF; id++)
        for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
            char line[64];
            bench *b = setup_bench();
            destroy_segment(b, id, s);
            repair(b);
            assert_int_equal(assert_points(b, 0), 0);
            snprintf(line, sizeof line, "chunk %u: rebuilt", id);
            assert_non_null(strstr(b->report, line));
            free_bench(b);
        }
}

/* Wipes, changes and exchanges entries of leaves and of inner chunks. */
static void test_entries(void **state)
{
    (void)state;
    for (uint32_t id = 0; id < CHUNKS; id++) {
        bench *b = setup_bench();
        memset(entry(b, id), 0, STP_ENTRY_BYTES);
        repair(b);
        assert_int_equal(assert_points(b, 0), 0);
        memcpy(entry(b, id), b->bytes + (entry(b, id) - b->damaged), STP_ENTRY_BYTES);
        entry(b, id)[88] ^= 7; /* the origin, which no payload holds */
        entry(b, id)[94] ^= 1;
        repair(b);
        assert_int_equal(assert_points(b, 0), 0);
        free_bench(b);
    }
    bench *b = setup_bench();
    for (uint32_t id = 0; id < FIRST_LEAF; id++) {
        entry(b, id)[78] ^= STP_CHUNK_LINKED; /* the flag that says how to decode the payload */
        entry(b, id)[148] ^= 1;
    }
    repair(b);
    assert_original(b);
    free_bench(b);
    b = setup_bench();
    for (uint32_t id = FIRST_LEAF; id < CHUNKS; id++)
        memset(entry(b, id), 0, STP_ENTRY_BYTES);
    repair(b);
    assert_original(b);
    free_bench(b);
}

/* The directory's end is cut off, with the checksum of its remaining part. */
static void test_cut(void **state)
{
    (void)state;
    bench *b = setup_bench();
    for (size_t cut = 1; cut < 1100; cut += 333) {
        unlink(output_path());
        assert_int_equal(repair_size(b, b->size - cut, output_path(), false), STP_OK);
        assert_non_null(strstr(b->report, "the file was cut"));
        assert_int_equal(assert_points(b, 0), 0);
    }
    free_bench(b);
}

/* ---- with loss ---- */

static void assert_named(bench *b, uint32_t id)
{
    const stp_chunk *leaf = b->tree.chunks[leaf_handle[id]];
    char line[64];
    snprintf(line, sizeof line, "chunk %u: %u points in the box", id,
             leaf->level_begin[0][leaf->patch_count]);
    assert_non_null(strstr(b->report, line));
}

static void test_leaf(void **state)
{
    (void)state;
    for (uint32_t id = FIRST_LEAF; id < CHUNKS; id++)
        for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
            bench *b = setup_bench();
            const stp_chunk *leaf = b->tree.chunks[leaf_handle[id]];
            int level = s == 2 ? 1 : s == 1 ? 2 : 3; /* the finest left, or the parent's */
            destroy_segment(b, id, s);
            repair(b);
            assert_int_equal(assert_points(b, 1u << id),
                             leaf->level_begin[level][leaf->patch_count]);
            assert_named(b, id);
            free_bench(b);
        }
}

/* The metadata names the box, the counts and the chunk's id, as SPEC.md says. */
static void test_metadata_names(void **state)
{
    (void)state;
    bench *b = setup_bench();
    destroy_segment(b, 5, 2);
    repair(b);
    uint64_t stand_ins = assert_points(b, 1u << 5);
    const stp_chunk *leaf = b->tree.chunks[leaf_handle[5]];
    stp_chunk_file *file = open_sound(b);
    cJSON *json = cJSON_Parse(stp_chunk_file_get_info(file)->metadata_json);
    assert_non_null(cJSON_GetObjectItem(json, "sources")); /* what was there before stays */
    const cJSON *repair_1 = cJSON_GetArrayItem(cJSON_GetObjectItem(json, "repaired"), 0);
    const cJSON *lost = cJSON_GetArrayItem(cJSON_GetObjectItem(repair_1, "lost"), 0);
    const cJSON *box = cJSON_GetObjectItem(lost, "box");
    double points = (double)leaf->level_begin[0][leaf->patch_count];
    assert_true(cJSON_GetObjectItem(repair_1, "points_lost")->valuedouble == points);
    assert_true(cJSON_GetObjectItem(repair_1, "stand_ins")->valuedouble == (double)stand_ins);
    assert_true(cJSON_GetObjectItem(lost, "chunk")->valuedouble == 5.0);
    assert_true(cJSON_GetObjectItem(lost, "points")->valuedouble == points);
    assert_int_equal(cJSON_GetArraySize(box), 6);
    static point inside[POINTS];
    uint32_t count = take_points(leaf, b->tree.entries[leaf_handle[5]].origin, inside);
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++)
            assert_true(inside[i].at[k] >= cJSON_GetArrayItem(box, k)->valuedouble &&
                        inside[i].at[k] <= cJSON_GetArrayItem(box, 3 + k)->valuedouble);
    cJSON_Delete(json);
    stp_chunk_file_close(&file);
    free_bench(b);
}

/* A payload is damaged, and the directory page of another chunk. What the entry still says of the
 * payload must be used, and no damaged point may pass for a sound one. */
static void test_leaf_and_page(void **state)
{
    (void)state;
    for (uint32_t id = FIRST_LEAF; id < CHUNKS; id++)
        for (int spoilt = 0; spoilt < 3; spoilt++) {
            bench *b = setup_bench();
            size_t size = 0;
            uint8_t *bytes = segment(b, id, 2, &size);
            bytes[size - 1] ^= 3; /* low bits of a colour or position: the payload still decodes */
            memset(entry(b, spoilt == 0 ? FIRST_LEAF + CHUNKS - 1 - id : (uint32_t)spoilt), 0,
                   STP_ENTRY_BYTES);
            if (spoilt == 2)
                memset(entry(b, id) + 100, 1, 8);
            repair(b);
            bool placed = spoilt < 2 || id < FIRST_LEAF + 2; /* else its place is unknown */
            assert_int_equal(assert_points(b, 1u << id) > 0, placed);
            free_bench(b);
        }
}

/* The parent is damaged too: what can be read of it stands in, and the rest is rebuilt. */
static void test_leaf_and_parent(void **state)
{
    (void)state;
    bench *b = setup_bench();
    destroy_segment(b, 1, 2);
    destroy_segment(b, 3, 0);
    repair(b);
    assert_true(assert_points(b, 1u << 3) > 0);
    assert_named(b, 3);
    free_bench(b);
    b = setup_bench();
    destroy_segment(b, 1, 0); /* now only the name of chunk 3 is left */
    destroy_segment(b, 3, 0);
    repair(b);
    assert_int_equal(assert_points(b, 1u << 3), 0);
    assert_named(b, 3);
    free_bench(b);
    b = setup_bench();
    for (uint32_t id = 1; id < FIRST_LEAF + 2; id += id == 1 ? 2 : 1)
        destroy_segment(b, id, 0); /* chunks 1, 3 and 4: the root stands in for all */
    repair(b);
    assert_true(assert_points(b, 1u << 3 | 1u << 4) > 0);
    free_bench(b);
}

static void test_metadata(void **state)
{
    (void)state;
    static const uint8_t no_text[] = {0x01, 0xff, '"', '}'};
    bench *b = setup_bench();
    uint8_t *metadata = b->damaged + stp_get_u64(b->bytes + 40);
    memcpy(metadata + 2, no_text, sizeof no_text);
    unlink(output_path());
    repair(b);
    assert_false(b->result.whole);
    assert_int_equal(b->result.points_lost, 0);
    b->result.whole = true;
    assert_int_equal(assert_points(b, 0), 0);
    stp_chunk_file *file = open_sound(b);
    const char *text = stp_chunk_file_get_info(file)->metadata_json;
    assert_non_null(strstr(text, "metadata_found"));
    assert_non_null(strstr(text, "a height field")); /* the rest can be read there */
    stp_chunk_file_close(&file);
    free_bench(b);
}

/* A repaired file is damaged again: its stand-ins are still known as such, though their chunk has a
 * new id. */
static void test_again(void **state)
{
    (void)state;
    bench *b = setup_bench();
    destroy_segment(b, 6, 2);
    repair(b);
    uint64_t first = assert_points(b, 1u << 6);
    stp_repair_result result = b->result;
    free(b->damaged);
    free(b->bytes);
    b->bytes = fixture_read_file(output_path(), &b->size);
    b->damaged = fixture_read_file(output_path(), &b->size);
    destroy_segment(b, 1, 0); /* chunk 3 is lost, and 6 becomes 5 */
    destroy_segment(b, 3, 0);
    repair(b);
    b->result.points_lost += result.points_lost;
    assert_int_equal(assert_points(b, 1u << 6 | 1u << 3), first);
    free_bench(b);
}

/* ---- nothing to write ---- */

static void test_sound(void **state)
{
    (void)state;
    bench *b = setup_bench();
    repair(b);
    assert_true(b->result.sound && b->result.whole);
    assert_int_equal(access(output_path(), F_OK), -1);
    assert_string_equal(b->report, "");
    free_bench(b);
}

static void assert_refused(bench *b, size_t size, const char *text)
{
    unlink(output_path());
    assert_int_not_equal(repair_size(b, size, output_path(), false), STP_OK);
    assert_non_null(strstr(b->err.message, text));
    assert_null(strchr(b->err.message, '\n'));
    assert_int_equal(access(output_path(), F_OK), -1);
}

static void test_refused(void **state)
{
    (void)state;
    bench *b = setup_bench();
    for (uint32_t id = 0; id < CHUNKS; id++)
        destroy_segment(b, id, 0);
    assert_refused(b, b->size, "cannot be repaired: neither the root");
    assert_refused(b, 100, "nothing is left of it");
    assert_refused(b, b->size / 2, "cannot be repaired");
    memset(b->damaged, 0, b->size);
    assert_refused(b, b->size, "not a stipple chunk file");
    memcpy(b->damaged, b->bytes, b->size);
    stp_put_u16(b->damaged + 8, STP_CHUNK_FILE_MAJOR + 1); /* a newer file is sound */
    const size_t hashed = header_size() - STP_HASH_BYTES;
    stp_put_u64(b->damaged + hashed, stp_hash(b->damaged, hashed));
    if (header_copies() == 2)
        memcpy(b->damaged + header_size(), b->damaged, header_size());
    assert_refused(b, b->size, "use a newer stipple");
    free_bench(b);
}

/* Checksums are right, but the content is wrong: nothing is damaged and nothing can be repaired. */
static void test_written_wrong(void **state)
{
    (void)state;
    bench *b = setup_bench();
    const char *path = fixture_path("wrong.stipple");
    b->tree.box.min.x += 0.5;
    assert_int_equal(fixture_write(&b->tree, path, bench_codec, NULL), STP_OK);
    free(b->damaged);
    b->damaged = fixture_read_file(path, &b->size);
    assert_refused(b, b->size, "no checksum is wrong");
    free_bench(b);
}

static void test_in_place(void **state)
{
    (void)state;
    bench *b = setup_bench();
    char path[256];
    size_t size = 0;
    snprintf(path, sizeof path, "%s", fixture_path("damaged.stipple"));
    b->damaged[1000] ^= 1;
    assert_int_equal(repair_size(b, b->size, path, true), STP_OK);
    uint8_t *bytes = fixture_read_file(path, &size);
    assert_int_equal(size, b->size);
    assert_memory_equal(bytes, b->bytes, size);
    free(bytes);
    destroy_segment(b, 3, 2); /* a loss: the damaged file is kept */
    assert_int_equal(repair_size(b, b->size, path, true), STP_INVALID_ARGUMENT);
    bytes = fixture_read_file(path, &size);
    assert_int_equal(size, b->size);
    assert_memory_equal(bytes, b->damaged, size);
    free(bytes);
    free_bench(b);
}

#define TESTS_OF_ALL_VERSIONS                                                                      \
    cmocka_unit_test(test_flipped_bits), cmocka_unit_test(test_many_bits),                         \
        cmocka_unit_test(test_header), cmocka_unit_test(test_appended),                            \
        cmocka_unit_test(test_inner), cmocka_unit_test(test_entries), cmocka_unit_test(test_cut),  \
        cmocka_unit_test(test_leaf), cmocka_unit_test(test_leaf_and_page),                         \
        cmocka_unit_test(test_metadata_names), cmocka_unit_test(test_leaf_and_parent),             \
        cmocka_unit_test(test_metadata), cmocka_unit_test(test_again),                             \
        cmocka_unit_test(test_sound), cmocka_unit_test(test_refused),                              \
        cmocka_unit_test(test_written_wrong), cmocka_unit_test(test_in_place)

int main(void)
{
    const struct CMUnitTest version_1[] = {TESTS_OF_ALL_VERSIONS};
    const struct CMUnitTest version_2[] = {TESTS_OF_ALL_VERSIONS, cmocka_unit_test(test_copies),
                                           cmocka_unit_test(test_records),
                                           cmocka_unit_test(test_joined)};
    const struct CMUnitTest zstd[] = {cmocka_unit_test(test_many_bits),
                                      cmocka_unit_test(test_entries), cmocka_unit_test(test_leaf)};
    int failed = cmocka_run_group_tests_name("repair", version_1, NULL, NULL);
    bench_codec = STP_CODEC_DRACO_BLOCKS;
    failed += cmocka_run_group_tests_name("repair in blocks", version_2, NULL, NULL);
    bench_codec = STP_CODEC_ZSTD_BLOCKS;
    return failed + cmocka_run_group_tests_name("repair in blocks of zstd", zstd, NULL,
                                                fixture_remove_folder);
}
