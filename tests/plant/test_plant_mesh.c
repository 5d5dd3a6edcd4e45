/* Tests meshes to lines, shape by shape: what becomes a ribbon, what becomes a tube, and what
 * stays. Broken meshes must lose nothing. */
#include "tests/fixtures/plant_fixture.h"

static const double pi = 3.14159265358979323846;
/* For a shape that is the whole model: leaves may be as large as the model, and tubes as thick. */
static const stp_plant_params alone = {.leaf_size = 1.0, .trunk_radius = 1.0};

/* Converts, checks how many triangles became ribbons and tubes, and clears the mesh. */
static stp_plant expect(plant_mesh *m, const stp_plant_params *params, uint64_t ribbon_triangles,
                        uint64_t tube_triangles)
{
    stp_plant plant = plant_convert(&m->mesh, params);
    assert_int_equal(plant.report.ribbon_triangles, ribbon_triangles);
    assert_int_equal(plant.report.tube_triangles, tube_triangles);
    plant_mesh_clear(m);
    return plant;
}

static void expect_all_kept(plant_mesh *m, const stp_plant_params *params)
{
    stp_plant plant = expect(m, params, 0, 0);
    assert_int_equal(plant.lines.vertex_count, 0);
    stp_plant_clear(&plant);
}

static void check_vertex(const stp_line_vertex *v, double x, double y, double z, double radius)
{
    const stp_dvec3 expected = {x, y, z};
    check_near(stp_dvec3_length(stp_dvec3_sub(v->position, expected)), 0.0, 1e-9);
    check_near((double)v->radius, radius, 1e-6);
}

/* An empty mesh, one triangle, a lone vertex. */
static void test_nearly_nothing(void **state)
{
    (void)state;
    plant_mesh m = plant_mesh_create(3, 1);
    expect_all_kept(&m, &alone);
    m = plant_mesh_create(3, 1);
    plant_mesh_vertex(&m, 1.0, 2.0, 3.0);
    expect_all_kept(&m, NULL);
    m = plant_mesh_create(3, 1);
    for (int i = 0; i < 3; i++)
        plant_mesh_vertex(&m, i == 1, i == 2, 0.0);
    plant_mesh_triangle(&m, 0, 1, 2);
    expect_all_kept(&m, &alone);
}

/* A card 3 wide and 4 long, cut either way: the ribbon must end where the card ends. */
static void test_cards(void **state)
{
    (void)state;
    for (int turn = 0; turn < 4; turn++) {
        plant_mesh m = plant_mesh_create(4, 2);
        plant_mesh_vertex(&m, -1.5, 0.0, 0.0);
        plant_mesh_vertex(&m, 1.5, 0.0, 0.0);
        plant_mesh_vertex(&m, 1.5, 4.0, 0.0);
        plant_mesh_vertex(&m, -1.5, 4.0, 0.0);
        const uint32_t t = (uint32_t)turn;
        plant_mesh_quad(&m, t, (t + 1) % 4, (t + 2) % 4, (t + 3) % 4);
        stp_plant plant = expect(&m, &alone, 2, 0);
        assert_int_equal(plant.lines.vertex_count, 2);
        const stp_line_vertex *v = plant.lines.vertices;
        const bool up = v[0].position.y < v[1].position.y;
        check_vertex(&v[!up], 0.0, 0.0, 0.0, 1.5);
        check_vertex(&v[up], 0.0, 4.0, 0.0, 1.5);
        check_near(fabs((double)v->direction.z), 1.0, 1e-6);
        assert_int_equal(v->rgb[0], 200 * 257);
        stp_plant_clear(&plant);
    }
}

/* A rhombus with a point at each end: three vertices. */
static void test_pointed_card(void **state)
{
    (void)state;
    plant_mesh m = plant_mesh_create(4, 2);
    plant_mesh_vertex(&m, 0.0, 0.0, 0.0);
    plant_mesh_vertex(&m, 1.0, 2.0, 0.0);
    plant_mesh_vertex(&m, 0.0, 4.0, 0.0);
    plant_mesh_vertex(&m, -1.0, 2.0, 0.0);
    plant_mesh_quad(&m, 1, 2, 3, 0);
    stp_plant plant = expect(&m, &alone, 2, 0);
    assert_int_equal(plant.lines.vertex_count, 3);
    check_vertex(&plant.lines.vertices[1], 0.0, 2.0, 0.0, 1.0);
    check_near(plant.lines.vertices[0].position.x, 0.0, 1e-9);
    stp_plant_clear(&plant);
}

