/* Makes leaf chunks of elevation maps. */
#include "preprocess/maps/map_leaves.h"

#include "base/memory.h"
#include "formats/chunk/codec/square.h"
#include "preprocess/cloud/morton.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>

#define SQUARE_SAMPLES (STP_SQUARE_SIDE * STP_SQUARE_SIDE)
/* A disc is at most as wide as where the surface is this many times as large as the plane. */
#define STRETCH_MOST 4.0
/* Discs have sizes of so many steps an octave, lest each has a size of its own. */
#define STRETCH_STEPS 4.0
/* Radius of a disc at a border, in spacings of the grid: a bit more than half a square's diagonal.
 */
#define BORDER_RADIUS 0.75
/* Least spacing of a disc, in spacings of the grid: discs of the default size then meet. */
#define LEAST_SPACING 0.85

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

/* Squares of all maps that have samples, in the order of the maps, and their middles' codes. */
typedef struct listing {
    stp_map_square *squares;
    stp_morton_place *codes;
    size_t count, square_capacity, code_capacity;
} listing;

static stp_status list_map(listing *l, const stp_maps *maps, uint32_t index,
                           const stp_morton_grid *grid, stp_error *err)
{
    stp_status status = STP_OK;
    const stp_map *map = &maps->maps[index];
    for (uint32_t row = 0; row < map->rows; row += STP_SQUARE_SIDE)
        for (uint32_t column = 0; column < map->columns; column += STP_SQUARE_SIDE) {
            const stp_map_square square = {index, column, row};
            stp_dbox box;
            if (measure_square(map, &square, &box) == 0)
                continue;
            STP_TRY(stp_grow(&l->squares, &l->square_capacity, l->count + 1, sizeof *l->squares,
                             "patches", err));
            STP_TRY(stp_grow(&l->codes, &l->code_capacity, l->count + 1, sizeof *l->codes,
                             "patches", err));
            l->squares[l->count] = square;
            l->codes[l->count] = (stp_morton_place){stp_morton_code(grid, stp_dbox_middle(&box)),
                                                    (uint32_t)l->count};
            l->count++;
        }
done:
    return status;
}

typedef struct cutting {
    const stp_map_leaves *leaves;
    stp_point_item_params params;
} cutting;

static stp_leaf_extent extent_of(const void *context, uint32_t index)
{
    const cutting *c = context;
    const stp_map_square *square = &c->leaves->squares[index];
    const stp_map *map = &c->leaves->maps->maps[square->map];
    stp_leaf_extent out;
    measure_square(map, square, &out.box);
    out.finest = stp_point_exponent(out.box.min, LEAST_SPACING * map->frame.spacing, &c->params);
    out.coarsest = stp_point_exponent(out.box.min, STRETCH_MOST * map->frame.spacing, &c->params);
    return out;
}

stp_status stp_map_leaves_create(stp_map_leaves *out, const stp_maps *maps, double lambda,
                                 const stp_resolution *resolution, stp_error *err)
{
    stp_status status = STP_OK;
    stp_map_leaves made = {.maps = maps, .box = maps->box};
    listing l = {0};
    const stp_morton_grid grid = stp_morton_grid_of(&maps->box);
    for (uint32_t i = 0; i < maps->count; i++)
        STP_TRY(list_map(&l, maps, i, &grid, err));
    stp_morton_order(l.codes, (uint32_t)l.count);
    STP_TRY(stp_alloc(&made.squares, l.count, sizeof *made.squares, "patches", err));
    for (size_t i = 0; i < l.count; i++)
        made.squares[i] = l.squares[l.codes[i].index];
    made.square_count = (uint32_t)l.count;
    const cutting c = {&made,
                       {.lambda = lambda, .resolution = *resolution, .vertex_least = INT_MIN / 2}};
    STP_TRY(stp_leaf_cut(&made.leaves, &made.leaf_count, made.square_count, extent_of, &c, err));
    *out = made;
    made = (stp_map_leaves){0};
done:
    stp_map_leaves_clear(&made);
    free(l.squares);
    free(l.codes);
    return status;
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

/* upwards: of the normal, along the map's axis. */
static double spacing_of(const stp_map *map, uint32_t column, uint32_t row, double upwards,
                         double lambda)
{
    const double larger = 1.0 / fmax(upwards, 1.0 / STRETCH_MOST);
    const double wide = is_border(map, column, row) ? BORDER_RADIUS * larger / lambda
                                                    : fmax(sqrt(larger), LEAST_SPACING);
    return map->frame.spacing * exp2(nearbyint(STRETCH_STEPS * log2(wide)) / STRETCH_STEPS);
}

static stp_item make_item(const stp_map *map, uint32_t column, uint32_t row,
                          const stp_point_item_params *params)
{
    const stp_map_sample *sample = stp_map_at(map, column, row);
    const vec3s normal = stp_normal_decode(sample->normal);
    const double upwards = stp_dvec3_dot(stp_dvec3_from_float(normal), map->frame.axes[2]);
    const bool oriented = sample->flags & STP_MAP_ORIENTED;
    stp_point_facts facts = {
        .position = stp_map_world(map, column, row),
        .spacing = spacing_of(map, column, row, upwards, params->lambda),
        .normal = normal,
        .normal_bits = params->normal_bits,
        .sheet = map->sheet,
        .source = STP_SOURCE_NONE,
        .intensity = stp_point_intensity(sample->intensity, params->intensity_max),
        .class_id = sample->class_id,
        .flags = (uint8_t)(STP_SAMPLE_HAS_NORMAL | (oriented ? STP_SAMPLE_ORIENTED : 0))};
    for (int c = 0; c < 3; c++)
        facts.rgb[c] = (uint16_t)(sample->rgb[c] * 257u);
    return stp_point_item_make(&facts, params);
}

/* Appends a square's samples in Morton order. Returns how many there are. */
static uint32_t add_square(const stp_map *map, const stp_map_square *square,
                           const stp_point_item_params *params, stp_item *items)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < SQUARE_SAMPLES; i++) {
        const uint32_t column = square->column + stp_square_column(i);
        const uint32_t row = square->row + stp_square_row(i);
        if (column < map->columns && row < map->rows &&
            stp_map_at(map, column, row)->flags & STP_MAP_SUPPORTED)
            items[count++] = make_item(map, column, row, params);
    }
    return count;
}

stp_status stp_map_leaf_build(const stp_map_leaves *leaves, uint32_t leaf,
                              const stp_point_item_params *params, stp_built_chunk *out,
                              stp_error *err)
{
    stp_status status = STP_OK;
    const stp_leaf_run *run = &leaves->leaves[leaf];
    const uint32_t squares = run->end - run->begin;
    stp_item *items = NULL;
    uint32_t *ends = NULL, count = 0;
    STP_TRY(stp_alloc(&items, (size_t)squares * SQUARE_SAMPLES, sizeof *items, "samples", err));
    STP_TRY(stp_alloc(&ends, squares, sizeof *ends, "patches", err));
    for (uint32_t i = 0; i < squares; i++) {
        const stp_map_square *square = &leaves->squares[run->begin + i];
        const stp_map *map = &leaves->maps->maps[square->map];
        count += add_square(map, square, params, items + count);
        ends[i] = count;
    }
    const stp_item_group group = {
        .items = items, .count = count, .run_ends = ends, .run_count = squares};
    STP_TRY(stp_chunk_build_leaf(out, &group, params, err));
done:
    free(items);
    free(ends);
    return status;
}

void stp_map_leaves_clear(stp_map_leaves *leaves)
{
    free(leaves->squares);
    free(leaves->leaves);
    *leaves = (stp_map_leaves){0};
}
