/* Tests elevation maps: each point is within the stated distance of a map, or stays a point;
 * planes, spheres, noise, ramps that turn above each other, volumes, and hardly any points; meshes;
 * the same bytes for any threads and memory. */
#include "preprocess/maps/face_tree.h"
#include "preprocess/maps/map_distance.h"
#include "preprocess/maps/maps_make.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/surface_fixture.h"

#define OUT "test_maps.stipple"
#define DEGREE (M_PI / 180.0)

/* A cloud whose spacings, normals and signs are known. */
static surface_cloud oriented(gen_shape shape, uint32_t count, double noise)
{
    surface_cloud s = surface_scan(shape, count, noise, 0);
    surface_prepare(&s, STP_PREP_NEIGHBOURS);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_PROPAGATE});
    return s;
}

/* Makes maps and checks that all points are accounted for. Returns the points that were there,
 * which the maps stand for unless the cloud still has them. */
static stp_dvec3 *make_maps(surface_cloud *s, stp_maps *maps, double cone_deg, double error)
{
    const stp_maps_params params = {.cone_deg = cone_deg, .error = error};
    const uint64_t count = s->cloud.count;
    stp_dvec3 *points = calloc(count, sizeof *points);
    stp_error err = {0};
    assert_non_null(points);
    for (uint32_t i = 0; i < count; i++)
        points[i] = s->cloud.points[i].position;
    assert_int_equal(stp_maps_make(maps, &s->cloud, &params, s->pool, NULL, &err), STP_OK);
    assert_int_equal(maps->counts.as_points, s->cloud.count);
    assert_int_equal(maps->counts.represented + maps->counts.as_points, count);
    return points;
}

static double nearest_map(const stp_maps *maps, stp_dvec3 point)
{
    double least = INFINITY;
    for (uint32_t m = 0; m < maps->count; m++)
        least = fmin(least, stp_map_distance(&maps->maps[m], point));
    return least;
}

/* Counts the points that are farther than the stated distance from all maps: at most those that
 * stay. */
static uint64_t count_far(const stp_maps *maps, const stp_dvec3 *points, uint64_t count)
{
    uint64_t far = 0;
    for (uint64_t i = 0; i < count; i++)
        far += nearest_map(maps, points[i]) > maps->counts.greatest;
    return far;
}

static void test_coverage(void **state)
{
    static const double cones[] = {30.0, 60.0, 75.0};
    uint32_t before = UINT32_MAX;
    (void)state;
    for (size_t c = 0; c < 3; c++) {
        surface_cloud s = oriented(GEN_BUMPY, 20000, 0.0);
        stp_maps maps = {0};
        const uint64_t count = s.cloud.count;
        stp_dvec3 *points = make_maps(&s, &maps, cones[c], 0.0);
        assert_true(c == 1 ? maps.count < before / 2 : maps.count <= before);
        before = maps.count;
        assert_true(maps.counts.as_points < count / 100);
        assert_true(count_far(&maps, points, count) <= maps.counts.as_points);
        assert_true(maps.counts.samples > 0.8 * (double)count &&
                    maps.counts.samples < 1.4 * (double)count);
        free(points);
        stp_maps_clear(&maps);
        surface_clear(&s);
    }
}

/* With --map-error no point that a map stands for is farther. */
static void test_error(void **state)
{
    surface_cloud s = oriented(GEN_SPHERE, 20000, 0.3);
    stp_maps maps = {0};
    const double error = 0.3 * (double)s.cloud.points[0].spacing;
    const uint64_t count = s.cloud.count;
    stp_dvec3 *points = make_maps(&s, &maps, 60.0, error);
    (void)state;
    assert_true(maps.counts.greatest <= error);
    assert_true(maps.counts.as_points > 0);
    assert_true(count_far(&maps, points, count) <= maps.counts.as_points);
    free(points);
    stp_maps_clear(&maps);
    surface_clear(&s);
}

