/* Tests output files that appear whole or not at all, reading files, and making folders. */
#include "base/file.h"
#include "base/temporary.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <sys/xattr.h>
#include <unistd.h>

/* Makes a fresh folder; cmocka's state is its name. */
static int make_folder(void **state)
{
    char name[] = "base-XXXXXX";
    char *path = mkdtemp(name);
    *state = path ? strdup(path) : NULL;
    return *state ? 0 : -1;
}

static int remove_folder(void **state)
{
    char command[256];
    snprintf(command, sizeof command, "rm -rf '%s'", (char *)*state);
    int code = system(command);
    free(*state);
    return code;
}

static size_t count_files(const char *folder)
{
    size_t count = 0;
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    for (struct dirent *e = readdir(directory); e; e = readdir(directory))
        count += e->d_name[0] != '.';
    closedir(directory);
    return count;
}

static void assert_content(const char *path, const char *expected)
{
    char content[256] = "";
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    size_t size = fread(content, 1, sizeof content - 1, file);
    fclose(file);
    assert_int_equal(size, strlen(expected));
    assert_string_equal(content, expected);
}
static void test_output_commit(void **state)
{
    char path[256];
    stp_error err = {0};
    stp_output *output = NULL;
    snprintf(path, sizeof path, "%s/\xc3\xa9t\xc3\xa9 1.bin", (char *)*state);
    assert_int_equal(stp_output_create(&output, path, false, &err), STP_OK);
    assert_int_equal(stp_output_write(output, "hello world", 11, &err), STP_OK);
    assert_int_equal(stp_output_write_at(output, 6, "W", 1, &err), STP_OK);
    assert_int_equal(stp_output_write(output, "!", 1, &err), STP_OK);
    assert_true(stp_output_size(output) == 12);
    assert_int_equal(access(path, F_OK), -1);
    assert_int_equal(access(stp_output_temporary_path(output), F_OK), 0);
    assert_int_equal(stp_output_commit(&output, &err), STP_OK);
    assert_null(output);
    assert_content(path, "hello World!");
    assert_int_equal(count_files(*state), 1);
}

/* Another process writes a part of the file, also behind what this one has written so far. */
static void test_output_shared(void **state)
{
    char path[256];
    int other = -1;
    stp_error err = {0};
    stp_output *output = NULL;
    snprintf(path, sizeof path, "%s/shared", (char *)*state);
    assert_int_equal(stp_output_create_shared(&output, path, false, &err), STP_OK);
    assert_int_equal(stp_output_write(output, "hello ", 6, &err), STP_OK);
    assert_int_equal(stp_file_join(stp_output_temporary_path(output), &other, &err), STP_OK);
    assert_int_equal(stp_file_write_at(other, path, 12, "too", 3, &err), STP_OK);
    assert_int_equal(stp_output_skip(output, 5, &err), STP_OK);
    assert_int_equal(stp_output_write(output, " ", 1, &err), STP_OK);
    assert_int_equal(stp_output_skip(output, 3, &err), STP_OK);
    assert_true(stp_output_size(output) == 15);
    assert_int_equal(stp_file_write_at(other, path, 6, "World", 5, &err), STP_OK);
    assert_int_equal(stp_file_close(other, path, &err), STP_OK);
    assert_int_equal(access(path, F_OK), -1);
    assert_int_equal(stp_output_sweep(path, NULL), 0); /* it is in use */
    assert_int_equal(stp_output_commit(&output, &err), STP_OK);
    assert_content(path, "hello World too");
    assert_int_equal(stp_output_create_shared(&output, path, true, &err), STP_OK);
    assert_int_equal(count_files(*state), 2);
    stp_output_destroy(&output);
    assert_int_equal(count_files(*state), 1);
    assert_int_equal(stp_file_join("/dev/full", &other, &err), STP_OK);
    assert_int_equal(stp_file_write_at(other, path, 0, "x", 1, &err), STP_IO);
    assert_non_null(strstr(err.message, "/shared: the disk is full"));
    close(other);
    snprintf(path, sizeof path, "%s/none", (char *)*state);
    assert_int_equal(stp_file_join(path, &other, &err), STP_IO);
    assert_non_null(strstr(err.message, "/none: cannot be opened for writing"));
}

static void test_output_abort(void **state)
{
    char path[256];
    stp_output *output = NULL;
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    assert_int_equal(stp_output_create(&output, path, false, NULL), STP_OK);
    assert_int_equal(stp_output_write(output, "x", 1, NULL), STP_OK);
    stp_output_destroy(&output);
    assert_null(output);
    stp_output_destroy(&output);
    assert_int_equal(count_files(*state), 0);
}

