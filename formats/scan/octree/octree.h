/* Octrees of points: the names of their nodes, and which nodes a region needs.
 *
 * A node is a cube. The root has depth 0; a node at depth d has a side of (root's side) / 2^d and
 * points that are (root's spacing) / 2^d apart. A point is in one node alone: the points of a node
 * are not those of its ancestors. EPT and COPC agree on all of this. Threads: any. */
#ifndef STP_FORMATS_SCAN_OCTREE_OCTREE_H
#define STP_FORMATS_SCAN_OCTREE_OCTREE_H

#include "formats/scan/scan.h"

/* Places at greater depths do not fit 32 bits. */
#define STP_OCTREE_DEPTH_MOST 30u
/* More nodes are no set of points that a model could hold. */
#define STP_OCTREE_NODES_MOST ((size_t)1 << 23)

/* x, y and z are below 2^depth. */
typedef struct stp_octree_key {
    uint32_t depth, x, y, z;
} stp_octree_key;

typedef struct stp_octree {
    double min[3], size[3]; /* the root's cube */
    double spacing;         /* of the root's points */
    double slack;           /* rounding may move points out of their node by this much */
} stp_octree;

/* Whether x, y and z are below 2^depth, and depth is not above STP_OCTREE_DEPTH_MOST. */
bool stp_octree_key_valid(stp_octree_key key);
/* Whether a key is the ancestor's or below it. */
bool stp_octree_key_below(stp_octree_key key, stp_octree_key ancestor);
/* For qsort: by depth, then by x, y and z. */
int stp_octree_key_compare(const void *a, const void *b);
/* Whether a node may have points of the region. region NULL: all of them. */
bool stp_octree_wants(const stp_octree *octree, const stp_scan_region *region, stp_octree_key key);

/* Whether the region has the position; NaN is in it. region NULL: every position. */
static inline bool stp_scan_region_has(const stp_scan_region *region, stp_dvec3 p)
{
    return !region || !region->bounded ||
           !(p.x < region->min[0] || p.x > region->max[0] || p.y < region->min[1] ||
             p.y > region->max[1] || p.z < region->min[2] || p.z > region->max[2]);
}

/* Says that a scan without levels cannot be read at a resolution. Returns INVALID_ARGUMENT. */
stp_status stp_octree_missing(const char *path, stp_error *err);

#endif
