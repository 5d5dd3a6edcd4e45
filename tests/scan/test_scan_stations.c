/* Tests the positions of scanners and which one saw a point: written, read back, and wrong in the
 * file. */
#include "formats/scan/ply/ply_write.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

#define XYZ "property float x\nproperty float y\nproperty float z\n"

typedef struct stations_read {
    stp_point *points;
    stp_dvec3 *stations;
    stp_scan_info info;
} stations_read;

/* Reads all of a file; free it with release. */
static stations_read read_all(const char *path, const stp_scan_params *params)
{
    stations_read r = {0};
    stp_scan *scan = NULL;
    stp_error err = {0};
    if (stp_scan_open(&scan, path, params, &err) != STP_OK)
        fail_msg("%s", err.message);
    const stp_scan_info *info = stp_scan_get_info(scan);
    r.stations = calloc(info->station_count + 1u, sizeof *r.stations);
    assert_non_null(r.stations);
    if (info->station_count > 0)
        memcpy(r.stations, info->stations, info->station_count * sizeof *r.stations);
    stp_scan_close(&scan);
    r.points = scan_fixture_read(path, params, &r.info);
    return r;
}

static void release(stations_read *r)
{
    free(r->points);
    free(r->stations);
}

/* A position that needs many digits and differs from its neighbours. */
static stp_dvec3 place(uint32_t i)
{
    return (stp_dvec3){500000.1 + (double)i / 3.0, -1e-7 * (double)i, 1e9 / (i + 1.0)};
}

static bool header_has(const char *path, const char *line)
{
    char text[256];
    bool found = false;
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    while (!found && fgets(text, sizeof text, file) && strcmp(text, "end_header\n") != 0)
        found = strcmp(text, line) == 0;
    fclose(file);
    return found;
}

/* Uses every station number; every seventh point has an unknown station. */
static void round_trip(uint32_t station_count, uint32_t attributes, const char *property)
{
    enum { COUNT = 70000 };
    stp_error err = {0};
    stp_ply_writer *writer = NULL;
    stp_dvec3 *stations = calloc(station_count, sizeof *stations);
    assert_non_null(stations);
    for (uint32_t i = 0; i < station_count; i++)
        stations[i] = place(i);
    const stp_ply_writer_params params = {.force = true,
                                          .vertex_count = COUNT,
                                          .attributes = attributes | STP_POINT_HAS_STATION,
                                          .stations = stations,
                                          .station_count = station_count};
    assert_int_equal(stp_ply_writer_create(&writer, "trip.ply", &params, &err), STP_OK);
    for (uint32_t i = 0; i < COUNT; i++) {
        const stp_point point = {.rgb = {257, 257, 257},
                                 .class_id = (uint8_t)i,
                                 .station = (uint16_t)(i % 7 == 6 ? 0 : i % station_count + 1)};
        assert_int_equal(stp_ply_writer_points(writer, &point, 1, &err), STP_OK);
    }
    assert_int_equal(stp_ply_writer_finish(&writer, &err), STP_OK);
    assert_true(header_has("trip.ply", property));
    stations_read r = read_all("trip.ply", NULL);
    assert_int_equal(r.info.attributes, attributes | STP_POINT_HAS_STATION);
    assert_int_equal(r.info.station_count, station_count);
    assert_memory_equal(r.stations, stations, station_count * sizeof *stations);
    for (uint32_t i = 0; i < COUNT; i++) {
        assert_int_equal(r.points[i].station, i % 7 == 6 ? 0 : i % station_count + 1);
        if (attributes & STP_POINT_HAS_CLASS)
            assert_int_equal(r.points[i].class_id, (uint8_t)i);
    }
    release(&r);
    free(stations);
}

static void stations_come_back(void **state)
{
    (void)state;
    round_trip(1, 0, "property uchar station\n");
    round_trip(2, STP_POINT_HAS_CLASS, "property uchar station\n");
    round_trip(255, 0, "property uchar station\n");
    round_trip(256, STP_POINT_HAS_CLASS | STP_POINT_HAS_COLOUR, "property ushort station\n");
    round_trip(10000, 0, "property ushort station\n");
}

static void what_cannot_be_written(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_ply_writer *writer = NULL;
    stp_ply_writer_params params = {.attributes = STP_POINT_HAS_STATION};
    assert_int_equal(stp_ply_writer_create(&writer, "no.ply", &params, &err), STP_INVALID_ARGUMENT);
    params = (stp_ply_writer_params){.station_count = STP_STATION_LIMIT + 1};
    params.stations = calloc(params.station_count, sizeof *params.stations);
    assert_non_null(params.stations);
    assert_int_equal(stp_ply_writer_create(&writer, "no.ply", &params, &err), STP_INVALID_ARGUMENT);
    assert_null(writer);
    assert_int_equal(access("no.ply", F_OK), -1);
    free((void *)(uintptr_t)params.stations);
}

