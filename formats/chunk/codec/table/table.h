/* A table of integer columns, as a payload's parts hold them (table_code.h). Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_TABLE_TABLE_H
#define STP_FORMATS_CHUNK_CODEC_TABLE_TABLE_H

#include "formats/chunk/codec/odds/known_odds.h"
#include "formats/chunk/codec/predict/scale.h"
#include "formats/chunk/codec/table/column.h"

/* The mask has bits for other things behind those of columns. */
#define STP_TABLE_COLUMNS_LIMIT 55u
/* A column that no other column tells of; a column of kinds, such as flags: not of numbers. */
#define STP_BESIDE_NONE (-1)
#define STP_BESIDE_KINDS (-2)

/* The row_count values of column c begin at values + c * stride. */
typedef struct stp_table {
    int16_t *values;
    size_t stride;
    unsigned column_count;
    uint32_t row_count;
    /* Decoding a table without odds. Bit c: column c is coded in one stream with the column before
     * it. The first files of version 2 have such tables. */
    uint64_t joined;
    bool smallest; /* encoding: see stp_column_encode */
    /* By column: the column whose cells tell how large this one's are, or -1. NULL: the table
     * cannot be coded by odds. Decoding sets by_odds. */
    const int16_t *beside;
    bool by_odds;
    /* Normals are on the grid of this shift (normal_grid.h). Decoding sets it if the table may have
     * one; else the file must say 0. */
    unsigned normal_shift;
    bool may_shift;
    unsigned normal_odd; /* likewise, of its step; not 0 only if the table may be coarse, below */
    /* The scale of positions. Decoding sets it if the table may have one. */
    stp_scale scale;
    bool may_scale;
    /* Of levels 2 to 0 of points: the grid of radii, whose codes are 1 + a multiple of 2^shift, and
     * the sublattice of each patch's positions, sublattice_count in all, 0 but for level 0 (NULL).
     * Only a tight table may have them. Decoding sets both. */
    bool may_coarsen;
    unsigned radius_shift;
    uint8_t *sublattices;
    uint32_t sublattice_count;
    /* Of patches of a block (patch.h): their bounds have their centres in the middles of their
     * lattices, as a rule; squares follow the table (square.h). Decoding sets the other three. */
    bool is_patches;
    bool middles, squares, tilted;
    /* Of patches: squares place them, and placed.h codes their origins and counts. */
    bool placed;
    /* With middles, by column: the bits of the mean that its odds begin with (cells.h). */
    const uint8_t *first;
    /* The table is tight (tight.h). By column: likewise, and the sign that its cells have as a
     * rule, or 0; NULL: all have both. Decoding sets `tight` of patches. */
    bool tight;
    const uint8_t *tight_first;
    const int8_t *side;
    /* If the odds of a tight part are known: the curves of each column (known_odds.h), and of each
     * row stp_row_kind_of; NULL: all 0. */
    const uint8_t *known;
    uint8_t *row_kinds;
    /* Whether odds go by signed cells (known_odds.h); decoding sets it. may_sign: the table may
     * have them, since it is of elder children of points, of `level`. */
    bool may_sign, is_signed;
    int level;
    /* Decoding adds each column's bytes here; those of a stream go to its first column. NULL:
     * nobody asks. */
    uint64_t *column_bytes;
} stp_table;

static inline int16_t *stp_table_column(const stp_table *table, unsigned column)
{
    return table->values + column * table->stride;
}

/* Makes room for cells, all 0; other members stay as they are. Free `values`. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_table_create(stp_table *table, unsigned column_count, uint32_t row_count,
                            stp_error *err);
/* Bit c: all cells of column c are equal. */
uint64_t stp_table_constants(const stp_table *table);
/* Errors: CORRUPT (no normals are shifted so far). */
stp_status stp_table_check_shift(const stp_table *table, stp_error *err);

#endif
