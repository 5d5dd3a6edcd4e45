/* Tests `gen tree` to lines: each leaf is one ribbon by MKC08's formula, each ring of a branch is a
 * vertex of a tube with the ring's centre and mean width, and the thick trunk stays. The order of
 * the mesh must not matter. */
#include "tests/fixtures/plant_fixture.h"

static const double pi = 3.14159265358979323846;

enum { VERTEX_COUNT = 12000 };

static gen_tree tree;
static plant_mesh mesh, shuffled;
static double greatest_radius;

static int set_up(void **state)
{
    (void)state;
    stp_dbox box = stp_dbox_empty();
    if (gen_tree_grow(&tree, VERTEX_COUNT, 3, NULL) != STP_OK)
        return -1;
    mesh = plant_mesh_of_tree(&tree);
    shuffled = plant_mesh_of_tree(&tree);
    free(shuffled.mesh.normals);
    free(shuffled.mesh.rgb);
    shuffled.mesh.normals = NULL;
    shuffled.mesh.rgb = NULL;
    plant_mesh_shuffle(&shuffled.mesh, 1);
    for (size_t i = 0; i < mesh.mesh.vertex_count; i++)
        stp_dbox_add(&box, mesh.mesh.positions[i]);
    greatest_radius = stp_dvec3_length(stp_dvec3_sub(box.max, box.min)) / 128.0;
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    gen_tree_clear(&tree);
    plant_mesh_clear(&mesh);
    plant_mesh_clear(&shuffled);
    return 0;
}

static bool is_near(stp_dvec3 a, stp_dvec3 b)
{
    return stp_dvec3_length(stp_dvec3_sub(a, b)) < 1e-9;
}

/* Finds the ribbon of a leaf. The leaf's vertices are base, pair, pair, tip; *reverse: the ribbon
 * begins at the tip. */
static const stp_line_vertex *find_ribbon(const stp_plant *plant, const stp_dvec3 leaf[6],
                                          bool *reverse)
{
    const stp_line_vertex *found = NULL;
    for (uint64_t i = 0; i < plant->lines.strip_count; i++) {
        const stp_line_strip *strip = &plant->lines.strips[i];
        const stp_line_vertex *v = plant->lines.vertices + strip->begin;
        if (strip->kind != STP_LINE_RIBBON)
            continue;
        const stp_dvec3 begin = v[0].position, end = v[strip->count - 1].position;
        if (!(is_near(begin, leaf[0]) && is_near(end, leaf[5])) &&
            !(is_near(begin, leaf[5]) && is_near(end, leaf[0])))
            continue;
        assert_null(found);
        assert_int_equal(strip->count, 4);
        found = v;
        *reverse = is_near(begin, leaf[5]) && !is_near(begin, leaf[0]);
    }
    return found;
}

/* Checks positions and radii by the formula; returns the ribbon, from the base on. */
static void check_leaf(const stp_plant *plant, size_t leaf, stp_line_vertex ribbon[4])
{
    const uint32_t first = tree.first_leaf_vertex + (uint32_t)(6 * leaf);
    const stp_dvec3 *p = mesh.mesh.positions + first;
    bool reverse = false;
    const stp_line_vertex *v = find_ribbon(plant, p, &reverse);
    assert_non_null(v);
    for (int i = 0; i < 4; i++)
        ribbon[i] = v[reverse ? 3 - i : i];
    for (int i = 1; i < 3; i++) {
        const stp_dvec3 a = p[2 * i - 1], b = p[2 * i];
        assert_true(is_near(ribbon[i].position, stp_dvec3_scale(stp_dvec3_add(a, b), 0.5)));
        check_near((double)ribbon[i].radius, 0.5 * stp_dvec3_length(stp_dvec3_sub(a, b)), 1e-6);
    }
    assert_true(ribbon[0].radius < 0.02f * ribbon[1].radius);
    assert_true(ribbon[3].radius < 0.02f * ribbon[2].radius);
}

static void test_leaves(void **state)
{
    (void)state;
    stp_plant plant = plant_convert(&mesh.mesh, NULL);
    assert_int_equal(plant.report.ribbons, tree.leaf_count);
    assert_int_equal(plant.report.ribbon_triangles, 4 * tree.leaf_count);
    for (size_t i = 0; i < tree.leaf_count; i++) {
        stp_line_vertex ribbon[4];
        check_leaf(&plant, i, ribbon);
        const size_t first = tree.first_leaf_vertex + 6 * i;
        static const int pairs[4][2] = {{0, 0}, {1, 2}, {3, 4}, {5, 5}};
        for (int row = 0; row < 4; row++) {
            const size_t a = first + (size_t)pairs[row][0], b = first + (size_t)pairs[row][1];
            const vec3s normal =
                glms_vec3_normalize(glms_vec3_add(mesh.mesh.normals[a], mesh.mesh.normals[b]));
            check_near((double)glms_vec3_norm(glms_vec3_sub(ribbon[row].direction, normal)), 0.0,
                       1e-5);
            for (int c = 0; c < 3; c++)
                check_near((double)ribbon[row].rgb[c],
                           0.5 * ((double)mesh.mesh.rgb[a][c] + (double)mesh.mesh.rgb[b][c]), 1.0);
        }
    }
    stp_plant_clear(&plant);
}

