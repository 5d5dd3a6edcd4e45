/* Finds the parts of a triangle mesh with hash tables of positions, triangles and edges, and a
 * union-find. */
#include "preprocess/plant/mesh_parts.h"

#include "base/memory.h"
#include "base/random.h"
#include "preprocess/orient/forest.h"

#include <stdlib.h>
#include <string.h>

#define NONE UINT32_MAX
#define COUNT_LIMIT ((uint64_t)1 << 30)

/* An edge between two positions, the lower number first. uses 0: a free slot of the table. */
typedef struct edge {
    uint32_t low, high;
    uint32_t triangle; /* the first one with this edge */
    uint32_t uses;
} edge;

typedef struct edge_table {
    edge *edges;
    size_t mask;
} edge_table;

/* The least power of two that leaves a quarter of the slots empty. */
static size_t table_size(uint64_t count)
{
    size_t size = 16;
    while (3 * size < 4 * count)
        size *= 2;
    return size;
}

static uint64_t bits(double x)
{
    uint64_t out;
    const double same = x + 0.0; /* -0 becomes 0 */
    memcpy(&out, &same, sizeof out);
    return out;
}

static uint64_t position_hash(stp_dvec3 p)
{
    return stp_random_u64(stp_random_u64(bits(p.x), bits(p.y)), bits(p.z));
}

/* Sets first_at. A position that is not finite equals nothing. */
static stp_status weld(stp_mesh_parts *parts, const stp_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *table = NULL;
    const size_t size = table_size(mesh->vertex_count);
    STP_TRY(stp_alloc(&table, size, sizeof *table, "positions", err));
    memset(table, 0xff, size * sizeof *table);
    for (uint32_t i = 0; i < mesh->vertex_count; i++) {
        const stp_dvec3 p = mesh->positions[i];
        size_t place = (size_t)position_hash(p) & (size - 1);
        while (table[place] != NONE && !stp_dvec3_equal(mesh->positions[table[place]], p))
            place = (place + 1) & (size - 1);
        if (table[place] == NONE) {
            table[place] = i;
            parts->position_count++;
        }
        parts->first_at[i] = table[place];
    }
done:
    free(table);
    return status;
}

static edge *find_edge(const edge_table *table, uint32_t a, uint32_t b)
{
    const uint32_t low = a < b ? a : b, high = a < b ? b : a;
    size_t place = (size_t)stp_random_u64(low, high) & table->mask;
    edge *e = &table->edges[place];
    while (e->uses > 0 && (e->low != low || e->high != high)) {
        place = (place + 1) & table->mask;
        e = &table->edges[place];
    }
    e->low = low;
    e->high = high;
    return e;
}

static bool is_triangle(const stp_mesh *mesh, const uint32_t corners[3])
{
    for (int k = 0; k < 3; k++)
        if (corners[k] == corners[(k + 1) % 3] || !stp_dvec3_finite(mesh->positions[corners[k]]))
            return false;
    return true;
}

/* The triangle's corners as positions. False if it is degenerate. */
static bool welded(const stp_mesh_parts *parts, const stp_mesh *mesh, uint32_t triangle,
                   uint32_t corners[3])
{
    for (int k = 0; k < 3; k++)
        corners[k] = parts->first_at[mesh->triangles[triangle][k]];
    return is_triangle(mesh, corners);
}

/* Sorts the corners in ascending order. */
static void sort_corners(uint32_t c[3])
{
    for (int k = 0; k < 3; k++) {
        const int i = k % 2; /* 0, 1, 0 */
        const uint32_t low = c[i] < c[i + 1] ? c[i] : c[i + 1];
        c[i + 1] = c[i] < c[i + 1] ? c[i + 1] : c[i];
        c[i] = low;
    }
}

static bool is_same(const stp_mesh_parts *parts, const stp_mesh *mesh, uint32_t triangle,
                    const uint32_t sorted[3])
{
    uint32_t c[3];
    welded(parts, mesh, triangle, c);
    sort_corners(c);
    return c[0] == sorted[0] && c[1] == sorted[1] && c[2] == sorted[2];
}

/* Sets first_same, and counts_not of degenerate triangles and twins. */
static stp_status find_twins(stp_mesh_parts *parts, const stp_mesh *mesh, uint8_t *counts_not,
                             stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *table = NULL, c[3];
    const size_t size = table_size(mesh->triangle_count);
    STP_TRY(stp_alloc(&table, size, sizeof *table, "triangles", err));
    memset(table, 0xff, size * sizeof *table);
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        parts->first_same[i] = i;
        counts_not[i] = !welded(parts, mesh, i, c);
        if (counts_not[i])
            continue;
        sort_corners(c);
        const uint64_t hash = stp_random_u64(stp_random_u64(c[0], c[1]), c[2]);
        size_t place = (size_t)hash & (size - 1);
        while (table[place] != NONE && !is_same(parts, mesh, table[place], c))
            place = (place + 1) & (size - 1);
        counts_not[i] = table[place] != NONE;
        if (table[place] == NONE)
            table[place] = i;
        parts->first_same[i] = table[place];
    }
done:
    free(table);
    return status;
}

