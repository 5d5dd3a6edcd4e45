/* Walks over the points of a cell whose neighbours are kept. Threads: any, each with its own walk.
 */
#ifndef STP_PREPROCESS_ORIENT_KEPT_WALK_H
#define STP_PREPROCESS_ORIENT_KEPT_WALK_H

#include "preprocess/cloud/nearest_list.h"
#include "preprocess/orient/sheets.h"

/* A walk over a cell's kept points (graph.h), in their order:
 *     for (stp_kept_walk kept = stp_kept_begin(sheets, cell); stp_kept_next(&kept);) */
typedef struct stp_kept_walk {
    const stp_graph *graph;
    const uint8_t *next_list;
    unsigned k;
    uint32_t done;
    uint64_t number_begin, place_begin;

    uint64_t number;                           /* of the kept point, among those of all cells */
    uint64_t self;                             /* its place in the cloud */
    uint64_t neighbours[STP_NEIGHBOURS_LIMIT]; /* places of up to k; then STP_PLACE_NONE */
} stp_kept_walk;

stp_kept_walk stp_kept_begin(const stp_sheets *sheets, size_t cell);
/* Goes to the next kept point; false if there is none. */
bool stp_kept_next(stp_kept_walk *walk);

#endif
