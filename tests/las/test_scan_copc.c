/* Tests COPC: parts of the octree against brute force, and files that lie. If STIPPLE_SCANS names
 * real scans, the COPC files there are read in part and whole. */
#include "formats/scan/octree/octree.h"
#include "tests/fixtures/scan/ept_fixture.h"

#include <math.h>

static las_file file;

/* Whether the point in the middle of a node is in a region down to a depth. */
static bool is_wanted(unsigned depth, const unsigned key[3], const stp_scan_region *region,
                      unsigned last)
{
    ept_point p = {{0}, 0, {0}, 0, 0, depth, {0}};
    copc_middle(depth, key, p.at);
    return depth <= last && stp_scan_region_has(region, ept_position(&p));
}

static unsigned count_wanted(const stp_scan_region *region, unsigned last)
{
    unsigned depth = 0, key[3] = {0}, count = 0;
    do
        count += is_wanted(depth, key, region, last);
    while (ept_next_node(&depth, key));
    return count;
}

/* Reads a region. Returns the number of points that it has; *read: that were read for it. */
static unsigned read_region(const char *path, const stp_scan_region *region, uint64_t *read)
{
    const stp_scan_params params = {.region = region};
    stp_scan_info info;
    unsigned count = 0;
    stp_point *points = scan_fixture_read(path, &params, &info);
    *read = info.point_count;
    for (uint64_t i = 0; i < info.point_count; i++) {
        const bool inside = stp_scan_region_has(region, points[i].position);
        assert_int_equal(points[i].reject, inside ? STP_REJECT_NONE : STP_REJECT_OUTSIDE);
        count += inside;
    }
    free(points);
    return count;
}

static void whole(void **state)
{
    (void)state;
    stp_scan_info info;
    copc_make(&file);
    las_save(&file, "a.copc.laz");
    stp_point *points = scan_fixture_read("a.copc.laz", NULL, &info);
    assert_int_equal(info.point_count, COPC_NODES);
    for (unsigned i = 0; i < COPC_NODES; i++)
        assert_int_equal(points[i].intensity, 1000 + i);
    free(points);
    stp_error err = {0};
    stp_scan *scan = NULL;
    assert_int_equal(stp_scan_open(&scan, "a.copc.laz", NULL, &err), STP_OK);
    assert_string_equal(stp_scan_get_info(scan)->format, "COPC 1.4 point format 6");
    assert_true(stp_scan_get_info(scan)->octree_spacing == 4.0);
    stp_scan_close(&scan);
}

static void regions(void **state)
{
    (void)state;
    uint64_t read;
    copc_make(&file);
    las_save(&file, "a.copc.laz");
    for (uint64_t i = 0; i < 60; i++) {
        stp_scan_region region = {.bounded = i % 4 != 3};
        for (unsigned k = 0; k < 3; k++) {
            region.min[k] = 95.0 + 100.0 * k + (double)(stp_random_u64(20 + k, i) % 70);
            region.max[k] = region.min[k] + (double)(stp_random_u64(30, i) % 40);
        }
        const unsigned depth = i % 3 == 0 ? EPT_DEPTHS : (unsigned)(i % 3) - 1;
        region.resolution = i % 3 == 0 ? 0.0 : depth == 0 ? 4.0 : 2.5;
        assert_int_equal(read_region("a.copc.laz", &region, &read), count_wanted(&region, depth));
    }
    const stp_scan_region corner = {
        .bounded = true, .min = {100, 200, 300}, .max = {108, 208, 308}};
    const stp_scan_region nowhere = {.bounded = true, .min = {0}, .max = {1, 1, 1}};
    assert_int_equal(read_region("a.copc.laz", &corner, &read), 1);
    assert_int_equal(read, 3); /* of the root, of its corner, of the corner's corner */
    assert_int_equal(read_region("a.copc.laz", &nowhere, &read), 0);
    assert_int_equal(read, 0);
}

