/* Tests the disk cache: it returns the right bytes or drops them, never exceeds its budget, and is
 * never in the way of a read. */
#include "tests/fixtures/chunk_fixture.h"

#include "base/pool.h"
#include "formats/chunk/byte_source.h"
#include "formats/chunk/remote/disk_cache.h"
#include "tests/support/check.h"
#include "tests/support/fault_server.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#define FILE_BYTES 400000u

static uint8_t file_bytes[FILE_BYTES];

static int set_up(void **state)
{
    (void)state;
    for (size_t i = 0; i < FILE_BYTES; i++)
        file_bytes[i] = (uint8_t)stp_random_u64(1, i);
    return 0;
}

/* ---- looking into the folder ---- */

/* Returns the bytes of all files in the folder. *count is the number of ranges, `last` the name of
 * one of them. */
static uint64_t folder_bytes(const char *path, size_t *count, char last[300])
{
    uint64_t bytes = 0;
    DIR *folder = opendir(path);
    assert_non_null(folder);
    *count = 0;
    for (struct dirent *e = readdir(folder); e != NULL; e = readdir(folder)) {
        struct stat info;
        if (e->d_name[0] == '.' || fstatat(dirfd(folder), e->d_name, &info, 0) != 0)
            continue;
        bool range = strstr(e->d_name, ".range") != NULL;
        bytes += range ? (uint64_t)info.st_size : 0;
        *count += range;
        if (range && last != NULL)
            snprintf(last, 300, "%s/%s", path, e->d_name);
    }
    closedir(folder);
    return bytes;
}

static stp_disk_cache *open_cache(const char *folder, uint64_t budget, const char *key)
{
    stp_disk_cache *cache = NULL;
    check_ok(stp_disk_cache_open(&cache, folder, budget, key, err));
    return cache;
}

static bool is_well(stp_disk_cache *cache)
{
    stp_error note = {0};
    return !stp_disk_cache_note(cache, &note);
}

static void keep(stp_disk_cache *cache, uint64_t offset, size_t size)
{
    stp_disk_cache_write(cache, offset, file_bytes + offset, size);
}

static size_t get(stp_disk_cache *cache, uint64_t offset, size_t size)
{
    static uint8_t got[FILE_BYTES];
    size_t bytes = stp_disk_cache_read(cache, offset, got, size);
    assert_true(bytes <= size);
    assert_memory_equal(got, file_bytes + offset, bytes);
    return bytes;
}

/* ---- ranges ---- */

static void ranges_are_found_again(void **state)
{
    const char *folder = fixture_path("found");
    stp_disk_cache *cache = open_cache(folder, 0, "one");
    (void)state;
    keep(cache, 1000, 500);
    keep(cache, 1500, 700);
    keep(cache, 5000, 100);
    keep(cache, 900, 50);
    for (int again = 0; again < 2; again++) {
        assert_int_equal(get(cache, 1000, 1200), 1200);
        assert_int_equal(get(cache, 1100, 1000), 1000);
        assert_int_equal(get(cache, 1100, 3000), 1100);
        assert_int_equal(get(cache, 999, 10), 0);
        assert_int_equal(get(cache, 900, 100), 50);
        assert_int_equal(get(cache, 5099, 1), 1);
        assert_int_equal(get(cache, 5100, 1), 0);
        assert_int_equal(get(cache, 0, 0), 0);
        assert_true(is_well(cache));
        stp_disk_cache_close(&cache);
        cache = open_cache(folder, 0, "one");
    }
    stp_disk_cache *other = open_cache(folder, 0, "another state of the file");
    assert_int_equal(get(other, 1000, 500), 0);
    stp_disk_cache_drop(cache, 1600, 3500);
    assert_int_equal(get(cache, 1000, 1200), 500);
    assert_int_equal(get(cache, 5000, 100), 0);
    stp_disk_cache_close(&other);
    stp_disk_cache_close(&cache);
}