/* The comments of a header, a property's type, the numbers of four points, and the meaning: the x
 * of each point's station, 0 if it is unknown. */
typedef struct meaning {
    const char *comments, *property, *numbers[4];
    uint32_t station_count;
    double x[4];
} meaning;

static void check_meaning(const meaning *m)
{
    char text[4096];
    bool has = m->property != NULL;
    snprintf(text, sizeof text,
             "ply\nformat ascii 1.0\n%selement vertex 4\n" XYZ
             "%s%s%send_header\n0 0 0 %s\n1 0 0 %s\n0 1 0 %s\n0 0 1 %s\n",
             m->comments, has ? "property " : "", has ? m->property : "", has ? "\n" : "",
             m->numbers[0], m->numbers[1], m->numbers[2], m->numbers[3]);
    scan_fixture_text("meaning.ply", text);
    stations_read r = read_all("meaning.ply", NULL);
    assert_int_equal(r.info.point_count, 4);
    assert_int_equal(r.info.station_count, m->station_count);
    for (int i = 0; i < 4; i++) {
        assert_true(r.points[i].station <= r.info.station_count);
        double x = r.points[i].station ? r.stations[r.points[i].station - 1].x : 0.0;
        if (x != m->x[i])
            fail_msg("point %d of\n%sis from %g, expected %g", i, text, x, m->x[i]);
    }
    release(&r);
}

