/* Collects the borders of trimmed maps. */
#include "preprocess/gaps/map_border.h"

#include "base/memory.h"
#include "formats/chunk/sample/sample.h"
#include "preprocess/gaps/map_trim.h"

#include <stdlib.h>

#define ALL_CELLS 15u

typedef struct collecting {
    stp_map_border out;
    size_t vertex_capacity, position_capacity, normal_capacity, triangle_capacity;
    uint32_t *numbers; /* by place of the map's grid: one more than its vertex */
} collecting;

static stp_status add_vertex(collecting *c, const stp_map *map, uint32_t index, uint32_t column,
                             uint32_t row, uint32_t *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_border *b = &c->out;
    uint32_t *number = &c->numbers[(size_t)row * map->columns + column];
    const size_t count = b->mesh.vertex_count;
    if (*number == 0) {
        if (count >= UINT32_MAX - 1)
            return stp_error_set(err, STP_LIMIT,
                                 "the maps have more than 2^32 border samples: "
                                 "give --gaps overlap");
        STP_TRY(stp_grow(&b->vertices, &c->vertex_capacity, count + 1, sizeof *b->vertices,
                         "borders", err));
        STP_TRY(stp_grow(&b->mesh.positions, &c->position_capacity, count + 1,
                         sizeof *b->mesh.positions, "borders", err));
        STP_TRY(stp_grow(&b->mesh.normals, &c->normal_capacity, count + 1, sizeof *b->mesh.normals,
                         "borders", err));
        b->vertices[count] = (stp_map_vertex){
            index, column, row, stp_map_cells_around(map, column, row) != ALL_CELLS, 0.0};
        b->mesh.positions[count] = stp_map_world(map, column, row);
        b->mesh.normals[count] = stp_normal_decode(stp_map_at(map, column, row)->normal);
        b->mesh.vertex_count++;
        *number = (uint32_t)count + 1;
    }
    *out = *number - 1;
done:
    return status;
}

static stp_status add_cell(collecting *c, const stp_map *map, uint32_t index, uint32_t column,
                           uint32_t row, stp_error *err)
{
    static const uint32_t corners[2][3] = {{0, 1, 2}, {1, 3, 2}};
    stp_status status = STP_OK;
    stp_mesh *mesh = &c->out.mesh;
    uint32_t numbers[4];
    for (uint32_t k = 0; k < 4; k++)
        STP_TRY(add_vertex(c, map, index, column + (k & 1), row + (k >> 1), &numbers[k], err));
    STP_TRY(stp_grow(&mesh->triangles, &c->triangle_capacity, mesh->triangle_count + 2,
                     sizeof *mesh->triangles, "borders", err));
    for (int t = 0; t < 2; t++, mesh->triangle_count++)
        for (int k = 0; k < 3; k++)
            mesh->triangles[mesh->triangle_count][k] = numbers[corners[t][k]];
done:
    return status;
}

/* Whether a cell touches the border. */
static bool is_outer(const stp_map *map, uint32_t column, uint32_t row)
{
    for (uint32_t k = 0; k < 4; k++)
        if (stp_map_cells_around(map, column + (k & 1), row + (k >> 1)) != ALL_CELLS)
            return true;
    return false;
}

static stp_status collect_map(collecting *c, const stp_map *map, uint32_t index, stp_error *err)
{
    stp_status status = STP_OK;
    c->numbers = NULL;
    if (map->count == 0)
        return STP_OK;
    STP_TRY(stp_alloc(&c->numbers, (size_t)map->columns * map->rows, sizeof *c->numbers, "borders",
                      err));
    for (uint32_t row = 0; row + 1 < map->rows; row++)
        for (uint32_t column = 0; column + 1 < map->columns; column++)
            if (stp_map_is_cell(map, column, row) && is_outer(map, column, row))
                STP_TRY(add_cell(c, map, index, column, row, err));
done:
    free(c->numbers);
    return status;
}

/* Sets the sizes of all vertices. */
static stp_status measure(stp_map_border *b, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_mesh *mesh = &b->mesh;
    uint32_t *edges = NULL;
    STP_TRY(stp_alloc(&edges, mesh->vertex_count, sizeof *edges, "borders", err));
    for (uint64_t t = 0; t < mesh->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            const uint32_t from = mesh->triangles[t][k], to = mesh->triangles[t][(k + 1) % 3];
            const double length =
                stp_dvec3_length(stp_dvec3_sub(mesh->positions[from], mesh->positions[to]));
            b->vertices[from].size += length;
            b->vertices[to].size += length;
            edges[from]++;
            edges[to]++;
        }
    for (uint64_t v = 0; v < mesh->vertex_count; v++)
        b->vertices[v].size /= edges[v];
done:
    free(edges);
    return status;
}

stp_status stp_map_border_create(stp_map_border *out, const stp_map *maps, uint32_t count,
                                 stp_error *err)
{
    stp_status status = STP_OK;
    collecting c = {0};
    for (uint32_t i = 0; i < count; i++)
        STP_TRY(collect_map(&c, &maps[i], i, err));
    STP_TRY(measure(&c.out, err));
    *out = c.out;
    c.out = (stp_map_border){0};
done:
    stp_map_border_clear(&c.out);
    return status;
}

void stp_map_border_clear(stp_map_border *border)
{
    free(border->mesh.positions);
    free(border->mesh.normals);
    free(border->mesh.triangles);
    free(border->vertices);
    *border = (stp_map_border){0};
}
