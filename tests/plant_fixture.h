/* Meshes of plants made by hand or by `stipple gen tree`, and what must hold for any conversion. */
#ifndef STP_TESTS_PLANT_FIXTURE_H
#define STP_TESTS_PLANT_FIXTURE_H

#include "base/random.h"
#include "preprocess/plant.h"
#include "tests/support/check.h"
#include "tools/gen/tree.h"

/* A mesh that grows to a fixed size. */
typedef struct plant_mesh {
    stp_mesh mesh;
    size_t vertex_capacity, triangle_capacity;
} plant_mesh;

static inline plant_mesh plant_mesh_create(size_t vertices, size_t triangles)
{
    plant_mesh m = {.vertex_capacity = vertices, .triangle_capacity = triangles};
    m.mesh.positions = calloc(vertices + 1, sizeof *m.mesh.positions);
    m.mesh.triangles = calloc(triangles + 1, sizeof *m.mesh.triangles);
    assert_non_null(m.mesh.positions);
    assert_non_null(m.mesh.triangles);
    return m;
}

static inline void plant_mesh_clear(plant_mesh *m)
{
    free(m->mesh.positions);
    free(m->mesh.normals);
    free(m->mesh.rgb);
    free(m->mesh.triangles);
    *m = (plant_mesh){0};
}

static inline uint32_t plant_mesh_vertex(plant_mesh *m, double x, double y, double z)
{
    assert_true(m->mesh.vertex_count < m->vertex_capacity);
    m->mesh.positions[m->mesh.vertex_count] = (stp_dvec3){x, y, z};
    return (uint32_t)m->mesh.vertex_count++;
}

static inline void plant_mesh_triangle(plant_mesh *m, uint32_t a, uint32_t b, uint32_t c)
{
    assert_true(m->mesh.triangle_count < m->triangle_capacity);
    uint32_t *t = m->mesh.triangles[m->mesh.triangle_count++];
    t[0] = a;
    t[1] = b;
    t[2] = c;
}

static inline void plant_mesh_quad(plant_mesh *m, uint32_t a, uint32_t b, uint32_t c, uint32_t d)
{
    plant_mesh_triangle(m, a, b, c);
    plant_mesh_triangle(m, a, c, d);
}

/* A ring about the y axis; first_vertex of `sides`, the last joined to the first. */
static inline uint32_t plant_mesh_ring(plant_mesh *m, uint32_t sides, double y, double radius)
{
    const uint32_t first = (uint32_t)m->mesh.vertex_count;
    for (uint32_t k = 0; k < sides; k++) {
        const double angle = 2.0 * 3.14159265358979323846 * k / sides;
        plant_mesh_vertex(m, radius * cos(angle), y, radius * sin(angle));
    }
    return first;
}

static inline void plant_mesh_join(plant_mesh *m, uint32_t low, uint32_t high, uint32_t sides)
{
    for (uint32_t k = 0; k < sides; k++) {
        const uint32_t next = (k + 1) % sides;
        plant_mesh_quad(m, low + k, low + next, high + next, high + k);
    }
}

/* The tree's mesh with its normals and colours. */
static inline plant_mesh plant_mesh_of_tree(const gen_tree *tree)
{
    const size_t vertices = tree->mesh.vertex_count, triangles = tree->mesh.triangle_count;
    plant_mesh m = plant_mesh_create(vertices, triangles);
    m.mesh.normals = calloc(vertices, sizeof *m.mesh.normals);
    m.mesh.rgb = calloc(vertices, sizeof *m.mesh.rgb);
    assert_non_null(m.mesh.normals);
    assert_non_null(m.mesh.rgb);
    for (size_t i = 0; i < vertices; i++) {
        m.mesh.positions[i] = stp_dvec3_from_float(tree->mesh.positions[i]);
        m.mesh.normals[i] = tree->mesh.normals[i];
        for (int c = 0; c < 3; c++)
            m.mesh.rgb[i][c] = (uint16_t)(tree->mesh.colours[i].raw[c] * 65535.0f);
    }
    memcpy(m.mesh.triangles, tree->mesh.triangles, triangles * sizeof *m.mesh.triangles);
    m.mesh.vertex_count = vertices;
    m.mesh.triangle_count = triangles;
    return m;
}

