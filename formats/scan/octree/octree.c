/* Finds which nodes of an octree a region needs. */
#include "formats/scan/octree/octree.h"

#include <math.h>

bool stp_octree_key_valid(stp_octree_key key)
{
    return key.depth <= STP_OCTREE_DEPTH_MOST && ((key.x | key.y | key.z) >> key.depth) == 0;
}

bool stp_octree_key_below(stp_octree_key key, stp_octree_key ancestor)
{
    if (key.depth < ancestor.depth)
        return false;
    const uint32_t steps = key.depth - ancestor.depth;
    return key.x >> steps == ancestor.x && key.y >> steps == ancestor.y &&
           key.z >> steps == ancestor.z;
}

int stp_octree_key_compare(const void *a, const void *b)
{
    const stp_octree_key *k = a, *l = b;
    const uint32_t left[4] = {k->depth, k->x, k->y, k->z}, right[4] = {l->depth, l->x, l->y, l->z};
    for (int i = 0; i < 4; i++)
        if (left[i] != right[i])
            return left[i] < right[i] ? -1 : 1;
    return 0;
}

/* The first depth whose spacing is not above the resolution. */
static unsigned last_depth(const stp_octree *octree, double resolution)
{
    unsigned depth = 0;
    while (depth < STP_OCTREE_DEPTH_MOST && ldexp(octree->spacing, -(int)depth) > resolution)
        depth++;
    return depth;
}

bool stp_octree_wants(const stp_octree *octree, const stp_scan_region *region, stp_octree_key key)
{
    const uint32_t place[3] = {key.x, key.y, key.z};
    if (!region)
        return true;
    if (region->resolution > 0.0 && key.depth > last_depth(octree, region->resolution))
        return false;
    for (int axis = 0; axis < 3 && region->bounded; axis++) {
        const double side = ldexp(octree->size[axis], -(int)key.depth);
        const double low = octree->min[axis] + side * place[axis];
        if (low - octree->slack > region->max[axis] ||
            low + side + octree->slack < region->min[axis])
            return false;
    }
    return true;
}

stp_status stp_octree_missing(const char *path, stp_error *err)
{
    return stp_error_set(err, STP_INVALID_ARGUMENT,
                         "%s has no levels of detail, which EPT and COPC have: --resolution cannot "
                         "choose among them; leave it out, or make a COPC file first (untwine, "
                         "PDAL's writers.copc)",
                         path);
}
