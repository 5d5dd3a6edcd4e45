/* Tests Entwine Point Tile sets: tiles of three kinds, regions against brute force, and sets that
 * lie. If STIPPLE_SCANS names real scans, all points of the set there are read, too. */
#include "formats/scan/octree/octree.h"
#include "tests/fixtures/numbers_fixture.h"
#include "tests/fixtures/scan/ept_fixture.h"

#include <math.h>

static const char *const folders[EPT_KINDS] = {"laszip", "binary", "zstandard"};

static int enter(void **state)
{
    if (scan_fixture_enter(state) != 0)
        return -1;
    for (int kind = 0; kind < EPT_KINDS; kind++)
        ept_write((ept_kind)kind, folders[kind]);
    return 0;
}

/* Reading a set to its end must fail with this status, in one line with the words. */
static void fails(const char *path, stp_status expected, const char *words)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    stp_point points[64];
    size_t count = 1;
    stp_status status = stp_scan_open(&scan, path, NULL, &err);
    while (status == STP_OK && count > 0)
        status = stp_scan_read(scan, points, 64, &count, &err);
    stp_scan_close(&scan);
    if (status != expected || !strstr(err.message, words) || !strstr(err.message, "/ept") ||
        strchr(err.message, '\n'))
        fail_msg("expected %s with `%s`, got %s: %s", stp_status_name(expected), words,
                 stp_status_name(status), err.message);
}

/* ---- brute force ---- */

static int compare_points(const void *a, const void *b)
{
    const stp_point *p = a, *q = b;
    const double left[4] = {p->position.x, p->position.y, p->position.z, p->intensity};
    const double right[4] = {q->position.x, q->position.y, q->position.z, q->intensity};
    for (int i = 0; i < 4; i++)
        if (left[i] != right[i])
            return left[i] < right[i] ? -1 : 1;
    return 0;
}

/* The points of a region, sorted; `depth` is the last that is read. */
static size_t make_expected(stp_point out[EPT_POINTS], ept_kind kind, const stp_scan_region *region,
                            unsigned depth)
{
    size_t count = 0;
    for (uint64_t i = 0; i < EPT_POINTS; i++) {
        const ept_point p = ept_point_at(i);
        stp_point made = {
            .position = ept_position(&p), .intensity = p.intensity, .class_id = p.class_id};
        if (kind != EPT_LASZIP)
            memcpy(made.rgb, p.rgb, sizeof made.rgb);
        if (p.depth <= depth && !p.withheld && stp_scan_region_has(region, made.position))
            out[count++] = made;
    }
    qsort(out, count, sizeof *out, compare_points);
    return count;
}

/* The attributes of each point lie beside it: the fixture's times are a quarter of intensities. */
static void attributes(void **state)
{
    (void)state;
    for (int kind = 0; kind < EPT_KINDS; kind++) {
        const stp_scan_params params = {.numbers = true};
        stp_error err = {0};
        stp_scan *scan = NULL;
        stp_point points[77];
        size_t count = 1, total = 0;
        char path[64];
        snprintf(path, sizeof path, "%s/ept.json", folders[kind]);
        assert_int_equal(stp_scan_open(&scan, path, &params, &err), STP_OK);
        const stp_attribute_list *list = stp_scan_get_info(scan)->extra;
        const size_t bytes = stp_attribute_list_bytes(list);
        size_t at[2] = {0};
        static const char *const names[2] = {"gps_time", "intensity"};
        for (int k = 0; k < 2; k++) {
            const uint32_t index = stp_attribute_find(list, names[k]);
            assert_true(index < list->count);
            for (uint32_t i = 0; i < index; i++)
                at[k] += stp_attribute_bytes(list->items[i].type);
        }
        assert_int_equal(stp_attribute_find(list, "classification"), UINT32_MAX);
        assert_int_equal(stp_attribute_find(list, "red") == UINT32_MAX, kind == EPT_LASZIP);
        for (; count > 0; total += count) {
            assert_int_equal(stp_scan_read(scan, points, 77, &count, &err), STP_OK);
            const uint8_t *packed = stp_scan_numbers(scan);
            for (size_t i = 0; i < count; i++, packed += bytes) {
                double time;
                memcpy(&time, packed + at[0], sizeof time);
                assert_int_equal(packed[at[1]] | packed[at[1] + 1] << 8, points[i].intensity);
                assert_true(time == 0.25 * points[i].intensity);
            }
        }
        assert_int_equal(total, EPT_POINTS);
        stp_scan_close(&scan);
    }
}

