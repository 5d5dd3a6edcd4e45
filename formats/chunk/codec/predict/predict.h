/* Samples as columns of small numbers: the residuals after each sample is predicted from its
 * parent.
 *
 * Level 3 is predicted from its patch header, each finer level from the next coarser one. A child
 * is predicted from what its elder siblings leave of its parent, as the area-weighted mean of all
 * children; its position also from the plane of the normals, its normal also from how the normals
 * turn (predict_normal.h). formats/SPEC.md, "Sample columns", has the arithmetic; its results are
 * integers, the same on every machine. Encoding and decoding run the same code. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_PREDICT_PREDICT_H
#define STP_FORMATS_CHUNK_CODEC_PREDICT_PREDICT_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/predict/corners.h"
#include "formats/chunk/codec/table/table.h"

/* Columns of a table of samples, in this order. */
enum {
    STP_COLUMN_RADIUS,
    STP_COLUMN_FLAGS,
    STP_COLUMN_CLASS,
    STP_COLUMN_NORMAL_U,
    STP_COLUMN_NORMAL_V,
    STP_COLUMN_GREEN,
    STP_COLUMN_RED,
    STP_COLUMN_BLUE,
    STP_COLUMN_INTENSITY,
    STP_COLUMN_POSITION_A, /* first in-plane axis of the predicted normal */
    STP_COLUMN_POSITION_B,
    STP_COLUMN_POSITION_C, /* the normal's greatest axis */
    STP_SAMPLE_COLUMN_COUNT
};

/* Two tables of a level: elder children (all but the last child of each parent), and last children,
 * whose residuals are much smaller. */
typedef struct stp_level_tables {
    stp_table elder, last;
    stp_corners corners; /* of level 0 of triangles: the tables lack those that are not told */
} stp_level_tables;

/* Rows of a level's two tables (level 0..2). Needs only patches and level_begin. */
void stp_predict_row_counts(const stp_chunk *chunk, int level, uint32_t *elder, uint32_t *last);

/* What the parents tell of the rows of a level's tables (known_odds.h); NULL for no rows. The next
 * coarser level must be there. corners: of all samples of level 0, or NULL. */
void stp_predict_row_kinds(const stp_chunk *chunk, int level, const stp_corner *corners,
                           uint8_t *elder, uint8_t *last);

/* Level 3, one table of patch_count rows. */
void stp_predict_vertices_encode(const stp_chunk *chunk, const stp_table *table);
void stp_predict_vertices_decode(stp_chunk *chunk, const stp_table *table);

/* Levels 0..2. The next coarser level of the chunk must be there. */
void stp_predict_level_encode(const stp_chunk *chunk, int level, const stp_level_tables *tables);
void stp_predict_level_decode(stp_chunk *chunk, int level, const stp_level_tables *tables);

#endif
