/* Tests PTX: poses, stations, missing returns, wrong files, and normals that face the scanner of
 * their points. */
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tests/fixtures/surface_fixture.h"

#include <math.h>

#define AXES "1 0 0\n0 1 0\n0 0 1\n"
#define IDENTITY "1 0 0 0\n0 1 0 0\n0 0 1 0\n0 0 0 1\n"

/* Opens and reads a file; copies the stations. */
static stp_point *read_ptx(const char *path, stp_scan_info *info, stp_dvec3 *stations)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    if (stp_scan_open(&scan, path, NULL, &err) != STP_OK)
        fail_msg("%s", err.message);
    for (uint32_t i = 0; i < stp_scan_get_info(scan)->station_count; i++)
        stations[i] = stp_scan_get_info(scan)->stations[i];
    stp_scan_close(&scan);
    return scan_fixture_read(path, NULL, info);
}

static void expect_station(stp_dvec3 station, double x, double y, double z)
{
    if (station.x != x || station.y != y || station.z != z)
        fail_msg("station %g %g %g, expected %g %g %g", station.x, station.y, station.z, x, y, z);
}

/* Two scans: one is turned by a right angle about z and moved, the other is not. */
static void two_scans(void **state)
{
    (void)state;
    scan_fixture_text("two.ptx",
                      "3\n1\n100 200 300\n0 1 0\n-1 0 0\n0 0 1\n"
                      "0 1 0 0\n-1 0 0 0\n0 0 1 0\n636100.125 200 300 1\n"
                      "1 2 3 0.5 10 20 30\n0 0 0 0.5 0 0 0\n-4 5 6 1 40 50 60\n"
                      "1\n2\n7 8 9\n" AXES IDENTITY "1 2 3 0 1 2 255\n4 5 6 0.25 0 0 0\n");
    stp_scan_info info;
    stp_dvec3 stations[2];
    stp_point *points = read_ptx("two.ptx", &info, stations);
    assert_string_equal(info.format, "PTX");
    assert_int_equal(info.point_count, 5);
    assert_int_equal(info.attributes,
                     STP_POINT_HAS_COLOUR | STP_POINT_HAS_INTENSITY | STP_POINT_HAS_STATION);
    assert_int_equal(info.station_count, 2);
    expect_station(stations[0], 636100.125, 200, 300);
    expect_station(stations[1], 7, 8, 9);
    scan_fixture_position(&points[0], 636098.125, 201, 303);
    scan_fixture_position(&points[2], 636095.125, 196, 306);
    scan_fixture_position(&points[3], 1, 2, 3);
    scan_fixture_rgb(&points[0], 10 * 257, 20 * 257, 30 * 257);
    scan_fixture_scalars(&points[0], 32768, 0);
    scan_fixture_scalars(&points[2], 65535, 0);
    for (int i = 0; i < 5; i++) {
        assert_int_equal(points[i].station, i < 3 ? 1 : 2);
        assert_int_equal(points[i].reject, i == 1 ? STP_REJECT_NO_RETURN : STP_REJECT_NONE);
    }
    free(points);
}

/* Turned the other way, short lines for rays without a return, and a scan without colour. */
static void odd_files(void **state)
{
    (void)state;
    stp_scan_info info;
    stp_dvec3 stations[3];
    scan_fixture_text("odd.ptx",
                      "\xef\xbb\xbf"
                      "2\r\n1\r\n0 0 0\r\n" AXES "0 -1 0 10\n1 0 0 20\n0 0 1 -30\n0 0 0 1\n\n"
                      "0 0 0\n1 2 3 0.5 10 20 255\n"
                      "1\n2\n0 0 0\n" AXES IDENTITY "1 1 1 0\n-0.0 0 0.000\n"
                      "0\n7\n0 0 1\n" AXES IDENTITY);
    stp_point *points = read_ptx("odd.ptx", &info, stations);
    assert_int_equal(info.point_count, 4);
    assert_int_equal(info.station_count, 3);
    expect_station(stations[0], 10, 20, -30);
    expect_station(stations[2], 0, 0, 1);
    scan_fixture_position(&points[1], 8, 21, -27);
    assert_int_equal(points[0].reject, STP_REJECT_NO_RETURN);
    assert_int_equal(points[3].reject, STP_REJECT_NO_RETURN);
    scan_fixture_rgb(&points[1], 10 * 257, 20 * 257, 65535);
    scan_fixture_rgb(&points[2], 51400, 51400, 51400);
    free(points);
    scan_fixture_text("none.ptx", "1\n2\n0 0 0\n" AXES IDENTITY "0 0 0 0.5\n0 0 0 0.5\n");
    points = read_ptx("none.ptx", &info, stations);
    assert_int_equal(info.point_count, 2);
    assert_int_equal(info.attributes, STP_POINT_HAS_STATION);
    assert_int_equal(points[1].reject, STP_REJECT_NO_RETURN);
    free(points);
    /* Leica's range of intensities must be found in spite of poses with large numbers. */
    scan_fixture_text("range.ptx", "1\n2\n0 0 0\n" AXES "1 0 0 -500000\n0 1 0 70000\n0 0 1 0\n"
                                   "0 0 0 1\n1 2 3 -2048\n1 2 3 2047\n");
    points = read_ptx("range.ptx", &info, stations);
    scan_fixture_scalars(&points[0], 0, 0);
    scan_fixture_scalars(&points[1], 65535, 0);
    free(points);
}