/* Withheld points that are kept come with an attribute that says so. */
static void withheld(void **state)
{
    (void)state;
    for (int kind = 0; kind < EPT_KINDS; kind++) {
        char path[64];
        snprintf(path, sizeof path, "%s/ept.json", folders[kind]);
        numbers n = numbers_read_with(path, &(stp_scan_params){.keep_withheld = true});
        uint64_t marked = 0, wanted = 0;
        for (uint64_t i = 0; i < EPT_POINTS; i++) {
            const bool is_withheld = numbers_word(&n, "withheld", i) == 1;
            const double time = numbers_value(&n, "gps_time", i);
            assert_int_equal(n.points[i].reject, STP_REJECT_NONE);
            wanted += ept_point_at(i).withheld;
            for (uint64_t k = 0; is_withheld && k < EPT_POINTS; k++) {
                const ept_point p = ept_point_at(k);
                marked += p.withheld && 0.25 * p.intensity == time &&
                          ept_position(&p).x == n.points[i].position.x &&
                          ept_position(&p).y == n.points[i].position.y;
            }
        }
        assert_true(wanted > 0);
        assert_int_equal(marked, wanted);
        numbers_free(&n);
        n = numbers_read(path, NULL);
        numbers_lack(&n, "withheld");
        numbers_free(&n);
    }
}

/* Reads a region and compares what it has. Returns the number of points that were read for it. */
static uint64_t check_region(ept_kind kind, const stp_scan_region *region, unsigned depth)
{
    static stp_point expected[EPT_POINTS];
    char path[64];
    stp_scan_info info;
    const stp_scan_params params = {.region = region};
    snprintf(path, sizeof path, "%s/ept.json", folders[kind]);
    stp_point *points = scan_fixture_read(path, &params, &info);
    const size_t wanted = make_expected(expected, kind, region, depth);
    size_t count = 0;
    for (uint64_t i = 0; i < info.point_count; i++)
        if (points[i].reject == STP_REJECT_NONE)
            points[count++] = points[i];
    qsort(points, count, sizeof *points, compare_points);
    assert_int_equal(count, wanted);
    for (size_t i = 0; i < count; i++) {
        scan_fixture_position(&points[i], expected[i].position.x, expected[i].position.y,
                              expected[i].position.z);
        scan_fixture_scalars(&points[i], expected[i].intensity, expected[i].class_id);
        assert_memory_equal(points[i].rgb, expected[i].rgb, sizeof points[i].rgb);
    }
    free(points);
    return info.point_count;
}

static void all_points(void **state)
{
    (void)state;
    for (int kind = 0; kind < EPT_KINDS; kind++)
        assert_int_equal(check_region((ept_kind)kind, NULL, EPT_DEPTHS), EPT_POINTS);
}

static void regions(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 30; i++) {
        stp_scan_region region = {.bounded = i % 4 != 3};
        for (unsigned k = 0; k < 3; k++) {
            const double at = 95.0 + 100.0 * k + (double)(stp_random_u64(20 + k, i) % 7000) / 100.0;
            region.min[k] = i % 4 == 1 && k == 2 ? -INFINITY : at;
            region.max[k] =
                i % 4 == 1 && k == 2 ? INFINITY : at + (double)(stp_random_u64(30, i) % 40);
        }
        const unsigned depth = i % 3 == 0 ? EPT_DEPTHS : (unsigned)(i % 3) - 1;
        region.resolution = i % 3 == 0 ? 0.0 : depth == 0 ? 4.0 : 2.5;
        const uint64_t read = check_region((ept_kind)(i % EPT_KINDS), &region, depth);
        assert_true(read <= EPT_POINTS);
    }
}

/* Tiles that the region does not touch are not even opened. */
static void needs_no_more(void **state)
{
    (void)state;
    const stp_scan_region corner = {
        .bounded = true, .min = {100, 200, 300}, .max = {101, 201, 301}};
    const stp_scan_region coarse = {.resolution = 4.0};
    assert_int_equal(rename("binary/ept-data/1-1-1-1.bin", "away"), 0);
    assert_true(check_region(EPT_BINARY, &corner, EPT_DEPTHS) < EPT_POINTS / 2);
    assert_true(check_region(EPT_BINARY, &coarse, 0) == EPT_POINTS / 5);
    fails("binary/ept.json", STP_NOT_FOUND, "binary/ept-data/1-1-1-1.bin");
    assert_int_equal(rename("away", "binary/ept-data/1-1-1-1.bin"), 0);
}

