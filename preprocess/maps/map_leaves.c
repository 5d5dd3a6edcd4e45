/* Makes leaf chunks of elevation maps. */
#include "preprocess/maps/map_leaves.h"

#include "base/memory.h"
#include "base/sort.h"
#include "formats/chunk/codec/square/square.h"
#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/cloud/morton.h"
#include "preprocess/maps/map_raster.h"
#include "preprocess/maps/maps_share.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

/* A disc is at most as wide as where the surface is this many times as large as the plane. */
#define STRETCH_MOST 4.0
/* Radius of a disc at a border, in spacings of the grid: a fifth more than half a square's
 * diagonal, so that no gap is left between maps. */
#define BORDER_RADIUS 0.86
/* Least spacing of a disc, in spacings of the grid: discs of the default size then meet. */
#define LEAST_SPACING 0.85

/* Rounding moves merged normals by less than this part of how far the normals under them spread,
 * but there are at least so many bits. */
#define SPREAD_PARTS 2.0
#define MERGED_BITS_LEAST 7u

/* So many squares may lie together rather than that a map is cut. */
#define TOGETHER_LEAST 32u

/* The box and the number of a square's samples. */
static uint32_t measure_square(const stp_map *map, const stp_map_square *square, stp_dbox *box)
{
    uint32_t count = 0;
    *box = stp_dbox_empty();
    for (uint32_t row = square->row; row < square->row + STP_SQUARE_SIDE; row++)
        for (uint32_t column = square->column; column < square->column + STP_SQUARE_SIDE;
             column++) {
            if (column >= map->columns || row >= map->rows ||
                !(stp_map_at(map, column, row)->flags & STP_MAP_SUPPORTED))
                continue;
            stp_dbox_add(box, stp_map_world(map, column, row));
            count++;
        }
    return count;
}

/* A square that has samples, and their box. */
typedef struct listed {
    stp_map_square square;
    stp_dbox box;
} listed;

/* Lists the squares of a map. */
static stp_status list_map(stp_bytes *out, const stp_maps *maps, uint32_t index, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_map *map = &maps->maps[index];
    for (uint32_t row = 0; row < map->rows; row += STP_SQUARE_SIDE)
        for (uint32_t column = 0; column < map->columns; column += STP_SQUARE_SIDE) {
            listed item = {.square = {index, column, row}};
            if (measure_square(map, &item.square, &item.box) > 0)
                STP_TRY(stp_bytes_append(out, &item, sizeof item, err));
        }
done:
    return status;
}

/* Lists the squares of all maps; if ranks have them, each lists those of its own. */
static stp_status list_all(stp_bytes *out, const stp_maps *maps, stp_error *err)
{
    stp_status status = STP_OK;
    const uint64_t *firsts = maps->ranks ? maps->firsts + maps->ranks->self : NULL;
    const uint64_t end = firsts ? firsts[1] : maps->count;
    for (uint64_t i = firsts ? firsts[0] : 0; i < end; i++)
        STP_TRY(list_map(out, maps, (uint32_t)i, err));
    if (maps->ranks)
        STP_TRY(stp_ranks_join(maps->ranks, out, err));
done:
    return status;
}

typedef struct cutting {
    const stp_map_leaves *leaves;
    const stp_dbox *boxes; /* by square */
    stp_point_item_params params;
} cutting;

static stp_leaf_extent extent_of(const void *context, uint32_t index)
{
    const cutting *c = context;
    const double spacing = c->leaves->maps->maps[c->leaves->squares[index].map].frame.spacing;
    const stp_dbox box = c->boxes[index];
    return (stp_leaf_extent){box, stp_point_exponent(box.min, LEAST_SPACING * spacing, &c->params),
                             stp_point_exponent(box.min, STRETCH_MOST * spacing, &c->params)};
}

stp_status stp_map_leaves_create(stp_map_leaves *out, const stp_maps *maps, double lambda,
                                 const stp_resolution *resolution, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_leaves made = {.maps = maps, .box = maps->box};
    stp_bytes bytes = {0};
    stp_morton_place *codes = NULL;
    stp_dbox *boxes = NULL;
    const stp_morton_grid grid = stp_morton_grid_of(&maps->box);
    STP_TRY(list_all(&bytes, maps, err));
    const listed *all = (const listed *)bytes.data;
    const uint32_t count = (uint32_t)(bytes.size / sizeof *all);
    STP_TRY(stp_alloc(&codes, count, sizeof *codes, "patches", err));
    STP_TRY(stp_alloc(&boxes, count, sizeof *boxes, "patches", err));
    STP_TRY(stp_alloc(&made.squares, count, sizeof *made.squares, "patches", err));
    STP_TRY(stp_alloc(&made.wanted, maps->count, sizeof *made.wanted, "maps", err));
    for (uint32_t i = 0; i < count; i++)
        codes[i] = (stp_morton_place){stp_morton_code(&grid, stp_dbox_middle(&all[i].box)), i};
    stp_morton_order(codes, count);
    for (uint32_t i = 0; i < count; i++) {
        made.squares[i] = all[codes[i].index].square;
        boxes[i] = all[codes[i].index].box;
    }
    made.square_count = count;
    const cutting c = {
        &made, boxes, {.lambda = lambda, .resolution = *resolution, .vertex_least = INT_MIN / 2}};
    STP_TRY(stp_leaf_cut(&made.leaves, &made.leaf_count, count, extent_of, &c, err));
    *out = made;
    made = (stp_map_leaves){0};
done:
    stp_map_leaves_clear(&made);
    free(bytes.data);
    free(codes);
    free(boxes);
    return status;
}