/* A scan without an octree is cut point by point, and has no resolutions. */
static void no_octree(void **state)
{
    (void)state;
    uint64_t read;
    const stp_scan_region box = {.bounded = true, .min = {0, 0, 0}, .max = {2, 2, 2}};
    const stp_scan_region coarse = {.resolution = 1.0};
    const stp_scan_params params = {.region = &coarse};
    scan_fixture_text("a.xyz", "0 0 0\n1 1 1\n2 2 2\n3 3 3\n1 1 9\n");
    assert_int_equal(read_region("a.xyz", &box, &read), 3);
    assert_int_equal(read, 5);
    scan_fixture_fails("a.xyz", &params, STP_INVALID_ARGUMENT, "has no levels of detail");
    las_begin(&file, 2, 0, 20);
    las_add_point(&file, -1998, 8000, -23992);
    las_add_point(&file, 0, 0, 0);
    las_set_count(&file, 2);
    las_save(&file, "a.las");
    assert_int_equal(read_region("a.las", &box, &read), 1);
    assert_int_equal(read, 2);
    scan_fixture_fails("a.las", &params, STP_INVALID_ARGUMENT, "has no levels of detail");
}

/* ---- files that lie ---- */

typedef struct lie {
    size_t at; /* in the record "copc" 1, or in the first page from 160 on */
    size_t bytes;
    uint64_t value;
    stp_status status;
    const char *words;
} lie;

#define PAGE 160u
#define ENTRY 32u
/* The entry of the first page that names the second. */
#define LAST_ENTRY (PAGE + ENTRY * 64u)

static void files_that_lie(void **state)
{
    (void)state;
    static const lie lies[] = {
        {24, 8, 0x7ff0000000000000u, STP_CORRUPT, "half a side of inf"},
        {0, 8, 0x7ff8000000000000u, STP_CORRUPT, "COPC record says"},
        {32, 8, 0, STP_CORRUPT, "spacing of 0"},
        {32, 8, 0xbff0000000000000u, STP_CORRUPT, "spacing of -1"},
        {40, 8, UINT64_MAX, STP_CORRUPT, "a page of the hierarchy for node 0-0-0-0"},
        {48, 8, UINT64_MAX, STP_CORRUPT, "a page of the hierarchy for node 0-0-0-0"},
        {48, 8, 33, STP_CORRUPT, "a page of the hierarchy for node 0-0-0-0"},
        {48, 8, 0, STP_CORRUPT, "a page of the hierarchy for node 0-0-0-0"},
        {PAGE, 4, 31, STP_CORRUPT, "lists node 31-0-0-0"},
        {PAGE, 4, UINT32_MAX, STP_CORRUPT, "lists node 4294967295-0-0-0"},
        {PAGE + 4, 4, 1, STP_CORRUPT, "lists node 0-1-0-0"},
        {PAGE + 16, 8, UINT64_MAX - 4, STP_CORRUPT, "the points for node 0-0-0-0"},
        {PAGE + 16, 8, 4, STP_CORRUPT, "the points for node 0-0-0-0"},
        {PAGE + 24, 4, 0x7fffffff, STP_CORRUPT, "the points for node 0-0-0-0"},
        {PAGE + 24, 4, 29, STP_CORRUPT, "the points for node 0-0-0-0"},
        {PAGE + 24, 4, UINT32_MAX, STP_CORRUPT, "has 1 points in -1 bytes"},
        {PAGE + 24, 4, 34, STP_CORRUPT, "its chunk ends too early"},
        {PAGE + 28, 4, 0x7fffffff, STP_CORRUPT, "not as many points as the hierarchy says"},
        {PAGE + 28, 4, 2, STP_CORRUPT, "not as many points as the hierarchy says"},
        {PAGE + 28, 4, (uint32_t)-2, STP_CORRUPT, "has -2 points"},
        {PAGE + 28, 4, UINT32_MAX, STP_CORRUPT, "says that it itself lists"},
        {PAGE + ENTRY + 12, 4, 1, STP_CORRUPT, "lists node 1-0-0-1 twice"},
        {PAGE + ENTRY + 24, 4, 200, STP_CORRUPT, "two nodes of its hierarchy have the same points"},
        {LAST_ENTRY, 4, 2, STP_CORRUPT, "which does not lie in it"},
        {LAST_ENTRY + 24, 4, 32, STP_OK, ""},
    };
    const stp_scan_region all = {.bounded = true, .min = {0}, .max = {1000, 1000, 1000}};
    const stp_scan_params params = {.region = &all};
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        const size_t page = copc_make(&file);
        const size_t at = lies[i].at < PAGE ? COPC_INFO_AT + lies[i].at : page + lies[i].at - PAGE;
        uint64_t read;
        las_put(&file, at, lies[i].bytes, lies[i].value);
        las_save(&file, "b.copc.laz");
        if (lies[i].status == STP_OK)
            read_region("b.copc.laz", &all, &read);
        else
            scan_fixture_fails("b.copc.laz", &params, lies[i].status, lies[i].words);
    }
    const size_t page = copc_make(&file); /* a page that is the first one again */
    las_put(&file, page + LAST_ENTRY - PAGE + 16, 8, page);
    las_save(&file, "b.copc.laz");
    scan_fixture_fails("b.copc.laz", &params, STP_CORRUPT, "which does not lie in it");
}

