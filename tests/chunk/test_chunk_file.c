/* Tests valid chunk files: writing, reading, verifying, versions, and the writer's promises. */
#include "tests/fixtures/chunk_fixture.h"

#include "formats/chunk/verify/verify.h"
#include "tests/fixtures/chunk_reseal.h"

#include <setjmp.h>
#include <stdarg.h>
#include <sys/stat.h>

#include <cmocka.h>

static void assert_same_chunk(const stp_chunk *a, const stp_chunk *b, int finest_level)
{
    assert_int_equal(a->patch_count, b->patch_count);
    assert_int_equal(a->linked, b->linked);
    assert_memory_equal(a->patches, b->patches, a->patch_count * sizeof *a->patches);
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        assert_memory_equal(a->level_begin[l], b->level_begin[l],
                            (a->patch_count + 1) * sizeof(uint32_t));
    for (int l = 0; l < finest_level; l++)
        assert_null(b->samples[l]);
    for (int l = finest_level; l < STP_LEVEL_COUNT; l++)
        assert_memory_equal(a->samples[l], b->samples[l],
                            a->level_begin[l][a->patch_count] * sizeof(stp_sample));
}

static void assert_verifies(const char *path)
{
    stp_error err = {0};
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    assert_int_equal(stp_pool_create(&pool, 2, NULL), STP_OK);
    assert_int_equal(stp_chunk_file_open(&file, path, &err), STP_OK);
    stp_status status = stp_chunk_file_verify(file, pool, NULL, &err);
    if (status != STP_OK)
        print_error("%s\n", err.message);
    assert_int_equal(status, STP_OK);
    stp_chunk_file_close(&file);
    stp_pool_destroy(&pool);
}