static void tells(void **state)
{
    (void)state;
    stp_scan_info info;
    free(scan_fixture_read("zstandard/ept.json", NULL, &info));
    assert_string_equal(info.format, "EPT zstandard");
    assert_int_equal(info.attributes,
                     STP_POINT_HAS_COLOUR | STP_POINT_HAS_INTENSITY | STP_POINT_HAS_CLASS);
    assert_true(info.coordinate_step == EPT_STEP && info.heights);
    las_expect_note("zstandard/ept.json", "geokeys",
                    "GTModelTypeGeoKey=1\nProjectedCSTypeGeoKey=26912");
    las_expect_note("zstandard/ept.json", "left_out", "GpsTime");
    las_expect_note("zstandard/ept.json", "counts", "");
}

/* Keys at the ends of the box, faces of nodes, keys out of range. */
static void keys(void **state)
{
    (void)state;
    const stp_octree octree = {.size = {8, 8, 8}, .spacing = 1.0, .slack = 0.0};
    const stp_scan_region face = {.bounded = true, .min = {4, 0, 0}, .max = {4, 8, 8}};
    const stp_scan_region fine = {.resolution = 0.3};
    assert_true(stp_octree_wants(&octree, &face, (stp_octree_key){1, 0, 0, 0}));
    assert_true(stp_octree_wants(&octree, &face, (stp_octree_key){1, 1, 0, 0}));
    assert_false(stp_octree_wants(&octree, &face, (stp_octree_key){2, 0, 0, 0}));
    assert_true(stp_octree_wants(&octree, &fine, (stp_octree_key){2, 3, 3, 3}));
    assert_false(stp_octree_wants(&octree, &fine, (stp_octree_key){3, 3, 3, 3}));
    assert_true(stp_octree_key_valid((stp_octree_key){30, (1u << 30) - 1, 0, 0}));
    assert_false(stp_octree_key_valid((stp_octree_key){31, 0, 0, 0}));
    assert_false(stp_octree_key_valid((stp_octree_key){0, 1, 0, 0}));
    assert_true(stp_octree_key_below((stp_octree_key){3, 7, 0, 4}, (stp_octree_key){1, 1, 0, 1}));
    assert_false(stp_octree_key_below((stp_octree_key){3, 7, 0, 4}, (stp_octree_key){1, 1, 1, 1}));
}

/* ---- sets that lie ---- */

/* Replaces the first `from` in a text. */
static void replace(char *text, size_t size, const char *from, const char *to)
{
    static char rest[8192];
    char *at = strstr(text, from);
    assert_non_null(at);
    snprintf(rest, sizeof rest, "%s", at + strlen(from));
    snprintf(at, size - (size_t)(at - text), "%s%s", to, rest);
}

typedef struct lie {
    const char *from, *to;
    stp_status status;
    const char *words;
} lie;

static void heads_that_lie(void **state)
{
    (void)state;
    char good[4096], text[8192];
    static const lie lies[] = {
        {"\"span\": 16", "\"span\": 0", STP_FORMAT, "no octree"},
        {"\"span\": 16", "\"span\": -3", STP_FORMAT, "\"span\" is no whole number"},
        {"[100, 200", "[1e999, 200", STP_FORMAT, "\"bounds\" is not 6 numbers"},
        {"[100, 200", "[NaN, 200", STP_FORMAT, "not a JSON object"},
        {"[100, 200", "[164, 200", STP_FORMAT, "no octree"},
        {"[100, 200", "[-1e308, 200, 300, 1e308, 264, 364, 1, 2", STP_FORMAT, "is not 6 numbers"},
        {", 264, 364]", "]", STP_FORMAT, "\"bounds\" is not 6 numbers"},
        {"\"binary\"", "\"pnts\"", STP_UNSUPPORTED, "`pnts`"},
        {"\"json\"", "\"gzip\"", STP_UNSUPPORTED, "of type gzip"},
        {"\"1.0.0\"", "\"2.0.0\"", STP_VERSION, "version 2.0.0"},
        {"\"points\": 3000", "\"points\": 1.5", STP_FORMAT, "\"points\" is no whole"},
        {"\"schema\"", "\"scheme\"", STP_FORMAT, "no \"schema\""},
        {"\"name\": \"Y\"", "\"name\": \"X\"", STP_FORMAT, "the field `X` twice"},
        {"\"name\": \"Y\"", "\"name\": \"W\"", STP_FORMAT, "has no Y"},
        {"\"size\": 4", "\"size\": 3", STP_FORMAT, "3 bytes"},
        {"\"size\": 8", "\"size\": 1e30", STP_FORMAT, "\"size\" is no whole"},
        {"\"type\": \"signed\"", "\"type\": \"string\"", STP_FORMAT, "`string`"},
        {"\"scale\": 0.01", "\"scale\": 0", STP_FORMAT, "scale 0"},
        {"\"size\": 8", "\"size\": 4", STP_CORRUPT, "was cut or is of another set"},
        {"}", "", STP_FORMAT, "not a JSON object"},
    };
    ept_head(EPT_BINARY, good);
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        memcpy(text, good, sizeof good);
        replace(text, sizeof text, lies[i].from, lies[i].to);
        scan_fixture_text("binary/ept.json", text);
        fails("binary/ept.json", lies[i].status, lies[i].words);
    }
    scan_fixture_text("binary/ept.json", good);
}

