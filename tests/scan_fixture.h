/* What the scan tests share: files made in a folder of the test's own, and scans read whole. */
#ifndef STP_TESTS_SCAN_FIXTURE_H
#define STP_TESTS_SCAN_FIXTURE_H

#include "formats/scan/scan.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* For group setup and teardown: everything happens in a fresh folder. */
static inline int scan_fixture_enter(void **state)
{
    static char folder[] = "scan-XXXXXX";
    *state = NULL;
    return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static inline int scan_fixture_leave(void **state)
{
    (void)state;
    char folder[4096], command[4200];
    if (!getcwd(folder, sizeof folder) || chdir("..") != 0)
        return -1;
    snprintf(command, sizeof command, "rm -rf '%s'", folder);
    return system(command);
}

/* Whether a folder of real scans is named; a test skips without it: the scans are not the project's
 * to give. */
static inline bool scan_fixture_has_real(void)
{
    if (!getenv("STIPPLE_SCANS"))
        puts("skipped: STIPPLE_SCANS names no folder of real scans");
    return getenv("STIPPLE_SCANS") != NULL;
}

/* Where a real scan is; false, and said, where it is not. */
static inline bool scan_fixture_real(const char *name, char path[4096])
{
    snprintf(path, 4096, "%s/%s", getenv("STIPPLE_SCANS"), name);
    bool there = access(path, R_OK) == 0;
    if (!there)
        print_message("skipped: no %s\n", path);
    return there;
}

static inline void scan_fixture_bytes(const char *path, const void *bytes, size_t size)
{
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    assert_int_equal(fwrite(bytes, 1, size, file), size);
    assert_int_equal(fclose(file), 0);
}

static inline void scan_fixture_text(const char *path, const char *text)
{
    scan_fixture_bytes(path, text, strlen(text));
}

/* All points of a scan; free with free(). The batch is odd, to meet the ends of blocks. */
static inline stp_point *scan_fixture_read(const char *path, const stp_scan_params *params,
                                           stp_scan_info *info)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    const size_t batch = 777;
    if (stp_scan_open(&scan, path, params, &err) != STP_OK)
        fail_msg("%s", err.message);
    *info = *stp_scan_get_info(scan);
    stp_point *points = calloc((size_t)info->point_count + batch, sizeof *points);
    assert_non_null(points);
    uint64_t total = 0;
    for (size_t count = 1; count > 0; total += count) {
        if (stp_scan_read(scan, points + total, batch, &count, &err) != STP_OK)
            fail_msg("%s", err.message);
        assert_true(total + count <= info->point_count);
    }
    assert_int_equal(total, info->point_count);
    info->stations = NULL; /* they end with the scan */
    stp_scan_close(&scan);
    assert_null(scan);
    return points;
}

/* All points of a file with this text. */
static inline stp_point *scan_fixture_points(const char *path, const char *text,
                                             stp_scan_info *info)
{
    scan_fixture_text(path, text);
    return scan_fixture_read(path, NULL, info);
}

/* Opening or reading to the end fails with this status and a sentence that holds the text and the
 * path; nothing but a closed scan is left. */
static inline void scan_fixture_fails(const char *path, const stp_scan_params *params,
                                      stp_status expected, const char *text)
{
    stp_error err = {0};
    stp_scan *scan = NULL;
    stp_point points[64];
    size_t count = 1;
    stp_status status = stp_scan_open(&scan, path, params, &err);
    if (status != STP_OK)
        assert_null(scan);
    while (status == STP_OK && count > 0)
        status = stp_scan_read(scan, points, 64, &count, &err);
    stp_scan_close(&scan);
    if (status != expected || !strstr(err.message, text) || !strstr(err.message, path))
        fail_msg("%s: expected %s with `%s`, got %s: %s", path, stp_status_name(expected), text,
                 stp_status_name(status), err.message);
    assert_null(strchr(err.message, '\n'));
}

/* A file and how it fails: names matter where content does not say the format. */
typedef struct scan_malformed {
    const char *name, *content;
    stp_status status;
    const char *text;
} scan_malformed;

static inline void scan_fixture_malformed(const scan_malformed *cases, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        scan_fixture_text(cases[i].name, cases[i].content);
        scan_fixture_fails(cases[i].name, NULL, cases[i].status, cases[i].text);
    }
}

static inline void scan_fixture_position(const stp_point *point, double x, double y, double z)
{
    if (point->position.x != x || point->position.y != y || point->position.z != z)
        fail_msg("position %.17g %.17g %.17g, expected %.17g %.17g %.17g", point->position.x,
                 point->position.y, point->position.z, x, y, z);
}

static inline void scan_fixture_normal(const stp_point *point, double x, double y, double z)
{
    const double distance = hypot(hypot((double)point->normal.x - x, (double)point->normal.y - y),
                                  (double)point->normal.z - z);
    if (!(distance < 1e-6))
        fail_msg("normal %g %g %g, expected %g %g %g", (double)point->normal.x,
                 (double)point->normal.y, (double)point->normal.z, x, y, z);
}

static inline void scan_fixture_rgb(const stp_point *point, unsigned r, unsigned g, unsigned b)
{
    assert_int_equal(point->rgb[0], r);
    assert_int_equal(point->rgb[1], g);
    assert_int_equal(point->rgb[2], b);
}

static inline void scan_fixture_scalars(const stp_point *point, unsigned intensity,
                                        unsigned class_id)
{
    assert_int_equal(point->intensity, intensity);
    assert_int_equal(point->class_id, class_id);
}

#endif