static void damage_is_dropped_and_counted(void **state)
{
    const char *folder = fixture_path("damaged");
    char name[300];
    size_t count = 0;
    (void)state;
    for (int harm = 0; harm < 5; harm++) {
        stp_disk_cache *cache = open_cache(folder, 0, "one");
        size_t size = 0;
        keep(cache, 0, 10000);
        (void)folder_bytes(folder, &count, name);
        assert_int_equal(count, 1);
        uint8_t *bytes = fixture_read_file(name, &size);
        if (harm == 0) /* a bit of the data; of the header; cut; extended; another file */
            bytes[5000] ^= 1;
        else if (harm == 1)
            bytes[30] ^= 1;
        else
            size = harm == 2 ? size - 1 : harm == 3 ? size + 1 : 0;
        fixture_write_file(name, bytes, size);
        free(bytes);
        assert_int_equal(get(cache, 0, 10000), 0);
        assert_int_equal(stp_disk_cache_damaged(cache), 1);
        assert_true(access(name, F_OK) != 0);
        keep(cache, 0, 10000);
        assert_int_equal(get(cache, 0, 10000), 10000);
        stp_disk_cache_drop(cache, 0, 10000);
        stp_disk_cache_close(&cache);
    }
    /* a range removed by another process is no damage; a folder under the range's name is */
    stp_disk_cache *cache = open_cache(folder, 0, "one");
    keep(cache, 0, 10000);
    keep(cache, 20000, 10000);
    (void)folder_bytes(folder, &count, name);
    assert_int_equal(unlink(name), 0);
    assert_int_equal(get(cache, 0, 10000) + get(cache, 20000, 10000), 10000);
    assert_int_equal(stp_disk_cache_damaged(cache), 0);
    (void)folder_bytes(folder, &count, name);
    assert_int_equal(unlink(name), 0);
    assert_int_equal(mkdir(name, 0700), 0);
    assert_int_equal(get(cache, 0, 10000) + get(cache, 20000, 10000), 0);
    assert_int_equal(stp_disk_cache_damaged(cache), 1);
    stp_disk_cache_close(&cache);
}

/* ---- budget ---- */

static void the_budget_is_kept(void **state)
{
    const uint64_t budget = 60000;
    const char *folder = fixture_path("budget");
    stp_disk_cache *cache = open_cache(folder, budget, "one");
    size_t count = 0;
    (void)state;
    char own[400];
    snprintf(own, sizeof own, "%s/of the user.txt", folder);
    fixture_write_file(own, file_bytes, 50000);
    for (uint64_t i = 0; i < 200; i++) {
        uint64_t offset = stp_random_u64(3, i) % 300000;
        keep(cache, offset, 1 + stp_random_u64(4, i) % 20000);
        assert_true(folder_bytes(folder, &count, NULL) <= budget);
        assert_true(count > 0);
    }
    keep(cache, 0, 70000); /* never fits */
    assert_true(folder_bytes(folder, &count, NULL) <= budget && count > 0);
    stp_disk_cache_close(&cache);
    /* a killed writer left a file, and the budget shrank */
    char part[400];
    snprintf(part, sizeof part, "%s/stipple-cache.part", folder);
    fixture_write_file(part, file_bytes, 1000);
    cache = open_cache(folder, 30000, "two");
    assert_true(folder_bytes(folder, &count, NULL) <= 30000);
    assert_true(access(part, F_OK) != 0 && access(own, F_OK) == 0);
    assert_true(is_well(cache));
    stp_disk_cache_close(&cache);
}

/* Makes a file look as if it had been used this many seconds ago. */
static void make_older(const char *name, time_t seconds)
{
    struct stat info;
    assert_int_equal(stat(name, &info), 0);
    const struct timespec times[2] = {{.tv_nsec = UTIME_OMIT}, {info.st_mtim.tv_sec - seconds, 0}};
    assert_int_equal(utimensat(AT_FDCWD, name, times, 0), 0);
}

