/* Sorts a cloud's points along the Morton curve and cuts the order into cells. Threads: one
 * builder. */
#ifndef STP_PREPROCESS_CLOUD_CLOUD_CELLS_H
#define STP_PREPROCESS_CLOUD_CLOUD_CELLS_H

#include "preprocess/cloud/cloud.h"

/* Makes room for `capacity` points; places and records are numbered from `first` on; the cloud is
 * empty. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_cloud_create(stp_cloud *out, uint64_t first, uint64_t capacity, stp_spill *spill,
                            stp_error *err);
/* Sorts the points along the Morton curve of their bounding cube (ties by coordinates, then by
 * source), cuts the order into cells, and allocates the arrays by point. Errors: OUT_OF_MEMORY, IO.
 */
stp_status stp_cloud_sort(stp_cloud *cloud, stp_pool *pool, stp_error *err);
/* Cuts points, which are sorted, into cells, and allocates the arrays by point: the end of
 * stp_cloud_sort. Errors: likewise. */
stp_status stp_cloud_arrange(stp_cloud *cloud, stp_pool *pool, stp_error *err);
/* Finds the boxes of cells that were cut. If ranks share the cloud, each then owns whole cells.
 * Errors: OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_cloud_settle_cells(stp_cloud *cloud, stp_pool *pool, stp_error *err);
/* Cuts a run of points, which follow the Morton curve of the cloud's box, into cells behind those
 * that there are. Errors: OUT_OF_MEMORY, IO. */
stp_status stp_cloud_cut(stp_cloud *cloud, uint64_t begin, uint64_t end, stp_error *err);
/* Frees what the sort made. The points may then change and be sorted again. */
void stp_cloud_unsort(stp_cloud *cloud);
/* Gives back the disk space of a cell's points, sheets and marks, which nobody needs any more. */
void stp_cloud_forget(stp_cloud *cloud, const stp_cell *cell);
/* Frees what the cloud owns. */
void stp_cloud_clear(stp_cloud *cloud);

#endif
