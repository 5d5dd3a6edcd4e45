/* Tests that verify names a single flipped bit, wherever it is: every bit of a small file, padding
 * included (every third of files of version 1), and some bits of a large one (long_flips.c tries
 * all of those). */
#include "tests/fixtures/flip_fixture.h"

#include "tests/fixtures/size.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>

#include <cmocka.h>

static stp_pool *make_pool(unsigned threads)
{
    stp_pool *pool = NULL;
    assert_int_equal(stp_pool_create(&pool, threads, NULL), STP_OK);
    return pool;
}

/* The message must be one line that says which file, what is wrong, and where. */
static void assert_named(const flip_file *f, size_t bit, stp_pool *pool)
{
    stp_error err = {0};
    stp_status status = flip_and_verify(f, bit, pool, &err);
    if (status == STP_OK)
        print_error("bit %zu of byte %zu is not found\n", bit % 8, bit / 8);
    assert_true(status == STP_CORRUPT || (bit < 64 && status == STP_FORMAT) ||
                (bit >= 64 && bit < 80 && status == STP_VERSION));
    assert_int_equal(strncmp(err.message, f->path, strlen(f->path)), 0);
    assert_null(strchr(err.message, '\n'));
    assert_true(bit < 80 || strstr(err.message, "byte"));
}

static void flip_bits(fixture_tree *tree, stp_codec codec, size_t step)
{
    stp_pool *pool = make_pool(1);
    const char *path = fixture_path("small.stipple");
    assert_int_equal(fixture_write(tree, path, codec, NULL), STP_OK);
    fixture_destroy(tree);
    flip_file f = flip_file_open(path);
    for (size_t bit = 0; bit < 8 * f.size; bit += step)
        assert_named(&f, bit, pool);
    assert_int_equal(flip_verify(f.path, pool, NULL), STP_OK);
    flip_file_close(&f);
    stp_pool_destroy(&pool);
}

static void test_every_third_bit(void **state)
{
    (void)state;
    for (int codec = 0; codec <= STP_CODEC_ZSTD; codec++) {
        fixture_tree tree;
        fixture_tree_of_seven(&tree, 2, 2);
        flip_bits(&tree, (stp_codec)codec, 3);
    }
}

/* A root over a leaf of two blocks. */
static void test_every_bit_of_blocks(void **state)
{
    (void)state;
    for (int codec = STP_CODEC_RAW_BLOCKS; codec < STP_CODEC_COUNT; codec++) {
        const uint32_t leaf = 0;
        fixture_tree tree;
        fixture_single(&tree, 9, TEST_SIZE(3, 1));
        fixture_add_parent(&tree, &leaf, 1);
        flip_bits(&tree, (stp_codec)codec, 1);
    }
}

static void test_some_bits(void **state)
{
    (void)state;
    stp_pool *pool = make_pool(2);
    flip_file f = flip_large_file();
    assert_true(f.size > 900000 && f.size < 1400000);
    assert_int_equal(flip_verify(f.path, pool, NULL), STP_OK);
    for (uint64_t i = 0; i < TEST_SIZE(40, 4); i++)
        assert_named(&f, (size_t)(stp_random_u64(3, i) % (8 * f.size)), pool);
    assert_int_equal(flip_verify(f.path, pool, NULL), STP_OK);
    flip_file_close(&f);
    stp_pool_destroy(&pool);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_third_bit),
        cmocka_unit_test(test_every_bit_of_blocks),
        cmocka_unit_test(test_some_bits),
    };
    return cmocka_run_group_tests_name("flips", tests, NULL, fixture_remove_folder);
}