static void numbers_name_positions(void **state)
{
    (void)state;
    const meaning cases[] = {
        {"comment station 0 10 0 0\ncomment station 1 11 0 0\n",
         "uchar station",
         {"0", "1", "1", "0"},
         2,
         {10, 11, 11, 10}},
        /* in any order, with any numbers, among other comments, of any type */
        {"comment station 205 12.5 -3 0.25\ncomment by hand\ncomment station 7 1e1 0 0\n"
         "comment   station\t4294967295  13 0 +0  \nobj_info station 6 99 0 0\n",
         "uint station",
         {"205", "7", "4294967295", "6"},
         3,
         {12.5, 10, 13, 0}},
        {"comment station 1 11 0 0\ncomment station 0 10 0 0\n",
         "float scalar_Station",
         {"1", "0", "1.0", "0e5"},
         2,
         {11, 10, 11, 10}},
        /* one position: without a property it is every point's */
        {"comment station 3 10 0 0\n", NULL, {"", "", "", ""}, 1, {10, 10, 10, 10}},
        {"comment station 3 10 0 0\n", "uchar station", {"3", "0", "3", "1"}, 1, {10, 0, 10, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_meaning(&cases[i]);
}

static void lies_make_stations_unknown(void **state)
{
    (void)state;
    const meaning cases[] = {
        /* numbers out of range, negative, fractional, or not numbers */
        {"comment station 0 10 0 0\n", "uchar station", {"0", "1", "255", "0"}, 1, {10, 0, 0, 10}},
        {"comment station 0 10 0 0\n", "char station", {"0", "-1", "-128", "0"}, 1, {10, 0, 0, 10}},
        {"comment station 0 10 0 0\ncomment station 1 11 0 0\n",
         "double station",
         {"0.5", "nan", "1e300", "-inf"},
         2,
         {0, 0, 0, 0}},
        {"comment station 0 10 0 0\n",
         "double station",
         {"4294967296", "-0", "1e-300", "0"},
         1,
         {0, 10, 0, 10}},
        /* missing positions, and positions of stations that no point names */
        {"", "uchar station", {"0", "1", "2", "3"}, 0, {0, 0, 0, 0}},
        {"comment station 1 11 0 0\n", "uchar station", {"0", "1", "2", "1"}, 1, {0, 11, 0, 11}},
        {"comment station 0 10 0 0\ncomment station 1 11 0 0\n",
         NULL,
         {"", "", "", ""},
         2,
         {0, 0, 0, 0}},
        /* comments that only look like positions */
        {"comment station 0\ncomment station 0 1 2\ncomment station 0 1 2 3 4\n"
         "comment station zero 1 2 3\ncomment station -1 1 2 3\ncomment station 0 1 2 x\n"
         "comment station 1.5 1 2 3\ncomment stations 0 1 2 3\ncomment Station 0 1 2 3\n"
         "comment station 0 nan 2 3\ncomment station 0 1 inf 3\ncomment station 0 1e400 0 0\n"
         "comment station 4294967296 1 2 3\ncomment station 99999999999999999999 1 2 3\n"
         "comment station\ncomment\ncomment station 0 1,5 2 3\ncomment the station 0 1 2 3\n",
         "uchar station",
         {"0", "1", "2", "3"},
         0,
         {0, 0, 0, 0}},
        /* a position given twice is valid if equal; otherwise the station has none */
        {"comment station 0 10 0 0\ncomment station 1 11 0 0\ncomment station 0 10 0 0\n"
         "comment station 1 11 0 0.5\n",
         "uchar station",
         {"0", "1", "0", "1"},
         1,
         {10, 0, 10, 0}},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++)
        check_meaning(&cases[i]);
}

/* A list is no station number, and the data after a wrong property is read as usual. */
static void other_properties(void **state)
{
    (void)state;
    scan_fixture_text("list.ply", "ply\nformat ascii 1.0\ncomment station 0 10 0 0\n"
                                  "comment station 1 11 0 0\nelement vertex 1\n" XYZ
                                  "property list uchar int station\nproperty uchar class\n"
                                  "end_header\n1 2 3 2 0 1 9\n");
    stations_read r = read_all("list.ply", NULL);
    assert_int_equal(r.info.attributes, STP_POINT_HAS_CLASS);
    assert_int_equal(r.points[0].station, 0);
    assert_int_equal(r.points[0].class_id, 9);
    release(&r);
    scan_fixture_text("cut.ply", "ply\nformat binary_big_endian 1.0\ncomment station 0 1 2 3\n"
                                 "element vertex 2\n" XYZ "property ushort station\nend_header\n"
                                 "123456789012\1\1");
    scan_fixture_fails("cut.ply", NULL, STP_CORRUPT, "declares 2 vertices");
}

/* Vertices of a mesh keep their stations; samples of its faces have none. */
static void meshes(void **state)
{
    (void)state;
    scan_fixture_text("mesh.ply", "ply\nformat ascii 1.0\ncomment station 0 10 0 0\n"
                                  "comment station 1 11 0 0\nelement vertex 3\n" XYZ
                                  "property uchar station\nelement face 1\n"
                                  "property list uchar int vertex_indices\nend_header\n"
                                  "0 0 0 1\n1 0 0 0\n0 1 0 7\n3 0 1 2\n");
    stations_read r = read_all("mesh.ply", NULL);
    assert_true(r.info.normals_from_faces);
    assert_true(r.info.attributes & STP_POINT_HAS_STATION);
    assert_int_equal(r.points[0].station, 2);
    assert_int_equal(r.points[1].station, 1);
    assert_int_equal(r.points[2].station, 0);
    assert_true(r.stations[0].x == 10.0 && r.stations[1].x == 11.0);
    release(&r);
    const stp_scan_params sampled = {.sample_count = 100};
    r = read_all("mesh.ply", &sampled);
    assert_int_equal(r.info.attributes & STP_POINT_HAS_STATION, 0);
    assert_int_equal(r.info.station_count, 0);
    for (size_t i = 0; i < 100; i++)
        assert_int_equal(r.points[i].station, 0);
    release(&r);
}

/* As many positions as a header can hold, out of order. */
static void many_positions(void **state)
{
    (void)state;
    enum { COUNT = 20000 };
    FILE *file = fopen("many.ply", "wb");
    assert_non_null(file);
    fprintf(file, "ply\nformat ascii 1.0\n");
    for (uint32_t i = 0; i < COUNT; i++) {
        uint32_t number = (i * 7919u) % COUNT;
        fprintf(file, "comment station %u %u 0 0\n", 3 * number, number + 1);
    }
    fprintf(file, "element vertex %d\n" XYZ "property int station\nend_header\n", COUNT);
    for (uint32_t i = 0; i < COUNT; i++)
        fprintf(file, "0 0 0 %u\n", i);
    assert_int_equal(fclose(file), 0);
    stations_read r = read_all("many.ply", NULL);
    assert_int_equal(r.info.station_count, COUNT);
    for (uint32_t i = 0; i < COUNT; i++) {
        assert_int_equal(r.points[i].station > 0, i % 3 == 0);
        if (i % 3 == 0)
            assert_true(r.stations[r.points[i].station - 1].x == i / 3 + 1.0);
    }
    release(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(stations_come_back),     cmocka_unit_test(what_cannot_be_written),
        cmocka_unit_test(numbers_name_positions), cmocka_unit_test(lies_make_stations_unknown),
        cmocka_unit_test(other_properties),       cmocka_unit_test(meshes),
        cmocka_unit_test(many_positions),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