/* A bent blade of grass of quads that ends in a point: each pair gives a vertex, and so does the
 * point. */
static void test_blade(void **state)
{
    (void)state;
    enum { ROWS = 6 };
    plant_mesh m = plant_mesh_create(2 * ROWS + 1, 2 * ROWS);
    for (int i = 0; i < ROWS; i++)
        for (int side = -1; side < 2; side += 2)
            plant_mesh_vertex(&m, side * 0.1 * (1.0 - 0.1 * i), i, 0.05 * i * i);
    plant_mesh_vertex(&m, 0.0, ROWS, 0.05 * ROWS * ROWS);
    for (uint32_t i = 0; i + 1 < ROWS; i++)
        plant_mesh_quad(&m, 2 * i, 2 * i + 1, 2 * i + 3, 2 * i + 2);
    plant_mesh_triangle(&m, 2 * ROWS - 2, 2 * ROWS - 1, 2 * ROWS);
    stp_plant plant = expect(&m, &alone, 2 * ROWS - 1, 0);
    assert_int_equal(plant.lines.vertex_count, ROWS + 1);
    const bool up = plant.lines.vertices[0].position.y < 1.0;
    for (int i = 1; i < ROWS; i++)
        check_vertex(&plant.lines.vertices[up ? i : ROWS - i], 0.0, i, 0.05 * i * i,
                     0.1 * (1.0 - 0.1 * i));
    stp_plant_clear(&plant);
}

/* Four triangles that form a row of two squares are no pointed leaf, but three pairs. */
static void test_two_squares(void **state)
{
    (void)state;
    plant_mesh m = plant_mesh_create(6, 4);
    for (int i = 0; i < 3; i++) {
        plant_mesh_vertex(&m, -1.0, 2.0 * i, 0.0);
        plant_mesh_vertex(&m, 1.0, 2.0 * i, 0.0);
    }
    plant_mesh_quad(&m, 0, 1, 3, 2);
    plant_mesh_quad(&m, 2, 3, 5, 4);
    stp_plant plant = expect(&m, &alone, 4, 0);
    assert_int_equal(plant.lines.vertex_count, 3);
    check_vertex(&plant.lines.vertices[1], 0.0, 2.0, 0.0, 1.0);
    stp_plant_clear(&plant);
}

/* A leaf of six vertices: end, pairs, end; the pairs are 2 wide. */
static void add_leaf(plant_mesh *m, const uint32_t v[6])
{
    plant_mesh_triangle(m, v[0], v[1], v[2]);
    plant_mesh_quad(m, v[1], v[3], v[4], v[2]);
    plant_mesh_triangle(m, v[3], v[5], v[4]);
}

/* Two leaves that share their first vertex, and two whose first vertices are at one position. */
static void test_leaves_that_touch(void **state)
{
    (void)state;
    for (int shared = 0; shared < 2; shared++) {
        plant_mesh m = plant_mesh_create(12, 8);
        for (int side = -1; side < 2; side += 2) {
            uint32_t v[6] = {0};
            if (side < 0 || !shared)
                v[0] = plant_mesh_vertex(&m, 0.0, 0.0, 0.0);
            for (uint32_t i = 1; i < 5; i++)
                v[i] = plant_mesh_vertex(&m, i % 2 ? 1.0 : -1.0, side * (i < 3 ? 2.0 : 3.0), 0.0);
            v[5] = plant_mesh_vertex(&m, 0.0, side * 5.0, 0.0);
            add_leaf(&m, v);
        }
        stp_plant plant = expect(&m, &alone, 8, 0);
        assert_int_equal(plant.report.ribbons, 2);
        assert_int_equal(plant.report.positions_before, 11);
        for (uint64_t i = 0; i < 2; i++) {
            const stp_line_vertex *l = plant.lines.vertices + 4 * i;
            const double up = i == 0 ? -1.0 : 1.0;
            const int turned = fabs(l[0].position.y) > 4.0;
            assert_int_equal(plant.lines.strips[i].count, 4);
            check_vertex(&l[turned ? 2 : 1], 0.0, up * 2.0, 0.0, 1.0);
            check_vertex(&l[turned ? 1 : 2], 0.0, up * 3.0, 0.0, 1.0);
            check_vertex(&l[turned ? 3 : 0], 0.0, 0.0, 0.0, 0.01);
        }
        stp_plant_clear(&plant);
    }
}