static void what_was_used_lately_stays(void **state)
{
    const char *folder = fixture_path("lately");
    stp_disk_cache *cache = open_cache(folder, 45000, "one");
    char name[300];
    size_t count = 0;
    (void)state;
    for (uint64_t i = 0; i < 4; i++) {
        keep(cache, 20000 * i, 10000);
        (void)folder_bytes(folder, &count, name);
        /* makes every range in the folder 1000 s older, in whatever order readdir lists them */
        DIR *all = opendir(folder);
        for (struct dirent *e = readdir(all); e != NULL; e = readdir(all)) {
            snprintf(name, sizeof name, "%.40s/%.200s", folder, e->d_name);
            if (strstr(e->d_name, ".range") != NULL)
                make_older(name, 1000);
        }
        closedir(all);
    }
    assert_int_equal(get(cache, 0, 10000), 10000); /* was the oldest, but is used now */
    keep(cache, 100000, 10000);
    assert_int_equal(get(cache, 0, 10000), 10000);
    assert_int_equal(get(cache, 100000, 10000), 10000);
    assert_int_equal(get(cache, 20000, 10000), 0);
    stp_disk_cache_close(&cache);
}

static void several_processes_share(void **state)
{
    const uint64_t budget = 150000;
    const char *folder = fixture_path("shared");
    size_t count = 0;
    (void)state;
    stp_disk_cache *cache = open_cache(folder, budget, "one");
    stp_disk_cache_close(&cache);
    for (unsigned p = 0; p < 4; p++) {
        if (fork() != 0)
            continue;
        cache = open_cache(folder, budget, "one");
        for (uint64_t i = 0; i < 150; i++) {
            uint64_t offset = stp_random_u64(p, i) % 40 * 8000;
            size_t size = 1000 + stp_random_u64(9, i) % 7000;
            if (get(cache, offset, size) < size)
                keep(cache, offset, size);
        }
        bool right = stp_disk_cache_damaged(cache) == 0 && is_well(cache);
        stp_disk_cache_close(&cache);
        _exit(right ? 0 : 1);
    }
    for (unsigned running = 4; running > 0;) {
        int code = 0;
        assert_true(folder_bytes(folder, &count, NULL) <= budget);
        if (waitpid(-1, &code, WNOHANG) > 0) {
            assert_int_equal(code, 0);
            running--;
        }
    }
    assert_true(folder_bytes(folder, &count, NULL) <= budget && count > 0);
}

static stp_status use_cache(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_disk_cache *cache = context;
    uint8_t got[9000];
    uint64_t offset = stp_random_u64(5, index) % 40 * 8000;
    size_t size = 1000 + stp_random_u64(6, index) % 8000;
    (void)worker;
    size_t bytes = stp_disk_cache_read(cache, offset, got, size);
    if (memcmp(got, file_bytes + offset, bytes) != 0)
        return stp_error_set(err, STP_CORRUPT, "wrong bytes at %u", (unsigned)offset);
    if (bytes < size)
        keep(cache, offset + bytes, size - bytes);
    if (index % 7 == 0)
        stp_disk_cache_drop(cache, offset, size);
    return STP_OK;
}

static void several_threads_share(void **state)
{
    const uint64_t budget = 150000;
    const char *folder = fixture_path("threads");
    stp_disk_cache *cache = open_cache(folder, budget, "one");
    stp_pool *pool = NULL;
    size_t count = 0;
    (void)state;
    check_ok(stp_pool_create(&pool, 6, err));
    check_ok(stp_pool_run(pool, 1000, use_cache, cache, err));
    assert_true(folder_bytes(folder, &count, NULL) <= budget && count > 0);
    assert_true(is_well(cache) && stp_disk_cache_damaged(cache) == 0);
    stp_pool_destroy(&pool);
    stp_disk_cache_close(&cache);
}

/* ---- unusable folders ---- */

static void a_folder_that_does_not_do_is_told(void **state)
{
    stp_error note = {0};
    (void)state;
    const char *plain = fixture_path("plain");
    fixture_write_file(plain, "x", 1);
    stp_disk_cache *cache = open_cache(plain, 0, "one");
    keep(cache, 0, 1000);
    assert_int_equal(get(cache, 0, 1000), 0);
    assert_true(stp_disk_cache_note(cache, &note));
    assert_non_null(strstr(note.message, "nothing can be kept there"));
    stp_disk_cache_close(&cache);
    cache = open_cache("/proc/no/such", 0, "one");
    keep(cache, 0, 1000);
    assert_false(is_well(cache));
    stp_disk_cache_close(&cache);
    char deep[300];
    snprintf(deep, sizeof deep, "%s/a//b/c/", fixture_folder);
    cache = open_cache(deep, 0, "one");
    assert_true(is_well(cache));
    stp_disk_cache_close(&cache);
    assert_int_equal(access(deep, F_OK), 0);
}