/* The root of the mean square distance of all samples from a sphere of radius 1. */
static double off_sphere(const stp_maps *maps, double *most)
{
    double sum = 0.0;
    uint64_t count = 0;
    *most = 0.0;
    for (uint32_t m = 0; m < maps->count; m++)
        for (uint32_t r = 0; r < maps->maps[m].rows; r++)
            for (uint32_t c = 0; c < maps->maps[m].columns; c++) {
                const stp_map *map = &maps->maps[m];
                if (!(stp_map_at(map, c, r)->flags & STP_MAP_SUPPORTED))
                    continue;
                const stp_dvec3 p = stp_map_world(map, c, r);
                const double off = fabs(stp_dvec3_length(p) - 1.0);
                sum += off * off;
                *most = fmax(*most, off);
                count++;
            }
    return sqrt(sum / (double)count);
}

/* The surface of the maps is nearer to the true one than noisy points are, and without noise it is
 * off by little of the spacing. */
static void test_noise(void **state)
{
    (void)state;
    for (int noisy = 0; noisy < 2; noisy++) {
        surface_cloud s = oriented(GEN_SPHERE, 30000, noisy ? 0.3 : 0.0);
        const double spacing = sqrt(4.0 * M_PI / (double)s.cloud.count);
        double points = 0.0, most = 0.0;
        stp_maps maps = {0};
        for (uint32_t i = 0; i < s.cloud.count; i++) {
            const double off = stp_dvec3_length(s.cloud.points[i].position) - 1.0;
            points += off * off / (double)s.cloud.count;
        }
        free(make_maps(&s, &maps, 60.0, 0.0));
        const double maps_off = off_sphere(&maps, &most);
        if (noisy)
            assert_true(maps_off < 0.35 * sqrt(points));
        else
            assert_true(maps_off < 0.02 * spacing && most < 0.1 * spacing);
        stp_maps_clear(&maps);
        surface_clear(&s);
    }
}

/* A cloud of given points, with spacings and normals as prep finds them. */
static surface_cloud cloud_of(uint32_t count, stp_dvec3 (*place)(uint32_t))
{
    surface_cloud s = {0};
    s.cloud.points = calloc(count, sizeof *s.cloud.points);
    assert_non_null(s.cloud.points);
    s.cloud.capacity = s.cloud.count = count;
    for (uint32_t i = 0; i < count; i++)
        s.cloud.points[i] = (stp_cloud_point){.position = place(i), .source = i};
    surface_prepare(&s, STP_PREP_NEIGHBOURS);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_PROPAGATE});
    return s;
}

static stp_dvec3 in_plane(uint32_t i)
{
    const double u = stp_random_unit(1, i), v = stp_random_unit(2, i);
    return (stp_dvec3){500000.0 + 3.0 * u, 4000000.0 + 2.0 * v, u + 2.0 * v};
}

/* A plane is one map, and its heights are those of the plane to a height step. */
static void test_plane(void **state)
{
    surface_cloud s = cloud_of(9000, in_plane);
    stp_maps maps = {0};
    stp_dvec3 *points = make_maps(&s, &maps, 60.0, 0.0);
    (void)state;
    assert_int_equal(maps.count, 1);
    assert_int_equal(maps.counts.represented, 9000);
    assert_true(maps.counts.greatest < 2.0 * maps.maps[0].frame.height_step);
    const stp_dvec3 *axes = maps.maps[0].frame.axes;
    assert_true(fabs(stp_dvec3_dot(axes[0], axes[1])) < 1e-12);
    assert_true(stp_dvec3_dot(stp_dvec3_cross(axes[0], axes[1]), axes[2]) > 1.0 - 1e-12);
    free(points);
    stp_maps_clear(&maps);
    surface_clear(&s);
}

/* How many squares have samples if the grid of squares is moved; those that are not full count
 * twice. */