/* A leaf much too large for the model is ground or a wall. */
static void test_large_cards_stay(void **state)
{
    (void)state;
    plant_mesh m = plant_mesh_create(4, 2);
    for (int i = 0; i < 4; i++)
        plant_mesh_vertex(&m, i == 1 || i == 2, i > 1, 0.0);
    plant_mesh_quad(&m, 0, 1, 2, 3);
    expect_all_kept(&m, NULL);
}

/* An open tube of a regular polygon: checks centres, mean widths and tangents. */
static void test_open_tube(void **state)
{
    (void)state;
    for (uint32_t sides = 3; sides < 13; sides++) {
        enum { RINGS = 5 };
        plant_mesh m = plant_mesh_create((size_t)sides * RINGS, (size_t)sides * 2 * RINGS);
        for (uint32_t r = 0; r < RINGS; r++) {
            const uint32_t first = plant_mesh_ring(&m, sides, 2.0 * r, 1.0 - 0.1 * r);
            if (r > 0)
                plant_mesh_join(&m, first - sides, first, sides);
        }
        stp_plant plant = expect(&m, &alone, 0, (uint64_t)sides * 2 * (RINGS - 1));
        assert_int_equal(plant.report.tubes, 1);
        assert_int_equal(plant.lines.vertex_count, RINGS);
        const bool up = plant.lines.vertices[0].position.y < 1.0;
        for (int r = 0; r < RINGS; r++) {
            const stp_line_vertex *v = &plant.lines.vertices[up ? r : RINGS - 1 - r];
            check_vertex(v, 0.0, 2.0 * r, 0.0,
                         (1.0 - 0.1 * r) * (double)sides * sin(pi / (double)sides) / pi);
            check_near(fabs((double)v->direction.y), 1.0, 1e-6);
        }
        stp_plant_clear(&plant);
    }
}

/* Rings with a seam (their first vertex is repeated at the end, as in files with textures), with
 * lids at both ends or a tip. */
static void test_seam_and_lids(void **state)
{
    (void)state;
    enum { SIDES = 6, RINGS = 4 };
    for (int lids = 0; lids < 2; lids++) {
        plant_mesh m = plant_mesh_create((SIDES + 1) * RINGS + 1, 2 * SIDES * RINGS + 8);
        for (uint32_t r = 0; r < RINGS; r++) {
            const uint32_t first = plant_mesh_ring(&m, SIDES, 3.0 * r, 1.0);
            const stp_dvec3 seam = m.mesh.positions[first];
            plant_mesh_vertex(&m, seam.x, seam.y, -seam.z);
            for (uint32_t k = 0; k < SIDES && r > 0; k++)
                plant_mesh_quad(&m, first + k - SIDES - 1, first + k - SIDES, first + k + 1,
                                first + k);
        }
        const uint32_t last = (SIDES + 1) * (RINGS - 1);
        const uint32_t tip = plant_mesh_vertex(&m, 0.0, 3.0 * RINGS, 0.0);
        for (uint32_t k = 0; k < SIDES && !lids; k++)
            plant_mesh_triangle(&m, last + k, last + k + 1, tip);
        for (uint32_t k = 1; k + 1 < SIDES && lids; k++) {
            plant_mesh_triangle(&m, 0, k, k + 1);
            plant_mesh_triangle(&m, last, last + k, last + k + 1);
        }
        const uint64_t all = m.mesh.triangle_count;
        stp_plant plant = expect(&m, &alone, 0, all);
        assert_int_equal(plant.report.positions_before, SIDES * RINGS + 1);
        assert_int_equal(plant.report.rings, lids ? RINGS : RINGS + 1);
        stp_plant_clear(&plant);
    }
}

