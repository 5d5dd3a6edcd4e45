/* Tests valid files of version 2: a block decodes to its part of the chunk, whatever the codec and
 * the number of blocks, and converting to version 2 and back gives the same bytes. */
#include "formats/chunk/block/block.h"
#include "formats/chunk/block/block_table.h"
#include "formats/chunk/convert.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/verify/verify.h"
#include "tests/fixtures/chunk_fixture.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

static stp_chunk_file *open_sound(const char *path)
{
    stp_error err = {0};
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    assert_int_equal(stp_pool_create(&pool, 2, NULL), STP_OK);
    stp_status status = stp_chunk_file_open(&file, path, &err);
    if (status == STP_OK)
        status = stp_chunk_file_verify(file, pool, NULL, &err);
    if (status != STP_OK)
        fail_msg("%s", err.message);
    stp_pool_destroy(&pool);
    return file;
}

/* Patches [first, ...) of a chunk are those of its part. */
static void assert_part(const stp_chunk *chunk, uint32_t first, const stp_chunk *part)
{
    assert_int_equal(part->linked, chunk->linked);
    assert_memory_equal(part->patches, chunk->patches + first,
                        part->patch_count * sizeof *part->patches);
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        const uint32_t *begin = chunk->level_begin[l] + first;
        for (uint32_t p = 0; p <= part->patch_count; p++)
            assert_int_equal(part->level_begin[l][p], begin[p] - begin[0]);
        assert_true((part->samples[l] == NULL) == (chunk->samples[l] == NULL));
        if (part->samples[l])
            assert_memory_equal(part->samples[l], chunk->samples[l] + begin[0],
                                part->level_begin[l][part->patch_count] * sizeof(stp_sample));
    }
}

static void assert_block(stp_chunk_file *file, const stp_block *block, const stp_chunk *chunk,
                         int level)
{
    stp_error err = {0};
    stp_chunk *part = NULL;
    const uint32_t bytes = stp_block_payload_bytes(block, level);
    uint8_t *payload = malloc((size_t)bytes + 1);
    assert_non_null(payload);
    assert_int_equal(stp_block_fetch(file, block, 0, bytes, payload, &err), STP_OK);
    stp_status status = stp_block_decode(file, block, level, payload, NULL, &part, &err);
    if (status != STP_OK)
        fail_msg("%s", err.message);
    assert_part(chunk, block->first_patch, part);
    assert_int_equal(part->memory_bytes, stp_block_memory_bytes(block, level));
    stp_chunk_destroy(&part);
    free(payload);
}

/* Each block of a chunk decodes to its part of the chunk; the blocks hold each patch once. Returns
 * the number of blocks. */
static uint32_t assert_blocks(stp_chunk_file *file, uint32_t id)
{
    uint32_t count = 0, patches = 0;
    assert_int_equal(stp_chunk_file_block_count(file, id, &count, NULL), STP_OK);
    stp_block *blocks = calloc(count, sizeof *blocks);
    assert_non_null(blocks);
    assert_int_equal(stp_chunk_file_blocks(file, id, blocks, NULL), STP_OK);
    for (int level = 2; level >= 0; level--) {
        stp_chunk *chunk = NULL;
        assert_int_equal(stp_chunk_file_read(file, id, level, &chunk, NULL), STP_OK);
        patches = 0;
        for (uint32_t b = 0; b < count; b++) {
            assert_int_equal(blocks[b].first_patch, patches);
            patches += blocks[b].patch_count;
            assert_block(file, &blocks[b], chunk, level);
        }
        assert_int_equal(patches, chunk->patch_count);
        stp_chunk_destroy(&chunk);
    }
    free(blocks);
    return count;
}

/* A chunk that is read back is the fixture's. */
static void assert_chunk(stp_chunk_file *file, uint32_t id, const stp_chunk *expected)
{
    stp_chunk *chunk = NULL;
    assert_int_equal(stp_chunk_file_read(file, id, 0, &chunk, NULL), STP_OK);
    assert_int_equal(chunk->patch_count, expected->patch_count);
    assert_part(expected, 0, chunk);
    stp_chunk_destroy(&chunk);
}