void stp_map_leaf_ask(const stp_map_leaves *leaves, uint32_t leaf)
{
    for (uint32_t i = leaves->leaves[leaf].begin; i < leaves->leaves[leaf].end; i++)
        leaves->wanted[leaves->squares[i].map] = true;
}

stp_status stp_map_leaves_fetch(const stp_map_leaves *leaves, stp_error *err)
{
    return stp_maps_fetch(leaves->maps, leaves->wanted, err);
}

/* Whether one of the eight samples around is none of the map. */
static bool is_border(const stp_map *map, uint32_t column, uint32_t row)
{
    if (column == 0 || row == 0 || column + 1 == map->columns || row + 1 == map->rows)
        return true;
    for (uint32_t r = row - 1; r <= row + 1; r++)
        for (uint32_t c = column - 1; c <= column + 1; c++)
            if (!(stp_map_at(map, c, r)->flags & STP_MAP_SUPPORTED))
                return true;
    return false;
}

static double spacing_of(const stp_map *map, uint32_t column, uint32_t row, vec3s normal,
                         double lambda)
{
    const double upwards = stp_dvec3_dot(stp_dvec3_from_float(normal), map->frame.axes[2]);
    const double larger = stp_stretch(upwards);
    return map->frame.spacing *
           (is_border(map, column, row) ? BORDER_RADIUS * larger / lambda : sqrt(larger));
}

/* What a leaf is made of. */
typedef struct making {
    const stp_point_item_params *params;
    const stp_map *map;
    stp_raster raster; /* of the map */
    stp_item *items;
    uint32_t *ends;        /* of the squares' items */
    stp_patch_grid *grids; /* by square */
    uint32_t *together;    /* ends, among the squares, of those that lie together */
    uint32_t count, squares, together_count;
    double moved, moved_most; /* how far samples were moved to places that the codec knows */
} making;

/* A square and the samples around it, as far as normals reach. */
#define WINDOW_SIDE (STP_SQUARE_SIDE + 2 * STP_MAP_NORMAL_REACH)
typedef struct window {
    stp_dvec3 at[WINDOW_SIDE][WINDOW_SIDE];  /* by row: where the samples are stored */
    double height[WINDOW_SIDE][WINDOW_SIDE]; /* along the raster's axis; NaN: no sample */
    int exponent[WINDOW_SIDE][WINDOW_SIDE];  /* of their lattices */
} window;

stp_dvec3 stp_map_leaf_place(const stp_map *map, const stp_raster *raster, uint32_t column,
                             uint32_t row, const stp_point_item_params *params, int *exponent)
{
    const vec3s normal = stp_normal_decode(stp_map_at(map, column, row)->normal);
    const double spacing = spacing_of(map, column, row, normal, params->lambda);
    *exponent = stp_point_exponent(stp_map_world(map, column, row), spacing, params);
    return stp_map_snapped(map, raster, column, row, ldexp(1.0, *exponent));
}

static void load(const making *m, const stp_map_square *square, window *w)
{
    const stp_map *map = m->map;
    for (uint32_t j = 0; j < WINDOW_SIDE; j++)
        for (uint32_t i = 0; i < WINDOW_SIDE; i++) {
            /* beyond 0 they are the greatest numbers */
            const uint32_t column = square->column + i - STP_MAP_NORMAL_REACH;
            const uint32_t row = square->row + j - STP_MAP_NORMAL_REACH;
            w->height[j][i] = NAN;
            if (column >= map->columns || row >= map->rows ||
                !(stp_map_at(map, column, row)->flags & STP_MAP_SUPPORTED))
                continue;
            const stp_dvec3 at =
                stp_map_leaf_place(map, &m->raster, column, row, m->params, &w->exponent[j][i]);
            w->at[j][i] = at;
            w->height[j][i] = (const double[3]){at.x, at.y, at.z}[m->raster.axis];
        }
}