static void hierarchies_that_lie(void **state)
{
    (void)state;
    static const lie lies[] = {
        {NULL, "{\"0-0-0-0\": 1e12}", STP_CORRUPT, "entry `0-0-0-0`"},
        {NULL, "{\"0-0-0-0\": -2}", STP_CORRUPT, "entry `0-0-0-0`"},
        {NULL, "{\"0-0-0-0\": 0.5}", STP_CORRUPT, "entry `0-0-0-0`"},
        {NULL, "{\"0-0-0-0\": \"7\"}", STP_CORRUPT, "entry `0-0-0-0`"},
        {NULL, "{\"../../x\": 7}", STP_CORRUPT, "entry `../../x`"},
        {NULL, "{\"1-0-0\": 7}", STP_CORRUPT, "entry `1-0-0`"},
        {NULL, "{\"1-0-0-0-0\": 7}", STP_CORRUPT, "entry `1-0-0-0-0`"},
        {NULL, "{\"0-0-0-0\": -1}", STP_CORRUPT, "says that it itself lists"},
        {NULL, "{\"1-2-0-0\": 7}", STP_CORRUPT, "lists node 1-2-0-0, which does not lie in it"},
        {NULL, "{\"31-0-0-0\": 7}", STP_CORRUPT, "which does not lie in it"},
        {NULL, "{\"0-0-0-0\": 1, \"0-0-0-0\": 1}", STP_CORRUPT, "lists node 0-0-0-0 twice"},
        {NULL, "{\"1-1-1-1\": -1, \"2-2-2-2\": 1}", STP_CORRUPT, "lists node 2-2-2-2 twice"},
        {NULL, "{\"1-1-1-1\": -1, \"1-1-1-1\": -1}", STP_CORRUPT, "lists node 1-1-1-1 twice"},
        {NULL, "{\"1-0-0-0\": -1}", STP_NOT_FOUND, "the EPT needs it"},
        {NULL, "{\"0-0-0-0\": 599}", STP_CORRUPT, "and 599 points of 30 bytes"},
        {NULL, "{\"5-0-0-0\": 7}", STP_NOT_FOUND, "5-0-0-0.bin"},
        {NULL, "[1, 2]", STP_FORMAT, "not a JSON object"},
        {NULL, "", STP_FORMAT, "not a JSON object"},
    };
    assert_int_equal(rename("binary/ept-hierarchy/0-0-0-0.json", "away"), 0);
    for (size_t i = 0; i < sizeof lies / sizeof *lies; i++) {
        scan_fixture_text("binary/ept-hierarchy/0-0-0-0.json", lies[i].to);
        fails("binary/ept.json", lies[i].status, lies[i].words);
    }
    assert_int_equal(truncate("binary/ept-hierarchy/0-0-0-0.json", 25 << 20), 0);
    fails("binary/ept.json", STP_FORMAT, "has 26214400 bytes, and at most");
    scan_fixture_text("binary/ept-hierarchy/0-0-0-0.json", "{\"0-0-0-0\": 600}");
    las_expect_note("binary/ept.json", "counts",
                    "ept.json says 3000 points, its hierarchy 600: those were read");
    assert_int_equal(rename("away", "binary/ept-hierarchy/0-0-0-0.json"), 0);
}

/* ---- tiles that lie ---- */

static size_t load(const char *path, unsigned char *out, size_t capacity)
{
    FILE *f = fopen(path, "rb");
    assert_non_null(f);
    const size_t size = fread(out, 1, capacity, f);
    assert_int_equal(fclose(f), 0);
    assert_true(size < capacity);
    return size;
}