static void test_many_blocks(void **state)
{
    (void)state;
    static const uint32_t handle_of[7] = {6, 2, 5, 0, 1, 3, 4};
    for (int codec = 0; codec < STP_CODEC_COUNT; codec++) {
        const bool in_blocks = stp_codec_has_blocks((stp_codec)codec);
        const char *path = fixture_path("many.stipple");
        fixture_tree tree;
        fixture_tree_of_seven(&tree, 100, 33);
        assert_int_equal(fixture_write(&tree, path, (stp_codec)codec, NULL), STP_OK);
        stp_chunk_file *file = open_sound(path);
        assert_int_equal(stp_chunk_file_get_info(file)->version_major, in_blocks ? 2 : 1);
        for (uint32_t id = 0; id < 7; id++) {
            assert_chunk(file, id, tree.chunks[handle_of[id]]);
            assert_int_equal(assert_blocks(file, id), !in_blocks || id == 0 ? 1 : id < 3 ? 4 : 13);
        }
        stp_chunk_file_close(&file);
        fixture_destroy(&tree);
    }
}

static void test_one_block(void **state)
{
    (void)state;
    static const struct {
        uint32_t patch_count;
        unsigned per_patch;
    } cases[] = {{1, 1}, {1, 2}, {2, 1}, {1, 64}, {5, 5}, {1000, 64}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        for (int codec = STP_CODEC_RAW_BLOCKS; codec < STP_CODEC_COUNT; codec++) {
            const char *path = fixture_path("one.stipple");
            fixture_tree tree;
            fixture_single(&tree, cases[i].patch_count, cases[i].per_patch);
            assert_int_equal(fixture_write(&tree, path, (stp_codec)codec, NULL), STP_OK);
            stp_chunk_file *file = open_sound(path);
            assert_chunk(file, 0, tree.chunks[0]);
            assert_int_equal(assert_blocks(file, 0), 1);
            stp_chunk_file_close(&file);
            fixture_destroy(&tree);
        }
}

#define PATCHES 65536u
#define PER_PARENT 64u /* patches of the leaf that a patch of its parent stands for */

/* Makes a leaf of as many patches as there may be, one sample each, on a square. */
static stp_chunk *largest_leaf(void)
{
    static uint8_t counts[PATCHES];
    memset(counts, 1, sizeof counts);
    stp_chunk *leaf = fixture_allocate(counts, PATCHES);
    for (uint32_t p = 0; p < PATCHES; p++) {
        stp_sample *s = &leaf->samples[0][p];
        leaf->patches[p].origin[0] = (int32_t)(256 * (p % 256));
        leaf->patches[p].origin[1] = (int32_t)(256 * (p / 256));
        *s = (stp_sample){.position = {100, 100, (uint16_t)(p % 7)},
                          .radius = 1 + 16 * 5,
                          .flags = STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL,
                          .rgb = {(uint8_t)p, (uint8_t)(p >> 8), 9}};
        stp_normal_encode((vec3s){{0.0f, 0.0f, 1.0f}}, s->normal);
        fixture_finish_patch(leaf, p, FIXTURE_LEAF_ERROR);
    }
    return leaf;
}

static stp_chunk *parent_of_largest(const stp_chunk *leaf)
{
    uint8_t counts[PATCHES / PER_PARENT];
    memset(counts, PER_PARENT, sizeof counts);
    stp_chunk *parent = fixture_allocate(counts, PATCHES / PER_PARENT);
    parent->linked = true;
    for (uint32_t p = 0; p < parent->patch_count; p++) {
        const stp_patch *first = &leaf->patches[PER_PARENT * p];
        parent->patches[p].child = 0;
        parent->patches[p].first_below = (uint16_t)(PER_PARENT * p);
        memcpy(parent->patches[p].origin, first->origin, sizeof first->origin);
        for (uint32_t i = PER_PARENT * p; i < PER_PARENT * (p + 1); i++) {
            stp_sample *s = &parent->samples[0][i];
            *s = leaf->samples[3][i];
            s->position[0] =
                (uint16_t)(s->position[0] + leaf->patches[i].origin[0] - first->origin[0]);
        }
        fixture_finish_patch(parent, p, leaf->patches[0].error[STP_LEVEL_COUNT - 1]);
    }
    return parent;
}

static void test_most_patches(void **state)
{
    (void)state;
    fixture_tree tree;
    memset(&tree, 0, sizeof tree);
    tree.box = (stp_dbox){{0, 0, 0}, {512, 512, 1}};
    fixture_add(&tree, largest_leaf(), (stp_dvec3){0, 0, 0}, PATCHES);
    fixture_add(&tree, parent_of_largest(tree.chunks[0]), (stp_dvec3){0, 0, 0}, PATCHES);
    tree.child_counts[1] = 1;
    for (int codec = STP_CODEC_RAW_BLOCKS; codec < STP_CODEC_COUNT; codec++) {
        stp_error err = {0};
        const char *path = fixture_path("most.stipple");
        stp_status status = fixture_write(&tree, path, (stp_codec)codec, &err);
        if (status != STP_OK)
            fail_msg("%s", err.message);
        stp_chunk_file *file = open_sound(path);
        assert_chunk(file, 1, tree.chunks[0]);
        assert_int_equal(assert_blocks(file, 1), PATCHES / PER_PARENT);
        stp_chunk_file_close(&file);
    }
    fixture_destroy(&tree);
}

static void convert(const char *from, const char *to, int format)
{
    stp_error err = {0};
    stp_chunk_file *file = NULL;
    const stp_convert_params params = {.keep_codec = true, .format = format, .force = true};
    assert_int_equal(stp_chunk_file_open(&file, from, &err), STP_OK);
    stp_status status = stp_chunk_file_convert(file, to, &params, &err);
    if (status != STP_OK)
        fail_msg("%s", err.message);
    stp_chunk_file_close(&file);
}

static void assert_same_bytes(const char *a, const char *b)
{
    size_t size[2];
    uint8_t *bytes[2] = {fixture_read_file(a, &size[0]), fixture_read_file(b, &size[1])};
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    free(bytes[0]);
    free(bytes[1]);
}

static void test_there_and_back(void **state)
{
    (void)state;
    for (int codec = 0; codec <= STP_CODEC_ZSTD; codec++)
        for (int linked = 0; linked < 2; linked++) {
            char there[256], back[256], from[256];
            fixture_tree tree;
            snprintf(from, sizeof from, "%s", fixture_path("from.stipple"));
            snprintf(there, sizeof there, "%s", fixture_path("there.stipple"));
            snprintf(back, sizeof back, "%s", fixture_path("back.stipple"));
            fixture_tree_of_seven(&tree, 200, 64);
            for (uint32_t h = 0; h < tree.count && !linked; h++)
                fixture_unlink(tree.chunks[h]);
            assert_int_equal(fixture_write(&tree, from, (stp_codec)codec, NULL), STP_OK);
            convert(from, there, 2);
            convert(there, back, 1);
            assert_same_bytes(from, back);
            stp_chunk_file *file = open_sound(there);
            const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
            assert_int_equal(info->version_major, 2);
            assert_true(linked ? info->block_count > 7 : info->block_count == 7);
            for (uint32_t id = 0; id < 7; id++)
                assert_true(assert_blocks(file, id) > 0);
            stp_chunk_file_close(&file);
            fixture_destroy(&tree);
        }
}

/* A small record has what the wide one has; its box and cone hold those of the wide one, and exceed
 * them by no more than a place, or the steps of two codes. */
static void assert_holds(const stp_block *small, const stp_block *wide, const stp_chunk_entry *e)
{
    assert_int_equal(small->patch_count, wide->patch_count);
    assert_memory_equal(small->sample_count, wide->sample_count, sizeof wide->sample_count);
    assert_int_equal(small->flags, wide->flags);
    for (int s = 0; s < STP_SEGMENT_COUNT; s++) {
        assert_int_equal(small->parts[s].offset, wide->parts[s].offset);
        assert_int_equal(small->parts[s].bytes, wide->parts[s].bytes);
        assert_int_equal(small->parts[s].hash, wide->parts[s].hash);
    }
    assert_memory_equal(small->error, wide->error, sizeof wide->error);
    assert_memory_equal(small->tangential_error, wide->tangential_error,
                        sizeof wide->tangential_error);
    assert_memory_equal(small->colour_error, wide->colour_error, sizeof wide->colour_error);
    assert_float_equal(small->radius_max, wide->radius_max, 0.0f);
    for (int i = 0; i < 3; i++) {
        const float place = (e->box_max.raw[i] - e->box_min.raw[i]) / 1000.0f;
        assert_true(small->box_min.raw[i] <= wide->box_min.raw[i] &&
                    small->box_min.raw[i] >= wide->box_min.raw[i] - place);
        assert_true(small->box_max.raw[i] >= wide->box_max.raw[i] &&
                    small->box_max.raw[i] <= wide->box_max.raw[i] + place);
    }
    const double angle = (double)wide->cone_angle < M_PI ? (double)wide->cone_angle : M_PI;
    const double off = acos(fmin((double)glms_vec3_dot(small->cone_axis, wide->cone_axis), 1.0));
    assert_true((double)small->cone_angle >= fmin(angle + off - 1e-3, M_PI));
    assert_true((double)small->cone_angle <= angle + M_PI / 255.0 + 2e-3);
}

/* Files of the first writers have wide records. Small ones made from these say the same. */
static void test_wide_records(void **state)
{
    (void)state;
    const char *source = getenv("STIPPLE_SOURCE");
    static const char *const codecs[] = {"raw", "draco", "zstd"};
    for (int c = 0; c < 3; c++) {
        char path[1024];
        stp_chunk_file *file = NULL;
        stp_bytes records = {0};
        stp_block *wide = NULL, *small = NULL;
        uint32_t count = 0;
        stp_chunk_entry e;
        snprintf(path, sizeof path, "%s/tests/known/files/blocks_2_0_%s.stipple",
                 source ? source : ".", codecs[c]);
        assert_int_equal(stp_chunk_file_open(&file, path, NULL), STP_OK);
        for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
            assert_int_equal(stp_chunk_file_entry(file, id, &e, NULL), STP_OK);
            assert_int_equal(stp_chunk_file_block_count(file, id, &count, NULL), STP_OK);
            wide = calloc(count, sizeof *wide);
            small = calloc(count, sizeof *small);
            assert_true(wide && small);
            records.size = 0;
            assert_int_equal(stp_chunk_file_blocks(file, id, wide, NULL), STP_OK);
            assert_int_equal(stp_chunk_file_records(file, id, &records, NULL), STP_OK);
            assert_int_equal(records.size, (size_t)count * STP_BLOCK_BYTES);
            assert_int_equal(
                stp_block_records_read(records.data, STP_BLOCK_BYTES, &e, id, small, NULL), STP_OK);
            for (uint32_t b = 0; b < count; b++)
                assert_holds(&small[b], &wide[b], &e);
            free(wide);
            free(small);
        }
        free(records.data);
        stp_chunk_file_close(&file);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_many_blocks),  cmocka_unit_test(test_one_block),
        cmocka_unit_test(test_most_patches), cmocka_unit_test(test_there_and_back),
        cmocka_unit_test(test_wide_records),
    };
    return cmocka_run_group_tests_name("blocks", tests, NULL, fixture_remove_folder);
}
