/* The base library: errors, memory, checked arithmetic, the pool, output files, progress, random.
 */
#include "base/checked.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/pool.h"
#include "base/progress.h"
#include "base/random.h"
#include "base/vec.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mount.h>
#include <sys/stat.h>
#include <unistd.h>

/* A fresh folder; cmocka's state is its name. */
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

static void test_error_texts(void **state)
{
    (void)state;
    stp_error err = {0};
    assert_int_equal(stp_error_set(&err, STP_CORRUPT, "%s at byte %d", "x", 7), STP_CORRUPT);
    assert_int_equal(err.status, STP_CORRUPT);
    assert_string_equal(err.message, "x at byte 7");
    assert_int_equal(stp_error_set(NULL, STP_IO, "%d", 1), STP_IO);
    assert_string_equal(stp_status_name(STP_OK), "OK");
    assert_string_equal(stp_status_name(STP_INTERNAL), "INTERNAL");
    for (stp_status s = STP_OK; s <= STP_INTERNAL; s++) {
        assert_string_not_equal(stp_status_name(s), "UNKNOWN");
        assert_true(strlen(stp_status_text(s)) > 3);
    }
    assert_string_equal(stp_status_name((stp_status)99), "UNKNOWN");
    assert_non_null(stp_status_text((stp_status)99));
}

static void test_error_truncates(void **state)
{
    (void)state;
    stp_error err;
    char text[3000];
    memset(text, 'a', sizeof text - 1);
    text[sizeof text - 1] = '\0';
    stp_error_set(&err, STP_IO, "%s", text);
    assert_int_equal(strlen(err.message), sizeof err.message - 1);
}

static void test_checked(void **state)
{
    (void)state;
    uint64_t u = 5;
    size_t s = 5;
    assert_true(stp_add_u64(UINT64_MAX - 1, 1, &u));
    assert_true(u == UINT64_MAX);
    assert_false(stp_add_u64(UINT64_MAX, 1, &u));
    assert_true(stp_mul_u64(UINT64_C(1) << 32, UINT32_MAX, &u));
    assert_false(stp_mul_u64(UINT64_C(1) << 32, UINT64_C(1) << 32, &u));
    assert_true(stp_mul_size(SIZE_MAX, 1, &s));
    assert_false(stp_mul_size(SIZE_MAX, 2, &s));
    assert_true(stp_range_inside(0, 0, 0));
    assert_true(stp_range_inside(4, 6, 10));
    assert_false(stp_range_inside(4, 7, 10));
    assert_false(stp_range_inside(11, 0, 10));
    assert_false(stp_range_inside(UINT64_MAX, UINT64_MAX, 10));
}

static void test_alloc(void **state)
{
    (void)state;
    stp_error err = {0};
    int *numbers = NULL;
    assert_int_equal(stp_alloc(&numbers, 4, sizeof *numbers, "numbers", &err), STP_OK);
    assert_int_equal(numbers[3], 0);
    int *kept = numbers;
    assert_int_equal(stp_alloc(&numbers, SIZE_MAX / 2, 8, "numbers", &err), STP_OUT_OF_MEMORY);
    assert_ptr_equal(numbers, kept);
    assert_non_null(strstr(err.message, "numbers"));
    free(numbers);
    assert_int_equal(stp_alloc(&numbers, 0, 8, "none", &err), STP_OK);
    assert_null(numbers);
    char *text = NULL;
    assert_int_equal(stp_text_copy(&text, "kept", "a text", &err), STP_OK);
    assert_string_equal(text, "kept");
    free(text);
}

static void test_grow(void **state)
{
    (void)state;
    stp_error err = {0};
    int *array = NULL;
    size_t capacity = 0;
    for (size_t i = 0; i < 1000; i++) {
        assert_int_equal(stp_grow(&array, &capacity, i + 1, sizeof *array, "array", &err), STP_OK);
        assert_true(capacity > i);
        array[i] = (int)i;
    }
    assert_int_equal(array[999], 999);
    int *kept = array;
    size_t before = capacity;
    assert_int_equal(stp_grow(&array, &capacity, SIZE_MAX / 2, sizeof *array, "array", &err),
                     STP_OUT_OF_MEMORY);
    assert_ptr_equal(array, kept);
    assert_int_equal(capacity, before);
    free(array);
}

enum { TASK_COUNT = 1000 };

typedef struct job {
    _Atomic unsigned runs[TASK_COUNT];
    _Atomic unsigned worker_max;
    size_t fail_every; /* indices divisible by it fail; 0: none */
    size_t fail_from;
} job;

