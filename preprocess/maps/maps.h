/* The elevation maps of a cloud's surface, and what is counted of them. */
#ifndef STP_PREPROCESS_MAPS_MAPS_H
#define STP_PREPROCESS_MAPS_MAPS_H

#include "formats/scan/mesh/mesh.h"
#include "preprocess/cloud/cloud.h"
#include "preprocess/gaps/map_fill.h"
#include "preprocess/ranks/ranks.h"

#define STP_MAP_POINTS_LEAST 32u
#define STP_MAP_OFF_MOST 0.05

typedef struct stp_maps_params {
    double cone_deg; /* greatest angle between a map's axis and a normal, 10 to 80 */
    double error;    /* farthest that a point may be from its map, world units; 0: by the spacing */
    bool fill;       /* trim the maps, and fill what is between them (map_trim.h, map_fill.h) */
    bool paper;      /* they are stored by STP_CODEC_PAPER; the file must be of format 2 */
    const stp_mesh *mesh; /* whose triangles are the surface where they are near; borrowed; NULL:
                             the points alone tell the surface */
} stp_maps_params;

typedef struct stp_maps_counts {
    uint64_t maps, samples;
    uint64_t represented; /* points that maps stand for */
    uint64_t as_points;   /* points that stay */
    uint64_t between;     /* triangles that fill the gaps between maps */
    uint64_t open_edges;  /* of cells and these triangles, that have one triangle */
    double greatest, sum; /* of the distances of represented points from their maps' surfaces */
} stp_maps_counts;

typedef struct stp_maps {
    stp_map *maps;
    uint32_t count;
    stp_dbox box; /* of all samples, world */
    stp_maps_counts counts;
    stp_map_fill fill; /* empty unless it is wanted */
    bool paper;        /* as the parameters say */
    stp_spill *spill;  /* where samples lie, borrowed */
    stp_ranks *ranks;  /* each has the samples of its maps; borrowed; NULL: all are here */
    uint64_t *firsts;  /* by rank: its first map; then the number of maps; NULL without ranks */
} stp_maps;

/* Counts a point that a map stands for. */
static inline void stp_maps_counts_add(stp_maps_counts *counts, double distance)
{
    counts->represented++;
    counts->greatest = stp_max(counts->greatest, distance);
    counts->sum += distance;
}

/* The mean distance of represented points from their maps; 0 if there are none. */
static inline double stp_maps_mean(const stp_maps_counts *counts)
{
    return counts->represented > 0 ? counts->sum / (double)counts->represented : 0.0;
}

#endif