static void count_edges(const stp_mesh_parts *parts, const stp_mesh *mesh,
                        const uint8_t *counts_not, edge_table *table)
{
    uint32_t corners[3];
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        if (counts_not[i])
            continue;
        welded(parts, mesh, i, corners);
        for (int k = 0; k < 3; k++) {
            edge *e = find_edge(table, corners[k], corners[(k + 1) % 3]);
            if (e->uses++ == 0)
                e->triangle = i;
        }
    }
}

/* Joins triangles across edges of two; marks the other edges as open. */
static void join(stp_mesh_parts *parts, const stp_mesh *mesh, const uint8_t *counts_not,
                 const edge_table *table, stp_forest *forest)
{
    uint32_t corners[3];
    for (uint32_t i = 0; i < mesh->triangle_count; i++) {
        welded(parts, mesh, i, corners);
        for (int k = 0; k < 3 && !counts_not[i]; k++) {
            const edge *e = find_edge(table, corners[k], corners[(k + 1) % 3]);
            if (e->uses == 2)
                stp_forest_join(forest, e->triangle, i, false);
            else
                parts->open_edges[i] |= (uint8_t)(1u << k);
        }
    }
}

/* Numbers the roots in `number`, counts their triangles and lists them by a counting sort. */
static stp_status list(stp_mesh_parts *parts, uint32_t count, stp_forest *forest,
                       const uint8_t *counts_not, stp_error *err)
{
    stp_status status = STP_OK;
    uint32_t *number = NULL;
    uint8_t parity;
    STP_TRY(stp_alloc(&number, count, sizeof *number, "parts", err));
    STP_TRY(stp_alloc(&parts->order, count, sizeof *parts->order, "parts", err));
    STP_TRY(stp_alloc(&parts->begins, (size_t)count + 2, sizeof *parts->begins, "parts", err));
    uint32_t *ends = parts->begins + 1; /* end of part i; finally the begin of part i + 1 */
    for (uint32_t i = 0; i < count; i++) {
        if (counts_not[i])
            continue;
        const uint32_t root = stp_forest_find(forest, i, &parity);
        if (root == i)
            number[i] = parts->part_count++;
        ends[number[root] + 1]++;
    }
    for (uint32_t i = 0; i < parts->part_count; i++) {
        if (ends[i + 1] > parts->most_triangles)
            parts->most_triangles = ends[i + 1];
        ends[i + 1] += ends[i];
    }
    for (uint32_t i = 0; i < count; i++)
        if (!counts_not[i])
            parts->order[ends[number[stp_forest_find(forest, i, &parity)]]++] = i;
done:
    free(number);
    return status;
}

static stp_status check_size(const stp_mesh *mesh, stp_error *err)
{
    if (mesh->vertex_count < COUNT_LIMIT && mesh->triangle_count < COUNT_LIMIT)
        return STP_OK;
    return stp_error_set(err, STP_LIMIT,
                         "a mesh of %llu vertices and %llu triangles: plants have fewer than 2^30 "
                         "of each; cut it into several",
                         (unsigned long long)mesh->vertex_count,
                         (unsigned long long)mesh->triangle_count);
}

stp_status stp_mesh_parts_find(stp_mesh_parts *out, const stp_mesh *mesh, stp_error *err)
{
    stp_status status = STP_OK;
    stp_mesh_parts parts = {0};
    stp_forest forest = {0};
    edge_table table = {0};
    uint8_t *counts_not = NULL;
    STP_TRY(check_size(mesh, err));
    const size_t vertices = (size_t)mesh->vertex_count, triangles = (size_t)mesh->triangle_count;
    STP_TRY(stp_alloc(&parts.first_at, vertices, sizeof *parts.first_at, "positions", err));
    STP_TRY(stp_alloc(&parts.open_edges, triangles, sizeof *parts.open_edges, "edges", err));
    STP_TRY(stp_alloc(&parts.first_same, triangles, sizeof *parts.first_same, "triangles", err));
    STP_TRY(stp_alloc(&counts_not, triangles, sizeof *counts_not, "triangles", err));
    STP_TRY(weld(&parts, mesh, err));
    STP_TRY(find_twins(&parts, mesh, counts_not, err));
    table.mask = table_size(3 * mesh->triangle_count) - 1;
    STP_TRY(stp_alloc(&table.edges, table.mask + 1, sizeof *table.edges, "edges", err));
    STP_TRY(stp_forest_create(&forest, (uint32_t)triangles, NULL, err));
    count_edges(&parts, mesh, counts_not, &table);
    join(&parts, mesh, counts_not, &table, &forest);
    STP_TRY(list(&parts, (uint32_t)triangles, &forest, counts_not, err));
    *out = parts;
    parts = (stp_mesh_parts){0};
done:
    free(counts_not);
    free(table.edges);
    stp_forest_clear(&forest);
    stp_mesh_parts_clear(&parts);
    return status;
}

void stp_mesh_parts_clear(stp_mesh_parts *parts)
{
    free(parts->first_at);
    free(parts->open_edges);
    free(parts->first_same);
    free(parts->begins);
    free(parts->order);
    *parts = (stp_mesh_parts){0};
}