/* A thin closed tube becomes one line, except for the section where it closes, in linear time. */
static void test_hoop(void **state)
{
    (void)state;
    enum { SIDES = 5, RINGS = 40000 };
    plant_mesh m = plant_mesh_create(SIDES * RINGS, 2 * SIDES * RINGS);
    for (uint32_t r = 0; r < RINGS; r++) {
        const uint32_t first = plant_mesh_ring(&m, SIDES, 0.0, 0.01);
        const double angle = 2.0 * pi * r / RINGS;
        for (uint32_t k = first; k < first + SIDES; k++) {
            const stp_dvec3 p = m.mesh.positions[k];
            m.mesh.positions[k] =
                (stp_dvec3){(9.0 + p.x) * cos(angle), (9.0 + p.x) * sin(angle), p.z};
        }
    }
    for (uint32_t r = 0; r < RINGS; r++)
        plant_mesh_join(&m, SIDES * r, SIDES * ((r + 1) % RINGS), SIDES);
    stp_plant plant = expect(&m, NULL, 0, 2 * SIDES * (RINGS - 1));
    assert_int_equal(plant.report.tubes, 1);
    assert_int_equal(plant.report.rings, RINGS);
    stp_plant_clear(&plant);
}

/* A tube with eight sides below and four above. */
static void test_fewer_sides(void **state)
{
    (void)state;
    plant_mesh m = plant_mesh_create(32, 80);
    plant_mesh_ring(&m, 8, 0.0, 0.5);
    plant_mesh_ring(&m, 8, 2.0, 0.5);
    plant_mesh_ring(&m, 4, 4.0, 0.4);
    plant_mesh_ring(&m, 4, 6.0, 0.3);
    plant_mesh_join(&m, 0, 8, 8);
    for (uint32_t k = 0; k < 4; k++) {
        const uint32_t low = 8 + 2 * k, next = 8 + (2 * k + 2) % 8;
        plant_mesh_triangle(&m, low, low + 1, 16 + k);
        plant_mesh_triangle(&m, low + 1, next, 16 + k);
        plant_mesh_triangle(&m, next, 16 + (k + 1) % 4, 16 + k);
    }
    plant_mesh_join(&m, 16, 20, 4);
    stp_plant plant = expect(&m, &alone, 0, 16 + 12 + 8);
    assert_int_equal(plant.report.rings, 4);
    stp_plant_clear(&plant);
}

/* Normals that lean by 45 degrees, which is light, and by 80, which no disc of the ribbon can
 * follow. */
static void test_leaf_normals(void **state)
{
    (void)state;
    for (int lean_deg = 45; lean_deg <= 80; lean_deg += 35) {
        plant_mesh m = plant_mesh_create(4, 2);
        const float lean = (float)lean_deg * 3.14159265f / 180.0f;
        for (int i = 0; i < 4; i++)
            plant_mesh_vertex(&m, i == 1 || i == 2, i > 1 ? 3.0 : 0.0, 0.0);
        m.mesh.normals = calloc(4, sizeof *m.mesh.normals);
        assert_non_null(m.mesh.normals);
        for (int i = 0; i < 4; i++)
            m.mesh.normals[i] = (vec3s){{0.0f, sinf(lean), cosf(lean)}};
        plant_mesh_quad(&m, 0, 1, 2, 3);
        stp_plant plant = expect(&m, &alone, 2, 0);
        const double up = fabs((double)plant.lines.vertices[0].direction.z);
        check_near(up, lean_deg == 45 ? sqrt(0.5) : 1.0, 1e-6);
        stp_plant_clear(&plant);
    }
}

enum { FORK_SIDES = 4, FORK_RINGS = 5 };

