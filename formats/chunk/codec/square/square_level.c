/* Codes the levels of a block of squares: the order of the steps, and what a writer chooses. */
#include "formats/chunk/codec/square/square_level.h"

#include "formats/chunk/codec/square/level_coder.h"

#include <stdlib.h>

/* Sets the heights of a level that is there. */
static void set_heights(const stp_chunk *block, int level, const stp_square_map *map)
{
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const stp_patch *patch = &block->patches[p];
        const stp_square_grid *grid = stp_square_grid_of(map, p);
        const unsigned axis = grid->raster->axis;
        const double steps = stp_square_map_steps(map, patch);
        for (uint32_t i = block->level_begin[level][p]; i < block->level_begin[level][p + 1]; i++)
            grid->level[level].height[i] =
                ((double)patch->origin[axis] + block->samples[level][i].position[axis]) * steps;
    }
}

static uint64_t normals_cost(const stp_level_tables *tables)
{
    const stp_table *both[2] = {&tables->elder, &tables->last};
    uint64_t sum = 0;
    for (int t = 0; t < 2; t++)
        for (uint32_t i = 0; i < both[t]->row_count; i++)
            sum += (uint64_t)abs(stp_table_column(both[t], STP_COLUMN_NORMAL_U)[i]) +
                   (uint64_t)abs(stp_table_column(both[t], STP_COLUMN_NORMAL_V)[i]);
    return sum;
}

/* Lets normals follow from what they are nearest to, the given reach if in doubt. That one is tried
 * late, since it need not be coded again then. Where heights tell normals to a step of the grid,
 * the parents' are not tried. */
static void choose_reach(stp_level_coder *c, stp_square_choice *choice)
{
    const bool spreads = stp_raster_spreads(stp_square_grid_of(c->map, 0)->raster);
    const unsigned reaches[5] = {0, choice->reach, STP_SQUARE_REACH_PARENTS, STP_SQUARE_REACH_LOOSE,
                                 STP_SQUARE_REACH_STRIDES};
    const unsigned end = !spreads ? 3 : c->level > 1 || !choice->tight ? 4 : 5;
    const uint32_t count = c->tables->elder.row_count + c->tables->last.row_count;
    unsigned coded = 0;
    uint64_t least = UINT64_MAX;
    for (unsigned i = c->level > 0 || spreads ? 0 : 1; i < end; i++) {
        if (i == 2 && !spreads && least <= count)
            break;
        const bool fit = stp_level_code_normals(c, reaches[i]);
        coded = reaches[i];
        const uint64_t cost = fit ? normals_cost(c->tables) : UINT64_MAX;
        if (cost < least || (i == 1 && cost == least)) {
            choice->reach = coded;
            least = cost;
        }
    }
    if (coded != choice->reach)
        (void)stp_level_code_normals(c, choice->reach);
}

/* Sets what the level's parents tell. Their colours take the place of the map's sums. */
static stp_level_coder begin(const stp_chunk *block, int level, stp_square_map *map,
                             const stp_ladder *ladder, const stp_square_choice *choice,
                             const stp_level_tables *tables, bool decode)
{
    const uint32_t count = block->level_begin[level + 1][block->patch_count];
    const stp_sample *parents = block->samples[level + 1];
    double *colours = map->sums;
    /* All grids have the same heights. */
    const double *heights = stp_square_grid_of(map, 0)->level[level + 1].height;
    stp_level_coder c = {block, map,    ladder, tables, {[STP_HEIGHT] = heights},
                         NULL,  choice, level,  false,  decode};
    set_heights(block, level + 1, map);
    for (int v = STP_GREEN; v <= STP_BLUE; v++, colours += count) {
        for (uint32_t i = 0; i < count && !choice->rows; i++)
            colours[i] = parents[i].rgb[stp_level_channel[v]];
        c.values[v] = colours;
    }
    return c;
}

void stp_square_level_encode(const stp_chunk *block, int level, stp_square_map *map,
                             const stp_ladder *ladder, stp_square_choice *choice,
                             const stp_level_tables *tables)
{
    stp_square_choice_find(block, level, map, tables->last.normal_shift, choice);
    stp_level_coder c = begin(block, level, map, ladder, choice, tables, false);
    choice->loose = stp_level_code_values(&c) && !choice->rows;
    if (choice->loose)
        stp_level_code_values(&c);
    choose_reach(&c, choice);
    stp_level_code_radii(&c);
    choice->follow = !choice->rows && stp_square_colours_follow(&tables->elder);
    if (choice->follow)
        stp_square_colours_move(&tables->elder, -1);
}

void stp_square_level_decode(stp_chunk *block, int level, stp_square_map *map,
                             const stp_ladder *ladder, const stp_square_choice *choice,
                             const stp_level_tables *tables)
{
    stp_level_coder c = begin(block, level, map, ladder, choice, tables, true);
    if (choice->follow)
        stp_square_colours_move(&tables->elder, 1);
    stp_level_code_values(&c);
    (void)stp_level_code_normals(&c, choice->reach);
    stp_level_code_radii(&c);
}
