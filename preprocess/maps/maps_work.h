/* What maps are made of, from the cut to the maps. A *list* is a merged part that is large enough,
 * and the maps that are made of it.
 *
 * If ranks share the cloud, each cuts its own cells, and merges the parts of each cell. All know
 * the parts that are left, without points, and merge them alike; the rank that has the first point
 * of a merged part makes its maps, with copies of points of others, and keeps their samples. What
 * it finds about points goes back to those who have them. */
#ifndef STP_PREPROCESS_MAPS_MAPS_WORK_H
#define STP_PREPROCESS_MAPS_MAPS_WORK_H

#include "preprocess/cloud/cloud_blocks.h"
#include "preprocess/maps/map_try.h"
#include "preprocess/maps/parts/part_cut.h"

#include <stdatomic.h>

typedef struct stp_maps_work {
    stp_cloud *cloud;
    stp_ranks *ranks; /* that share the cloud; NULL: all points are here */
    const stp_maps_params *params;
    const stp_progress *progress;
    stp_face_tree faces;
    double cut_cosine; /* of the cone that parts keep before they are merged */
    stp_cell_parts *cells;
    uint32_t cell_count;   /* before points leave the cloud, and cells with them */
    bool *done;            /* by cell, then by list */
    uint32_t *cell_first;  /* by cell: the number of its first part among all */
    uint64_t *part_firsts; /* by rank: its first part; then the number of parts */
    uint32_t part_count;
    stp_part *parts;   /* of all cells */
    uint32_t *numbers; /* by point: its part in its cell, then among all, then its list */
    bool *mapped;      /* by own point: a map stands for it */
    uint32_t list_count;
    uint64_t *list_firsts; /* by rank: its first list; then the number of lists */
    stp_rank_part own;     /* lists of this rank */
    uint32_t *begins;      /* by list: where its places begin among all; then their number */
    uint32_t *places;      /* of own lists, list after list */
    bool *taken;           /* by these places: a map stands for the point */
    uint32_t *map_first;   /* by list: its first map; then the number of maps */
    stp_map_list *lists;
    atomic_uint_fast64_t done_points; /* of twice as many: cut, then sampled */
} stp_maps_work;

/* Numbers the lists in the order of their first points, and the points by them; those of other
 * parts are of none. roots: by part, what it was merged into. Errors: OUT_OF_MEMORY. */
stp_status stp_maps_number_lists(stp_maps_work *w, const uint32_t *roots, stp_error *err);
/* Finds the places of own lists. Errors: OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_maps_find_places(stp_maps_work *w, stp_error *err);
/* Marks the points that own lists have taken as mapped, whoever has them. Errors: likewise. */
stp_status stp_maps_mark_taken(stp_maps_work *w, stp_error *err);
/* Gives each guest to the map that it is nearest to, and numbers it as that map's points. Errors:
 * likewise. */
stp_status stp_maps_settle_guests(stp_maps_work *w, stp_error *err);
/* Removes the points that maps stand for from the cloud. Cells that have become small are joined.
 * Errors: likewise. */
stp_status stp_maps_keep_others(stp_maps_work *w, stp_pool *pool, stp_error *err);

/* The places of an own list. */
static inline size_t stp_maps_place_begin(const stp_maps_work *w, uint32_t list)
{
    return w->begins[list] - w->begins[w->own.begin];
}

#endif
