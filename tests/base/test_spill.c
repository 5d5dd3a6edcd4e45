/* Tests arrays that may be larger than memory. In memory or in files, they must hold what was
 * written, even if the limit is far below their size. */
#include "base/pool.h"
#include "base/spill.h"
#include "tests/fixtures/size.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include <stdlib.h>
#include <time.h>

#define LIMIT_BYTES (160u << 20)
#define COUNT ((size_t)TEST_SIZE(48u << 20, 4u << 20)) /* 64-bit numbers: 384 MB */
#define PARTS 64u

static stp_spill *make(uint64_t memory_bytes, const char *folder)
{
    stp_error err = {0};
    stp_spill *spill = NULL;
    const stp_spill_params params = {.memory_bytes = memory_bytes, .folder = folder};
    assert_int_equal(stp_spill_create(&spill, &params, &err), STP_OK);
    return spill;
}

static void arrays_are_zero_and_kept(stp_spill *spill)
{
    stp_error err = {0};
    uint32_t *numbers[20] = {NULL};
    for (uint32_t a = 0; a < 20; a++) {
        assert_int_equal(
            stp_spill_alloc(spill, &numbers[a], 1 + 1000 * a, sizeof **numbers, "numbers", &err),
            STP_OK);
        for (uint32_t i = 0; i < 1 + 1000 * a; i++) {
            assert_int_equal(numbers[a][i], 0);
            numbers[a][i] = i * a;
        }
    }
    for (uint32_t a = 0; a < 20; a += 2)
        stp_spill_free(spill, numbers[a]);
    for (uint32_t a = 1; a < 20; a += 2)
        for (uint32_t i = 0; i < 1 + 1000 * a; i++)
            assert_int_equal(numbers[a][i], i * a);
    for (uint32_t a = 1; a < 20; a += 2)
        stp_spill_free(spill, numbers[a]);
    stp_spill_free(spill, NULL);
}

static void plain_memory(void **state)
{
    (void)state;
    arrays_are_zero_and_kept(NULL);
    stp_spill *spill = make(0, NULL);
    arrays_are_zero_and_kept(spill);
    assert_int_equal(stp_spill_most_file_bytes(spill), 0);
    uint32_t one = 1, *nothing = &one;
    assert_int_equal(stp_spill_alloc(spill, &nothing, 0, 4, "nothing", NULL), STP_OK);
    assert_null(nothing);
    stp_spill_destroy(&spill);
    stp_spill_destroy(&spill);
}

static void files(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_spill *spill = make(LIMIT_BYTES, ".");
    arrays_are_zero_and_kept(spill);
    assert_true(stp_spill_most_file_bytes(spill) >= 20 * 19 / 2 * 1000 * 4);
    char *text = strdup("kept"), *lost = NULL;
    const char *was = text;
    assert_int_equal(stp_spill_move(spill, &text, 5, 1, "text", &err), STP_OK);
    assert_true(text != was && strcmp(text, "kept") == 0);
    stp_spill_free(spill, text);
    stp_spill_free(spill, strdup("plain memory"));
    assert_int_equal(stp_spill_alloc(spill, &lost, 10, 1, "left to destroy", &err), STP_OK);
    assert_int_equal(stp_spill_alloc(spill, &lost, SIZE_MAX / 2, 3, "too much", &err),
                     STP_OUT_OF_MEMORY);
    assert_int_equal(stp_spill_alloc(spill, &lost, (size_t)1 << 61, 1, "of the disk", &err),
                     STP_IO);
    assert_non_null(strstr(err.message, "--temp"));
    stp_spill_destroy(&spill);
}

/* Many small arrays share few files, are freed in another order, and leave no file in the end. */
static void small_arrays_share_files(void **state)
{
    (void)state;
    enum { ARRAYS = 3000 };
    static uint32_t *arrays[ARRAYS];
    stp_error err = {0};
    stp_spill *spill = make(LIMIT_BYTES, ".");
    uint64_t bytes = 0;
    for (uint32_t a = 0; a < ARRAYS; a++) {
        uint32_t count = a % 100 == 99 ? 600000 : 1 + a * 7 % 5000;
        assert_int_equal(stp_spill_alloc(spill, &arrays[a], count, 4, "numbers", &err), STP_OK);
        assert_int_equal((uintptr_t)arrays[a] % 64, 0);
        assert_int_equal(arrays[a][0] | arrays[a][count - 1], 0);
        arrays[a][0] = arrays[a][count - 1] = a;
        bytes += 4 * count;
    }
    uint64_t taken = stp_spill_most_file_bytes(spill);
    assert_true(taken >= bytes && taken < bytes + bytes / 10 + (16u << 20));
    for (uint32_t i = 0; i < ARRAYS; i++) {
        uint32_t a = (uint32_t)((uint64_t)i * 1009 % ARRAYS);
        assert_int_equal(arrays[a][0], a);
        stp_spill_free(spill, arrays[a]);
    }
    uint32_t *large = NULL; /* as large as all of them together: their room is free again */
    assert_int_equal(stp_spill_alloc(spill, &large, taken, 1, "a large one", &err), STP_OK);
    assert_int_equal(stp_spill_most_file_bytes(spill), taken);
    stp_spill_free(spill, large);
    stp_spill_destroy(&spill);
}