static void test_output_existing(void **state)
{
    char path[256];
    stp_error err = {0};
    stp_output *output = NULL;
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    assert_int_equal(stp_output_create(&output, path, false, NULL), STP_OK);
    assert_int_equal(stp_output_write(output, "old", 3, NULL), STP_OK);
    assert_int_equal(stp_output_commit(&output, NULL), STP_OK);
    assert_int_equal(stp_output_create(&output, path, false, &err), STP_EXISTS);
    assert_non_null(strstr(err.message, "--force"));
    assert_null(output);
    /* An abandoned output leaves the old file; a finished one replaces it. */
    for (int finish = 0; finish < 2; finish++) {
        assert_int_equal(stp_output_create(&output, path, true, NULL), STP_OK);
        assert_int_equal(stp_output_write(output, "new", 3, NULL), STP_OK);
        if (finish)
            assert_int_equal(stp_output_commit(&output, NULL), STP_OK);
        else
            stp_output_destroy(&output);
        assert_content(path, finish ? "new" : "old");
    }
    assert_int_equal(count_files(*state), 1);
}

static void test_output_appeared_meanwhile(void **state)
{
    char path[256];
    stp_error err = {0};
    stp_output *first = NULL;
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    assert_int_equal(stp_output_create(&first, path, false, NULL), STP_OK);
    FILE *other = fopen(path, "w");
    assert_non_null(other);
    fputs("other", other);
    fclose(other);
    assert_int_equal(stp_output_commit(&first, &err), STP_EXISTS);
    assert_null(first);
    assert_content(path, "other");
    assert_int_equal(count_files(*state), 1);
}

/* The next run removes what a killed run left. It keeps what a living process is writing, and files
 * that only look alike. */
static void test_output_litter(void **state)
{
    static const char *const names[] = {"a.0123456789abcdef.part",
                                        "a.1.part",
                                        "a.part",
                                        "b.0123456789abcdef.part",
                                        "a.x123456789abcdef.part",
                                        "a.fedcba9876543210.part",
                                        "a.ffffffffffffffff.part"};
    const int count = (int)(sizeof names / sizeof *names);
    char path[256];
    int living = -1;
    uint64_t bytes = 0;
    stp_output *output = NULL;
    for (int i = 0; i < count; i++) {
        snprintf(path, sizeof path, "%s/%s", (char *)*state, names[i]);
        living = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        assert_true(living >= 0);
        assert_int_equal(write(living, "left", 4), 4);
        if (i != 5)
            assert_true(stp_temporary_mark(living));
        if (i == 0 && fgetxattr(living, "user.stipple.part", NULL, 0) < 0)
            skip(); /* the file system has no attributes */
        if (i < count - 1)
            close(living);
    }
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    assert_int_equal(stp_output_create(&output, path, false, NULL), STP_OK);
    stp_output_destroy(&output);
    assert_int_equal(count_files(*state), count - 1);
    assert_int_equal(stp_output_sweep(path, &bytes), 0);
    close(living);
    assert_int_equal(stp_output_sweep(path, &bytes), 1);
    assert_int_equal(bytes, 4);
    assert_int_equal(count_files(*state), count - 2);
    snprintf(path, sizeof path, "%s/%s", (char *)*state, names[0]);
    assert_int_equal(access(path, F_OK), -1);
}

/* While an output is written, it has no name that another process could open. */
static void test_output_nameless(void **state)
{
    char path[256];
    stp_output *output = NULL;
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    assert_int_equal(stp_output_create(&output, path, true, NULL), STP_OK);
    if (strncmp(stp_output_temporary_path(output), "/proc/", 6) == 0)
        assert_int_equal(count_files(*state), 0);
    assert_int_equal(stp_output_write(output, "whole", 5, NULL), STP_OK);
    assert_int_equal(stp_output_commit(&output, NULL), STP_OK);
    assert_content(path, "whole");
    assert_int_equal(getxattr(path, "user.stipple.part", NULL, 0), -1);
    assert_int_equal(count_files(*state), 1);
}

/* Many processes replace one file at once: each must succeed. */
static void test_output_together(void **state)
{
    enum { PROCESSES = 8, ROUNDS = 200 };
    char path[256];
    pid_t children[PROCESSES];
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    for (int p = 0; p < PROCESSES; p++) {
        children[p] = fork();
        assert_true(children[p] >= 0);
        for (int i = 0; children[p] == 0 && i < ROUNDS; i++) {
            stp_output *output = NULL;
            if (stp_output_create(&output, path, true, NULL) != STP_OK ||
                stp_output_write(output, "whole", 5, NULL) != STP_OK ||
                stp_output_commit(&output, NULL) != STP_OK)
                _exit(1);
        }
        if (children[p] == 0)
            _exit(0);
    }
    for (int p = 0; p < PROCESSES; p++) {
        int code = -1;
        assert_int_equal(waitpid(children[p], &code, 0), children[p]);
        assert_int_equal(code, 0);
    }
    assert_content(path, "whole");
    assert_int_equal(count_files(*state), 1);
}

