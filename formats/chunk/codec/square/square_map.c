/* Makes maps of squares. */
#include "formats/chunk/codec/square/square_map.h"

#include "base/memory.h"
#include "base/wide.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

/* A map's grids hold at most min(4 n, s, SQUARES_MOST) + SQUARES_FREE squares of a block of n
 * patches and s samples: memory is bounded by what the block has, and by 90 MB. `stipple prep`
 * makes blocks of some thousand samples. */
#define SQUARES_PER_PATCH 4u
#define SQUARES_PER_SAMPLE 1u
#define SQUARES_MOST 16384u
#define SQUARES_FREE 256u
/* Lattices of patches differ by at most so many octaves, so sums of heights are exact. */
#define OCTAVES_MOST 8

/* Columns, or rows, of squares. */
typedef struct range {
    uint32_t least, greatest;
} range;

static void widen(range *r, uint32_t place)
{
    r->least = place < r->least ? place : r->least;
    r->greatest = place > r->greatest ? place : r->greatest;
}

/* Squares of a raster. */
typedef struct extent {
    range columns, rows;
} extent;

static bool is_empty(const extent *e)
{
    return e->columns.least > e->columns.greatest;
}

static uint64_t width(const range *r)
{
    return (uint64_t)r->greatest - r->least + 1;
}

static void find_rasters(const stp_square *squares, uint32_t count, stp_square_map *map)
{
    range rasters = {UINT32_MAX, 0};
    for (uint32_t p = 0; p < count; p++)
        widen(&rasters, squares[p].raster);
    map->first_raster = rasters.least;
    map->grid_count = (uint32_t)width(&rasters);
}

static const char *find_lattice(const stp_chunk *block, stp_square_map *map)
{
    int most = INT16_MIN;
    map->exponent = INT16_MAX;
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const int exponent = block->patches[p].exponent;
        map->exponent = exponent < map->exponent ? exponent : map->exponent;
        most = exponent > most ? exponent : most;
    }
    return most - map->exponent > OCTAVES_MOST ? "the lattices of its squares are too unlike"
                                               : NULL;
}

/* Finds the squares of each raster. *squares: as many as all extents hold. */
static const char *find_extents(const stp_chunk *block, const stp_square_map *map, extent *extents,
                                size_t *squares)
{
    uint64_t count = 0;
    for (uint32_t r = 0; r < map->grid_count; r++)
        extents[r] = (extent){{UINT32_MAX, 0}, {UINT32_MAX, 0}};
    for (uint32_t p = 0; p < block->patch_count; p++) {
        extent *e = &extents[map->squares[p].raster - map->first_raster];
        widen(&e->columns, map->squares[p].column);
        widen(&e->rows, map->squares[p].row);
    }
    const uint64_t of_patches = (uint64_t)block->patch_count * SQUARES_PER_PATCH;
    const uint64_t of_samples =
        (uint64_t)block->level_begin[0][block->patch_count] * SQUARES_PER_SAMPLE;
    const uint64_t of_block = of_patches < of_samples ? of_patches : of_samples;
    const uint64_t most = (of_block < SQUARES_MOST ? of_block : SQUARES_MOST) + SQUARES_FREE;
    for (uint32_t r = 0; r < map->grid_count && count <= most; r++)
        if (!is_empty(&extents[r]))
            count += width(&extents[r].columns) * width(&extents[r].rows);
    *squares = (size_t)count;
    return count > most ? "its squares are too far apart" : NULL;
}

/* Parts the memory of samples among the levels of all grids, and that of cells among the grids.
 * cell: of the samples before, too. */