/* i, j: column and row in the square. */
static stp_item make_item(making *m, const stp_map_square *square, const window *w, uint32_t i,
                          uint32_t j)
{
    const uint32_t column = square->column + i, row = square->row + j;
    const stp_map_sample *sample = stp_map_at(m->map, column, row);
    double heights[STP_MAP_WINDOW * STP_MAP_WINDOW];
    for (uint32_t k = 0; k < STP_MAP_WINDOW * STP_MAP_WINDOW; k++)
        heights[k] = w->height[j + k / STP_MAP_WINDOW][i + k % STP_MAP_WINDOW];
    const vec3s normal = stp_map_normal(&m->raster, m->map->rough ? NULL : heights,
                                        stp_normal_decode(sample->normal), m->params->normal_bits);
    stp_point_facts facts = {
        .position = w->at[j + STP_MAP_NORMAL_REACH][i + STP_MAP_NORMAL_REACH],
        .spacing = spacing_of(m->map, column, row, normal, m->params->lambda),
        .normal = normal,
        .normal_step = stp_normal_bits_step(m->params->normal_bits),
        .sheet = m->map->sheet,
        .source = STP_SOURCE_NONE,
        .intensity = stp_point_intensity(sample->intensity, m->params->intensity_max),
        .class_id = sample->class_id,
        .flags = (uint8_t)(STP_SAMPLE_HAS_NORMAL |
                           (sample->flags & STP_MAP_ORIENTED ? STP_SAMPLE_ORIENTED : 0) |
                           (sample->flags & STP_MAP_CLOSED ? STP_SAMPLE_CLOSED : 0))};
    for (int c = 0; c < 3; c++)
        facts.rgb[c] = (uint16_t)(sample->rgb[c] * 257u);
    const double moved =
        stp_dvec3_length(stp_dvec3_sub(facts.position, stp_map_world(m->map, column, row)));
    m->moved += moved;
    m->moved_most = stp_max(m->moved_most, moved);
    stp_item item;
    stp_point_item_set(&item, &facts, stp_point_exponent(facts.position, facts.spacing, m->params),
                       m->params);
    item.exponent = w->exponent[j + STP_MAP_NORMAL_REACH][i + STP_MAP_NORMAL_REACH];
    return item;
}

/* The way along a map's axis, by a unit of its height. */
static stp_dvec3 along_of(const stp_raster *raster)
{
    double along[3];
    along[raster->axis] = 1.0;
    for (unsigned k = 0; k < 2; k++)
        along[(raster->axis + 1 + k) % 3] = raster->across[k][3];
    return (stp_dvec3){along[0], along[1], along[2]};
}

/* Appends a square's samples in Morton order. */
static void add_square(making *m, const stp_map_square *square)
{
    window w;
    load(m, square, &w);
    for (uint32_t k = 0; k < STP_SQUARE_SAMPLES; k++) {
        const uint32_t i = stp_square_column(k), j = stp_square_row(k);
        if (!isnan(w.height[j + STP_MAP_NORMAL_REACH][i + STP_MAP_NORMAL_REACH]))
            m->items[m->count++] = make_item(m, square, &w, i, j);
    }
    m->grids[m->squares] =
        (stp_patch_grid){.along = along_of(&m->raster), .spacing = m->map->frame.spacing};
    m->ends[m->squares++] = m->count;
}

/* Sorts the squares of a leaf by map, and maps by their first squares.
 * out: for each square the first of its map << 32 | its place. map_count: of different maps. */
static void sort_by_map(const stp_map_square *squares, uint32_t count, uint64_t *out,
                        uint32_t *map_count)
{
    for (uint32_t i = 0; i < count; i++)
        out[i] = (uint64_t)squares[i].map << 32 | i;
    stp_sort_u64(out, count);
    uint64_t map = UINT64_MAX, first = 0;
    *map_count = 0;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t place = (uint32_t)out[i];
        if (out[i] >> 32 != map) {
            map = out[i] >> 32;
            first = (uint64_t)place << 32;
            ++*map_count;
        }
        out[i] = first | place;
    }
    stp_sort_u64(out, count);
}

/* How far the normals of four samples that are merged are from their mean, radians, on average. */
static double spread_of(const making *m)
{
    double sum = 0.0;
    uint32_t count = 0;
    for (uint32_t s = 0, i = 0; s < m->squares; i = m->ends[s++])
        for (; i + 4 <= m->ends[s]; i += 4, count++) {
            stp_dvec3 mean = {0.0, 0.0, 0.0};
            for (uint32_t k = i; k < i + 4; k++)
                mean = stp_dvec3_add(mean, stp_dvec3_scale(m->items[k].disc.normal, 0.25));
            sum += sqrt(stp_max(0.0, 2.0 - 2.0 * stp_dvec3_length(mean)));
        }
    return count > 0 ? sum / count : 0.0;
}

