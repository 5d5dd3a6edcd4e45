/* Scans of known scenes: depth images of a wall with things before it, rooms, and what is made of
 * their files by the program's own way from paths to a chunk file. Failures end the test. */
#ifndef STP_TESTS_FIRST_VIEW_FIXTURE_H
#define STP_TESTS_FIRST_VIEW_FIXTURE_H

#include "base/random.h"
#include "preprocess/prep.h"
#include "tests/pcd_fixture.h"
#include "tests/scan_fixture.h"

#include <math.h>

/* A growing list of positions. */
typedef struct positions {
    stp_dvec3 *at;
    size_t count;
} positions;

static inline void positions_add(positions *p, double x, double y, double z)
{
    if ((p->count & (p->count - 1)) == 0) /* none, or a power of two: twice as many */
        p->at = realloc(p->at, (p->count > 0 ? 2 * p->count : 1) * sizeof *p->at);
    assert_non_null(p->at);
    p->at[p->count++] = (stp_dvec3){x, y, z};
}

/* ---- a depth camera ---- */

/* Pixels of side 1 / focal at distance 1, the axis through pixel (cx, cy); x to the right, y down,
 * z forwards. */
typedef struct depth_camera {
    size_t width, height;
    double focal, cx, cy;
} depth_camera;

static const depth_camera depth_small = {160, 120, 140.0, 80.7, 57.9};

/* Distance along z of what a ray meets: a ball, a box's front, else a wall that leans; NAN where
 * there is none. flat: the wall alone. */
static inline double depth_scene(double x, double y, bool flat)
{
    const double wall = 4.0 / (1.0 + 0.2 * x - 0.1 * y);
    /* |t (x, y, 1) - (-0.5, 0.2, 2.2)| = 0.45 */
    const double a = x * x + y * y + 1.0, b = -0.5 * x + 0.2 * y + 2.2;
    const double c = 0.25 + 0.04 + 2.2 * 2.2 - 0.45 * 0.45, d = b * b - a * c;
    const double box = 2.6;
    if (flat)
        return wall;
    if (x > 0.46 && y < -0.32)
        return NAN;
    if (d >= 0.0)
        return (b - sqrt(d)) / a;
    return fabs(box * x - 0.6) < 0.35 && fabs(box * y - 0.1) < 0.5 ? box : wall;
}

/* World positions, row by row, of a camera that is turned by an angle about an axis and stands at
 * a place. */
static inline positions depth_image(const depth_camera *c, bool flat, stp_dvec3 place,
                                    stp_dvec3 axis, double angle)
{
    positions out = {0};
    for (size_t row = 0; row < c->height; row++)
        for (size_t column = 0; column < c->width; column++) {
            const double x = ((double)column - c->cx) / c->focal;
            const double y = ((double)row - c->cy) / c->focal;
            const double z = depth_scene(x, y, flat);
            const stp_dvec3 p =
                stp_dvec3_add(place, stp_dvec3_rotate((stp_dvec3){x * z, y * z, z},
                                                      stp_dvec3_normalize(axis), angle));
            positions_add(&out, p.x, p.y, p.z);
        }
    return out;
}

/* Writes a PCD file of doubles; height 1: not organised, without what is not finite. */
static inline void depth_write(const char *path, const positions *p, size_t height,
                               const char *viewpoint)
{
    double *values[3];
    size_t count = 0;
    for (int axis = 0; axis < 3; axis++) {
        values[axis] = malloc(p->count * sizeof(double));
        assert_non_null(values[axis]);
    }
    for (size_t i = 0; i < p->count; i++) {
        if (height == 1 && !stp_dvec3_finite(p->at[i]))
            continue;
        values[0][count] = p->at[i].x;
        values[1][count] = p->at[i].y;
        values[2][count++] = p->at[i].z;
    }
    const pcd_column columns[] = {
        {"x", 'F', 8, 1, values[0]}, {"y", 'F', 8, 1, values[1]}, {"z", 'F', 8, 1, values[2]}};
    const pcd_file file = {columns, 3, count / height, height, viewpoint};
    byte_row bytes = pcd_make(&file, PCD_BINARY);
    scan_fixture_bytes(path, bytes.data, bytes.size);
    bytes_free(&bytes);
    for (int axis = 0; axis < 3; axis++)
        free(values[axis]);
}