/* Other orders of vertices, triangles and corners, and other directions around them. */
static inline void plant_mesh_shuffle(stp_mesh *mesh, uint64_t seed)
{
    uint32_t *places = calloc(mesh->vertex_count, sizeof *places);
    assert_non_null(places);
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        places[i] = i;
    for (uint32_t i = (uint32_t)mesh->vertex_count; i-- > 1;) {
        const uint32_t k = (uint32_t)(stp_random_u64(seed, i) % (i + 1));
        const uint32_t place = places[i];
        places[i] = places[k];
        places[k] = place;
    }
    const plant_mesh copy = plant_mesh_create(mesh->vertex_count, 0);
    memcpy(copy.mesh.positions, mesh->positions, mesh->vertex_count * sizeof *mesh->positions);
    for (uint32_t i = 0; i < mesh->vertex_count; i++)
        mesh->positions[places[i]] = copy.mesh.positions[i];
    for (uint64_t i = mesh->triangle_count; i-- > 0;) {
        uint32_t *a = mesh->triangles[i];
        uint32_t *b = mesh->triangles[stp_random_u64(seed + 1, i) % (i + 1)];
        const uint64_t turn = stp_random_u64(seed + 2, i);
        uint32_t old[3];
        memcpy(old, b, sizeof old);
        memcpy(b, a, sizeof old);
        for (uint64_t k = 0; k < 3; k++)
            a[k] = places[old[(turn & 8 ? 2 - k : k + turn) % 3]];
    }
    free(copy.mesh.positions);
    free(copy.mesh.triangles);
    free(places);
}

/* NaN is the same as NaN here. */
static inline bool plant_same_number(double a, double b)
{
    return a == b || (isnan(a) && isnan(b));
}

/* Whether a triangle of these corners' positions is in the mesh's, in this order. */
static inline bool plant_same_triangle(const stp_mesh *a, uint64_t i, const stp_mesh *b, uint64_t k)
{
    for (int c = 0; c < 3; c++) {
        const stp_dvec3 p = a->positions[a->triangles[i][c]];
        const stp_dvec3 q = b->positions[b->triangles[k][c]];
        if (!plant_same_number(p.x, q.x) || !plant_same_number(p.y, q.y) ||
            !plant_same_number(p.z, q.z))
            return false;
    }
    return true;
}

/* What is true of every conversion: sums, ranges, finite values, kept triangles in their order. */
static inline void plant_check(const stp_plant *plant, const stp_mesh *mesh)
{
    const stp_plant_report *r = &plant->report;
    const stp_line_set *lines = &plant->lines;
    assert_int_equal(r->vertices_before, mesh->vertex_count);
    assert_true(r->positions_before <= r->vertices_before);
    assert_int_equal(r->triangles, mesh->triangle_count);
    assert_int_equal(r->ribbon_triangles + r->tube_triangles + r->kept_triangles, r->triangles);
    assert_int_equal(r->kept_triangles, plant->rest->triangle_count);
    assert_int_equal(r->vertices_after, lines->vertex_count + plant->rest->vertex_count);
    assert_int_equal(r->ribbons + r->tubes, lines->strip_count);
    if (plant->rest->vertex_count > 0)
        assert_true(!plant->rest->normals == !mesh->normals && !plant->rest->rgb == !mesh->rgb);
    uint64_t next = 0;
    for (uint64_t i = 0; i < lines->strip_count; i++) {
        assert_int_equal(lines->strips[i].begin, next);
        assert_true(lines->strips[i].count >= 2);
        next += lines->strips[i].count;
    }
    assert_int_equal(next, lines->vertex_count);
    for (uint64_t i = 0; i < lines->vertex_count; i++) {
        const stp_line_vertex *v = &lines->vertices[i];
        assert_true(stp_dvec3_finite(v->position) && isfinite(v->radius) && v->radius > 0.0f);
        check_near((double)glms_vec3_norm(v->direction), 1.0, 1e-5);
    }
    uint64_t at = 0;
    for (uint64_t i = 0; i < plant->rest->triangle_count; i++, at++)
        while (!plant_same_triangle(plant->rest, i, mesh, at))
            assert_true(++at < mesh->triangle_count);
}

static inline stp_plant plant_convert(const stp_mesh *mesh, const stp_plant_params *params)
{
    stp_plant plant;
    check_ok(stp_plant_convert(&plant, mesh, params, err));
    plant_check(&plant, mesh);
    return plant;
}

#endif
