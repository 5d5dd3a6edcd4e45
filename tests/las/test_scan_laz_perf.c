/* Compares our LAZ with laz-perf, another decoder, under node: files that we pack, in every format
 * that laz-perf reads, and each LAZ file that STIPPLE_SCANS names. Skipped without node, or if npm
 * cannot get laz-perf. */
#include "tests/fixtures/scan/laz_fixture.h"

#include <ftw.h>
#include <limits.h>

#define VERSION "0.0.7"

static char modules[PATH_MAX];
static unsigned compared;

/* The version of the first item of LASzip's record, whose items follow 34 bytes: u16 type, size and
 * version. */
static unsigned item_version(const laz_unpacked *u)
{
    return (unsigned)las_bytes_get(u->records.kept[STP_LAS_LASZIP].bytes + 38, 2);
}

/* Unpacks a file both ways. False if laz-perf does not read it, or not rightly: it knows neither
 * waveforms nor the fourth version of items. */
static bool agrees(const char *path)
{
    char command[4 * PATH_MAX];
    stp_error err = {0};
    laz_unpacked ours = {0};
    size_t size;
    unlink("perf.records");
    snprintf(command, sizeof command, "node '%s/tests/support/laz_perf.js' '%s' '%s' perf.records",
             getenv("STIPPLE_SOURCE"), modules, path);
    assert_int_equal(system(command), 0);
    if (access("perf.records", R_OK) != 0)
        return false;
    if (laz_unpack(&ours, path, true, &err) != STP_OK)
        fail_msg("%s", err.message);
    const bool known = item_version(&ours) < 4;
    unsigned char *theirs = scan_fixture_load("perf.records", &size);
    assert_true(size >= ours.size && ours.size > 0); /* we stop at 200,000 points */
    if (known)
        assert_memory_equal(ours.bytes, theirs, ours.size);
    compared += known;
    free(theirs);
    laz_unpacked_free(&ours);
    return known;
}

static void packed_by_us(void **state)
{
    (void)state;
    static const unsigned formats[] = {0, 1, 2, 3, 6, 7, 8};
    for (unsigned i = 0; i < 2 * sizeof formats / sizeof *formats; i++) {
        const unsigned format = formats[i / 2];
        const laz_way way = {.format = format,
                             .record_bytes = las_record_bytes[format] + i % 3,
                             .chunk_points = 300};
        unsigned char *records = laz_make_records(format, way.record_bytes, 1000, i % 2);
        laz_write("p.laz", &way, records, 1000);
        assert_true(agrees("p.laz"));
        free(records);
    }
}

static int check_file(const char *path, const struct stat *st, int kind, struct FTW *where)
{
    (void)st, (void)where;
    if (kind == FTW_F && strlen(path) > 4 && strcmp(path + strlen(path) - 4, ".laz") == 0)
        agrees(path);
    return 0;
}

static void packed_by_others(void **state)
{
    (void)state;
    char folder[4096];
    if (!laz_scans_path(folder, "laz"))
        skip();
    compared = 0;
    assert_int_equal(nftw(folder, check_file, 8, 0), 0);
    assert_true(compared > 0);
}

/* Gets laz-perf into the working folder, once, and tries whether this node loads it. */
static bool find_laz_perf(void)
{
    char folder[PATH_MAX - 32], command[3 * PATH_MAX];
    if (!getcwd(folder, sizeof folder) || system("node --version >/dev/null 2>&1") != 0)
        return false;
    snprintf(modules, sizeof modules, "%s/laz-perf/node_modules", folder);
    snprintf(command, sizeof command, "node '%s/tests/support/laz_perf.js' '%s' >/dev/null 2>&1",
             getenv("STIPPLE_SOURCE"), modules);
    return system(command) == 0 ||
           (system("timeout 60 npm install --silent --no-audit --no-fund --fetch-retries=0 "
                   "--prefix laz-perf laz-perf@" VERSION " >/dev/null 2>&1") == 0 &&
            system(command) == 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packed_by_us),
        cmocka_unit_test(packed_by_others),
    };
    if (!find_laz_perf()) {
        puts("no node, or npm cannot get laz-perf");
        return 77;
    }
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
