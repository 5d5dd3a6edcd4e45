/* Makes triangle meshes of parameter domains. */
#include "tools/gen/grid.h"

#include "base/memory.h"

#include <stdlib.h>

/* Makes room for more vertices and triangles; checks that 32-bit indices are enough. */
static stp_status reserve(gen_mesh *mesh, uint64_t vertices, uint64_t triangles, stp_error *err)
{
    stp_status status = STP_OK;
    size_t vertex_capacity = mesh->vertex_count, triangle_capacity = mesh->triangle_count;
    if (mesh->vertex_count + vertices > UINT32_MAX)
        return stp_error_set(err, STP_LIMIT, "the mesh has more than 2^32 vertices; ask for fewer");
    STP_TRY(stp_grow(&mesh->positions, &vertex_capacity, mesh->vertex_count + (size_t)vertices,
                     sizeof *mesh->positions, "mesh", err));
    STP_TRY(stp_grow(&mesh->triangles, &triangle_capacity, mesh->triangle_count + (size_t)triangles,
                     sizeof *mesh->triangles, "mesh", err));
done:
    return status;
}

static void add_triangle(gen_mesh *mesh, size_t a, size_t b, size_t c)
{
    uint32_t *triangle = mesh->triangles[mesh->triangle_count++];
    triangle[0] = (uint32_t)a;
    triangle[1] = (uint32_t)b;
    triangle[2] = (uint32_t)c;
}

static stp_status append(const gen_surface *surface, const gen_grid *grid, gen_mesh *mesh,
                         stp_error *err)
{
    size_t extra = grid->wraps ? 0 : 1, width = grid->columns + extra;
    size_t height = grid->rows + extra, first = mesh->vertex_count;
    stp_status status =
        reserve(mesh, (uint64_t)width * height, 2 * (uint64_t)grid->columns * grid->rows, err);
    if (status != STP_OK)
        return status;
    for (size_t y = 0; y < height; y++)
        for (size_t x = 0; x < width; x++) {
            double u = (double)x / (double)grid->columns, v = (double)y / (double)grid->rows;
            mesh->positions[mesh->vertex_count++] = stp_dvec3_to_float(grid->map(surface, u, v));
        }
    for (size_t y = 0; y < grid->rows; y++)
        for (size_t x = 0; x < grid->columns; x++) {
            /* the loops run, so there is a cell: NOLINTNEXTLINE(clang-analyzer-core.DivideZero) */
            size_t right = (x + 1) % width, up = (y + 1) % height;
            size_t a = first + y * width + x, b = first + y * width + right;
            size_t c = first + up * width + right, d = first + up * width + x;
            add_triangle(mesh, a, b, c);
            add_triangle(mesh, a, c, d);
        }
    return STP_OK;
}

stp_status gen_grid_mesh(const gen_surface *surface, const gen_grid *grids, size_t grid_count,
                         gen_mesh *out, stp_error *err)
{
    gen_mesh mesh = {0};
    stp_status status = STP_OK;
    for (size_t i = 0; i < grid_count; i++)
        STP_TRY(append(surface, &grids[i], &mesh, err));
    *out = mesh;
    mesh = (gen_mesh){0};
done:
    gen_mesh_clear(&mesh);
    return status;
}

/* The index of a vertex of the octahedron. Row y of the upper half has y + 1 points per quarter. A
 * vertex is found by its integer coordinates with |x| + |y| + |z| = n, so neighbouring faces share
 * it. */
static size_t octahedron_index(int64_t n, int64_t x, int64_t y, int64_t z)
{
    /* Rings of constant z: ring r = n - |z| has max(1, 4 r) points. Counts the points above. */
    int64_t r = n - llabs(z);
    int64_t before;
    if (z >= 0)
        before = r == 0 ? 0 : 1 + 2 * r * (r - 1);
    else
        before = 1 + 2 * n * (n + 1) + (2 * n * (n - 1) - 2 * r * (r + 1));
    if (r == 0)
        return (size_t)before;
    int64_t around = y >= 0 ? (x > 0 ? y : r - x) : (x < 0 ? 2 * r - y : 3 * r + x);
    return (size_t)(before + around % (4 * r));
}

static stp_dvec3 project(const gen_surface *surface, double x, double y, double z)
{
    gen_hit hit;
    surface->project(surface, (stp_dvec3){x, y, z}, &hit);
    return hit.position;
}

/* Adds one face of the octahedron, given by the signs of its corners. */
static void octahedron_face(const gen_surface *surface, int64_t n, const int64_t sign[3],
                            gen_mesh *mesh)
{
    bool flip = sign[0] * sign[1] * sign[2] < 0;
    for (int64_t i = 0; i <= n; i++)
        for (int64_t j = 0; i + j <= n; j++) {
            int64_t x = sign[0] * i, y = sign[1] * j, z = sign[2] * (n - i - j);
            size_t a = octahedron_index(n, x, y, z);
            mesh->positions[a] =
                stp_dvec3_to_float(project(surface, (double)x, (double)y, (double)z));
            if (i + j == n)
                continue;
            int64_t z1 = sign[2] * (n - i - j - 1), z2 = sign[2] * (n - i - j - 2);
            size_t b = octahedron_index(n, x + sign[0], y, z1);
            size_t c = octahedron_index(n, x, y + sign[1], z1);
            add_triangle(mesh, a, flip ? c : b, flip ? b : c);
            if (i + j + 1 == n)
                continue;
            size_t d = octahedron_index(n, x + sign[0], y + sign[1], z2);
            add_triangle(mesh, b, flip ? c : d, flip ? d : c);
        }
}

stp_status gen_star_mesh(const gen_surface *surface, uint64_t triangle_count, stp_pool *pool,
                         gen_mesh *out, stp_error *err)
{
    (void)pool;
    uint64_t n = (uint64_t)ceil(sqrt((double)triangle_count / 8.0));
    n = n < 1 ? 1 : n;
    gen_mesh mesh = {0};
    uint64_t vertex_count = 4 * n * n + 2;
    stp_status status = reserve(&mesh, vertex_count, 8 * n * n, err);
    if (status != STP_OK)
        return status;
    mesh.vertex_count = (size_t)vertex_count;
    for (int64_t octant = 0; octant < 8; octant++) {
        int64_t sign[3] = {octant & 1 ? -1 : 1, octant & 2 ? -1 : 1, octant & 4 ? -1 : 1};
        octahedron_face(surface, (int64_t)n, sign, &mesh);
    }
    *out = mesh;
    return STP_OK;
}