/* Adds three arms of rings, one of them downwards; `ends` gets their rings at the fork. */
static void add_arms(plant_mesh *m, bool tips, uint32_t ends[3])
{
    for (int arm = 0; arm < 3; arm++) {
        const double side = arm == 0 ? 0.0 : arm == 1 ? -2.0 : 2.0;
        for (uint32_t r = 0; r < FORK_RINGS; r++) {
            const double y = arm == 0 ? -2.0 * r : 3.0 + 2.0 * r;
            const uint32_t first = plant_mesh_ring(m, FORK_SIDES, y, 0.5);
            for (uint32_t k = 0; k < FORK_SIDES; k++)
                m->mesh.positions[first + k].x += side;
            ends[arm] = r == 0 ? first : ends[arm];
            if (r > 0)
                plant_mesh_join(m, first - FORK_SIDES, first, FORK_SIDES);
        }
        const uint32_t last = (uint32_t)m->mesh.vertex_count - FORK_SIDES;
        const uint32_t tip =
            plant_mesh_vertex(m, side, (arm == 0 ? -2.0 : 2.0) * FORK_RINGS + side * side, 0.0);
        for (uint32_t k = 0; k < FORK_SIDES && tips; k++)
            plant_mesh_triangle(m, last + k, last + (k + 1) % FORK_SIDES, tip);
    }
}

/* A trunk forks in two: each of the three is a tube up to the fork, and the fork stays. With tips,
 * the mesh has no border. */
static void test_fork(void **state)
{
    (void)state;
    for (int tips = 0; tips < 2; tips++) {
        plant_mesh m = plant_mesh_create(100, 200);
        uint32_t ends[3] = {0};
        add_arms(&m, tips, ends);
        const uint64_t arms = m.mesh.triangle_count;
        /* joins halves of the lower ring to the rings above, and these by a saddle */
        const uint32_t l = ends[0], a = ends[1], b = ends[2];
        for (uint32_t k = 1; k < 3; k++)
            plant_mesh_quad(&m, l + k, l + k + 1, a + k + 1, a + k);
        for (uint32_t k = 3; k < 5; k++)
            plant_mesh_quad(&m, l + k % 4, l + (k + 1) % 4, b + (k + 1) % 4, b + k % 4);
        plant_mesh_quad(&m, a + 3, a, b + 2, b + 3);
        plant_mesh_quad(&m, a, a + 1, b + 1, b + 2);
        plant_mesh_triangle(&m, l + 1, a + 1, b + 1);
        plant_mesh_triangle(&m, l + 3, b + 3, a + 3);
        stp_plant plant = expect(&m, &alone, 0, arms);
        assert_int_equal(plant.report.tubes, 3);
        assert_int_equal(plant.report.rings, 3 * (FORK_RINGS + tips));
        stp_plant_clear(&plant);
    }
}

/* Latitudes and longitudes, as a closed tube has them, but no longer than wide. */
static plant_mesh make_sphere(uint32_t sides, uint32_t rings)
{
    plant_mesh m = plant_mesh_create((size_t)sides * rings + 2, (size_t)sides * 2 * (rings + 1));
    const uint32_t south = plant_mesh_vertex(&m, 0.0, -1.0, 0.0);
    for (uint32_t r = 0; r < rings; r++) {
        const double latitude = pi * ((r + 1.0) / (rings + 1.0) - 0.5);
        const uint32_t first = plant_mesh_ring(&m, sides, sin(latitude), cos(latitude));
        if (r > 0)
            plant_mesh_join(&m, first - sides, first, sides);
    }
    const uint32_t north = plant_mesh_vertex(&m, 0.0, 1.0, 0.0);
    for (uint32_t k = 0; k < sides; k++) {
        plant_mesh_triangle(&m, 1 + k, 1 + (k + 1) % sides, south);
        plant_mesh_triangle(&m, north - sides + k, north - sides + (k + 1) % sides, north);
    }
    return m;
}

static void test_sphere_stays(void **state)
{
    (void)state;
    plant_mesh m = make_sphere(12, 9);
    expect_all_kept(&m, &alone);
    m = make_sphere(200, 100);
    expect_all_kept(&m, NULL);
    m = make_sphere(40, 39); /* its meridians are rings too */
    expect_all_kept(&m, &alone);
}

/* A box with two long sides and two short ones is a plank. A pipe that is short for its width is a
 * ring. */