/* Cut at many places: points or a sentence. */
static void cut(void **state)
{
    (void)state;
    const stp_scan_region all = {.bounded = true, .min = {0}, .max = {1000, 1000, 1000}};
    const stp_scan_params params = {.region = &all};
    copc_make(&file);
    const size_t size = file.size;
    for (file.size = 0; file.size < size; file.size += 97) {
        stp_error err = {0};
        stp_scan *scan = NULL;
        stp_point points[64];
        size_t count = 1;
        las_save(&file, "c.copc.laz");
        stp_status status = stp_scan_open(&scan, "c.copc.laz", &params, &err);
        while (status == STP_OK && count > 0)
            status = stp_scan_read(scan, points, 64, &count, &err);
        stp_scan_close(&scan);
        assert_true(status != STP_OK && strstr(err.message, "c.copc.laz"));
    }
}

/* ---- real files ---- */

static void check_real(const char *name, double resolution)
{
    char path[4096];
    stp_scan_info info;
    if (!scan_fixture_real(name, path))
        return;
    stp_point *points = scan_fixture_read(path, NULL, &info);
    const uint64_t count = info.point_count;
    stp_dvec3 low = points[0].position, high = low;
    for (uint64_t i = 1; i < count; i++) {
        low.x = fmin(low.x, points[i].position.x);
        low.y = fmin(low.y, points[i].position.y);
        high.x = fmax(high.x, points[i].position.x);
        high.y = fmax(high.y, points[i].position.y);
    }
    const double dx = high.x - low.x, dy = high.y - low.y;
    for (int part = 0; part < 8; part++) {
        stp_scan_region region = {
            .bounded = true,
            .min = {low.x + 0.1 * part * dx, low.y + 0.05 * part * dy, -INFINITY},
            .max = {low.x + (0.1 * part + 0.2) * dx, low.y + (0.05 * part + 0.3) * dy, INFINITY}};
        uint64_t inside = 0, read = 0;
        for (uint64_t i = 0; i < count; i++)
            inside += stp_scan_region_has(&region, points[i].position);
        assert_int_equal(read_region(path, &region, &read), inside);
        assert_true(read <= count);
    }
    const stp_scan_region coarse = {.resolution = resolution}, fine = {.resolution = 1e-9};
    uint64_t some, all;
    read_region(path, &coarse, &some);
    read_region(path, &fine, &all);
    print_message("%s: %llu of %llu points at a resolution of %g\n", name, (unsigned long long)some,
                  (unsigned long long)count, resolution);
    assert_true(some > 0 && some <= count && all == count);
    free(points);
}

static void real_files(void **state)
{
    (void)state;
    if (!scan_fixture_has_real())
        skip();
    check_real("laz/1.2-with-color.copc.laz", 30.0);
    check_real("laz/ellipsoid.copc.laz", 10.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whole),          cmocka_unit_test(regions), cmocka_unit_test(no_octree),
        cmocka_unit_test(files_that_lie), cmocka_unit_test(cut),     cmocka_unit_test(real_files),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
