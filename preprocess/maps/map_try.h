/* Makes one or more maps of a merged part, by halving it until each half is a height field.
 * Threads: any, a part each. */
#ifndef STP_PREPROCESS_MAPS_MAP_TRY_H
#define STP_PREPROCESS_MAPS_MAP_TRY_H

#include "preprocess/maps/face_tree.h"
#include "preprocess/maps/maps.h"
#include "preprocess/maps/parts/part.h"

/* A point of no part that a map can stand for. */
typedef struct stp_map_guest {
    uint32_t place;
    uint32_t list;   /* number of the merged part, set by the caller */
    double distance; /* from the map's surface */
} stp_map_guest;

/* The maps of one merged part. */
typedef struct stp_map_list {
    stp_map *maps;
    size_t count, capacity;
    stp_map_guest *guests;
    size_t guest_count, guest_capacity;
    stp_maps_counts counts; /* of samples and points, without guests */
    stp_dbox box;           /* of all samples; empty without maps */
} stp_map_list;

/* Makes the maps of the points at `count` places, ascending; reorders them. Sets taken[i] if a map
 * stands for the point at places[i]. faces: of meshes; NULL: there are none. parts: by place in the
 * cloud; a point of no part has STP_PART_NONE. If ranks share the cloud and *cloud->missed becomes
 * true, nothing is made: try again when the points are here. Errors: OUT_OF_MEMORY, IO. Free with
 * stp_map_list_clear. */
stp_status stp_map_list_make(stp_map_list *out, const stp_cloud *cloud,
                             const stp_maps_params *params, const stp_face_tree *faces,
                             const uint32_t *parts, uint32_t *places, bool *taken, uint32_t count,
                             stp_error *err);
/* How far a point may be from the map that stands for it. */
double stp_map_limit(const stp_cloud *cloud, const stp_maps_params *params, uint32_t place);
void stp_map_list_clear(stp_map_list *list, stp_spill *spill);

#endif