static double width_radius(const gen_tree_ring *ring, uint32_t sides)
{
    return ring->radius * (double)sides * sin(pi / (double)sides) / pi;
}

/* Finds the one tube with an end at a tip; *step leads from there to the other end. */
static const stp_line_strip *find_tube(const stp_plant *plant, stp_dvec3 tip, int *step)
{
    const stp_line_strip *found = NULL;
    for (uint64_t i = 0; i < plant->lines.strip_count; i++) {
        const stp_line_strip *strip = &plant->lines.strips[i];
        const stp_line_vertex *v = plant->lines.vertices + strip->begin;
        const bool begins = is_near(v[0].position, tip);
        if (strip->kind != STP_LINE_TUBE || !(begins || is_near(v[strip->count - 1].position, tip)))
            continue;
        assert_null(found);
        found = strip;
        *step = begins ? 1 : -1;
    }
    return found;
}

/* The colour must be the mean of the ring's colours; the shuffled mesh has none. */
static void check_colour(const stp_plant *plant, const stp_line_vertex *v, uint32_t first,
                         uint32_t count)
{
    for (int c = 0; c < 3 && plant->rest->rgb != NULL; c++) {
        double sum = 0.0;
        for (uint32_t i = first; i < first + count; i++)
            sum += (double)mesh.mesh.rgb[i][c];
        check_near((double)v->rgb[c], sum / (double)count, 1.0);
    }
}

/* The tube's vertices must be the plan's thin rings, from the tip down; returns how many. */
static size_t check_tube(const stp_plant *plant, const gen_tree_tube *tube)
{
    int step = 0;
    const uint32_t tip = tube->first_vertex + tube->ring_count * tube->sides;
    const stp_line_strip *strip = find_tube(plant, mesh.mesh.positions[tip], &step);
    assert_non_null(strip);
    const stp_line_vertex *v = plant->lines.vertices + strip->begin;
    v += step < 0 ? strip->count - 1 : 0;
    size_t count = 1;
    for (uint32_t r = tube->ring_count; r-- > 0; count++) {
        const gen_tree_ring *ring = &tree.rings[tube->first_ring + r];
        if (width_radius(ring, tube->sides) > greatest_radius)
            break;
        v += step;
        check_near(stp_dvec3_length(stp_dvec3_sub(v->position, ring->centre)), 0.0, 1e-6);
        check_near((double)v->radius / width_radius(ring, tube->sides), 1.0, 0.01);
        check_near(fabs(stp_dvec3_dot(stp_dvec3_from_float(v->direction), ring->axis)), 1.0, 0.02);
        check_colour(plant, v, tube->first_vertex + r * tube->sides, tube->sides);
    }
    assert_int_equal(strip->count, count);
    return count;
}

static void check_rings(const stp_plant *plant)
{
    size_t thin = 0;
    for (size_t i = 0; i < tree.tube_count; i++)
        thin += check_tube(plant, &tree.tubes[i]);
    assert_int_equal(plant->report.rings, thin);
    assert_int_equal(plant->report.tubes, tree.tube_count);
}

/* Only the trunk is kept, from the root to the first thin ring. */
static void check_trunk(const stp_plant *plant)
{
    const gen_tree_tube *trunk = &tree.tubes[0];
    uint32_t thick = 0;
    while (width_radius(&tree.rings[thick], trunk->sides) > greatest_radius)
        thick++;
    assert_true(thick > 3 && thick < trunk->ring_count);
    assert_int_equal(plant->rest->triangle_count, thick * 2 * trunk->sides);
    assert_int_equal(plant->rest->vertex_count, (thick + 1) * trunk->sides);
    for (uint64_t i = 0; i < plant->rest->vertex_count; i++) {
        bool found = false;
        for (uint32_t v = 0; v < (thick + 1) * trunk->sides; v++)
            found |= is_near(plant->rest->positions[i], mesh.mesh.positions[v]);
        assert_true(found);
    }
}

static void test_branches_and_trunk(void **state)
{
    (void)state;
    stp_plant plant = plant_convert(&mesh.mesh, NULL);
    check_rings(&plant);
    check_trunk(&plant);
    const double share = (double)plant.report.vertices_after / (double)plant.report.vertices_before;
    print_message("%llu vertices become %llu: %.1f %%\n",
                  (unsigned long long)plant.report.vertices_before,
                  (unsigned long long)plant.report.vertices_after, 100.0 * share);
    assert_true(share <= 0.35);
    stp_plant_clear(&plant);
}

