/* Makes maps of squares. */
#include "formats/chunk/codec/square_map.h"

#include "base/memory.h"

#include <inttypes.h>
#include <math.h>
#include <stdlib.h>

/* A map has at most this many cells of a square for each patch, and so many more. */
#define CELLS_PER_PATCH 4u
#define CELLS_FREE 64u
/* Lattices of patches differ by at most so many octaves, so sums of heights are exact. */
#define OCTAVES_MOST 8
#define SQUARE_SAMPLES (STP_SQUARE_SIDE * STP_SQUARE_SIDE)

/* Columns, or rows, of squares. */
typedef struct range {
    uint32_t least, greatest;
} range;

static void widen(range *r, uint32_t place)
{
    r->least = place < r->least ? place : r->least;
    r->greatest = place > r->greatest ? place : r->greatest;
}

static const char *find_extent(const stp_chunk *block, const stp_square *squares, range *columns,
                               range *rows, stp_square_map *map)
{
    int most = INT16_MIN;
    map->exponent = INT16_MAX;
    *columns = *rows = (range){UINT32_MAX, 0};
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const int exponent = block->patches[p].exponent;
        widen(columns, squares[p].column);
        widen(rows, squares[p].row);
        map->exponent = exponent < map->exponent ? exponent : map->exponent;
        most = exponent > most ? exponent : most;
    }
    const uint64_t cells = ((uint64_t)columns->greatest - columns->least + 1) *
                           ((uint64_t)rows->greatest - rows->least + 1);
    if (cells > (uint64_t)block->patch_count * CELLS_PER_PATCH + CELLS_FREE)
        return "its squares are too far apart";
    return most - map->exponent > OCTAVES_MOST ? "the lattices of its squares are too unlike"
                                               : NULL;
}

/* Parts the memory among the levels. */
static stp_status allocate(const stp_chunk *block, size_t width, size_t height, stp_square_map *map,
                           stp_error *err)
{
    const size_t sums = STP_SQUARE_SUMS * width * height * SQUARE_SAMPLES;
    size_t doubles = sums, cells = 0;
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        doubles += 5 * (size_t)block->level_begin[l][block->patch_count];
        cells += (width * height * SQUARE_SAMPLES) >> 2 * l;
    }
    stp_status status = stp_alloc(&map->memory, doubles * sizeof(double) + cells * sizeof(int32_t),
                                  1, "a map of squares", err);
    if (status != STP_OK)
        return status;
    map->sums = map->memory;
    double *next = map->sums + sums;
    int32_t *cell = (int32_t *)(void *)(map->sums + doubles);
    for (int l = 0; l < STP_LEVEL_COUNT; l++) {
        stp_square_level *level = &map->level[l];
        double **arrays[] = {&level->column, &level->row, &level->x, &level->y, &level->z};
        for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
            *arrays[k] = next;
            next += block->level_begin[l][block->patch_count];
        }
        level->width = (int)(width * STP_SQUARE_SIDE >> l);
        level->height = (int)(height * STP_SQUARE_SIDE >> l);
        level->cells = cell;
        const size_t count = (size_t)level->width * (size_t)level->height;
        for (size_t k = 0; k < count; k++)
            cell[k] = -1;
        cell += count;
    }
    return STP_OK;
}

static void put_cell(stp_square_level *level, int l, uint32_t sample)
{
    const int column = stp_square_cell(level->column[sample], l);
    const int row = stp_square_cell(level->row[sample], l);
    level->cells[(size_t)row * (size_t)level->width + (size_t)column] = (int32_t)sample;
}

/* The nearest whole number, ties to even. */
static double nearest(double x)
{
    return nearbyint(x);
}

static void place_finest(const stp_chunk *block, const stp_square *square, uint32_t p,
                         stp_square_map *map)
{
    stp_square_level *level = &map->level[0];
    const stp_raster *r = &block->raster;
    const double inverse = ldexp(1.0, -block->patches[p].exponent);
    uint32_t i = block->level_begin[0][p];
    for (unsigned k = 0; k < SQUARE_SAMPLES; k++) {
        if (!(square->samples >> k & 1u))
            continue;
        const uint32_t column = square->column * STP_SQUARE_SIDE + stp_square_column(k);
        const uint32_t row = square->row * STP_SQUARE_SIDE + stp_square_row(k);
        level->column[i] = column - map->column;
        level->row[i] = row - map->row;
        level->x[i] = nearest((r->x + column * r->dx) * inverse);
        level->y[i] = nearest((r->y + row * r->dy) * inverse);
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
static void place_merged(const stp_chunk *block, uint32_t p, int l, stp_square_map *map)
{
    const stp_square_level *finer = &map->level[l - 1];
    stp_square_level *level = &map->level[l];
    const unsigned count = block->patches[p].counts[l], under = block->patches[p].counts[l - 1];
    for (unsigned j = 0; j < count; j++) {
        const uint32_t i = block->level_begin[l][p] + j;
        const uint32_t first = block->level_begin[l - 1][p];
        const uint32_t begin = first + stp_level_children_begin(j, count, under);
        const uint32_t end = first + stp_level_children_begin(j + 1, count, under);
        level->column[i] = mean(finer->column, begin, end);
        level->row[i] = mean(finer->row, begin, end);
        level->x[i] = nearest(mean(finer->x, begin, end));
        level->y[i] = nearest(mean(finer->y, begin, end));
        put_cell(level, l, i);
    }
}

stp_status stp_square_map_create(const stp_chunk *block, const stp_square *squares,
                                 stp_square_map *out, stp_error *err)
{
    stp_status status = STP_OK;
    stp_square_map map = {0};
    range columns, rows;
    const char *fault = find_extent(block, squares, &columns, &rows, &map);
    if (fault)
        return stp_error_set(err, STP_CORRUPT, "%s", fault);
    map.column = columns.least * STP_SQUARE_SIDE;
    map.row = rows.least * STP_SQUARE_SIDE;
    STP_TRY(allocate(block, columns.greatest - columns.least + 1, rows.greatest - rows.least + 1,
                     &map, err));
    const stp_square_level *coarsest = &map.level[STP_LEVEL_COUNT - 1];
    for (uint32_t p = 0; p < block->patch_count; p++) {
        if (stp_square_at(coarsest, (int)(squares[p].column - columns.least),
                          (int)(squares[p].row - rows.least)) >= 0) {
            status =
                stp_error_set(err, STP_CORRUPT, "patch %" PRIu32 " has another one's square", p);
            goto done;
        }
        place_finest(block, &squares[p], p, &map);
        for (int l = 1; l < STP_LEVEL_COUNT; l++)
            place_merged(block, p, l, &map);
    }
    *out = map;
    map.memory = NULL;
done:
    free(map.memory);
    return status;
}

void stp_square_map_clear(stp_square_map *map)
{
    free(map->memory);
    *map = (stp_square_map){0};
}

double stp_square_map_steps(const stp_square_map *map, const stp_patch *patch)
{
    return ldexp(1.0, patch->exponent - map->exponent);
}