static unsigned squares_of(const stp_map *map, uint32_t right, uint32_t down)
{
    unsigned count = 0;
    for (uint32_t r = 0; r < map->rows + down; r += 8)
        for (uint32_t c = 0; c < map->columns + right; c += 8) {
            unsigned samples = 0;
            for (uint32_t k = 0; k < 64; k++) {
                const uint32_t column = c + k % 8 - right, row = r + k / 8 - down; /* or great */
                if (column < map->columns && row < map->rows)
                    samples += stp_map_at(map, column, row)->flags & STP_MAP_SUPPORTED;
            }
            count += samples == 0 ? 0u : samples < 64 ? 2u : 1u;
        }
    return count;
}

/* No other place of the grid gives fewer. */
static void test_squares(void **state)
{
    surface_cloud s = oriented(GEN_BUMPY, 20000, 0.0);
    stp_maps maps = {0};
    free(make_maps(&s, &maps, 60.0, 0.0));
    (void)state;
    assert_true(maps.count > 5);
    for (uint32_t m = 0; m < maps.count; m++)
        for (uint32_t k = 0; k < 64; k++)
            assert_true(squares_of(&maps.maps[m], 0, 0) <= squares_of(&maps.maps[m], k % 8, k / 8));
    stp_maps_clear(&maps);
    surface_clear(&s);
}

/* Of a surface whose details are as fine as its sampling, few points stay: parts are small before
 * they are merged, and points that halving leaves go to other maps of their part. */
static void test_rough(void **state)
{
    surface_cloud s = oriented(GEN_STATUE, 20000, 0.0);
    stp_maps maps = {0};
    free(make_maps(&s, &maps, 60.0, 0.0));
    (void)state;
    assert_true(maps.counts.as_points < 300); /* 457 if cells are cut by the maps' cone */
    stp_maps_clear(&maps);
    surface_clear(&s);
}

/* Three turns of a ramp: each turn lies above the last. */
static stp_dvec3 on_ramp(uint32_t i)
{
    const double turn = 6.0 * M_PI * stp_random_unit(1, i), r = 1.0 + stp_random_unit(2, i);
    return (stp_dvec3){r * cos(turn), r * sin(turn), turn / 10.0};
}

/* All normals of a ramp are near the vertical, but it is no height field: it is parted, and no
 * point is far from its own turn. */
static void test_ramp(void **state)
{
    surface_cloud s = cloud_of(20000, on_ramp);
    stp_maps maps = {0};
    stp_dvec3 *points = make_maps(&s, &maps, 60.0, 0.0);
    (void)state;
    assert_true(maps.count >= 3);
    assert_true(maps.counts.greatest < 0.1); /* turns are 0.63 apart */
    assert_true(maps.counts.as_points < 200);
    assert_true(count_far(&maps, points, 20000) <= maps.counts.as_points);
    free(points);
    stp_maps_clear(&maps);
    surface_clear(&s);
}

/* Vertices of a rough mesh: a grid of which every fourth vertex stands up. */
#define MESH_SIDE 60u
static double rough(uint32_t column, uint32_t row)
{
    return 0.1 * column + (column % 2 == 0 && row % 2 == 0 ? 0.4 : 0.0);
}

static stp_dvec3 on_mesh(uint32_t i)
{
    const uint32_t column = i % MESH_SIDE, row = i / MESH_SIDE;
    return (stp_dvec3){column, row, rough(column, row)};
}

/* A sheet of the mesh, with a second one `below`, or turned over. */
static void add_sheet(stp_mesh *mesh, double below, bool turned)
{
    const uint32_t first = (uint32_t)mesh->vertex_count;
    for (uint32_t i = 0; i < MESH_SIDE * MESH_SIDE; i++) {
        mesh->positions[first + i] = on_mesh(i);
        mesh->positions[first + i].z -= below;
    }
    mesh->vertex_count += MESH_SIDE * MESH_SIDE;
    for (uint32_t row = 0; row + 1 < MESH_SIDE; row++)
        for (uint32_t column = 0; column + 1 < MESH_SIDE; column++)
            for (uint32_t k = 0; k < 2; k++) {
                const uint32_t a = first + row * MESH_SIDE + column, d = a + MESH_SIDE + 1;
                const uint32_t across = k == 0 ? a + 1 : d - 1;
                uint32_t *t = mesh->triangles[mesh->triangle_count++];
                t[0] = a;
                t[1] = (k == 0) != turned ? across : d;
                t[2] = (k == 0) != turned ? d : across;
            }
}