/* Writes a file of one chunk and reads it back at every level. */
static void round_trip(fixture_tree *tree, stp_codec codec)
{
    const char *path = fixture_path("one.stipple");
    stp_error err = {0};
    stp_chunk_file *file = NULL;
    stp_status status = fixture_write(tree, path, codec, &err);
    if (status != STP_OK)
        print_error("%s\n", err.message);
    assert_int_equal(status, STP_OK);
    assert_int_equal(stp_chunk_file_open(&file, path, &err), STP_OK);
    for (int level = 0; level <= 2; level++) {
        stp_chunk *chunk = NULL;
        stp_chunk_entry entry;
        assert_int_equal(stp_chunk_file_entry(file, 0, &entry, &err), STP_OK);
        assert_int_equal(stp_chunk_file_read(file, 0, level, &chunk, &err), STP_OK);
        assert_same_chunk(tree->chunks[0], chunk, level);
        assert_int_equal(chunk->memory_bytes, stp_chunk_memory_bytes(&entry, level));
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    assert_verifies(path);
}

static void test_round_trip(void **state)
{
    (void)state;
    static const struct {
        uint32_t patch_count;
        unsigned per_patch;
    } cases[] = {{1, 1}, {1, 2}, {2, 1}, {1, 64}, {5, 5}, {7, 64}, {20, 33}, {3, 17}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        for (int codec = 0; codec <= STP_CODEC_ZSTD; codec++) {
            fixture_tree tree;
            fixture_single(&tree, cases[i].patch_count, cases[i].per_patch);
            round_trip(&tree, (stp_codec)codec);
            fixture_destroy(&tree);
        }
    }
}

/* 1024 patches of 64 samples are the most that a chunk may have. */
static void test_full_chunk(void **state)
{
    (void)state;
    uint8_t counts[1024];
    memset(counts, 64, sizeof counts);
    fixture_tree tree;
    memset(&tree, 0, sizeof tree);
    stp_chunk *chunk = fixture_allocate(counts, 1024);
    assert_int_equal(chunk->level_begin[0][1024], STP_CHUNK_SAMPLES_LIMIT);
    for (uint32_t k = 0; k < STP_CHUNK_SAMPLES_LIMIT; k++) {
        uint64_t r = stp_random_u64(5, k);
        stp_sample *s = &chunk->samples[0][k];
        for (int i = 0; i < 3; i++) {
            s->position[i] = (uint16_t)(r >> (16 * i));
            s->normal[i] = (uint8_t)(r >> (8 * i));
            s->rgb[i] = (uint8_t)(r >> (5 * i));
        }
        s->radius = (uint8_t)(100 + (r >> 60));
        s->flags = STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL;
    }
    for (uint32_t i = 0; i < 1024; i++)
        fixture_finish_patch(chunk, i, FIXTURE_LEAF_ERROR);
    tree.box = (stp_dbox){{0, 0, 0}, {512, 512, 512}};
    fixture_add(&tree, chunk, (stp_dvec3){0, 0, 0}, STP_CHUNK_SAMPLES_LIMIT);
    round_trip(&tree, STP_CODEC_DRACO);
    fixture_destroy(&tree);
}

/* If all samples are equal, every column is constant and the payload is tiny. */
static void test_all_equal(void **state)
{
    (void)state;
    fixture_tree tree;
    fixture_single(&tree, 20, 64);
    stp_chunk *chunk = tree.chunks[0];
    for (uint32_t k = 0; k < chunk->level_begin[0][chunk->patch_count]; k++)
        chunk->samples[0][k] = chunk->samples[0][0];
    for (uint32_t i = 0; i < chunk->patch_count; i++) {
        chunk->patches[i].origin[0] = 0;
        memset(chunk->patches[i].radius, 0, sizeof chunk->patches[i].radius);
        fixture_finish_patch(chunk, i, FIXTURE_LEAF_ERROR);
    }
    round_trip(&tree, STP_CODEC_DRACO);
    assert_true(tree.entries[0].segment_end[2] < 1000);
    fixture_destroy(&tree);
}

/* Duplicates must stay, at their places. */
static void test_duplicates(void **state)
{
    (void)state;
    fixture_tree tree;
    fixture_single(&tree, 6, 64);
    stp_chunk *chunk = tree.chunks[0];
    for (uint32_t k = 0; k + 3 < chunk->level_begin[0][chunk->patch_count]; k += 5)
        chunk->samples[0][k + 1] = chunk->samples[0][k + 3] = chunk->samples[0][k];
    for (uint32_t i = 0; i < chunk->patch_count; i++)
        fixture_finish_patch(chunk, i, FIXTURE_LEAF_ERROR);
    round_trip(&tree, STP_CODEC_DRACO);
    fixture_destroy(&tree);
}

/* The leaves are appended first; the reader finds chunks breadth first: root, inner, leaves. */
static void tree_round_trip(stp_codec codec, bool linked)
{
    static const uint32_t handle_of[7] = {6, 2, 5, 0, 1, 3, 4};
    static const uint32_t parent_of[7] = {STP_CHUNK_NONE, 0, 0, 1, 1, 2, 2};
    const char *path = fixture_path("tree.stipple");
    fixture_tree tree;
    stp_error err = {0};
    stp_chunk_file *file = NULL;
    fixture_tree_of_seven(&tree, 20, 64);
    for (uint32_t h = 0; h < tree.count && !linked; h++)
        fixture_unlink(tree.chunks[h]);
    assert_int_equal(fixture_write(&tree, path, codec, &err), STP_OK);
    assert_int_equal(stp_chunk_file_open(&file, path, &err), STP_OK);
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    assert_int_equal(info->chunk_count, 7);
    assert_int_equal(info->depth, 3);
    assert_int_equal(info->point_count, tree.entries[6].points_under);
    assert_int_equal(info->attributes, STP_HAS_COLOUR | STP_HAS_INTENSITY | STP_HAS_OUTLIERS);
    assert_string_equal(info->metadata_json, FIXTURE_METADATA);
    assert_true(info->box.min.x == tree.box.min.x && info->box.max.z == tree.box.max.z);
    for (uint32_t id = 0; id < 7; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = NULL;
        assert_int_equal(stp_chunk_file_entry(file, id, &entry, &err), STP_OK);
        assert_int_equal(entry.parent, parent_of[id]);
        assert_int_equal(entry.child_count, id < 3 ? 2 : 0);
        assert_int_equal(entry.flags & STP_CHUNK_LINKED, linked && id < 3 ? STP_CHUNK_LINKED : 0);
        assert_int_equal(entry.first_child, id < 3 ? 2 * id + 1 : STP_CHUNK_NONE);
        assert_int_equal(stp_chunk_file_read(file, id, 0, &chunk, &err), STP_OK);
        assert_same_chunk(tree.chunks[handle_of[id]], chunk, 0);
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_entry entry;
    assert_int_equal(stp_chunk_file_entry(file, 7, &entry, &err), STP_INVALID_ARGUMENT);
    stp_chunk_file_close(&file);
    assert_verifies(path);
    fixture_destroy(&tree);
}

static void test_tree(void **state)
{
    (void)state;
    for (int codec = 0; codec <= STP_CODEC_ZSTD; codec++) {
        tree_round_trip((stp_codec)codec, false);
        tree_round_trip((stp_codec)codec, true);
    }
}

static void test_same_bytes(void **state)
{
    (void)state;
    uint8_t *bytes[2];
    size_t size[2];
    for (int i = 0; i < 2; i++) {
        fixture_tree tree;
        fixture_tree_of_seven(&tree, 4, 64);
        const char *path = fixture_path("same.stipple");
        assert_int_equal(fixture_write(&tree, path, STP_CODEC_DRACO, NULL), STP_OK);
        bytes[i] = fixture_read_file(path, &size[i]);
        fixture_destroy(&tree);
    }
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    free(bytes[0]);
    free(bytes[1]);
}

/* An abandoned writer leaves nothing behind, and an existing file stays as it was. */
static void test_writer_abandoned(void **state)
{
    (void)state;
    const char *path = fixture_path("abandoned.stipple");
    stp_chunk_writer_params params = {.codec = STP_CODEC_DRACO, .lambda = 1.7};
    stp_chunk_writer *writer = NULL;
    struct stat info;
    assert_int_equal(stp_chunk_writer_create(&writer, path, &params, NULL), STP_OK);
    stp_chunk_writer_destroy(&writer);
    assert_null(writer);
    assert_int_not_equal(stat(path, &info), 0);
    fixture_write_file(path, "old", 3);
    assert_int_equal(stp_chunk_writer_create(&writer, path, &params, NULL), STP_EXISTS);
    assert_null(writer);
    stp_chunk_writer_destroy(&writer);
    assert_int_equal(stat(path, &info), 0);
    assert_int_equal(info.st_size, 3);
}

/* The writer refuses invalid trees: a chunk without a parent, a chunk with two, no chunk, a wrong
 * patch. No file appears. */
static void test_writer_refuses(void **state)
{
    (void)state;
    fixture_tree tree;
    struct stat info;
    stp_error err = {0};
    const char *path = fixture_path("refused.stipple");
    fixture_tree_of_seven(&tree, 2, 4);
    tree.child_counts[6] = 1;
    assert_int_equal(fixture_write(&tree, path, STP_CODEC_RAW, &err), STP_INVALID_ARGUMENT);
    tree.child_counts[6] = 2;
    tree.children[6][1] = tree.children[6][0];
    assert_int_equal(fixture_write(&tree, path, STP_CODEC_RAW, &err), STP_INVALID_ARGUMENT);
    tree.children[6][1] = 77;
    assert_int_equal(fixture_write(&tree, path, STP_CODEC_RAW, &err), STP_INVALID_ARGUMENT);
    tree.chunks[0]->patches[1].exponent = 201;
    assert_int_equal(fixture_write(&tree, path, STP_CODEC_DRACO, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "patch 1"));
    assert_int_not_equal(stat(path, &info), 0);
    fixture_destroy(&tree);
}

/* A newer minor version may have a longer header and longer entries: the reader reads what it
 * knows. */
static void test_newer_minor(void **state)
{
    (void)state;
    const char *path = fixture_path("minor.stipple");
    fixture_tree tree;
    stp_chunk_file *file = NULL;
    stp_chunk *chunk = NULL;
    stp_error err = {0};
    size_t size = 0;
    const size_t grown_header = STP_HEADER_BYTES + 16;
    const size_t grown_entry = STP_ENTRY_BYTES + 32;
    fixture_single(&tree, 3, 20);
    assert_int_equal(fixture_write(&tree, path, STP_CODEC_DRACO, &err), STP_OK);
    uint8_t *old = fixture_read_file(path, &size);
    size_t directory = (size_t)stp_get_u64(old + 32);
    uint8_t *bytes = calloc(size + 48, 1);
    assert_non_null(bytes);
    memcpy(bytes, old, STP_HEADER_BYTES - STP_HASH_BYTES);
    memcpy(bytes + grown_header, old + STP_HEADER_BYTES, directory - STP_HEADER_BYTES);
    memcpy(bytes + directory + 16, old + directory, STP_ENTRY_BYTES);
    memset(bytes + directory + 16 + STP_ENTRY_BYTES, 0xab, 32);
    memset(bytes + STP_HEADER_BYTES - 8, 0xcd, 16);
    stp_put_u16(bytes + 10, 7);
    stp_put_u32(bytes + 12, (uint32_t)grown_header);
    stp_put_u32(bytes + 24, (uint32_t)grown_entry);
    stp_put_u64(bytes + 32, directory + 16);
    stp_put_u64(bytes + 40, stp_get_u64(bytes + 40) + 16);
    stp_put_u64(bytes + directory + 16, stp_get_u64(bytes + directory + 16) + 16);
    reseal(bytes, size + 48, true);
    fixture_write_file(path, bytes, size + 48);
    stp_status status = stp_chunk_file_open(&file, path, &err);
    if (status != STP_OK)
        print_error("%s\n", err.message);
    assert_int_equal(status, STP_OK);
    assert_int_equal(stp_chunk_file_get_info(file)->version_minor, 7);
    assert_int_equal(stp_chunk_file_read(file, 0, 0, &chunk, &err), STP_OK);
    assert_same_chunk(tree.chunks[0], chunk, 0);
    stp_chunk_destroy(&chunk);
    stp_chunk_file_close(&file);
    assert_verifies(path);
    free(bytes);
    free(old);
    fixture_destroy(&tree);
}

/* A root with 64 leaves needs more than one page of the directory. */
static void test_many_pages(void **state)
{
    (void)state;
    enum { LEAVES = 64, COUNT = LEAVES + 1 };
    const char *path = fixture_path("pages.stipple");
    fixture_tree tree;
    stp_error err = {0};
    memset(&tree, 0, sizeof tree);
    tree.box = stp_dbox_empty();
    uint32_t leaf = fixture_add_leaf(&tree, 3, 1, 8, (stp_dvec3){0, 0, 0});
    uint8_t counts[LEAVES];
    memset(counts, 1, sizeof counts);
    stp_chunk *root = fixture_allocate(counts, LEAVES);
    for (uint32_t i = 0; i < LEAVES; i++) {
        root->patches[i].child = (uint8_t)i;
        root->patches[i].origin[2] = -100;
        root->samples[0][i] = tree.chunks[leaf]->samples[3][0];
        fixture_finish_patch(root, i, tree.chunks[leaf]->patches[0].error[STP_LEVEL_COUNT - 1]);
    }
    uint32_t handle = fixture_add(&tree, root, (stp_dvec3){0, 0, 0}, 4 * LEAVES);
    stp_chunk_writer *writer = NULL;
    stp_chunk_writer_params params = {
        .force = true, .codec = STP_CODEC_DRACO, .attributes = STP_HAS_OUTLIERS, .lambda = 1.7};
    const uint32_t *children[COUNT] = {0};
    uint32_t ids[LEAVES];
    uint32_t child_counts[COUNT] = {0};
    assert_int_equal(stp_chunk_writer_create(&writer, path, &params, &err), STP_OK);
    for (uint32_t i = 0; i < COUNT; i++) {
        uint32_t which = i < LEAVES ? leaf : handle;
        void *payload = NULL;
        uint32_t got = 0;
        assert_int_equal(stp_chunk_encode(tree.chunks[which], STP_CODEC_DRACO, &payload,
                                          &tree.entries[which], &err),
                         STP_OK);
        assert_int_equal(stp_chunk_writer_append(writer, payload, &tree.entries[which], &got, &err),
                         STP_OK);
        assert_int_equal(got, i);
        free(payload);
        if (i < LEAVES)
            ids[i] = i;
    }
    children[LEAVES] = ids;
    child_counts[LEAVES] = LEAVES;
    assert_int_equal(stp_chunk_writer_finish(&writer, LEAVES, children, child_counts, &tree.box,
                                             FIXTURE_METADATA, NULL, &err),
                     STP_OK);
    assert_verifies(path);
    fixture_destroy(&tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_round_trip),
        cmocka_unit_test(test_full_chunk),
        cmocka_unit_test(test_all_equal),
        cmocka_unit_test(test_duplicates),
        cmocka_unit_test(test_tree),
        cmocka_unit_test(test_same_bytes),
        cmocka_unit_test(test_writer_abandoned),
        cmocka_unit_test(test_writer_refuses),
        cmocka_unit_test(test_newer_minor),
        cmocka_unit_test(test_many_pages),
    };
    return cmocka_run_group_tests_name("chunk file", tests, NULL, fixture_remove_folder);
}