static void malformed(void **state)
{
    (void)state;
    const struct {
        const char *content, *text;
    } cases[] = {
        {"1\n2\n0 0 0\n" AXES IDENTITY "1 1 1 0\n", "declares 2 points, but 1 follow"},
        {"1\n2\n0 0 0\n" AXES IDENTITY "1 1 1 0\n1\n1\n", "next number at line 12"},
        {"1\n1\n0 0 0\n" AXES IDENTITY "1 1 1 0\n2 2 2 0\n", "line 12: expected the number of col"},
        {"1\n2\n0 0 0\n" AXES IDENTITY "1 1 1 0\n1 1 1", "ends at line 12, after 3 of 4"},
        {"1\n2\n0 0 0\n" AXES IDENTITY "1 1 1 0\n1 1 x 0\n", "line 12: `x`"},
        {"1\n1\n0 0 0\n" AXES IDENTITY "1 1 1 0 0\n", "line 11 has 5 numbers"},
        {"1\n1\n0 0\n" AXES IDENTITY "1 1 1 0\n", "line 3: expected 3 numbers"},
        {"1\n1\n0 0 nan\n" AXES IDENTITY "1 1 1 0\n", "line 3: expected 3 numbers"},
        {"1\n1\n0 0 0\n" AXES "1 0 0 0\n0 1 0 0\n0 0 1 0\n1 1 1 7\n1 1 1 0\n", "lines 7 to 10"},
        {"1\n1\n0 0 0\n" AXES "1 0 0 0\n1 0 0 0\n0 0 1 0\n0 0 0 1\n1 1 1 0\n", "lines 7 to 10"},
        {"1\n1\n0 0 0\n" AXES "1 0 0 0\n", "ends at line 7 within the header"},
        {"1\n", "ends at line 1 within the header"},
        {"18446744073709551614\n2\n0 0 0\n" AXES IDENTITY "1 1 1 0\n", "no file has so many"},
        {"4294967296\n4294967295\n0 0 0\n" AXES IDENTITY "1 1 1 0\n", "but 1 follow"},
        {"1\n-2\n0 0 0\n" AXES IDENTITY "1 1 1 0\n", "line 2"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        scan_fixture_text("wrong.ptx", cases[i].content);
        scan_fixture_fails("wrong.ptx", NULL, STP_CORRUPT, cases[i].text);
    }
}

static void too_many_scans(void **state)
{
    (void)state;
    FILE *file = fopen("many.ptx", "w");
    assert_non_null(file);
    for (unsigned i = 0; i <= STP_STATION_LIMIT; i++)
        fputs("0\n0\n0 0 0\n" AXES IDENTITY, file);
    assert_int_equal(fclose(file), 0);
    scan_fixture_fails("many.ptx", NULL, STP_LIMIT, "more than 65535 scans");
}

/* Writes a known surface as two scanners saw it, each in its scanner's own axes; the second's are
 * turned by a right angle about z. Every fifth ray has no return. */
static void write_sheet(const surface_cloud *s, const char *path)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (unsigned station = 1; station <= 2; station++) {
        const stp_dvec3 at = s->stations[station - 1];
        uint32_t count = 0, written = 0;
        for (uint32_t i = 0; i < s->cloud.count; i++)
            count += s->cloud.points[i].station == station;
        fprintf(file, "%u\n5\n%.9f %.9f %.9f\n", (count + 3) / 4, at.x, at.y, at.z);
        fputs(station == 1 ? AXES : "0 1 0\n-1 0 0\n0 0 1\n", file);
        fputs(station == 1 ? "1 0 0 0\n0 1 0 0\n0 0 1 0\n" : "0 1 0 0\n-1 0 0 0\n0 0 1 0\n", file);
        fprintf(file, "%.9f %.9f %.9f 1\n", at.x, at.y, at.z);
        for (uint32_t i = 0; i < s->cloud.count; i++) {
            const stp_dvec3 p = stp_dvec3_sub(s->cloud.points[i].position, at);
            if (s->cloud.points[i].station != station)
                continue;
            if (station == 1)
                fprintf(file, "%.9f %.9f %.9f 0.25\n", p.x, p.y, p.z);
            else
                fprintf(file, "%.9f %.9f %.9f 0.75\n", p.y, -p.x, p.z);
            if (++written % 4 == 0)
                fputs("0 0 0 0.5\n", file);
        }
        for (uint32_t total = written + written / 4; total < (count + 3) / 4 * 5; total++)
            fputs("0 0 0 0.5\n", file);
    }
    assert_int_equal(fclose(file), 0);
}