/* The height of the mesh. Squares are cut from (0, 0) to (1, 1). */
static double mesh_height(double x, double y)
{
    const uint32_t column = (uint32_t)floor(x), row = (uint32_t)floor(y);
    const double u = x - column, v = y - row, a = rough(column, row);
    const double d = rough(column + 1, row + 1);
    const double across = u > v ? rough(column + 1, row) : rough(column, row + 1);
    return u > v ? a + u * (across - a) + v * (d - across)
                 : a + v * (across - a) + u * (d - across);
}

/* How far samples are from the mesh, along its heights. */
static double off_mesh(const stp_maps *maps, uint32_t *count)
{
    double most = 0.0;
    *count = 0;
    for (uint32_t m = 0; m < maps->count; m++)
        for (uint32_t r = 0; r < maps->maps[m].rows; r++)
            for (uint32_t c = 0; c < maps->maps[m].columns; c++) {
                const stp_dvec3 p = stp_map_world(&maps->maps[m], c, r);
                if (!(stp_map_at(&maps->maps[m], c, r)->flags & STP_MAP_SUPPORTED) ||
                    !(fmin(p.x, p.y) >= 0.0 && fmax(p.x, p.y) < MESH_SIDE - 1.001))
                    continue;
                most = fmax(most, fabs(p.z - mesh_height(p.x, p.y)));
                ++*count;
            }
    return most;
}

/* Samples lie on the triangles of a mesh, whichever way these are turned, and on no sheet beneath
 * that faces the other way. Without the mesh they lie off it. */
static void test_mesh(void **state)
{
    static const uint32_t all = MESH_SIDE * MESH_SIDE;
    stp_mesh mesh = {.positions = calloc(2u * all, sizeof *mesh.positions),
                     .triangles = calloc(4u * all, sizeof *mesh.triangles)};
    (void)state;
    assert_true(mesh.positions && mesh.triangles);
    for (int k = 0; k < 4; k++) {
        stp_maps_params params = {.cone_deg = 60.0, .mesh = k < 3 ? &mesh : NULL};
        stp_error err = {0};
        stp_maps maps = {0};
        uint32_t count = 0;
        mesh.vertex_count = mesh.triangle_count = 0;
        add_sheet(&mesh, 0.0, k == 1);
        if (k == 2)
            add_sheet(&mesh, 0.05, true);
        surface_cloud s = cloud_of(all, on_mesh);
        assert_int_equal(stp_maps_make(&maps, &s.cloud, &params, s.pool, NULL, &err), STP_OK);
        const double off = off_mesh(&maps, &count);
        assert_true(count > 0.9 * all);
        if (k < 3)
            assert_true(off < 0.01); /* heights have 256 steps in a spacing, or more */
        else
            assert_true(off > 0.1);
        stp_maps_clear(&maps);
        surface_clear(&s);
    }
    free(mesh.positions);
    free(mesh.triangles);
}

/* A plane whose mesh has wide triangles in the middle: there every vertex of three columns is that
 * of the next column. */
static uint32_t beside_gap(uint32_t i)
{
    const uint32_t column = i % MESH_SIDE, row = i / MESH_SIDE;
    return column >= 30 && column < 33 && row >= 20 && row < 40 ? i + 33 - column : i;
}

static stp_dvec3 with_gap(uint32_t i)
{
    const uint32_t at = beside_gap(i), column = at % MESH_SIDE;
    return (stp_dvec3){column, at / MESH_SIDE, 0.1 * column};
}