static stp_status job_task(void *context, size_t index, unsigned worker, stp_error *err)
{
    job *j = context;
    j->runs[index]++;
    unsigned seen = j->worker_max;
    while (worker > seen && !atomic_compare_exchange_weak(&j->worker_max, &seen, worker))
        ;
    if (j->fail_every && index >= j->fail_from && index % j->fail_every == 0)
        return stp_error_set(err, STP_CORRUPT, "task %zu", index);
    return STP_OK;
}

static void test_pool_runs_each_once(void **state)
{
    (void)state;
    stp_error err = {0};
    for (unsigned threads = 1; threads <= 4; threads++) {
        stp_pool *pool = NULL;
        assert_int_equal(stp_pool_create(&pool, threads, &err), STP_OK);
        assert_int_equal(stp_pool_thread_count(pool), threads);
        for (unsigned round = 1; round <= 20; round++) {
            job j = {.fail_every = 0};
            assert_int_equal(stp_pool_run(pool, TASK_COUNT, job_task, &j, &err), STP_OK);
            for (size_t i = 0; i < TASK_COUNT; i++)
                assert_int_equal(j.runs[i], 1);
            assert_true(j.worker_max < threads);
        }
        assert_int_equal(stp_pool_run(pool, 0, job_task, NULL, &err), STP_OK);
        stp_pool_destroy(&pool);
        assert_null(pool);
    }
    stp_pool *none = NULL;
    stp_pool_destroy(&none);
}

/* Whatever the threads, the lowest failing index is the one reported, and all below it have run. */
static void test_pool_failure_order(void **state)
{
    (void)state;
    for (unsigned threads = 1; threads <= 4; threads++) {
        stp_pool *pool = NULL;
        assert_int_equal(stp_pool_create(&pool, threads, NULL), STP_OK);
        for (unsigned round = 0; round < 50; round++) {
            job j = {.fail_every = 7, .fail_from = 350};
            stp_error err = {0};
            assert_int_equal(stp_pool_run(pool, TASK_COUNT, job_task, &j, &err), STP_CORRUPT);
            assert_string_equal(err.message, "task 350");
            unsigned total = 0;
            for (size_t i = 0; i < TASK_COUNT; i++)
                total += j.runs[i];
            for (size_t i = 0; i <= 350; i++)
                assert_int_equal(j.runs[i], 1);
            assert_true(total < TASK_COUNT);
            assert_int_equal(stp_pool_run(pool, TASK_COUNT, job_task, &j, NULL), STP_CORRUPT);
        }
        job good = {.fail_every = 0};
        assert_int_equal(stp_pool_run(pool, TASK_COUNT, job_task, &good, NULL), STP_OK);
        stp_pool_destroy(&pool);
    }
}

