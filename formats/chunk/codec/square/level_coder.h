/* What the steps of coding a level of squares share (square_level.c): the coder, its next rows in
 * the level's two tables, and the walk over families, a parent and its children each.
 *
 * stp_level_code either writes the cell of a known value or returns the value of a known cell, so
 * one text encodes and decodes. Threads: any, one coder each. */
#ifndef STP_FORMATS_CHUNK_CODEC_SQUARE_LEVEL_CODER_H
#define STP_FORMATS_CHUNK_CODEC_SQUARE_LEVEL_CODER_H

#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/codec/predict/scale.h"
#include "formats/chunk/codec/square/ladder.h"
#include "formats/chunk/codec/square/square_choice.h"
#include "formats/chunk/codec/square/square_slope.h"

/* All that the functions of loops call with numbers is a part of them. GCC 12 leaves out vzeroupper
 * before a call of a static function that it knows to keep some registers: code for AVX2
 * (base/wide.h) then waits at each such call, and again behind it. */

/* Values that have slopes. */
enum { STP_HEIGHT, STP_GREEN, STP_RED, STP_BLUE, STP_LEVEL_VALUES };
static const uint8_t stp_level_channel[STP_LEVEL_VALUES] = {
    [STP_GREEN] = 1, [STP_RED] = 0, [STP_BLUE] = 2};

typedef struct stp_level_coder {
    const stp_chunk *block;
    stp_square_map *map;
    const stp_ladder *ladder; /* NULL: none */
    const stp_level_tables *tables;
    const double *values[STP_LEVEL_VALUES]; /* of the samples of the next coarser level */
    const stp_square_grid *grid;            /* of the patch at hand */
    const stp_square_choice *choice;
    int level;
    bool heights_only; /* have slopes now: colours are coded by rows */
    bool decode;
} stp_level_coder;

/* A row of a table: `column` at cell + column * stride. */
typedef struct stp_level_row {
    int16_t *cell;
    size_t stride;
} stp_level_row;

/* Codes a value modulo mask + 1, with the cell of least magnitude. Returns the value. */
STP_INLINE int32_t stp_level_code(const stp_level_coder *c, const stp_level_row *r, unsigned column,
                                  int32_t predicted, int32_t value, int32_t mask)
{
    int16_t *cell = r->cell + column * r->stride;
    if (c->decode)
        return (predicted + *cell) & mask;
    const int32_t low = (value - predicted) & mask;
    *cell = (int16_t)(low > mask >> 1 ? low - mask - 1 : low);
    return value;
}

/* A parent and its children. */
typedef struct stp_level_family {
    stp_square_field field;
    double left[STP_LEVEL_VALUES]; /* what is left of the parent's mean */
    unsigned count;
    uint32_t parent, first; /* samples */
    const stp_patch *patch;
    double steps; /* of the finest lattice in one of the patch */
    stp_patch_scale scale;
    uint64_t tied, loose; /* sums of magnitudes of the level's cells of colours, if choice->loose is
                             not set and if it is */
} stp_level_family;

/* Sets what the parent's slopes let expect of child k. */
STP_INLINE void stp_level_expect(const stp_level_coder *c, const stp_level_family *f, unsigned k,
                                 double out[STP_LEVEL_VALUES])
{
    const stp_square_level *on = &c->grid->level[c->level];
    if (c->heights_only) /* loops of a constant length */
        stp_square_expect(&f->field, on, c->level, f->first + k, f->count, 1, out);
    else
        stp_square_expect(&f->field, on, c->level, f->first + k, f->count, STP_LEVEL_VALUES, out);
}

/* Sets the field of the family at hand: its parent's values and their slopes. */
STP_INLINE void stp_level_begin_family(const stp_level_coder *c, stp_level_family *f)
{
    const int level = c->level + 1;
    const stp_square_level *on = &c->grid->level[level];
    f->field = c->heights_only ? stp_square_field_at(on, level, (int32_t)f->parent, c->values, 1)
                               : stp_square_field_at(on, level, (int32_t)f->parent, c->values,
                                                     STP_LEVEL_VALUES);
    for (int v = 0; v < STP_LEVEL_VALUES; v++)
        f->left[v] = 0.0;
}

/* A walk over the families of a level. Begins as zeros. */
typedef struct stp_level_walk {
    uint32_t elder, last; /* next rows of the two tables */
    uint32_t patch;       /* of the next family */
    unsigned parent;      /* likewise, in its patch */
    stp_level_family f;   /* at hand */
} stp_level_walk;

/* Goes to the next family; false if there is none. */
STP_INLINE bool stp_level_next_family(stp_level_coder *c, stp_level_walk *w)
{
    const stp_chunk *block = c->block;
    while (w->patch < block->patch_count &&
           w->parent == block->patches[w->patch].counts[c->level + 1]) {
        w->patch++;
        w->parent = 0;
    }
    if (w->patch == block->patch_count)
        return false;
    const stp_patch *patch = w->f.patch = &block->patches[w->patch];
    const unsigned j = w->parent++;
    const unsigned parents = patch->counts[c->level + 1], children = patch->counts[c->level];
    const unsigned begin = stp_level_children_begin(j, parents, children);
    w->f.count = stp_level_children_begin(j + 1, parents, children) - begin;
    w->f.parent = block->level_begin[c->level + 1][w->patch] + j;
    w->f.first = block->level_begin[c->level][w->patch] + begin;
    c->grid = stp_square_grid_of(c->map, w->patch);
    return true;
}

/* The row of child k of the family at hand. To be asked for once, in order. */
STP_INLINE stp_level_row stp_level_next_row(const stp_level_coder *c, stp_level_walk *w, unsigned k)
{
    const bool last = k + 1 == w->f.count;
    const stp_table *table = last ? &c->tables->last : &c->tables->elder;
    return (stp_level_row){table->values + (last ? w->last++ : w->elder++), table->stride};
}

/* ---- the steps, in their order ---- */

/* Codes all but normals and radii, and sets heights. Returns whether colours take less if they are
 * loose. */
bool stp_level_code_values(stp_level_coder *c);
/* Codes normals, as choice->reach says but by `reach`. False: some are not off by whole strides. */
bool stp_level_code_normals(stp_level_coder *c, unsigned reach);
/* Codes radii. */
void stp_level_code_radii(stp_level_coder *c);

#endif
