/* One run of appending, as its parts share it. */
#ifndef STP_PREPROCESS_APPEND_APPEND_JOB_H
#define STP_PREPROCESS_APPEND_APPEND_JOB_H

#include "base/file.h"
#include "formats/chunk/block/block.h"
#include "formats/chunk/measure/chunk_boxes.h"
#include "preprocess/append/append.h"
#include "preprocess/patch/item.h"
#include "preprocess/prep_job.h"

/* In place of the leaf that a point joins. */
#define STP_LEAF_FREE UINT32_MAX          /* none is near: a leaf of its own */
#define STP_LEAF_CONTEXT (UINT32_MAX - 1) /* the point stays in its leaf, and is only looked at */

/* What a stored sample has besides its place and colours. */
typedef struct stp_old_point {
    double radius;
    int16_t exponent; /* of the lattice that its position lies on */
    uint8_t normal[3], flags;
    uint8_t class_id, intensity;
} stp_old_point;

typedef struct stp_append {
    stp_prep_job job;
    stp_append_result *result;
    stp_output *output; /* the model, locked */
    stp_chunk_file *file;
    const stp_chunk_file_info *info;
    stp_chunk_entry *entries;        /* of the file, by id */
    uint32_t first_leaf, leaf_count; /* the leaves are the chunks from first_leaf on */
    bool *touched;                   /* by leaf */
    /* Sources below read_count are new points; then old points, then context. */
    uint32_t read_count;
    uint32_t *leaf_of;  /* by source, in the spill: the leaf that the point joins, or STP_LEAF_* */
    stp_old_point *old; /* by source - read_count, in the spill */
    stp_spill *read_spill; /* of the new points as they were read; NULL when they are copied */
    uint32_t *cell_leaf;   /* by cell: the leaf that its points join, or STP_LEAF_FREE */
} stp_append;

static inline const stp_chunk_entry *stp_append_leaf(const stp_append *a, uint32_t leaf)
{
    return &a->entries[a->first_leaf + leaf];
}

/* The blocks of a leaf. Free with free(). Errors: as stp_chunk_file_blocks, OUT_OF_MEMORY. */
stp_status stp_append_blocks(const stp_append *a, uint32_t leaf, stp_block **out, uint32_t *count,
                             stp_error *err);
/* Finds which leaf each new point joins, and which leaves the new points touch: those that have a
 * disc near one of them. The only leaf of a model is always touched. Errors: OUT_OF_MEMORY, IO,
 * CORRUPT. */
stp_status stp_append_find(stp_append *a, stp_error *err);
/* Makes the cloud: the new points, the points of touched leaves, and points around these. Errors:
 * likewise, LIMIT. */
stp_status stp_append_gather(stp_append *a, stp_error *err);
/* Gives new points the signs that old points of the same sheets have. guessed: signs that the
 * points have so far are guesses. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_append_sign(stp_append *a, bool guessed, stp_error *err);
/* Leaves out the context, orders the points by the leaves that they join, and cuts these into
 * cells. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_append_cut(stp_append *a, stp_error *err);
/* Makes an item of each point of a cell; old points stay as they are. */
void stp_append_items(const stp_append *a, stp_item *items, uint32_t begin, uint32_t count,
                      const stp_point_item_params *params);
/* Builds the new chunks and writes all. Errors: those of stp_tree_write. */
stp_status stp_append_write(stp_append *a, stp_error *err);
/* The model's metadata with those of the source. Returns NULL if out of memory. Free with free().
 */
char *stp_append_metadata(const stp_append *a, const stp_tree_stats *tree);
/* Why points cannot be added to a model with such metadata, or NULL. */
const char *stp_append_refusal(const stp_chunk_file_info *info);
/* A number of the model's metadata; 0 if it is not there. */
double stp_append_noted(const stp_append *a, const char *key);

#endif
