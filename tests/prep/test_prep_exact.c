/* Tests what prep reports about stored positions, against the points read. With --precision exact,
 * every number of the file must come back. */
#include "formats/scan/coordinate_step.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/e57_fixture.h"
#include "tests/fixtures/scan/las_fixture.h"

#include <cjson/cJSON.h>
#include <math.h>

#define OUT "exact.stipple"

enum { DENSE = 3000, FAR = 60, COUNT = DENSE + FAR };

/* A dense patch of ground and a few points kilometres around it, in whole steps. */
static void place(size_t i, double steps[3])
{
    const double side = i < DENSE ? 2e4 : 3e6;
    for (int axis = 0; axis < 3; axis++)
        steps[axis] = floor((stp_random_unit((uint64_t)axis + 7, i) - 0.5) * (axis < 2    ? side
                                                                              : i < DENSE ? 50.0
                                                                                          : 3e5));
}

/* Reads all points of a scan, numbered in their order. */
static prep_cloud read_scan(const char *path, double *step)
{
    stp_scan *scan = NULL;
    stp_error err = {0};
    size_t got = 0;
    prep_cloud cloud = prep_cloud_make(COUNT);
    for (int pass = 0; pass < 2; pass++) {
        if (stp_scan_open(&scan, path, NULL, &err) != STP_OK ||
            (pass == 0 && stp_scan_find_step(scan, true, step, &err) != STP_OK))
            fail_msg("%s", err.message);
        for (size_t count = 1; pass == 1 && count > 0; got += count)
            assert_int_equal(stp_scan_read(scan, cloud.points + got, COUNT - got, &count, &err),
                             STP_OK);
        stp_scan_close(&scan);
    }
    assert_int_equal(got, COUNT);
    for (size_t i = 0; i < COUNT; i++)
        prep_number(&cloud.points[i], (uint32_t)i);
    return cloud;
}