/* Rounds merged normals to the coarsest grid that their spread hides. */
static void choose_merged_bits(making *m)
{
    const double angle = spread_of(m) / SPREAD_PARTS;
    unsigned bits = MERGED_BITS_LEAST;
    while (bits < STP_MERGED_SQUARE_BITS && stp_normal_grid_angle(bits) > angle)
        bits++;
    for (uint32_t s = 0; s < m->squares; s++)
        m->grids[s].merged_bits = bits;
}

/* Squares since the last ones that lie together. */
static uint32_t open_squares(const making *m)
{
    return m->squares - (m->together_count ? m->together[m->together_count - 1] : 0);
}

static void end_together(making *m)
{
    if (open_squares(m) > 0)
        m->together[m->together_count++] = m->squares;
}

/* Squares of one map lie together, or of maps that follow each other. Blocks end where they end: a
 * map in two blocks costs a raster, and normals at the cut. */
static void add_maps(making *m, const stp_maps *maps, const stp_map_square *squares,
                     const uint64_t *order, uint32_t count)
{
    for (uint32_t next = 0, end = 0; next < count; next = end) {
        while (end < count && order[end] >> 32 == order[next] >> 32)
            end++;
        const uint32_t before = open_squares(m);
        m->map = &maps->maps[squares[(uint32_t)order[next]].map];
        m->raster = stp_map_raster(&m->map->frame, m->map->frame.origin);
        if (before >= TOGETHER_LEAST && before + (end - next) > STP_PATCH_SAMPLES)
            end_together(m);
        for (; next < end; next++) {
            add_square(m, &squares[(uint32_t)order[next]]);
            if (open_squares(m) == STP_PATCH_SAMPLES)
                end_together(m);
        }
    }
    end_together(m);
}

/* The rasters of a leaf's maps. */
static void find_rasters(const stp_maps *maps, const stp_map_square *squares, const uint64_t *order,
                         uint32_t count, stp_dvec3 origin, stp_raster *out)
{
    for (uint32_t i = 0; i < count; i++)
        if (i == 0 || order[i] >> 32 != order[i - 1] >> 32)
            *out++ = stp_map_raster(&maps->maps[squares[(uint32_t)order[i]].map].frame, origin);
}

stp_status stp_map_leaf_build(const stp_map_leaves *leaves, uint32_t leaf,
                              const stp_point_item_params *params, stp_built_chunk *out,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const stp_leaf_run *run = &leaves->leaves[leaf];
    const stp_map_square *squares = leaves->squares + run->begin;
    const uint32_t count = run->end - run->begin;
    uint32_t map_count;
    making m = {.params = params};
    uint64_t *order = NULL;
    stp_raster *rasters = NULL;
    STP_TRY(stp_alloc(&order, count, sizeof *order, "patches", err));
    sort_by_map(squares, count, order, &map_count);
    STP_TRY(stp_alloc(&rasters, map_count, sizeof *rasters, "rasters", err));
    STP_TRY(
        stp_alloc(&m.items, (size_t)count * STP_SQUARE_SAMPLES, sizeof *m.items, "samples", err));
    STP_TRY(stp_alloc(&m.ends, count, sizeof *m.ends, "patches", err));
    STP_TRY(stp_alloc(&m.grids, count, sizeof *m.grids, "patches", err));
    STP_TRY(stp_alloc(&m.together, count, sizeof *m.together, "patches", err));
    add_maps(&m, leaves->maps, squares, order, count);
    choose_merged_bits(&m);
    const stp_item_group group = {.items = m.items,
                                  .run_ends = m.ends,
                                  .together_ends = m.together,
                                  .run_grids = m.grids,
                                  .count = m.count,
                                  .run_count = m.squares,
                                  .together_count = m.together_count};
    STP_TRY(stp_chunk_build_leaf(out, &group, params, err));
    find_rasters(leaves->maps, squares, order, count, out->origin, rasters);
    out->chunk->rasters = rasters;
    out->chunk->raster_count = map_count;
    out->chunk->reach = STP_MAP_NORMAL_REACH;
    out->displacement.sum += m.moved;
    out->displacement.greatest += m.moved_most;
    rasters = NULL;
done:
    free(order);
    free(rasters);
    free(m.items);
    free(m.ends);
    free(m.grids);
    free(m.together);
    return status;
}

void stp_map_leaves_clear(stp_map_leaves *leaves)
{
    free(leaves->squares);
    free(leaves->leaves);
    free(leaves->wanted);
    *leaves = (stp_map_leaves){0};
}