static void share_out(const stp_chunk *block, const extent *extents, double *next, int32_t *cell,
                      double *sums, stp_square_map *map)
{
    stp_square_level samples[STP_LEVEL_COUNT] = {{0}};
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        double **arrays[] = {&samples[l].column, &samples[l].row, &samples[l].across[0],
                             &samples[l].across[1], &samples[l].height};
        for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
            *arrays[k] = next;
            next += block->level_begin[l][block->patch_count];
        }
        samples[l].before = cell;
        cell += block->level_begin[l][block->patch_count];
    }
    for (uint32_t r = 0; r < map->grid_count; r++) {
        if (is_empty(&extents[r]))
            continue;
        const int columns = (int)(width(&extents[r].columns) * STP_SQUARE_SIDE);
        const int rows = (int)(width(&extents[r].rows) * STP_SQUARE_SIDE);
        stp_square_grid *grid = &map->grids[r];
        grid->raster = &block->rasters[map->first_raster + r];
        grid->column = extents[r].columns.least * STP_SQUARE_SIDE;
        grid->row = extents[r].rows.least * STP_SQUARE_SIDE;
        grid->sums = sums;
        sums += sums ? STP_SQUARE_SUMS * (size_t)columns * (size_t)rows : 0;
        for (int l = 0; l < STP_LEVEL_COUNT; l++) {
            stp_square_level *level = &grid->level[l];
            *level = samples[l];
            level->cell_columns = columns >> l;
            level->cell_rows = rows >> l;
            level->cells = cell;
            const size_t count = (size_t)level->cell_columns * (size_t)level->cell_rows;
            for (size_t k = 0; k < count; k++)
                cell[k] = -1;
            cell += count;
        }
    }
}

/* squares: that the grids hold. */
static stp_status allocate(const stp_chunk *block, const extent *extents, size_t squares,
                           bool planes, stp_square_map *map, stp_error *err)
{
    stp_status status = STP_OK;
    const size_t parents = block->level_begin[1][block->patch_count];
    /* Where rasters spread, many patches may have one square, and so more parents than cells. */
    const size_t of_cells = planes ? STP_SQUARE_SUMS * squares * STP_SQUARE_SAMPLES : 0,
                 of_parents = STP_SQUARE_PARENT_VALUES * parents,
                 sums = of_cells > of_parents ? of_cells : of_parents;
    size_t doubles = sums, cells = 0;
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        doubles += 5 * (size_t)block->level_begin[l][block->patch_count];
        cells += block->level_begin[l][block->patch_count];
        cells += (squares * STP_SQUARE_SAMPLES) >> 2 * l;
    }
    STP_TRY(stp_alloc(&map->grids, map->grid_count, sizeof *map->grids, "a map of squares", err));
    STP_TRY(stp_alloc_unset(&map->memory, doubles * sizeof(double) + cells * sizeof(int32_t), 1,
                            "a map of squares", err));
    map->sums = map->memory;
    share_out(block, extents, map->sums + sums, (int32_t *)(void *)(map->sums + doubles),
              planes ? map->sums : NULL, map);
done:
    return status;
}

static void put_cell(const stp_square_level *level, int l, uint32_t sample)
{
    const int column = stp_square_cell(level->column[sample], l);
    const int row = stp_square_cell(level->row[sample], l);
    int32_t *cell = &level->cells[(size_t)row * (size_t)level->cell_columns + (size_t)column];
    level->before[sample] = *cell;
    *cell = (int32_t)sample;
}

/* The nearest whole number, ties to even. */
static double nearest(double x)
{
    return nearbyint(x);
}

/* Column of a sample within a square by its bit; row, by half of it. */
static unsigned place_of(unsigned bit)
{
    return (bit & 1u) | (bit >> 1 & 2u) | (bit >> 2 & 4u);
}

/* Of level grids, places across are whole numbers. */
STP_WIDE
static void place_finest(const stp_chunk *block, uint32_t p, const stp_square_map *map)
{
    const stp_square *square = &map->squares[p];
    const stp_square_grid *grid = stp_square_grid_of(map, p);
    const stp_square_level *level = &grid->level[0];
    const double(*a)[6] = grid->raster->across;
    const bool flat = grid->raster->level;
    const double inverse = ldexp(1.0, -block->patches[p].exponent);
    uint32_t i = block->level_begin[0][p];
    for (unsigned k = 0; k < STP_SQUARE_SAMPLES; k++) {
        if (!(square->samples >> k & 1u))
            continue;
        const uint32_t column = square->column * STP_SQUARE_SIDE + place_of(k);
        const uint32_t row = square->row * STP_SQUARE_SIDE + place_of(k >> 1);
        level->column[i] = column - grid->column;
        level->row[i] = row - grid->row;
        for (int j = 0; j < 2; j++) {
            const double at = (a[j][0] + column * a[j][1] + row * a[j][2]) * inverse;
            level->across[j][i] = flat ? nearest(at) : at;
        }
        put_cell(level, 0, i++);
    }
}

static double mean(const double *values, uint32_t begin, uint32_t end)
{
    double sum = 0.0;
    for (uint32_t i = begin; i < end; i++)
        sum += values[i];
    return sum / (end - begin);
}

