/* The chunk tree: leaf chunks from cells, lines and triangles, and parents from their children's
 * patch vertices. */
#ifndef STP_PREPROCESS_TREE_TREE_H
#define STP_PREPROCESS_TREE_TREE_H

#include "base/progress.h"
#include "formats/attribute/attribute.h"
#include "formats/chunk/chunk_file.h"
#include "preprocess/cloud/cloud.h"
#include "preprocess/patch/displacement.h"
#include "preprocess/patch/point_item.h"
#include "preprocess/ranks/ranks.h"
#include "preprocess/tree/leaf_order.h"

/* The attributes of the inputs' points that a model keeps. */
typedef struct stp_point_numbers {
    const stp_attribute_list *list;
    uint64_t first;         /* the first record that is here */
    const uint8_t *packed;  /* by record from there on: stp_attribute_list_bytes each */
    const uint64_t *begins; /* by rank: the first record that it has; then where the last one's end.
                               NULL: each process has all */
} stp_point_numbers;

typedef struct stp_tree_params {
    double lambda;                    /* radius of a sample over its spacing */
    uint16_t intensity_max;           /* 255 in the file stands for it, and for what is more */
    stp_resolution resolution;        /* of the inputs */
    unsigned normal_bits, given_bits; /* of the grids of normals, see point_item.h */
    unsigned normal_step;             /* likewise */
    stp_codec codec;
    stp_leaf_sources sources;  /* borrowed */
    stp_point_numbers numbers; /* borrowed; list NULL: no attributes */
    stp_ranks *ranks;          /* that share the work, borrowed; NULL: this process alone */
} stp_tree_params;

typedef struct stp_tree_stats {
    uint32_t chunk_count;
    uint64_t patch_count;
    uint64_t file_bytes;
    stp_displacement displacement; /* of points only, not of lines and triangles */
} stp_tree_stats;

/* Makes the file's metadata when all chunks are written. Returns NULL if out of memory. Free with
 * free(). `stats` lacks file_bytes. */
typedef char *stp_metadata_maker(void *context, const stp_tree_stats *stats);

/* How points become items of leaves. box: the model's. A chunk of any tier is at most as wide as
 * the box, which gives vertex_least. */
stp_point_item_params stp_tree_item_params(const stp_tree_params *params, const stp_dbox *box);

/* Builds all chunks, appends them to the writer and finishes it (*writer becomes NULL in any case).
 * *writer is NULL on ranks other than 0, which write their payloads into the same file
 * (tier_file.h). Uses up the cloud: its points may be lost. The cloud may be empty if there are
 * other sources of leaves. Chunks are built on the pool and written in order: the same bytes for
 * any number of threads. Errors: those of stp_chunk_build and the writer, CANCELLED. */
stp_status stp_tree_write(stp_chunk_writer **writer, stp_cloud *cloud,
                          const stp_tree_params *params, stp_metadata_maker *metadata,
                          void *context, stp_pool *pool, const stp_progress *progress,
                          stp_tree_stats *stats, stp_error *err);

#endif