/* A tile that is cut gives one sentence, a tile with a wrong bit the same or points. */
static void damage(const char *set, const char *tile)
{
    static unsigned char good[1 << 17], bad[1 << 17];
    const size_t size = load(tile, good, sizeof good);
    for (size_t i = 0; i < 40; i++) {
        stp_error err = {0};
        stp_scan *scan = NULL;
        stp_point points[64];
        size_t count = 1, length = i < 20 ? size * i / 20 : size;
        memcpy(bad, good, size);
        if (i >= 20)
            bad[stp_random_u64(50, i) % size] ^= (unsigned char)(1u << i % 8);
        scan_fixture_bytes(tile, bad, length);
        stp_status status = stp_scan_open(&scan, set, NULL, &err);
        while (status == STP_OK && count > 0)
            status = stp_scan_read(scan, points, 64, &count, &err);
        stp_scan_close(&scan);
        if (status == STP_OK && i < 20)
            fail_msg("%s: damage %zu is not seen", tile, i);
        if (status != STP_OK && (!strstr(err.message, tile) || strchr(err.message, '\n')))
            fail_msg("%s", err.message);
    }
    scan_fixture_bytes(tile, good, size);
}

static void tiles_that_lie(void **state)
{
    (void)state;
    damage("laszip/ept.json", "laszip/ept-data/0-0-0-0.laz");
    damage("binary/ept.json", "binary/ept-data/2-3-1-2.bin");
    damage("zstandard/ept.json", "zstandard/ept-data/0-0-0-0.zst");
}

/* A frame that unpacks to more points than the node has, and one of no points. */
static void frames_that_lie(void **state)
{
    (void)state;
    static unsigned char good[1 << 17];
    static const char tile[] = "zstandard/ept-data/0-0-0-0.zst";
    const size_t size = load(tile, good, sizeof good), most = ZSTD_compressBound(40u << 20);
    void *zeros = calloc(40u << 20, 1), *frame = malloc(most);
    assert_true(zeros && frame);
    size_t packed = ZSTD_compress(frame, most, zeros, 40u << 20, 1);
    scan_fixture_bytes(tile, frame, packed);
    fails("zstandard/ept.json", STP_CORRUPT, "more points than the hierarchy says");
    packed = ZSTD_compress(frame, most, zeros, 0, 1);
    scan_fixture_bytes(tile, frame, packed);
    fails("zstandard/ept.json", STP_CORRUPT, "fewer points than the hierarchy says");
    scan_fixture_bytes(tile, good, size);
    free(zeros);
    free(frame);
}

/* ---- a real set ---- */

static void real_set(void **state)
{
    (void)state;
    char path[4096];
    stp_scan_info info;
    uint64_t inside = 0, found = 0;
    if (!scan_fixture_has_real() || !scan_fixture_real("laz/ept-lone-star/ept.json", path))
        skip();
    const stp_scan_region region = {.bounded = true,
                                    .min = {515380.0, 4918350.0, -INFINITY},
                                    .max = {515385.0, 4918360.0, INFINITY}};
    const stp_scan_region coarse = {.resolution = 0.2};
    const stp_scan_params cut = {.region = &region}, thin = {.region = &coarse};
    stp_point *points = scan_fixture_read(path, NULL, &info);
    assert_int_equal(info.point_count, 518862);
    assert_string_equal(info.format, "EPT laszip");
    assert_true(info.coordinate_step == 0.00025);
    for (uint64_t i = 0; i < info.point_count; i++)
        inside += stp_scan_region_has(&region, points[i].position);
    free(points);
    points = scan_fixture_read(path, &cut, &info);
    assert_true(info.point_count < 518862);
    for (uint64_t i = 0; i < info.point_count; i++)
        found += points[i].reject == STP_REJECT_NONE;
    assert_int_equal(found, inside);
    free(points);
    free(scan_fixture_read(path, &thin, &info));
    assert_int_equal(info.point_count, 41998 + 22108 + 25867 + 37195 + 32867 + 48879);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(attributes),
        cmocka_unit_test(withheld),
        cmocka_unit_test(all_points),
        cmocka_unit_test(regions),
        cmocka_unit_test(needs_no_more),
        cmocka_unit_test(tells),
        cmocka_unit_test(keys),
        cmocka_unit_test(heads_that_lie),
        cmocka_unit_test(hierarchies_that_lie),
        cmocka_unit_test(tiles_that_lie),
        cmocka_unit_test(frames_that_lie),
        cmocka_unit_test(real_set),
    };
    return cmocka_run_group_tests(tests, enter, scan_fixture_leave);
}