static void test_planks_and_rings_stay(void **state)
{
    (void)state;
    plant_mesh m = plant_mesh_create(8, 8);
    for (int i = 0; i < 8; i++)
        plant_mesh_vertex(&m, i % 4 == 1 || i % 4 == 2 ? 1.0 : 0.0, i > 3 ? 20.0 : 0.0,
                          i % 4 > 1 ? 0.01 : 0.0);
    plant_mesh_join(&m, 0, 4, 4);
    expect_all_kept(&m, &alone);
    m = plant_mesh_create(16, 16);
    plant_mesh_ring(&m, 8, 0.0, 1.0);
    plant_mesh_ring(&m, 8, 1.0, 1.0);
    plant_mesh_join(&m, 0, 8, 8);
    expect_all_kept(&m, &alone);
}

/* A tube with one damaged triangle: it has a twin, is degenerate, or has a corner that is not
 * finite. What can be read must be converted, nothing may be lost, and the leaf beside it must be
 * found. */
static void test_damage(void **state)
{
    (void)state;
    enum { SIDES = 5, RINGS = 12 };
    for (int damage = 0; damage < 5; damage++) {
        plant_mesh m = plant_mesh_create(SIDES * RINGS + 6, 2 * SIDES * RINGS + 10);
        for (uint32_t r = 0; r < RINGS; r++) {
            const uint32_t first = plant_mesh_ring(&m, SIDES, r, 0.2);
            if (r > 0)
                plant_mesh_join(&m, first - SIDES, first, SIDES);
        }
        uint32_t v[6];
        for (uint32_t i = 0; i < 6; i++)
            v[i] = plant_mesh_vertex(&m,
                                     i == 0 || i == 5 ? 0.0
                                     : i % 2          ? 1.0
                                                      : -1.0,
                                     (double)((i + 1) / 2), 5.0);
        add_leaf(&m, v);
        uint32_t *hit = m.mesh.triangles[SIDES * RINGS];
        if (damage == 0)
            plant_mesh_triangle(&m, hit[0], hit[1], hit[2]);
        else if (damage == 1)
            hit[1] = hit[0];
        else if (damage == 2)
            m.mesh.positions[hit[0]].y = NAN;
        else if (damage == 3)
            m.mesh.positions[hit[0]].x = INFINITY;
        else
            plant_mesh_triangle(&m, hit[0], hit[1], v[0]);
        const uint64_t all = m.mesh.triangle_count;
        stp_plant plant = plant_convert(&m.mesh, &alone);
        assert_int_equal(plant.report.ribbons, 1);
        /* a twin goes with its triangle; a triangle that only touches is no part of the tube */
        static const uint64_t tubes[] = {1, 2, 2, 2, 1};
        assert_int_equal(plant.report.tubes, tubes[damage]);
        assert_true((plant.report.kept_triangles >= 1) == (damage > 0));
        assert_true(plant.report.kept_triangles < all / 2);
        stp_plant_clear(&plant);
        plant_mesh_clear(&m);
    }
}

/* Every triangle uses the same few vertices, or all lie around one vertex. */
static void test_tangles(void **state)
{
    (void)state;
    enum { COUNT = 200000 };
    plant_mesh m = plant_mesh_create(8, 10000);
    for (int i = 0; i < 8; i++)
        plant_mesh_vertex(&m, stp_random_unit(1, (uint64_t)i), i % 3, i % 2);
    for (uint64_t i = 0; i < 10000; i++)
        plant_mesh_triangle(&m, (uint32_t)stp_random_u64(2, i) % 8,
                            (uint32_t)stp_random_u64(3, i) % 8, (uint32_t)stp_random_u64(4, i) % 8);
    expect_all_kept(&m, &alone);
    m = plant_mesh_create(2 * COUNT + 1, COUNT);
    plant_mesh_vertex(&m, 0.0, 0.0, 0.0);
    for (uint32_t i = 0; i < COUNT; i++) {
        const double angle = 2.0 * pi * i / COUNT;
        plant_mesh_vertex(&m, cos(angle), sin(angle), 0.0);
        plant_mesh_vertex(&m, cos(angle + 1e-6), sin(angle + 1e-6), 0.0);
        plant_mesh_triangle(&m, 0, 2 * i + 1, 2 * i + 2);
    }
    expect_all_kept(&m, NULL);
    m = plant_mesh_create(COUNT + 1, COUNT);
    plant_mesh_vertex(&m, 0.0, 0.0, 1.0);
    for (uint32_t i = 0; i < COUNT; i++)
        plant_mesh_vertex(&m, cos(2.0 * pi * i / COUNT), sin(2.0 * pi * i / COUNT), 0.0);
    for (uint32_t i = 0; i < COUNT; i++)
        plant_mesh_triangle(&m, 0, 1 + i, 1 + (i + 1) % COUNT);
    expect_all_kept(&m, NULL);
}