/* Places the merged samples of a level of a patch. */
STP_WIDE
static void place_merged(const stp_chunk *block, uint32_t p, int l, const stp_square_map *map)
{
    const stp_square_grid *grid = stp_square_grid_of(map, p);
    const stp_square_level *finer = &grid->level[l - 1], *level = &grid->level[l];
    const bool flat = grid->raster->level;
    const unsigned count = block->patches[p].counts[l], under = block->patches[p].counts[l - 1];
    for (unsigned j = 0; j < count; j++) {
        const uint32_t i = block->level_begin[l][p] + j;
        const uint32_t first = block->level_begin[l - 1][p];
        const uint32_t begin = first + stp_level_children_begin(j, count, under);
        const uint32_t end = first + stp_level_children_begin(j + 1, count, under);
        level->column[i] = mean(finer->column, begin, end);
        level->row[i] = mean(finer->row, begin, end);
        for (int k = 0; k < 2; k++) {
            const double at = mean(finer->across[k], begin, end);
            level->across[k][i] = flat ? nearest(at) : at;
        }
        put_cell(level, l, i);
    }
}

/* Whether no cell of a level's grids is empty. */
static bool is_full(const stp_square_map *map, int level)
{
    int32_t least = 0;
    for (uint32_t g = 0; g < map->grid_count; g++) {
        const stp_square_level *on = &map->grids[g].level[level];
        const size_t count = (size_t)on->cell_columns * (size_t)on->cell_rows;
        for (size_t i = 0; i < count; i++)
            least = on->cells[i] < least ? on->cells[i] : least;
    }
    return least >= 0;
}

stp_status stp_square_map_create(const stp_chunk *block, const stp_square *squares, bool planes,
                                 stp_square_map *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_square_map map = {.squares = squares};
    extent *extents = NULL;
    size_t count;
    find_rasters(squares, block->patch_count, &map);
    STP_TRY(stp_alloc(&extents, map.grid_count, sizeof *extents, "a map of squares", err));
    const char *fault = find_lattice(block, &map);
    if (!fault)
        fault = find_extents(block, &map, extents, &count);
    if (fault) {
        status = stp_error_set(err, STP_CORRUPT, "%s", fault);
        goto done;
    }
    STP_TRY(allocate(block, extents, count, planes, &map, err));
    map.stops = true;
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const stp_square_grid *grid = stp_square_grid_of(&map, p);
        map.stops = map.stops && grid->raster->stops;
        if (!stp_raster_spreads(grid->raster) &&
            stp_square_at(&grid->level[STP_LEVEL_COUNT - 1],
                          (int)(squares[p].column - grid->column / STP_SQUARE_SIDE),
                          (int)(squares[p].row - grid->row / STP_SQUARE_SIDE)) >= 0) {
            status =
                stp_error_set(err, STP_CORRUPT, "patch %" PRIu32 " has another one's square", p);
            goto done;
        }
        place_finest(block, p, &map);
        for (int l = 1; l < STP_LEVEL_COUNT; l++)
            place_merged(block, p, l, &map);
    }
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        map.full[l] = is_full(&map, l);
    *out = map;
    map = (stp_square_map){0};
done:
    free(extents);
    stp_square_map_clear(&map);
    return status;
}

void stp_square_map_clear(stp_square_map *map)
{
    free(map->memory);
    free(map->grids);
    *map = (stp_square_map){0};
}

double stp_square_map_steps(const stp_square_map *map, const stp_patch *patch)
{
    return ldexp(1.0, patch->exponent - map->exponent);
}

bool stp_square_is_beside_hole(const stp_square_map *map, const stp_square_grid *grid, int level,
                               uint32_t sample)
{
    const stp_square_level *on = &grid->level[level];
    const int column = stp_square_cell(on->column[sample], level);
    const int row = stp_square_cell(on->row[sample], level);
    const int left = column > 0 ? column - 1 : 0, top = row > 0 ? row - 1 : 0;
    const int right = column + 1 < on->cell_columns ? column + 1 : column;
    const int bottom = row + 1 < on->cell_rows ? row + 1 : row;
    for (int j = top; j <= bottom && !map->full[level]; j++) {
        const int32_t *cells = on->cells + (size_t)j * (size_t)on->cell_columns;
        for (int i = left; i <= right; i++)
            if (cells[i] < 0)
                return true;
    }
    return false;
}