/* Files may not grow beyond a size, as on a full disk: ranges that are there can still be read. */
static void a_full_disk_is_told(void **state)
{
    const char *folder = fixture_path("full");
    struct rlimit before;
    stp_error note = {0};
    (void)state;
    stp_disk_cache *cache = open_cache(folder, 0, "one");
    keep(cache, 0, 1000);
    getrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &(struct rlimit){2000, before.rlim_max});
    keep(cache, 5000, 50000);
    keep(cache, 200000, 1000);
    setrlimit(RLIMIT_FSIZE, &before);
    assert_true(stp_disk_cache_note(cache, &note));
    assert_non_null(strstr(note.message, "without keeping it"));
    assert_int_equal(get(cache, 0, 1000), 1000);
    assert_int_equal(get(cache, 5000, 50000) + get(cache, 200000, 1000), 0);
    stp_disk_cache_close(&cache);
}

/* ---- with a server ---- */

static void read_all(const fault_server *server, const char *folder, stp_byte_source_stats *stats,
                     bool *noted)
{
    static uint8_t got[FILE_BYTES];
    const stp_byte_source_params params = {.cache_folder = folder, .pause_ms = 2};
    stp_byte_source *source = NULL;
    stp_error note = {0};
    check_ok(stp_byte_source_open(&source, server->address, &params, err));
    for (size_t at = 0; at < FILE_BYTES; at += 50000)
        check_ok(stp_byte_source_read(source, at, got + at, 50000, err));
    assert_memory_equal(got, file_bytes, FILE_BYTES);
    check_ok(stp_byte_source_reread(source, 70000, got, 100, err)); /* goes past the cache */
    assert_memory_equal(got, file_bytes + 70000, 100);
    stp_byte_source_get_stats(source, stats);
    *noted = stp_byte_source_note(source, &note);
    stp_byte_source_close(&source);
}

static void a_second_reading_costs_no_bytes(void **state)
{
    const char *folder = fixture_path("server");
    stp_byte_source_stats stats;
    fault_server server;
    bool noted = false;
    (void)state;
    assert_true(fault_server_create(&server, file_bytes, FILE_BYTES));
    read_all(&server, folder, &stats, &noted);
    assert_int_equal(stats.cached_bytes, 0);
    assert_int_equal(stats.requests, 1 + 8 + 1);
    assert_false(noted);
    read_all(&server, folder, &stats, &noted);
    /* the read past the cache dropped one range and stored what it read */
    assert_int_equal(stats.requests, 1 + 1 + 1);
    assert_int_equal(stats.cached_bytes, FILE_BYTES - 50000);
    /* after the file changed, nothing of its first state is used */
    fault_server_order(&server, &(fault_orders){.validator = FAULT_MODIFIED});
    read_all(&server, folder, &stats, &noted);
    assert_int_equal(stats.cached_bytes, 0);
    /* a file without a validator cannot be recognised, so it is not kept */
    fault_server_order(&server, &(fault_orders){.validator = FAULT_NO_VALIDATOR});
    read_all(&server, folder, &stats, &noted);
    assert_true(noted);
    read_all(&server, folder, &stats, &noted);
    assert_int_equal(stats.cached_bytes, 0);
    fault_server_destroy(&server);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranges_are_found_again),
        cmocka_unit_test(damage_is_dropped_and_counted),
        cmocka_unit_test(the_budget_is_kept),
        cmocka_unit_test(what_was_used_lately_stays),
        cmocka_unit_test(several_processes_share),
        cmocka_unit_test(several_threads_share),
        cmocka_unit_test(a_folder_that_does_not_do_is_told),
        cmocka_unit_test(a_full_disk_is_told),
        cmocka_unit_test(a_second_reading_costs_no_bytes),
    };
    return cmocka_run_group_tests(tests, set_up, fixture_remove_folder);
}