/* A tree with triangles that are gone, rewired or moved to one place: whatever is found, no
 * triangle may be lost. */
static void test_random_damage(void **state)
{
    (void)state;
    gen_tree tree;
    check_ok(gen_tree_grow(&tree, 3000, 9, err));
    for (uint64_t seed = 0; seed < 40; seed++) {
        plant_mesh m = plant_mesh_of_tree(&tree);
        const uint64_t vertices = m.mesh.vertex_count, hits = m.mesh.triangle_count >> seed % 8;
        for (uint64_t i = 0; i < hits; i++) {
            const uint64_t random = stp_random_u64(seed, i);
            uint32_t *hit = m.mesh.triangles[random % m.mesh.triangle_count];
            const uint32_t near = hit[0] + (uint32_t)(random >> 40) % 8;
            if (random >> 32 & 1)
                hit[random >> 33 & 1] = near < vertices ? near : hit[0];
            else if (random >> 34 & 1)
                memcpy(hit, m.mesh.triangles[--m.mesh.triangle_count], 3 * sizeof *hit);
            else
                m.mesh.positions[hit[0]] = m.mesh.positions[hit[1]];
        }
        stp_plant plant = plant_convert(&m.mesh, seed % 2 ? NULL : &alone);
        stp_plant_clear(&plant);
        plant_mesh_clear(&m);
    }
    gen_tree_clear(&tree);
}

/* Models whose lengths no float can hold must stay as they are. */
static void test_sizes(void **state)
{
    (void)state;
    const double sizes[] = {1e-30, 1e-10, 1.0, 1e10, 1e30, 1e300};
    for (int i = 0; i < 6; i++) {
        plant_mesh m = plant_mesh_create(20, 40);
        for (uint32_t r = 0; r < 5; r++) {
            const uint32_t first = plant_mesh_ring(&m, 4, 4.0 * r, 0.5);
            if (r > 0)
                plant_mesh_join(&m, first - 4, first, 4);
        }
        for (int v = 0; v < 20; v++)
            m.mesh.positions[v] = stp_dvec3_scale(m.mesh.positions[v], sizes[i]);
        stp_plant plant = expect(&m, &alone, 0, i > 0 && i < 4 ? 32 : 0);
        stp_plant_clear(&plant);
    }
}

/* A tree of a million triangles takes seconds. If each triangle looked at all others, the test
 * would run out of time. */
static void test_large_tree(void **state)
{
    (void)state;
    gen_tree tree;
    check_ok(gen_tree_grow(&tree, 600000, 1, err));
    plant_mesh m = plant_mesh_of_tree(&tree);
    stp_plant plant;
    check_ok(stp_plant_convert(&plant, &m.mesh, NULL, err));
    assert_true(plant.report.ribbons > 0 && plant.report.tubes > 0);
    stp_plant_clear(&plant);
    plant_mesh_clear(&m);
    gen_tree_clear(&tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nearly_nothing),
        cmocka_unit_test(test_cards),
        cmocka_unit_test(test_pointed_card),
        cmocka_unit_test(test_blade),
        cmocka_unit_test(test_two_squares),
        cmocka_unit_test(test_leaves_that_touch),
        cmocka_unit_test(test_large_cards_stay),
        cmocka_unit_test(test_open_tube),
        cmocka_unit_test(test_seam_and_lids),
        cmocka_unit_test(test_hoop),
        cmocka_unit_test(test_fewer_sides),
        cmocka_unit_test(test_leaf_normals),
        cmocka_unit_test(test_fork),
        cmocka_unit_test(test_sphere_stays),
        cmocka_unit_test(test_planks_and_rings_stay),
        cmocka_unit_test(test_damage),
        cmocka_unit_test(test_tangles),
        cmocka_unit_test(test_random_damage),
        cmocka_unit_test(test_sizes),
        cmocka_unit_test(test_large_tree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
