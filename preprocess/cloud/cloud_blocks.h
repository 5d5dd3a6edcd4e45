/* The points of a cloud that ranks share.
 *
 * Each rank owns a run of the points: whole cells, once there are cells. The arrays by point are
 * sparse (spill.h) and as long as for all points, so that a place means the same point on every
 * rank. Points of others come from their owners in blocks of STP_BLOCK_POINTS:
 *
 *     every rank:  stp_cloud_has(cloud, i), for all points it needs    notes blocks that are away
 *     all ranks:   stp_cloud_fetch                                     copies them from their
 * owners
 *                  ... stp_cloud_refresh, if the owners changed them ...
 *     every rank:  stp_cloud_let_go
 *
 * If the cloud has no blocks, each process has all points: it owns them, and nothing is fetched.
 * Threads: any number may call stp_cloud_has; the rest is for the main thread, and what exchanges
 * something must be called by all ranks. Errors of that: OUT_OF_MEMORY, IO, CANCELLED. */
#ifndef STP_PREPROCESS_CLOUD_CLOUD_BLOCKS_H
#define STP_PREPROCESS_CLOUD_CLOUD_BLOCKS_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/ranks/ranks.h"

#include <stdatomic.h>

/* Points of a block: their bytes, of any array by point, are whole pages. */
#define STP_BLOCK_POINTS 4096u

/* Arrays by point. */
#define STP_ARRAY_POINTS 1u
#define STP_ARRAY_SHEETS 2u
#define STP_ARRAY_MARKS 4u
#define STP_ARRAY_NUMBERS 8u

typedef enum stp_block_state {
    STP_BLOCK_AWAY = 0, /* points of others are not here */
    STP_BLOCK_WANTED,
    STP_BLOCK_HERE, /* copied from the owners */
    STP_BLOCK_OWN
} stp_block_state;

typedef struct stp_cloud_blocks {
    stp_ranks *ranks; /* borrowed */
    uint64_t *begins; /* by rank: where its run begins; then where the last one ends */
    uint32_t count;
    atomic_uchar *states; /* by block: stp_block_state */
    uint32_t *numbers;    /* an array by point of a stage, which comes with points that are fetched;
                             borrowed; NULL: none */
} stp_cloud_blocks;

/* Shares a cloud of `count` points: rank r owns those from begins[r] on. Takes begins, also after a
 * failure. The arrays by point are made next. Errors: OUT_OF_MEMORY. */
stp_status stp_cloud_share(stp_cloud *cloud, uint64_t count, uint64_t *begins, stp_ranks *ranks,
                           stp_error *err);
/* Lets ranks own other runs, from begins[r] on. What a rank gets must be here. */
void stp_cloud_move_runs(stp_cloud *cloud, const uint64_t *begins);
/* Frees the blocks, not the arrays. */
void stp_cloud_blocks_destroy(stp_cloud_blocks *blocks);

/* Makes an array by point, zeroed; only own points may be touched as long as others are not
 * fetched. */
stp_status stp_cloud_array(const stp_cloud *cloud, void *out, size_t size, const char *what,
                           stp_error *err);

bool stp_cloud_ask(const stp_cloud *cloud, uint64_t i);
/* Whether point i is here. If not, its block is wanted, and *cloud->missed becomes true. */
static inline bool stp_cloud_has(const stp_cloud *cloud, uint64_t i)
{
    return !cloud->blocks || stp_cloud_ask(cloud, i);
}

/* The points that this process owns, and their cells. */
stp_rank_part stp_cloud_own(const stp_cloud *cloud);
stp_rank_part stp_cloud_own_cells(const stp_cloud *cloud);
/* About 1/N of the points, for rank r, if every rank has all. */
stp_rank_part stp_cloud_part(const stp_cloud *cloud, const stp_ranks *ranks, unsigned rank);
/* The cells of rank r: of its run or, if every rank has all points, of stp_cloud_part. */
stp_rank_part stp_cloud_cells(const stp_cloud *cloud, const stp_ranks *ranks, unsigned rank);

/* Puts the lists of cells that ranks made, each of its own, into one. */
stp_status stp_cloud_join_cells(const stp_cloud *cloud, stp_cell **cells, uint32_t *count,
                                stp_error *err);

/* Copies wanted blocks from their owners, all arrays. */
stp_status stp_cloud_fetch(stp_cloud *cloud, stp_error *err);
/* Copies arrays, STP_ARRAY_*, of the fetched blocks once more. */
stp_status stp_cloud_refresh(stp_cloud *cloud, unsigned arrays, stp_error *err);
/* Forgets all blocks that are not own. */
void stp_cloud_let_go(stp_cloud *cloud);

/* Adds up numbers over the points: each rank has added those of its own. */
stp_status stp_cloud_sum(const stp_cloud *cloud, uint64_t *numbers, size_t count, stp_error *err);
/* Adds up something whose order matters, in the order of the points: add(context) adds this
 * process's own points to data. One rank after the other does it; then every rank has the whole. */
stp_status stp_cloud_in_turn(const stp_cloud *cloud, void (*add)(void *), void *context, void *data,
                             size_t bytes, stp_error *err);
/* Lists the first point and every stride-th after it on every rank. Free with free(). */
stp_status stp_cloud_every(const stp_cloud *cloud, uint64_t stride, stp_cloud_point **out,
                           uint32_t *count, stp_error *err);

#endif
