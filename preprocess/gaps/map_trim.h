/* Trims maps until no two of them lie over each other, so that what is left between them can be
 * filled with triangles (map_fill.h).
 *
 * A cell of a map is the square between four samples. A map that has more samples keeps its cells;
 * another loses every cell that comes within TRIM_MARGIN of them. Then each sample is one of
 * a cell, and all cells around a sample follow each other:
 *
 *      x--x        the middle sample is lost, since the surface would
 *      |  |        touch itself there in one point
 *      x--x--x
 *         |  |
 *         x--x
 *
 * Threads: one. */
#ifndef STP_PREPROCESS_GAPS_MAP_TRIM_H
#define STP_PREPROCESS_GAPS_MAP_TRIM_H

#include "preprocess/maps/map.h"

#include "base/error.h"

/* Takes samples from the maps. A map may lose all of them. Errors: OUT_OF_MEMORY. */
stp_status stp_maps_trim(stp_map *maps, uint32_t count, stp_error *err);

/* Whether the cell of a column and row, both any number, has all four samples. */
static inline bool stp_map_is_cell(const stp_map *map, int64_t column, int64_t row)
{
    if (column < 0 || row < 0 || column + 1 >= map->columns || row + 1 >= map->rows)
        return false;
    const stp_map_sample *at = stp_map_at(map, (uint32_t)column, (uint32_t)row);
    return at[0].flags & at[1].flags & at[map->columns].flags & at[map->columns + 1].flags &
           STP_MAP_SUPPORTED;
}

/* The cells around a sample, counterclockwise from the one after it: bit k is set if cell k is
 * there. */
static inline unsigned stp_map_cells_around(const stp_map *map, int64_t column, int64_t row)
{
    return (stp_map_is_cell(map, column, row) ? 1u : 0u) |
           (stp_map_is_cell(map, column - 1, row) ? 2u : 0u) |
           (stp_map_is_cell(map, column - 1, row - 1) ? 4u : 0u) |
           (stp_map_is_cell(map, column, row - 1) ? 8u : 0u);
}

#endif