/* Triangles support what lies under them, where points alone leave a gap. */
static void test_wide_triangles(void **state)
{
    static const uint32_t all = MESH_SIDE * MESH_SIDE;
    stp_mesh mesh = {.positions = calloc(all, sizeof *mesh.positions),
                     .triangles = calloc(2u * all, sizeof *mesh.triangles)};
    (void)state;
    assert_true(mesh.positions && mesh.triangles);
    add_sheet(&mesh, 0.0, false);
    for (uint32_t i = 0; i < all; i++)
        mesh.positions[i] = with_gap(i);
    for (int k = 0; k < 2; k++) {
        const stp_maps_params params = {.cone_deg = 60.0, .mesh = k == 0 ? &mesh : NULL};
        stp_error err = {0};
        stp_maps maps = {0};
        uint32_t near = 0;
        surface_cloud s = cloud_of(all, with_gap);
        assert_int_equal(stp_maps_make(&maps, &s.cloud, &params, s.pool, NULL, &err), STP_OK);
        for (uint32_t row = 22; row < 38; row++)
            near += nearest_map(&maps, (stp_dvec3){31.0, row, 3.1}) < 0.2;
        assert_int_equal(near, k == 0 ? 16 : 0);
        stp_maps_clear(&maps);
        surface_clear(&s);
    }
    free(mesh.positions);
    free(mesh.triangles);
}

/* Any box finds the triangles that meet it, each once, but for those without area or place. */
static void test_face_tree(void **state)
{
    enum { TRIANGLES = 700 };
    stp_dvec3 positions[3 * TRIANGLES];
    uint32_t triangles[TRIANGLES][3];
    const stp_mesh mesh = {.vertex_count = 3u * TRIANGLES,
                           .positions = positions,
                           .triangle_count = TRIANGLES,
                           .triangles = triangles};
    stp_face_tree tree = {0};
    stp_error err = {0};
    (void)state;
    for (uint32_t i = 0; i < 3 * TRIANGLES; i++) {
        const double size = i < 30 ? 1.0 : 0.05; /* the first ones are large */
        const stp_dvec3 at = {stp_random_unit(1, i / 3), stp_random_unit(2, i / 3),
                              stp_random_unit(3, i / 3)};
        const stp_dvec3 by = {stp_random_unit(4, i), stp_random_unit(5, i), stp_random_unit(6, i)};
        positions[i] = stp_dvec3_add(at, stp_dvec3_scale(by, size));
        triangles[i / 3][i % 3] = i;
    }
    positions[3 * 40].y = NAN;
    positions[3 * 41] = positions[3 * 41 + 1];
    assert_int_equal(stp_face_tree_create(&tree, &mesh, &err), STP_OK);
    assert_int_equal(tree.count, TRIANGLES - 2);
    for (uint32_t b = 0; b < 200; b++) {
        const stp_dvec3 low = {stp_random_unit(7, b), stp_random_unit(8, b), stp_random_unit(9, b)};
        const double size = b == 0 ? 3.0 : 0.2 * stp_random_unit(10, b);
        const stp_dbox box = {low, stp_dvec3_add(low, (stp_dvec3){size, size, size})};
        uint8_t times[TRIANGLES] = {0};
        uint32_t *found = NULL;
        size_t count = 0;
        assert_int_equal(stp_face_tree_find(&tree, &box, &found, &count, &err), STP_OK);
        for (size_t i = 0; i < count; i++)
            times[found[i]]++;
        for (uint32_t t = 0; t < TRIANGLES; t++) {
            stp_dbox own = stp_dbox_empty();
            for (int k = 0; k < 3; k++)
                stp_dbox_add(&own, positions[triangles[t][k]]);
            assert_int_equal(times[t], t != 40 && t != 41 && stp_dbox_meet(&own, &box));
        }
        free(found);
    }
    stp_face_tree_clear(&tree);
    stp_face_tree_clear(&tree); /* a second time does nothing */
}

