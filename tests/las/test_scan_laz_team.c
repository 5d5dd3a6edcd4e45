/* Tests that several readers of a LAZ file give the points, and the errors, of one: of a COPC file
 * with a chunk for each point, of packed files, and, if STIPPLE_SCANS names real scans, of every
 * LAZ file there; also if the file is cut or damaged. */
#include "base/pool.h"
#include "tests/fixtures/scan/ept_fixture.h"
#include "tests/fixtures/scan/laz_fixture.h"
#include "tests/fixtures/size.h"

#include <ftw.h>
#include <unistd.h>

/* All that reading a file told. */
typedef struct told {
    stp_point *points;
    uint64_t count;
    stp_status status;
    stp_error error;
} told;

static told read_all(const char *path, const stp_scan_region *region, stp_pool *pool)
{
    const stp_scan_params params = {.region = region, .pool = pool};
    told out = {.error = {0}};
    stp_scan *scan = NULL;
    size_t count = 1;
    out.status = stp_scan_open(&scan, path, &params, &out.error);
    if (out.status != STP_OK)
        return out;
    out.points = calloc((size_t)stp_scan_get_info(scan)->point_count + 1, sizeof *out.points);
    assert_non_null(out.points);
    while (out.status == STP_OK && count > 0) {
        const uint64_t left = stp_scan_get_info(scan)->point_count - out.count;
        out.status = stp_scan_read(scan, out.points + out.count, left < 1501 ? (size_t)left : 1501,
                                   &count, &out.error);
        out.count += out.status == STP_OK ? count : 0;
    }
    stp_scan_close(&scan);
    return out;
}

static bool same_point(const stp_point *a, const stp_point *b)
{
    return a->position.x == b->position.x && a->position.y == b->position.y &&
           a->position.z == b->position.z && a->intensity == b->intensity &&
           a->class_id == b->class_id && a->reject == b->reject &&
           memcmp(a->rgb, b->rgb, sizeof a->rgb) == 0;
}

static void compare(const char *path, const stp_scan_region *region)
{
    const told one = read_all(path, region, NULL);
    for (unsigned threads = 1; threads <= 5; threads += threads == 3 ? 2 : 1) {
        stp_error err = {0};
        stp_pool *pool = NULL;
        assert_int_equal(stp_pool_create(&pool, threads, &err), STP_OK);
        const told more = read_all(path, region, pool);
        if (more.count != one.count || more.status != one.status ||
            strcmp(more.error.message, one.error.message) != 0)
            fail_msg("%s, %u threads: %llu points, then %s; one reader %llu, then %s", path,
                     threads, (unsigned long long)more.count, more.error.message,
                     (unsigned long long)one.count, one.error.message);
        for (uint64_t i = 0; i < one.count; i++)
            if (!same_point(&one.points[i], &more.points[i]))
                fail_msg("%s, %u threads: another point %llu", path, threads,
                         (unsigned long long)i);
        free(more.points);
        stp_pool_destroy(&pool);
    }
    free(one.points);
}

static void chosen_chunks(void **state)
{
    (void)state;
    static las_file file;
    const stp_scan_region all = {.resolution = 1e-3};
    const stp_scan_region corner = {
        .bounded = true, .min = {100, 200, 300}, .max = {120, 208, 330}};
    copc_make(&file);
    las_save(&file, "a.copc.laz");
    const told whole = read_all("a.copc.laz", &all, NULL);
    assert_true(whole.count == COPC_NODES);
    free(whole.points);
    compare("a.copc.laz", &all);
    compare("a.copc.laz", &corner);
    compare("a.copc.laz", NULL);
}

static unsigned files_compared;

static int check_file(const char *path, const struct stat *st, int kind, struct FTW *where)
{
    (void)st;
    (void)where;
    if (kind != FTW_F || !strstr(path, ".laz") || strstr(path, "ept-data"))
        return 0;
    compare(path, NULL);
    files_compared++;
    size_t size;
    unsigned char *content = scan_fixture_load(path, &size);
    for (size_t part = 3; part < 9; part += 2) { /* cut in the middle; damaged there */
        scan_fixture_bytes("c.laz", content, size / 10 * part);
        compare("c.laz", NULL);
        content[size / 10 * part] ^= 0x5a;
        scan_fixture_bytes("c.laz", content, size);
        compare("c.laz", NULL);
        content[size / 10 * part] ^= 0x5a;
    }
    free(content);
    return 0;
}

static void packed_files(void **state)
{
    (void)state;
    enum { COUNT = TEST_SIZE(9000, 3000) };
    static const unsigned formats[] = {1, 3, 6, 8};
    for (unsigned i = 0; i < 4; i++) {
        const laz_way way = {.format = formats[i],
                             .record_bytes = las_record_bytes[formats[i]] + i,
                             .chunk_points = 700};
        unsigned char *records = laz_make_records(way.format, way.record_bytes, COUNT, true);
        laz_write("p.laz", &way, records, COUNT);
        assert_int_equal(check_file("p.laz", NULL, FTW_F, NULL), 0);
        free(records);
    }
    assert_int_equal(files_compared, 4);
    files_compared = 0;
}

static void real_files(void **state)
{
    (void)state;
    char folder[4096];
    const char *scans = getenv("STIPPLE_SCANS");
    snprintf(folder, sizeof folder, "%s/laz", scans ? scans : "");
    if (!scans || access(folder, R_OK) != 0)
        skip();
    assert_int_equal(nftw(folder, check_file, 8, 0), 0);
    assert_true(files_compared >= 5);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(chosen_chunks),
        cmocka_unit_test(packed_files),
        cmocka_unit_test(real_files),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