static stp_status read_scan(void *context, stp_point *points, size_t capacity, size_t *count,
                            stp_error *err)
{
    return stp_scan_read(context, points, capacity, count, err);
}

/* At level 0 of the leaves, each sample's normal must point to the side of the sheet where its
 * station stands. The intensity names the station. */
static void expect_facing(const surface_cloud *s)
{
    uint32_t found = 0, facing = 0;
    stp_chunk_file *file = prep_open_verified("sheet.stipple");
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        const uint32_t end = entry.child_count == 0 ? chunk->level_begin[0][chunk->patch_count] : 0;
        for (uint32_t i = 0; i < end; i++) {
            const stp_sample *sample = &chunk->samples[0][i];
            const double side = s->stations[sample->intensity > 127].z;
            found++;
            facing += sample->flags & STP_SAMPLE_ORIENTED &&
                      (double)stp_normal_decode(sample->normal).z * side > 0.0;
        }
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    print_message("%u of %u samples face their stations\n", facing, found);
    assert_int_equal(found, s->cloud.count);
    assert_true(facing >= 0.999 * found);
}

/* A sheet with two sides one spacing apart, seen from both sides: only the stations say which way
 * each normal points. */
static void normals_face_the_stations(void **state)
{
    (void)state;
    stp_error err = {0};
    surface_cloud s = surface_scan(GEN_SHEET, 50000, 0.0, 2);
    write_sheet(&s, "sheet.ptx");
    stp_scan *scan = NULL;
    if (stp_scan_open(&scan, "sheet.ptx", NULL, &err) != STP_OK)
        fail_msg("%s", err.message);
    const stp_scan_info *info = stp_scan_get_info(scan);
    const stp_prep_file file = {.name = "sheet.ptx"};
    const stp_prep_source source = {.context = scan,
                                    .read = read_scan,
                                    .point_count = info->point_count,
                                    .attributes = info->attributes,
                                    .stations = info->stations,
                                    .station_count = info->station_count,
                                    .files = &file,
                                    .file_count = 1};
    const stp_prep_params params = {.neighbour_count = 16, .codec = STP_CODEC_RAW};
    stp_prep_stats stats = {0};
    assert_int_equal(stp_pool_create(&s.pool, 2, &err), STP_OK);
    if (stp_prep_run("sheet.stipple", &source, &params, s.pool, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    assert_true(s.stations[0].z * s.stations[1].z < 0.0); /* one on each side */
    assert_int_equal(stats.points_in, info->point_count);
    assert_int_equal(stats.points_out, s.cloud.count);
    assert_int_equal(stats.rejected[STP_REJECT_NO_RETURN], info->point_count - s.cloud.count);
    assert_true(stats.rejected[STP_REJECT_NO_RETURN] >= s.cloud.count / 4 - 1);
    assert_int_equal(stats.orientation, STP_ORIENTATION_POSITION);
    assert_int_equal(stats.station_count, 2);
    assert_int_equal(stats.points_unstationed, 0);
    stp_scan_close(&scan);
    expect_facing(&s);
    surface_clear(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_scans),
        cmocka_unit_test(odd_files),
        cmocka_unit_test(malformed),
        cmocka_unit_test(too_many_scans),
        cmocka_unit_test(normals_face_the_stations),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
