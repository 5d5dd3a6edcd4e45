/* Reads and writes what the writer of a level of squares chooses. */
#include "formats/chunk/codec/square/square_choice.h"

#include "formats/chunk/codec/predict/predict_normal.h"
#include "formats/chunk/codec/square/square.h"
#include "formats/chunk/codec/table/part_tables.h"
#include "formats/chunk/layout.h"
#include "formats/chunk/sample/normal_grid.h"

#include <stdlib.h>

#define REACH 7u
#define FOLLOW 8u
#define LADDER 16u
#define LOOSE 32u
#define MORE 64u
#define TIGHT 128u
/* The byte; behind it, if it says so, one more, and the number of rungs, less 1. */
#define BYTES 1u
#define MORE_BYTES 1u
#define LADDER_BYTES 2u
/* The other byte. */
#define STEPS 15u
/* Of level 0, which has no steps. */
#define ROWS 1u
#define BY_PARENTS 2u
#define SIDES 16u
#define RADII_SHIFT 5

/* The greatest shift of which all heights of a level are multiples, on the finest lattice. */
static unsigned height_steps(const stp_chunk *block, int level, const stp_square_map *map)
{
    uint32_t bits = UINT32_C(1) << STEPS;
    for (uint32_t p = 0; p < block->patch_count; p++) {
        const stp_patch *patch = &block->patches[p];
        const unsigned axis = stp_square_grid_of(map, p)->raster->axis;
        const uint32_t origin = (uint32_t)patch->origin[axis];
        const unsigned coarser = (unsigned)(patch->exponent - map->exponent);
        for (uint32_t i = block->level_begin[level][p]; i < block->level_begin[level][p + 1]; i++)
            bits |= (origin + block->samples[level][i].position[axis]) << coarser;
    }
    return (unsigned)__builtin_ctz(bits);
}

/* Whether normals lie on sides of their grid, and all of them are told by the lesser code. */
static bool has_sides(const stp_chunk *block, int level, unsigned shift)
{
    const int32_t top = stp_normal_grid_place(STP_NORMAL_CODE_MAX, shift);
    bool any = false;
    for (uint32_t i = 0; i < block->level_begin[level][block->patch_count]; i++) {
        int32_t place[2], lesser[2];
        stp_normal_codes_get(block->samples[level][i].normal, place);
        for (int k = 0; k < 2; k++) {
            lesser[k] = place[k] = stp_normal_grid_place(place[k], shift);
            any = any || place[k] == 0 || place[k] == top;
        }
        stp_normal_side(lesser, top);
        if (lesser[0] != place[0] || lesser[1] != place[1])
            return false;
    }
    return any;
}

void stp_square_choice_find(const stp_chunk *block, int level, const stp_square_map *map,
                            unsigned normal_shift, stp_square_choice *choice)
{
    if (!choice->tight)
        return;
    choice->steps = level > 0 ? height_steps(block, level, map) : 0;
    choice->sides = has_sides(block, level, normal_shift);
    choice->radii = stp_radius_shift(block, level);
}

stp_status stp_square_choice_write(const stp_square_choice *choice, stp_bytes *out, stp_error *err)
{
    const bool ladder = choice->rungs > 0,
               more = choice->steps > 0 || choice->rows || choice->sides || choice->radii > 0;
    uint8_t bytes[BYTES + MORE_BYTES + LADDER_BYTES];
    size_t size = 0;
    bytes[size++] =
        (uint8_t)(choice->reach | (choice->follow ? FOLLOW : 0) | (ladder ? LADDER : 0) |
                  (choice->loose ? LOOSE : 0) | (more ? MORE : 0) | (choice->tight ? TIGHT : 0));
    if (more)
        bytes[size++] = (uint8_t)(choice->steps | (choice->rows ? ROWS : 0) |
                                  (choice->by_parents ? BY_PARENTS : 0) |
                                  (choice->sides ? SIDES : 0) | choice->radii << RADII_SHIFT);
    stp_put_u16(bytes + size, (uint16_t)(choice->rungs - 1u));
    return stp_bytes_append(out, bytes, size + (ladder ? LADDER_BYTES : 0), err);
}