/* Arrays that fit into the memory of their own take no file, and are kept when pages are dropped;
 * when one is freed, another takes its place. */
static void memory_of_their_own(void **state)
{
    (void)state;
    enum { NUMBERS = 4 << 20 };
    stp_error err = {0};
    stp_spill *spill = NULL;
    const stp_spill_params params = {
        .memory_bytes = 1, .own_bytes = 5 * sizeof(uint32_t) * NUMBERS / 2, .folder = "."};
    uint32_t *arrays[3] = {NULL};
    assert_int_equal(stp_spill_create(&spill, &params, &err), STP_OK);
    for (uint32_t a = 0; a < 3; a++) {
        const uint64_t before = stp_spill_most_file_bytes(spill);
        assert_int_equal(stp_spill_alloc(spill, &arrays[a], NUMBERS, 4, "numbers", &err), STP_OK);
        assert_int_equal(stp_spill_most_file_bytes(spill) - before,
                         a < 2 ? 0 : NUMBERS * sizeof(uint32_t));
        for (uint32_t i = 0; i < NUMBERS; i++)
            arrays[a][i] = i + a;
    }
    stp_spill_relieve(spill); /* far beyond the limit: all that lies in files is dropped */
    for (uint32_t a = 0; a < 3; a++)
        for (uint32_t i = 0; i < NUMBERS; i++)
            assert_int_equal(arrays[a][i], i + a);
    stp_spill_free(spill, arrays[0]);
    const uint64_t before = stp_spill_most_file_bytes(spill);
    assert_int_equal(stp_spill_alloc(spill, &arrays[0], NUMBERS, 4, "numbers", &err), STP_OK);
    assert_int_equal(stp_spill_most_file_bytes(spill), before);
    assert_int_equal(arrays[0][0] | arrays[0][NUMBERS - 1], 0);
    stp_spill_destroy(&spill);
}

/* The room of a forgotten part can be used again; the parts around it are kept. */
static void forgotten_parts(void **state)
{
    (void)state;
    enum { COUNT_HERE = 4 << 20, BEGIN = 1 << 20, END = 3 << 20 };
    stp_error err = {0};
    uint32_t *numbers = NULL, *others = NULL;
    stp_spill *spill = make(LIMIT_BYTES, ".");
    assert_int_equal(stp_spill_alloc(spill, &numbers, COUNT_HERE, 4, "numbers", &err), STP_OK);
    for (uint32_t i = 0; i < COUNT_HERE; i++)
        numbers[i] = i;
    stp_spill_forget(spill, numbers + BEGIN + 1, (END - BEGIN - 2) * sizeof *numbers);
    stp_spill_forget(spill, numbers, sizeof *numbers); /* less than a page */
    for (uint32_t i = 0; i < COUNT_HERE; i++)
        if (i <= BEGIN || i >= END - 1)
            assert_int_equal(numbers[i], i);
    uint64_t taken = stp_spill_most_file_bytes(spill);
    assert_int_equal(stp_spill_alloc(spill, &others, END - BEGIN - 4096, 4, "others", &err),
                     STP_OK);
    assert_int_equal(stp_spill_most_file_bytes(spill), taken);
    stp_spill_free(spill, numbers);
    stp_spill_free(spill, others);
    assert_int_equal(stp_spill_alloc(spill, &numbers, taken, 1, "as much as there was", &err),
                     STP_OK);
    assert_int_equal(stp_spill_most_file_bytes(spill), taken);
    uint32_t plain[2048] = {1, 2};
    stp_spill_forget(NULL, plain, sizeof plain);
    stp_spill_forget(spill, plain, sizeof plain);
    assert_int_equal(plain[0] + plain[1], 3);
    stp_spill_destroy(&spill);
}