static stp_prep_stats run_cloud(prep_cloud *cloud, double step, bool exact)
{
    const stp_prep_file file = {.name = "points"};
    const stp_prep_source source = {.context = cloud,
                                    .read = prep_cloud_read,
                                    .point_count = cloud->count,
                                    .attributes = STP_POINT_HAS_COLOUR | STP_POINT_HAS_CLASS,
                                    .coordinate_step = step,
                                    .floats = step == 0.0,
                                    .files = &file,
                                    .file_count = 1};
    const stp_prep_params params = {.exact = exact, .force = true};
    stp_prep_stats stats;
    stp_pool *pool = NULL;
    stp_error err = {0};
    cloud->given = 0;
    assert_int_equal(stp_pool_create(&pool, 2, &err), STP_OK);
    if (stp_prep_run(OUT, &source, &params, pool, NULL, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_pool_destroy(&pool);
    return stats;
}

typedef struct stored_points {
    stp_dvec3 *at; /* by number */
    size_t found;
} stored_points;

static void take_point(void *context, const stp_chunk_entry *entry, const stp_patch *patch,
                       const stp_sample *sample)
{
    stored_points *points = context;
    points->at[prep_number_of(sample)] =
        stp_dvec3_add(entry->origin, stp_sample_position(sample, patch));
    points->found++;
}

/* Reads the stored positions, by number; free them with free(). */
static stp_dvec3 *stored(stp_chunk_file *file, size_t count)
{
    stored_points points = {.at = calloc(count, sizeof *points.at)};
    assert_non_null(points.at);
    prep_visit_points(file, take_point, &points);
    assert_int_equal(points.found, count);
    return points.at;
}

static double noted(const stp_chunk_file_info *info, const char *name)
{
    cJSON *json = cJSON_ParseWithLength(info->metadata_json, info->metadata_bytes);
    const cJSON *d = cJSON_GetObjectItemCaseSensitive(json, "displacement");
    const cJSON *number = cJSON_GetObjectItemCaseSensitive(d, name);
    assert_true(cJSON_IsNumber(number));
    const double value = number->valuedouble;
    cJSON_Delete(json);
    return value;
}

/* The report must be true: counts again the greatest and the mean displacement, and how many points
 * are displaced by more than the input resolves. */
static stp_displacement check_said(const prep_cloud *cloud, const stp_prep_stats *stats)
{
    stp_displacement d = {.points = cloud->count};
    stp_chunk_file *file = prep_open_verified(OUT);
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    stp_dvec3 *at = stored(file, cloud->count);
    for (size_t i = 0; i < cloud->count; i++) {
        const double off = stp_dvec3_length(stp_dvec3_sub(at[i], cloud->points[i].position));
        d.greatest = fmax(d.greatest, off);
        d.sum += off;
        d.beyond += stats->resolution.precision > 0.0 && off > stats->resolution.precision;
    }
    const stp_displacement *said = &stats->tree.displacement;
    assert_int_equal(said->points, cloud->count);
    assert_true(said->greatest == d.greatest);
    assert_true(fabs(said->sum - d.sum) <= 1e-9 * d.sum);
    assert_int_equal(said->beyond, d.beyond);
    assert_true(fabs(noted(info, "greatest") - d.greatest) <= 1e-12 * d.greatest);
    assert_true(fabs(noted(info, "mean") - d.sum / (double)cloud->count) <= 1e-9 * d.greatest);
    assert_true(noted(info, "beyond") == (double)d.beyond);
    free(at);
    stp_chunk_file_close(&file);
    return d;
}

/* Every stored number, printed with the file's decimals, must be the file's number. */
static void check_numbers(double scale, const double offset[3], int digits)
{
    stp_chunk_file *file = prep_open_verified(OUT);
    stp_dvec3 *at = stored(file, COUNT);
    for (size_t i = 0; i < COUNT; i++) {
        double steps[3];
        const double own[3] = {at[i].x, at[i].y, at[i].z};
        place(i, steps);
        for (int axis = 0; axis < 3; axis++)
            if (round((own[axis] - offset[axis]) / scale) != steps[axis])
                fail_msg("point %zu, axis %d: %.*f, in the file %.*f", i, axis, digits, own[axis],
                         digits, offset[axis] + scale * steps[axis]);
    }
    free(at);
    stp_chunk_file_close(&file);
}

/* By default far points are off, and prep says so; with exact, none is. */
static void check_file(const char *path, double scale, const double offset[3], int digits)
{
    double step = 0.0;
    prep_cloud cloud = read_scan(path, &step);
    assert_true(fabs(step - scale) <= 1e-12);
    stp_prep_stats stats = run_cloud(&cloud, step, false);
    const stp_displacement plain = check_said(&cloud, &stats);
    assert_true(plain.beyond > 0 && plain.greatest > scale);
    stats = run_cloud(&cloud, step, true);
    const stp_displacement exact = check_said(&cloud, &stats);
    assert_true(exact.beyond == 0 && stats.tree.displacement.changed == 0);
    check_numbers(scale, offset, digits);
    free(cloud.points);
}

static void las_with_offset(void **state)
{
    (void)state;
    static las_file f;
    const double offset[3] = {513000.37, 5402000.11, -100.5};
    las_begin(&f, 2, 0, 20);
    for (int axis = 0; axis < 3; axis++) {
        las_put_double(&f, 131 + 8 * (size_t)axis, 0.001);
        las_put_double(&f, 155 + 8 * (size_t)axis, offset[axis]);
    }
    for (size_t i = 0; i < COUNT; i++) {
        double s[3];
        place(i, s);
        las_add_point(&f, (int32_t)s[0], (int32_t)s[1], (int32_t)s[2]);
    }
    las_set_count(&f, COUNT);
    las_save(&f, "offset.las");
    check_file("offset.las", 0.001, offset, 3);
}

static void scaled_integers_of_e57(void **state)
{
    (void)state;
    enum { BITS = 22 }; /* for 4,000,001 values */
    const double offset[3] = {5.25, -700.125, 0.0};
    e57_stream streams[3] = {0};
    e57_file file;
    for (size_t i = 0; i < COUNT; i++) {
        double s[3];
        place(i, s);
        for (int axis = 0; axis < 3; axis++)
            bytes_bits(&streams[axis].bytes, (uint64_t)(s[axis] + 2000000.0), BITS);
    }
    e57_begin(&file);
    e57_vector(&file, streams, 3, false);
    e57_scan(&file, "", COUNT,
             E57_SCALED("cartesianX", "-2000000", "2000000", "0.001", "5.25")
                 E57_SCALED("cartesianY", "-2000000", "2000000", "0.001", "-700.125")
                     E57_SCALED("cartesianZ", "-2000000", "2000000", "0.001", "0"));
    e57_end(&file, "");
    e57_write("scaled.e57", &file);
    e57_free(&file);
    for (int axis = 0; axis < 3; axis++)
        bytes_free(&streams[axis].bytes);
    check_file("scaled.e57", 0.001, offset, 3);
}

/* Writes a head, then lines of three numbers with this many decimals. */
static void write_lines(const char *path, const char *head, double scale, int decimals)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(head, file);
    for (size_t i = 0; i < COUNT; i++) {
        double s[3];
        place(i, s);
        fprintf(file, "%.*f %.*f %.*f\n", decimals, scale * s[0], decimals, scale * s[1], decimals,
                scale * s[2]);
    }
    fclose(file);
}

static void decimals_of_text(void **state)
{
    (void)state;
    const double none[3] = {0.0, 0.0, 0.0};
    write_lines("three.xyz", "", 1e-3, 3);
    check_file("three.xyz", 1e-3, none, 3);
    write_lines("five.xyz", "", 1e-5, 5);
    check_file("five.xyz", 1e-5, none, 5);
}

/* Decimals in floats: the 24 bits of a float tell 3e6 steps apart. */
static void decimals_in_floats(void **state)
{
    (void)state;
    char head[256];
    const double none[3] = {0.0, 0.0, 0.0};
    snprintf(head, sizeof head,
             "ply\nformat ascii 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
             "property float z\nend_header\n",
             COUNT);
    write_lines("floats.ply", head, 1e-2, 2);
    check_file("floats.ply", 1e-2, none, 2);
    snprintf(head, sizeof head,
             "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH %d\nHEIGHT 1\n"
             "POINTS %d\nDATA ascii\n",
             COUNT, COUNT);
    write_lines("floats.pcd", head, 1e-2, 2);
    check_file("floats.pcd", 1e-2, none, 2);
}

/* Floats without decimal steps: if they have no more digits than patches have bits, all come back.
 * Otherwise prep must say how many do not. */
static void plain_floats(void **state)
{
    (void)state;
    for (int fine = 0; fine < 2; fine++) {
        prep_cloud cloud = prep_cloud_wavy(3000, (stp_dvec3){0.0, 0.0, 0.0}, 1.0);
        uint64_t changed = 0;
        for (size_t i = 0; i < cloud.count; i++) {
            stp_dvec3 *p = &cloud.points[i].position;
            const double unit = fine ? 0x1p-40 : 0x1p-16;
            *p = (stp_dvec3){(double)(float)(unit * round(p->x / unit)),
                             (double)(float)(unit * round(p->y / unit)),
                             (double)(float)(unit * round(p->z / unit))};
        }
        const stp_prep_stats stats = run_cloud(&cloud, 0.0, true);
        stp_chunk_file *file = prep_open_verified(OUT);
        stp_dvec3 *at = stored(file, cloud.count);
        for (size_t i = 0; i < cloud.count; i++) {
            const stp_dvec3 p = cloud.points[i].position;
            changed += (float)at[i].x != (float)p.x || (float)at[i].y != (float)p.y ||
                       (float)at[i].z != (float)p.z;
        }
        assert_int_equal(stats.tree.displacement.changed, changed);
        assert_true(fine ? changed > 0 : changed == 0);
        free(at);
        stp_chunk_file_close(&file);
        free(cloud.points);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(las_with_offset), cmocka_unit_test(scaled_integers_of_e57),
        cmocka_unit_test(decimals_of_text), cmocka_unit_test(decimals_in_floats),
        cmocka_unit_test(plain_floats)};
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