/* ---- rooms ---- */

/* Points on a rectangle, about 0.04 apart, jittered. */
static inline void room_face(positions *p, stp_dvec3 corner, stp_dvec3 a, stp_dvec3 b)
{
    const size_t columns = (size_t)(stp_dvec3_length(a) / 0.04) + 1;
    const size_t rows = (size_t)(stp_dvec3_length(b) / 0.04) + 1;
    for (size_t i = 0; i < columns * rows; i++) {
        const double u = ((double)(i % columns) + stp_random_unit(11, p->count)) / (double)columns;
        const double v = ((double)(i / columns) + stp_random_unit(12, p->count)) / (double)rows;
        const stp_dvec3 at =
            stp_dvec3_add(corner, stp_dvec3_add(stp_dvec3_scale(a, u), stp_dvec3_scale(b, v)));
        positions_add(p, at.x, at.y, at.z);
    }
}

/* Six faces of a box, bit i leaving out: x low, x high, y low, y high, z low, z high. */
static inline void room_box(positions *p, stp_dvec3 low, stp_dvec3 high, unsigned without)
{
    const stp_dvec3 size = stp_dvec3_sub(high, low);
    const stp_dvec3 x = {size.x, 0.0, 0.0}, y = {0.0, size.y, 0.0}, z = {0.0, 0.0, size.z};
    const stp_dvec3 begin[6] = {low, {high.x, low.y, low.z}, low, {low.x, high.y, low.z},
                                low, {low.x, low.y, high.z}};
    for (int face = 0; face < 6; face++)
        if (!(without >> face & 1u))
            room_face(p, begin[face], face < 2 ? y : x, face < 4 ? z : y);
}

/* 6 x 4 x 2.6 metres about (10, 20, 1.3), its floor at 0: with a table and a cupboard, or empty. */
static inline positions room_scan(bool furnished)
{
    positions p = {0};
    room_box(&p, (stp_dvec3){7.0, 18.0, 0.0}, (stp_dvec3){13.0, 22.0, 2.6}, 0);
    if (furnished) {
        room_box(&p, (stp_dvec3){9.4, 19.5, 0.7}, (stp_dvec3){10.6, 20.5, 0.75}, 0);
        room_box(&p, (stp_dvec3){7.05, 18.05, 0.0}, (stp_dvec3){8.0, 18.6, 2.0}, 1u | 4u | 16u);
    }
    return p;
}

static inline void room_turn(positions *p, stp_dvec3 axis, double angle)
{
    for (size_t i = 0; i < p->count; i++)
        p->at[i] = stp_dvec3_rotate(p->at[i], axis, angle);
}

/* ---- from files to a chunk file ---- */

static inline stp_status first_read(void *context, stp_point *points, size_t capacity,
                                    size_t *count, stp_error *err)
{
    return stp_scan_read(context, points, capacity, count, err);
}

/* Preprocesses a scan into first.stipple. */
static inline stp_prep_stats first_prep(const char *path, unsigned threads)
{
    const stp_prep_params params = {.force = true};
    stp_prep_stats stats;
    stp_scan *scan = NULL;
    stp_pool *pool = NULL;
    stp_error err = {0};
    if (stp_pool_create(&pool, threads, &err) != STP_OK ||
        stp_scan_open(&scan, path, NULL, &err) != STP_OK)
        fail_msg("%s: %s", path, err.message);
    const stp_scan_info *info = stp_scan_get_info(scan);
    const stp_prep_file file = {.name = path,
                                .grid = info->grid,
                                .station_word = info->station_word,
                                .station_count = info->station_count};
    const stp_prep_source source = {.context = scan,
                                    .read = first_read,
                                    .point_count = info->point_count,
                                    .attributes = info->attributes,
                                    .heights = info->heights,
                                    .stations = info->stations,
                                    .station_ups = info->station_ups,
                                    .station_count = info->station_count,
                                    .files = &file,
                                    .file_count = 1};
    if (stp_prep_run("first.stipple", &source, &params, pool, NULL, &stats, &err) != STP_OK)
        fail_msg("%s: %s", path, err.message);
    stp_scan_close(&scan);
    stp_pool_destroy(&pool);
    return stats;
}

#endif