/* Runs prep with maps and checks the file and the account. */
static stp_prep_stats run(prep_cloud *cloud, unsigned threads, uint64_t memory, const char *path)
{
    const stp_maps_params maps = {.cone_deg = 60.0};
    const stp_prep_params params = {.maps = &maps, .memory_bytes = memory};
    stp_prep_stats stats = {0};
    stp_error err = {0};
    if (prep_cloud_run(cloud, path, threads, &params, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    uint64_t rejected = 0;
    for (int r = 0; r < STP_REJECT_COUNT; r++)
        rejected += stats.rejected[r];
    assert_int_equal(stats.maps.represented + stats.maps.as_points + rejected, stats.points_in);
    stp_chunk_file *file = prep_open_verified(path);
    assert_int_equal(stp_chunk_file_get_info(file)->point_count,
                     stats.maps.samples + stats.maps.as_points);
    stp_chunk_file_close(&file);
    return stats;
}

static void test_same_bytes(void **state)
{
    static const unsigned threads[] = {1, 2, 3};
    static const uint64_t memory[] = {0, 0, 180u << 20};
    uint8_t *first = NULL;
    size_t first_size = 0;
    (void)state;
    for (int i = 0; i < 3; i++) {
        size_t size = 0;
        prep_cloud cloud = prep_cloud_wavy(150000, (stp_dvec3){1e5, 0.0, 0.0}, 10.0);
        const stp_prep_stats stats = run(&cloud, threads[i], memory[i], OUT);
        assert_true(stats.maps.maps > 5 && stats.maps.as_points < 1500);
        assert_true((memory[i] > 0) == (stats.temporary_bytes > 0));
        uint8_t *bytes = prep_file_bytes(OUT, &size);
        if (!first) {
            first = bytes;
            first_size = size;
        } else {
            assert_int_equal(size, first_size);
            assert_memory_equal(bytes, first, size);
            free(bytes);
        }
        free(cloud.points);
    }
    free(first);
}

/* Hardly any points, points that are all equal, on a line, in a volume: all are accounted for, and
 * what is no surface stays points. */
static void test_no_surface(void **state)
{
    static const size_t counts[] = {1, 2, 40, 300, 300, 20000};
    (void)state;
    for (size_t k = 0; k < 6; k++) {
        prep_cloud cloud = prep_cloud_make(counts[k]);
        for (size_t i = 0; i < counts[k] && k != 3; i++) {
            const double x = stp_random_unit(1, i), y = stp_random_unit(2, i);
            cloud.points[i].position = k == 4 ? (stp_dvec3){x, 2.0 * x, 3.0 * x}
                                              : (stp_dvec3){x, y, stp_random_unit(3, i)};
        }
        cloud.points[0].reject = k == 5 ? STP_REJECT_INVALID : STP_REJECT_NONE;
        const stp_prep_stats stats = run(&cloud, 2, 0, OUT);
        if (k < 5)
            assert_int_equal(stats.maps.as_points, counts[k]);
        else
            assert_true(stats.maps.as_points > counts[k] / 2);
        free(cloud.points);
    }
}

static void test_empty(void **state)
{
    const stp_maps_params maps = {.cone_deg = 60.0};
    const stp_prep_params params = {.maps = &maps};
    prep_cloud cloud = prep_cloud_make(0);
    stp_prep_stats stats = {0};
    stp_error err = {0};
    (void)state;
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, &params, &stats, &err), STP_EMPTY);
    free(cloud.points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_coverage),       cmocka_unit_test(test_error),
        cmocka_unit_test(test_noise),          cmocka_unit_test(test_plane),
        cmocka_unit_test(test_squares),        cmocka_unit_test(test_rough),
        cmocka_unit_test(test_ramp),           cmocka_unit_test(test_mesh),
        cmocka_unit_test(test_wide_triangles), cmocka_unit_test(test_face_tree),
        cmocka_unit_test(test_same_bytes),     cmocka_unit_test(test_no_surface),
        cmocka_unit_test(test_empty),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