static void test_output_is_input(void **state)
{
    char path[256], same[256], link_path[256];
    stp_error err = {0};
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    snprintf(same, sizeof same, "%s/./a", (char *)*state);
    snprintf(link_path, sizeof link_path, "%s/b", (char *)*state);
    assert_int_equal(stp_output_check_input(path, path, &err), STP_OK); /* neither exists */
    int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    assert_true(file >= 0);
    close(file);
    assert_int_equal(stp_output_check_input(link_path, path, &err), STP_OK);
    assert_int_equal(stp_output_check_input(same, path, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "also an input"));
    assert_int_equal(symlink("a", link_path), 0);
    assert_int_equal(stp_output_check_input(link_path, path, &err), STP_INVALID_ARGUMENT);
}

static void test_output_is_other_output(void **state)
{
    char path[256], same[256], other[256];
    stp_error err = {0};
    stp_output *output = NULL;
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    snprintf(same, sizeof same, "%s/./a", (char *)*state);
    snprintf(other, sizeof other, "%s/b", (char *)*state);
    assert_int_equal(stp_output_create(&output, path, false, &err), STP_OK);
    assert_int_equal(stp_output_check_other(output, other, &err), STP_OK);
    assert_int_equal(stp_output_check_other(output, path, &err), STP_INVALID_ARGUMENT);
    assert_int_equal(stp_output_check_other(output, same, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "written twice"));
    stp_output_destroy(&output);
}

static void test_output_bad_place(void **state)
{
    char path[256];
    stp_error err = {0};
    stp_output *output = NULL;
    snprintf(path, sizeof path, "%s/no/such/folder", (char *)*state);
    assert_int_equal(stp_output_create(&output, path, false, &err), STP_IO);
    assert_non_null(strstr(err.message, path));
    assert_int_equal(stp_output_create(&output, *state, true, &err), STP_IO);
    assert_null(output);
}

/* Writes until the disk is full. Only root can mount the tmpfs of 2 MB. */
static void test_output_disk_full(void **state)
{
    char path[256];
    stp_error err = {0};
    stp_output *output = NULL;
    char *block = calloc(1, 1 << 20);
    assert_non_null(block);
    if (mount("none", *state, "tmpfs", 0, "size=2m") != 0) {
        free(block);
        print_message("skipped: mounting a small tmpfs needs root\n");
        skip();
        return;
    }
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    stp_status status = stp_output_create(&output, path, false, &err);
    for (int i = 0; i < 8 && status == STP_OK; i++)
        status = stp_output_write(output, block, 1 << 20, &err);
    stp_output_destroy(&output);
    size_t left = count_files(*state);
    umount(*state);
    free(block);
    assert_int_equal(status, STP_IO);
    assert_non_null(strstr(err.message, "disk is full"));
    assert_int_equal(left, 0);
}

static void test_file_read(void **state)
{
    char path[256], data[8] = "";
    int descriptor = -1;
    uint64_t size = 0;
    stp_error err = {0};
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    assert_int_equal(stp_file_open(path, &descriptor, &size, &err), STP_NOT_FOUND);
    assert_int_equal(stp_file_open(*state, &descriptor, &size, &err), STP_IO);
    assert_int_equal(descriptor, -1);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("0123456789", file);
    fclose(file);
    assert_int_equal(stp_file_open(path, &descriptor, &size, &err), STP_OK);
    assert_true(size == 10);
    assert_int_equal(stp_file_read_at(descriptor, path, 3, data, 4, &err), STP_OK);
    assert_memory_equal(data, "3456", 4);
    assert_int_equal(stp_file_read_at(descriptor, path, 8, data, 4, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "byte 10"));
    close(descriptor);
}

static void test_folder_make(void **state)
{
    char path[256];
    stp_error err = {0};
    struct stat info;
    snprintf(path, sizeof path, "%s/a//b/c/", (char *)*state);
    assert_int_equal(stp_folder_make(path, 0700, &err), STP_OK);
    assert_int_equal(stp_folder_make(path, 0700, &err), STP_OK); /* it exists already */
    assert_true(stat(path, &info) == 0 && S_ISDIR(info.st_mode) && (info.st_mode & 0777) == 0700);
    snprintf(path, sizeof path, "%s/file", (char *)*state);
    close(open(path, O_WRONLY | O_CREAT, 0600));
    snprintf(path, sizeof path, "%s/file/b/c", (char *)*state);
    assert_int_equal(stp_folder_make(path, 0700, &err), STP_IO);
    assert_int_equal(errno, ENOTDIR);
    assert_non_null(strstr(err.message, "/file/b: cannot be made"));
    assert_int_equal(stp_folder_make("", 0700, &err), STP_OK);
}
int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_output_commit, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_shared, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_abort, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_existing, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_appeared_meanwhile, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_litter, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_nameless, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_together, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_is_input, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_is_other_output, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_bad_place, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_disk_full, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_file_read, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_folder_make, make_folder, remove_folder),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