/* The order of vertices, triangles and corners must not matter, nor whether there are normals and
 * colours. */
static void test_any_order(void **state)
{
    (void)state;
    stp_plant plant = plant_convert(&shuffled.mesh, NULL);
    assert_int_equal(plant.report.ribbons, tree.leaf_count);
    for (size_t i = 0; i < tree.leaf_count; i++) {
        stp_line_vertex ribbon[4];
        check_leaf(&plant, i, ribbon);
    }
    check_rings(&plant);
    check_trunk(&plant);
    stp_plant_clear(&plant);
}

/* Each triangle with three vertices of its own, and again from behind, as in files without shared
 * vertices. */
static void test_soup(void **state)
{
    (void)state;
    const uint64_t count = mesh.mesh.triangle_count;
    plant_mesh soup = plant_mesh_create(6 * count, 2 * count);
    for (uint64_t i = 0; i < 2 * count; i++) {
        uint32_t v[3];
        for (int k = 0; k < 3; k++) {
            const int corner = i < count ? k : 2 - k;
            const stp_dvec3 p = mesh.mesh.positions[mesh.mesh.triangles[i % count][corner]];
            v[k] = plant_mesh_vertex(&soup, p.x, p.y, p.z);
        }
        plant_mesh_triangle(&soup, v[0], v[1], v[2]);
    }
    stp_plant plant = plant_convert(&soup.mesh, NULL);
    assert_int_equal(plant.report.ribbons, tree.leaf_count);
    assert_int_equal(plant.report.ribbon_triangles, 8 * tree.leaf_count);
    check_rings(&plant);
    assert_true(plant.report.positions_before < mesh.mesh.vertex_count);
    assert_true(10 * plant.report.vertices_after < plant.report.vertices_before);
    stp_plant_clear(&plant);
    plant_mesh_clear(&soup);
}

static void test_same_bytes(void **state)
{
    (void)state;
    stp_plant a = plant_convert(&mesh.mesh, NULL), b = plant_convert(&mesh.mesh, NULL);
    assert_int_equal(a.lines.vertex_count, b.lines.vertex_count);
    for (uint64_t i = 0; i < a.lines.vertex_count; i++) {
        const stp_line_vertex *v = &a.lines.vertices[i], *w = &b.lines.vertices[i];
        assert_memory_equal(&v->position, &w->position, sizeof v->position);
        assert_memory_equal(&v->direction, &w->direction, sizeof v->direction);
        assert_true(v->radius == w->radius && v->rgb[0] == w->rgb[0]);
    }
    stp_plant_clear(&a);
    stp_plant_clear(&b);
}

static void test_thresholds(void **state)
{
    (void)state;
    const stp_plant_params thin = {.trunk_radius = 1e-6}, all = {.trunk_radius = 1.0};
    const stp_plant_params no_leaf = {.leaf_size = 1e-6};
    stp_plant plant = plant_convert(&mesh.mesh, &thin);
    assert_int_equal(plant.report.tubes, 0);
    assert_int_equal(plant.report.ribbons, tree.leaf_count);
    stp_plant_clear(&plant);
    plant = plant_convert(&mesh.mesh, &all);
    assert_int_equal(plant.report.kept_triangles, 0);
    assert_int_equal(plant.report.rings, tree.ring_count + tree.tube_count);
    stp_plant_clear(&plant);
    plant = plant_convert(&mesh.mesh, &no_leaf);
    assert_int_equal(plant.report.ribbons, 0);
    assert_int_equal(plant.report.tubes, tree.tube_count);
    stp_plant_clear(&plant);
}

static void test_parameters_are_checked(void **state)
{
    (void)state;
    const stp_plant_params wrong[] = {
        {.leaf_size = -1.0}, {.trunk_radius = NAN}, {.leaf_size = INFINITY}};
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++) {
        stp_plant plant = {.report.tubes = 77};
        stp_error error = {0};
        assert_int_equal(stp_plant_convert(&plant, &mesh.mesh, &wrong[i], &error),
                         STP_INVALID_ARGUMENT);
        assert_non_null(strstr(error.message, "0 for the default"));
        assert_int_equal(plant.report.tubes, 77);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_leaves),
        cmocka_unit_test(test_branches_and_trunk),
        cmocka_unit_test(test_any_order),
        cmocka_unit_test(test_soup),
        cmocka_unit_test(test_same_bytes),
        cmocka_unit_test(test_thresholds),
        cmocka_unit_test(test_parameters_are_checked),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
