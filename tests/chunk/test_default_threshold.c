/* Tests storing a model's default threshold: the rest of the file stays as it is, or nothing is
 * stored. */
#include "formats/chunk/convert.h"

#include "formats/chunk/layout.h"
#include "tests/fixtures/chunk_fixture.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

static double threshold_of(const char *path)
{
    stp_chunk_file *file = NULL;
    assert_int_equal(stp_chunk_file_open(&file, path, NULL), STP_OK);
    double px = stp_chunk_file_threshold(stp_chunk_file_get_info(file));
    stp_chunk_file_close(&file);
    return px;
}

static void test_set(void **state)
{
    (void)state;
    fixture_tree tree;
    stp_error err = {0};
    size_t size[3] = {0};
    uint8_t *bytes[3];
    const char *path = fixture_path("model.stipple");
    fixture_tree_of_seven(&tree, 6, 40);
    assert_int_equal(fixture_write(&tree, path, STP_CODEC_ZSTD, &err), STP_OK);
    bytes[0] = fixture_read_file(path, &size[0]);
    assert_true(threshold_of(path) == 0.0);
    assert_int_equal(stp_chunk_file_set_threshold(path, 1.75, &err), STP_OK);
    assert_true(threshold_of(path) == 1.75);
    bytes[1] = fixture_read_file(path, &size[1]);
    uint64_t payloads_end = stp_get_u64(bytes[0] + 40);
    assert_memory_equal(bytes[0] + 256, bytes[1] + 256, payloads_end - 256);
    assert_int_equal(stp_chunk_file_set_threshold(path, 4.0, &err), STP_OK);
    assert_int_equal(stp_chunk_file_set_threshold(path, 1.75, &err), STP_OK);
    bytes[2] = fixture_read_file(path, &size[2]);
    assert_int_equal(size[1], size[2]);
    assert_memory_equal(bytes[1], bytes[2], size[1]);
    for (int i = 0; i < 3; i++)
        free(bytes[i]);
    fixture_destroy(&tree);
}

static void test_refused(void **state)
{
    (void)state;
    fixture_tree tree;
    stp_error err = {0};
    static const double wrong[] = {0.0, -1.0, (double)INFINITY, (double)NAN};
    const char *path = fixture_path("refused.stipple");
    fixture_single(&tree, 3, 10);
    assert_int_equal(fixture_write(&tree, path, STP_CODEC_DRACO, &err), STP_OK);
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_int_equal(stp_chunk_file_set_threshold(path, wrong[i], &err), STP_INVALID_ARGUMENT);
    assert_int_equal(
        stp_chunk_file_set_threshold("http://127.0.0.1:1/m.stipple", 2.0, NULL) == STP_OK, 0);
    assert_true(threshold_of(path) == 0.0);
    fixture_destroy(&tree);
}

/* If a threshold cannot be written, the model must stay as it was, alone in its folder. */
static void check_unwritten(const char *path, const char *message)
{
    stp_error err = {0};
    size_t size[2] = {0};
    uint8_t *before = fixture_read_file(path, &size[0]);
    stp_status status = stp_chunk_file_set_threshold(path, 2.0, &err);
    uint8_t *after = fixture_read_file(path, &size[1]);
    bool same = size[0] == size[1] && memcmp(before, after, size[0]) == 0;
    free(before);
    free(after);
    assert_int_equal(status, STP_IO);
    assert_non_null(strstr(err.message, message));
    assert_true(same);
}

static void test_read_only_folder(void **state)
{
    (void)state;
    fixture_tree tree;
    stp_error err = {0};
    char folder[256];
    const char *path = fixture_path("locked/m.stipple");
    snprintf(folder, sizeof folder, "%s", fixture_path("locked"));
    fixture_single(&tree, 3, 10);
    assert_int_equal(mkdir(folder, 0755), 0);
    assert_int_equal(fixture_write(&tree, path, STP_CODEC_ZSTD, &err), STP_OK);
    fixture_destroy(&tree);
    assert_int_equal(chmod(folder, 0555), 0);
    bool refused = access(folder, W_OK) != 0;
    if (refused)
        check_unwritten(path, path);
    assert_int_equal(chmod(folder, 0755), 0);
    if (!refused) {
        print_message("skipped: this user may write everywhere\n");
        skip();
    }
}

/* The disk has room for one model only. Only root can mount a small tmpfs. */
static void test_disk_full(void **state)
{
    (void)state;
    fixture_tree tree;
    stp_error err = {0};
    char folder[256], room[32];
    size_t size = 0;
    const char *path = fixture_path("size.stipple");
    fixture_tree_of_seven(&tree, 40, 60);
    assert_int_equal(fixture_write(&tree, path, STP_CODEC_ZSTD, &err), STP_OK);
    free(fixture_read_file(path, &size));
    snprintf(room, sizeof room, "size=%zu", size + size / 2);
    snprintf(folder, sizeof folder, "%s", fixture_path("small"));
    assert_int_equal(mkdir(folder, 0755), 0);
    if (mount("none", folder, "tmpfs", 0, room) != 0) {
        fixture_destroy(&tree);
        print_message("skipped: mounting a small tmpfs needs root\n");
        skip();
        return;
    }
    path = fixture_path("small/m.stipple");
    assert_int_equal(fixture_write(&tree, path, STP_CODEC_ZSTD, &err), STP_OK);
    fixture_destroy(&tree);
    check_unwritten(path, "disk is full");
    assert_int_equal(unlink(path), 0);
    assert_int_equal(umount(folder), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_set),
        cmocka_unit_test(test_refused),
        cmocka_unit_test(test_read_only_folder),
        cmocka_unit_test(test_disk_full),
    };
    return cmocka_run_group_tests(tests, NULL, fixture_remove_folder);
}