/* An array larger than the disk takes the space of its claimed parts, one after the other. */
static void sparse_array(stp_spill *spill, bool in_files)
{
    enum { PART = 1 << 19 };
    const size_t count = (size_t)1 << TEST_SIZE(40, 34); /* TSan has no place for more */
    stp_error err = {0};
    uint32_t *numbers = NULL, *others = NULL;
    assert_int_equal(stp_spill_alloc_sparse(spill, &numbers, count, 4, "numbers", &err), STP_OK);
    assert_int_equal(stp_spill_most_file_bytes(spill), 0);
    for (size_t at = 0; at < count; at += count / 4) {
        uint32_t *part = numbers + at;
        assert_int_equal(stp_spill_claim(spill, part, PART * sizeof *part, "numbers", &err),
                         STP_OK);
        for (uint32_t i = 0; i < PART; i++) {
            assert_int_equal(part[i], 0);
            part[i] = i + 1;
        }
        if (at > 0)
            stp_spill_forget(spill, part, PART * sizeof *part);
    }
    assert_int_equal(
        stp_spill_claim(spill, numbers + count / 4, PART * sizeof *numbers, "a part", &err),
        STP_OK);
    assert_int_equal(numbers[count / 4] | numbers[count / 4 + PART - 1], 0);
    assert_int_equal(numbers[0] + numbers[PART - 1], 1 + PART);
    assert_int_equal(stp_spill_most_file_bytes(spill), in_files ? 2 * PART * sizeof *numbers : 0);
    stp_spill_free(spill, numbers);
    assert_int_equal(stp_spill_alloc(spill, &others, 2 * PART, 4, "others", &err), STP_OK);
    assert_int_equal(stp_spill_most_file_bytes(spill), in_files ? 2 * PART * sizeof *numbers : 0);
    stp_spill_free(spill, others);
    stp_spill_destroy(&spill);
}

static void sparse_arrays(void **state)
{
    (void)state;
    sparse_array(make(LIMIT_BYTES, "."), true);
    sparse_array(make(0, NULL), false);
}

static void a_folder_must_be_there(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_spill *spill = NULL;
    const stp_spill_params params = {.memory_bytes = 1, .folder = "./no such folder"};
    assert_int_equal(stp_spill_create(&spill, &params, &err), STP_IO);
    assert_non_null(strstr(err.message, "./no such folder"));
    assert_null(spill);
}

static uint64_t value_of(size_t i)
{
    return i * 0x9e3779b97f4a7c15u ^ i >> 7;
}

/* Waits before each part, so that three workers touch 0.9 GB a second at most, far more than any
 * stage of prep. On a crowded machine the watching thread may have to wait; what the workers touch
 * meanwhile is not tested. */
static void pause_before_part(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 20000000}, NULL);
}

static stp_status fill(void *context, size_t part, unsigned worker, stp_error *err)
{
    uint64_t *numbers = context;
    (void)worker;
    (void)err;
    pause_before_part();
    for (size_t i = part * (COUNT / PARTS); i < (part + 1) * (COUNT / PARTS); i++)
        numbers[i] = value_of(i);
    return STP_OK;
}

/* Each worker alternates between its part and another worker's. */
static stp_status compare(void *context, size_t part, unsigned worker, stp_error *err)
{
    const uint64_t *numbers = context;
    (void)worker;
    pause_before_part();
    for (size_t i = part * (COUNT / PARTS); i < (part + 1) * (COUNT / PARTS); i++) {
        size_t other = (i + COUNT / 3) % COUNT;
        if (numbers[i] != value_of(i) || numbers[other] != value_of(other))
            return stp_error_set(err, STP_INTERNAL, "number %zu is wrong", i);
    }
    return STP_OK;
}

/* The most memory that this process held, in bytes, as the system says; 0 if it does not say. */
static uint64_t most_resident(void)
{
    char line[256];
    unsigned long kilobytes = 0;
    FILE *file = fopen("/proc/self/status", "r");
    while (file && fgets(line, sizeof line, file))
        if (sscanf(line, "VmHWM: %lu", &kilobytes) == 1)
            break;
    if (file)
        fclose(file);
    return (uint64_t)kilobytes << 10;
}

static void more_than_the_limit(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_pool *pool = NULL;
    uint64_t *numbers = NULL;
    stp_spill *spill = make(LIMIT_BYTES, ".");
    assert_int_equal(stp_pool_create(&pool, 3, &err), STP_OK);
    assert_int_equal(stp_spill_alloc(spill, &numbers, COUNT, sizeof *numbers, "numbers", &err),
                     STP_OK);
    assert_int_equal(stp_pool_run(pool, PARTS, fill, numbers, &err), STP_OK);
    assert_int_equal(stp_pool_run(pool, PARTS, compare, numbers, &err), STP_OK);
#if !defined __SANITIZE_ADDRESS__ && !defined __SANITIZE_THREAD__
    /* Allows half as much again: on a crowded machine the watching thread may come late. */
    assert_true(most_resident() > 0 && most_resident() < LIMIT_BYTES * 3ull / 2);
#else
    (void)most_resident;
#endif
    stp_spill_free(spill, numbers);
    stp_pool_destroy(&pool);
    stp_spill_destroy(&spill);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(plain_memory),
        cmocka_unit_test(files),
        cmocka_unit_test(small_arrays_share_files),
        cmocka_unit_test(memory_of_their_own),
        cmocka_unit_test(forgotten_parts),
        cmocka_unit_test(sparse_arrays),
        cmocka_unit_test(a_folder_must_be_there),
        cmocka_unit_test(more_than_the_limit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