bool stp_square_choice_is_tight(uint8_t first_byte)
{
    return first_byte & TIGHT;
}

/* Reads the other byte. */
static stp_status read_more(stp_cursor *c, int level, stp_square_choice *out, stp_error *err)
{
    if (c->left < MORE_BYTES)
        return stp_error_set(err, STP_CORRUPT, "it ends before a level of squares");
    const uint8_t byte = *c->bytes;
    out->steps = level > 0 ? byte & STEPS : 0;
    out->rows = level == 0 && byte & ROWS;
    out->by_parents = level == 0 && byte & BY_PARENTS;
    out->sides = byte & SIDES;
    out->radii = byte >> RADII_SHIFT;
    if ((level == 0 && byte & STEPS & ~(ROWS | BY_PARENTS)) || (out->by_parents && !out->rows) ||
        (out->rows && (out->follow || out->loose)) || !out->tight)
        return stp_error_set(err, STP_CORRUPT, "a level of squares goes on with byte %u", byte);
    stp_cursor_skip(c, MORE_BYTES);
    return STP_OK;
}

stp_status stp_square_choice_read(stp_cursor *c, int level, bool tight, stp_square_choice *out,
                                  stp_error *err)
{
    stp_status status = STP_OK;
    if (c->left < BYTES)
        return stp_error_set(err, STP_CORRUPT, "it ends before a level of squares");
    const uint8_t byte = *c->bytes;
    const bool ladder = byte & LADDER;
    *out = (stp_square_choice){.reach = byte & REACH,
                               .follow = byte & FOLLOW,
                               .loose = byte & LOOSE,
                               .tight = byte & TIGHT};
    if ((out->reach == STP_SQUARE_REACH_STRIDES && (level > 1 || !tight)) || out->tight != tight ||
        (ladder && (level > 0 || !tight)))
        return stp_error_set(err, STP_CORRUPT, "a level of squares begins with byte %u", byte);
    stp_cursor_skip(c, BYTES);
    if (byte & MORE)
        STP_TRY(read_more(c, level, out, err));
    if (!ladder)
        goto done;
    if (c->left < LADDER_BYTES)
        return stp_error_set(err, STP_CORRUPT, "it ends before the heights of a ladder");
    out->rungs = stp_get_u16(c->bytes) + 1u;
    stp_cursor_skip(c, LADDER_BYTES);
done:
    return status;
}

static int16_t wrapped(int32_t x)
{
    return (int16_t)(((x + 128) & 0xff) - 128);
}

/* The sum of the magnitudes of red and blue, if they follow green or not. */
static uint64_t cost(const stp_table *table, bool follow)
{
    const int16_t *green = stp_table_column(table, STP_COLUMN_GREEN);
    const int16_t *red = stp_table_column(table, STP_COLUMN_RED);
    const int16_t *blue = stp_table_column(table, STP_COLUMN_BLUE);
    uint64_t sum = 0;
    for (uint32_t i = 0; i < table->row_count; i++) {
        const int32_t less = follow ? green[i] : 0;
        sum += (uint64_t)abs(wrapped(red[i] - less)) + (uint64_t)abs(wrapped(blue[i] - less));
    }
    return sum;
}

bool stp_square_colours_follow(const stp_table *elder)
{
    return cost(elder, true) < cost(elder, false);
}

void stp_square_colours_move(const stp_table *table, int sign)
{
    const int16_t *green = stp_table_column(table, STP_COLUMN_GREEN);
    int16_t *red = stp_table_column(table, STP_COLUMN_RED);
    int16_t *blue = stp_table_column(table, STP_COLUMN_BLUE);
    for (uint32_t i = 0; i < table->row_count; i++) {
        red[i] = wrapped(red[i] + sign * green[i]);
        blue[i] = wrapped(blue[i] + sign * green[i]);
    }
}
