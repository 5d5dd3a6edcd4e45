/* Tests the base library: errors, memory, checked arithmetic, the pool, progress, random
 * numbers. */
#include "base/checked.h"
#include "base/clock.h"
#include "base/error.h"
#include "base/file.h"
#include "base/memory.h"
#include "base/pool.h"
#include "base/progress.h"
#include "base/random.h"
#include "base/sort.h"
#include "base/vec.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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
    assert_int_equal(stp_alloc_unset(&numbers, SIZE_MAX / 2, 8, "numbers", &err),
                     STP_OUT_OF_MEMORY);
    assert_int_equal(stp_alloc_unset(&numbers, 4, sizeof *numbers, "numbers", &err), STP_OK);
    assert_non_null(numbers);
    free(numbers);
    assert_int_equal(stp_alloc_unset(&numbers, 0, 8, "none", &err), STP_OK);
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
    size_t fail_every; /* every index divisible by it fails; 0: none fails */
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

/* For any number of threads, the pool reports the lowest failing index, and all indices below it
 * have run. */
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

enum { AHEAD = 5 };

typedef struct ordered_job {
    job tasks;
    _Atomic size_t taken;    /* calls of `then` that have ended */
    _Atomic unsigned taking; /* and that have not */
    size_t fail_then;        /* `then` of this index fails */
} ordered_job;

static stp_status ordered_task(void *context, size_t index, unsigned worker, stp_error *err)
{
    ordered_job *j = context;
    assert_true(index - j->taken < AHEAD);
    for (volatile size_t i = index % 3 * 2000; i > 0; i--)
        ; /* so that tasks end out of order */
    return job_task(&j->tasks, index, worker, err);
}

static stp_status take_task(void *context, size_t index, unsigned worker, stp_error *err)
{
    ordered_job *j = context;
    (void)worker;
    assert_int_equal(j->taking++, 0);
    assert_int_equal(index, j->taken);
    assert_int_equal(j->tasks.runs[index], 1);
    j->taking--;
    j->taken++;
    if (index == j->fail_then)
        return stp_error_set(err, STP_CORRUPT, "then %zu", index);
    return STP_OK;
}

static void test_pool_in_order(void **state)
{
    (void)state;
    for (unsigned threads = 1; threads <= 8; threads++) {
        stp_error err = {0};
        stp_pool *pool = NULL;
        ordered_job good = {.fail_then = SIZE_MAX}, late = {.fail_then = 350};
        ordered_job bad = {.tasks = {.fail_every = 7, .fail_from = 350}, .fail_then = SIZE_MAX};
        assert_int_equal(stp_pool_create(&pool, threads, &err), STP_OK);
        assert_int_equal(
            stp_pool_run_in_order(pool, TASK_COUNT, AHEAD, ordered_task, take_task, &good, &err),
            STP_OK);
        assert_int_equal(good.taken, TASK_COUNT);
        assert_int_equal(
            stp_pool_run_in_order(pool, TASK_COUNT, AHEAD, ordered_task, take_task, &bad, &err),
            STP_CORRUPT);
        assert_string_equal(err.message, "task 350");
        assert_true(bad.taken <= 350);
        assert_int_equal(
            stp_pool_run_in_order(pool, TASK_COUNT, AHEAD, ordered_task, take_task, &late, &err),
            STP_CORRUPT);
        assert_string_equal(err.message, "then 350");
        assert_int_equal(late.taken, 351);
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

static void test_endings(void **state)
{
    (void)state;
    assert_true(stp_path_ends_in("a.folder/scan.LAZ", ".laz"));
    assert_true(stp_path_ends_in(".laz", ".laz"));
    assert_false(stp_path_ends_in("scan.laz.ply", ".laz"));
    assert_false(stp_path_ends_in("az", ".laz"));
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* Of all orders of values, and of those that divide badly. */
static void test_sort(void **state)
{
    enum { MOST = 3000, KINDS = 7 };
    static double values[MOST], sorted[MOST];
    (void)state;
    for (size_t count = 0; count <= MOST; count += 1 + count / 3)
        for (int kind = 0; kind < KINDS; kind++) {
            for (size_t i = 0; i < count; i++) {
                const double random = stp_random_unit((uint64_t)kind, i);
                const double all[KINDS] = {random,
                                           floor(4.0 * random),
                                           1.0,
                                           (double)i,
                                           -(double)i,
                                           (double)(i < count / 2 ? i : count - i),
                                           (double)(i % 2 ? i : count)};
                values[i] = sorted[i] = all[kind];
            }
            qsort(sorted, count, sizeof *sorted, compare_doubles);
            stp_sort_doubles(values, count);
            assert_memory_equal(values, sorted, count * sizeof *values);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_error_texts),
        cmocka_unit_test(test_error_truncates),
        cmocka_unit_test(test_sort),
        cmocka_unit_test(test_checked),
        cmocka_unit_test(test_alloc),
        cmocka_unit_test(test_grow),
        cmocka_unit_test(test_pool_runs_each_once),
        cmocka_unit_test(test_pool_failure_order),
        cmocka_unit_test(test_pool_in_order),
        cmocka_unit_test(test_pool_limits),
        cmocka_unit_test(test_progress),
        cmocka_unit_test(test_random_and_clock),
        cmocka_unit_test(test_box),
        cmocka_unit_test(test_endings),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
