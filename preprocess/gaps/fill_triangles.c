/* Makes the triangles between maps triangles of a chunk. */
#include "preprocess/gaps/fill_triangles.h"

#include "base/memory.h"
#include "formats/chunk/codec/square/square.h"
#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/maps/map_raster.h"
#include "preprocess/patch/world_lattice.h"

#include <stdlib.h>
#include <string.h>

#define UNKNOWN INT16_MAX

/* The map at hand. */
typedef struct storing {
    const stp_point_item_params *params;
    const stp_map *map;
    stp_raster raster;
    int16_t *lattices; /* by square: its exponent, or UNKNOWN */
} storing;

static uint32_t squares_in(uint32_t samples)
{
    return (samples + STP_SQUARE_SIDE - 1) / STP_SQUARE_SIDE;
}

static stp_status begin_map(storing *s, const stp_map *map, stp_error *err)
{
    const size_t count = (size_t)squares_in(map->columns) * squares_in(map->rows);
    free(s->lattices);
    s->lattices = NULL;
    s->map = map;
    s->raster = stp_map_raster(&map->frame, map->frame.origin);
    const stp_status status = stp_alloc(&s->lattices, count, sizeof *s->lattices, "maps", err);
    for (size_t i = 0; status == STP_OK && i < count; i++)
        s->lattices[i] = UNKNOWN;
    return status;
}

/* The exponent of the lattice of the square that has a sample. */
static int lattice_at(const storing *s, uint32_t column, uint32_t row)
{
    const uint32_t c = column / STP_SQUARE_SIDE, r = row / STP_SQUARE_SIDE;
    int16_t *known = &s->lattices[(size_t)r * squares_in(s->map->columns) + c];
    const uint32_t right = (c + 1) * STP_SQUARE_SIDE, down = (r + 1) * STP_SQUARE_SIDE;
    if (*known != UNKNOWN)
        return *known;
    for (uint32_t j = r * STP_SQUARE_SIDE; j < down && j < s->map->rows; j++)
        for (uint32_t i = c * STP_SQUARE_SIDE; i < right && i < s->map->columns; i++) {
            int own = UNKNOWN;
            if (stp_map_at(s->map, i, j)->flags & STP_MAP_SUPPORTED)
                stp_map_leaf_place(s->map, &s->raster, i, j, s->params, &own);
            *known = own < *known ? (int16_t)own : *known;
        }
    return *known;
}

/* The normal that the sample is stored with. */
static vec3s normal_at(const storing *s, uint32_t column, uint32_t row)
{
    double heights[STP_MAP_WINDOW * STP_MAP_WINDOW];
    const vec3s surface = stp_normal_decode(stp_map_at(s->map, column, row)->normal);
    for (uint32_t k = 0; k < STP_MAP_WINDOW * STP_MAP_WINDOW; k++) {
        /* beyond 0 they are the greatest numbers */
        const uint32_t c = column + k % STP_MAP_WINDOW - STP_MAP_NORMAL_REACH;
        const uint32_t r = row + k / STP_MAP_WINDOW - STP_MAP_NORMAL_REACH;
        int own;
        heights[k] = NAN;
        if (c >= s->map->columns || r >= s->map->rows ||
            !(stp_map_at(s->map, c, r)->flags & STP_MAP_SUPPORTED))
            continue;
        const stp_dvec3 at = stp_map_leaf_place(s->map, &s->raster, c, r, s->params, &own);
        heights[k] = (const double[3]){at.x, at.y, at.z}[s->raster.axis];
    }
    return stp_map_normal(&s->raster, s->map->rough ? NULL : heights, surface,
                          s->params->normal_bits);
}

static stp_line_vertex store(const storing *s, const stp_map_vertex *v, int lattice)
{
    const stp_map_sample *sample = stp_map_at(s->map, v->column, v->row);
    int own;
    const stp_dvec3 at = stp_map_leaf_place(s->map, &s->raster, v->column, v->row, s->params, &own);
    stp_line_vertex out = {.position = stp_on_lattice(at, lattice),
                           .direction = normal_at(s, v->column, v->row),
                           .intensity = sample->intensity,
                           .class_id = sample->class_id};
    for (int c = 0; c < 3; c++)
        out.rgb[c] = (uint16_t)(sample->rgb[c] * 257u);
    return out;
}

stp_status stp_fill_triangles(stp_triangle_set *out, const stp_maps *maps,
                              const stp_point_item_params *params, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_map_fill *fill = &maps->fill;
    stp_triangle_set made = {.vertex_count = fill->border.mesh.vertex_count,
                             .triangle_count = fill->count};
    storing s = {.params = params};
    STP_TRY(stp_alloc(&made.vertices, made.vertex_count, sizeof *made.vertices, "triangles", err));
    STP_TRY(stp_alloc(&made.lattices, made.vertex_count, sizeof *made.lattices, "triangles", err));
    STP_TRY(
        stp_alloc(&made.triangles, made.triangle_count, sizeof *made.triangles, "triangles", err));
    if (fill->count > 0)
        memcpy(made.triangles, fill->triangles, fill->count * sizeof *made.triangles);
    for (uint64_t v = 0; v < made.vertex_count; v++) {
        const stp_map_vertex *from = &fill->border.vertices[v];
        if (s.map != &maps->maps[from->map])
            STP_TRY(begin_map(&s, &maps->maps[from->map], err));
        if (!from->on_border)
            continue; /* of no triangle */
        made.lattices[v] = (int16_t)lattice_at(&s, from->column, from->row);
        made.vertices[v] = store(&s, from, made.lattices[v]);
    }
    *out = made;
    made = (stp_triangle_set){0};
done:
    stp_triangle_set_clear(&made);
    free(s.lattices);
    return status;
}