static void test_pool_limits(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_pool *pool = NULL;
    assert_int_equal(stp_pool_create(&pool, 257, &err), STP_LIMIT);
    assert_null(pool);
    assert_int_equal(stp_pool_create(&pool, 0, &err), STP_OK);
    assert_true(stp_pool_thread_count(pool) >= 1);
    stp_pool_destroy(&pool);
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
    /* An abandoned replacement leaves the old file, a finished one replaces it. */
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

/* What a killed run left goes with the next run; what a living one is writing stays. */
static void test_output_litter(void **state)
{
    static const char *const names[] = {"a.1.part", "a.x.part", "a.part", "b.1.part", "a.2.part"};
    char path[256];
    int living = -1;
    uint64_t bytes = 0;
    stp_output *output = NULL;
    for (int i = 0; i < 5; i++) {
        snprintf(path, sizeof path, "%s/%s", (char *)*state, names[i]);
        living = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        assert_true(living >= 0);
        assert_int_equal(write(living, "left", 4), 4);
        if (i < 4)
            close(living);
    }
    assert_int_equal(flock(living, LOCK_EX), 0);
    snprintf(path, sizeof path, "%s/a", (char *)*state);
    assert_int_equal(stp_output_create(&output, path, false, NULL), STP_OK);
    stp_output_destroy(&output);
    assert_int_equal(count_files(*state), 4);
    assert_int_equal(stp_output_sweep(path, &bytes), 0);
    close(living);
    assert_int_equal(stp_output_sweep(path, &bytes), 1);
    assert_int_equal(bytes, 4);
    assert_int_equal(count_files(*state), 3);
    snprintf(path, sizeof path, "%s/a.1.part", (char *)*state);
    assert_int_equal(access(path, F_OK), -1);
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

/* Writes until the disk says no; a tmpfs of 2 MB can only be mounted by root. */
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

typedef struct seen {
    uint64_t done;
    bool stop;
} seen;

static void see(void *context, const char *stage, uint64_t done, uint64_t total)
{
    assert_string_equal(stage, "sorting");
    assert_true(total == 9);
    ((seen *)context)->done = done;
}

static bool stop(void *context)
{
    return ((seen *)context)->stop;
}

static void test_folder_make(void **state)
{
    char path[256];
    stp_error err = {0};
    struct stat info;
    snprintf(path, sizeof path, "%s/a//b/c/", (char *)*state);
    assert_int_equal(stp_folder_make(path, 0700, &err), STP_OK);
    assert_int_equal(stp_folder_make(path, 0700, &err), STP_OK); /* it is there */
    assert_true(stat(path, &info) == 0 && S_ISDIR(info.st_mode) && (info.st_mode & 0777) == 0700);
    snprintf(path, sizeof path, "%s/file", (char *)*state);
    close(open(path, O_WRONLY | O_CREAT, 0600));
    snprintf(path, sizeof path, "%s/file/b/c", (char *)*state);
    assert_int_equal(stp_folder_make(path, 0700, &err), STP_IO);
    assert_int_equal(errno, ENOTDIR);
    assert_non_null(strstr(err.message, "/file/b: cannot be made"));
    assert_int_equal(stp_folder_make("", 0700, &err), STP_OK);
}

static void test_progress(void **state)
{
    (void)state;
    seen s = {0};
    stp_error err = {0};
    const stp_progress progress = {&s, see, stop};
    const stp_progress empty = {0};
    assert_int_equal(stp_progress_update(NULL, "sorting", 1, 9, &err), STP_OK);
    assert_int_equal(stp_progress_update(&empty, "sorting", 1, 9, &err), STP_OK);
    assert_int_equal(stp_progress_update(&progress, "sorting", 3, 9, &err), STP_OK);
    assert_true(s.done == 3);
    s.stop = true;
    assert_int_equal(stp_progress_update(&progress, "sorting", 4, 9, &err), STP_CANCELLED);
    assert_non_null(strstr(err.message, "sorting"));
}

static void test_random_and_clock(void **state)
{
    (void)state;
    double sum = 0.0;
    assert_true(stp_random_u64(1, 2) == stp_random_u64(1, 2));
    assert_true(stp_random_u64(1, 2) != stp_random_u64(1, 3));
    assert_true(stp_random_u64(1, 2) != stp_random_u64(2, 2));
    for (uint64_t i = 0; i < 10000; i++) {
        double u = stp_random_unit(7, i);
        assert_true(u >= 0.0 && u < 1.0);
        sum += u;
    }
    assert_true(fabs(sum / 10000.0 - 0.5) < 0.02);
    double start = stp_clock_seconds();
    assert_true(stp_clock_seconds() >= start);
    assert_true(stp_peak_rss_bytes() > 1 << 20);
}

static void test_box(void **state)
{
    (void)state;
    stp_dbox box = stp_dbox_empty();
    assert_true(stp_dbox_is_empty(&box));
    stp_dbox_add(&box, (stp_dvec3){1, 2, 3});
    assert_false(stp_dbox_is_empty(&box));
    stp_dbox_add(&box, (stp_dvec3){-1, 5, 3});
    assert_true(box.min.x == -1.0 && box.max.y == 5.0 && box.max.z == 3.0);
    stp_dvec3 zero = stp_dvec3_normalize((stp_dvec3){0, 0, 0});
    assert_true(stp_dvec3_length(zero) == 0.0);
    assert_false(stp_dvec3_finite((stp_dvec3){0, NAN, 0}));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_error_texts),
        cmocka_unit_test(test_error_truncates),
        cmocka_unit_test(test_checked),
        cmocka_unit_test(test_alloc),
        cmocka_unit_test(test_grow),
        cmocka_unit_test(test_pool_runs_each_once),
        cmocka_unit_test(test_pool_failure_order),
        cmocka_unit_test(test_pool_limits),
        cmocka_unit_test_setup_teardown(test_output_commit, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_abort, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_existing, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_appeared_meanwhile, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_litter, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_is_input, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_is_other_output, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_bad_place, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_output_disk_full, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_file_read, make_folder, remove_folder),
        cmocka_unit_test_setup_teardown(test_folder_make, make_folder, remove_folder),
        cmocka_unit_test(test_progress),
        cmocka_unit_test(test_random_and_clock),
        cmocka_unit_test(test_box),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
