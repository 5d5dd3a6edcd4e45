/* Where a cloud leaves room: a coarse grid of voxels over it, how far each is from a surface, and
 * rays through it.
 *
 * At most STP_SPACE_SIDE voxels along the longest side; points far out, one in a hundred at either
 * end of each axis, do not widen it. A voxel with points is solid. Memory: 12 bytes a voxel, at
 * most 17 MB, and 1 MB. Threads: one at a time. */
#ifndef STP_PREPROCESS_VIEWPOINT_FREE_SPACE_H
#define STP_PREPROCESS_VIEWPOINT_FREE_SPACE_H

#include "preprocess/cloud/cloud.h"

#define STP_SPACE_SIDE 112

typedef struct stp_space {
    stp_dbox box; /* of the points, but for those far out */
    stp_dvec3 origin;
    double side; /* of a voxel */
    int size[3];
    uint16_t *count;                 /* of points, by voxel, x fastest */
    uint16_t *level[3], *upright[3]; /* of those whose normal is along an axis (1: y, 2: z), or
                                        across it; of x: NULL */
    uint16_t *room;                  /* voxels to the nearest solid one, times STP_SPACE_ROOM */
} stp_space;

/* Unit of stp_space.room. */
#define STP_SPACE_ROOM 8.0

/* What a ray meets. */
typedef struct stp_space_hit {
    bool solid;
    double distance; /* to it, or to where the ray leaves the grid */
    size_t voxel;
} stp_space_hit;

/* The cloud has points. station: of all points (0) or of one station's. Errors: OUT_OF_MEMORY. */
stp_status stp_space_create(stp_space *out, const stp_cloud *cloud, uint16_t station,
                            stp_error *err);
void stp_space_clear(stp_space *space);

static inline size_t stp_space_at(const stp_space *s, int x, int y, int z)
{
    return ((size_t)z * (size_t)s->size[1] + (size_t)y) * (size_t)s->size[0] + (size_t)x;
}
/* The middle of a voxel. */
static inline stp_dvec3 stp_space_middle(const stp_space *s, int x, int y, int z)
{
    return stp_dvec3_add(s->origin,
                         stp_dvec3_scale((stp_dvec3){x + 0.5, y + 0.5, z + 0.5}, s->side));
}
/* From a position inside the grid along a unit direction, in steps of half a voxel. */
stp_space_hit stp_space_cast(const stp_space *space, stp_dvec3 from, stp_dvec3 direction);
/* The i-th of count unit directions, evenly around. */
stp_dvec3 stp_space_direction(int i, int count);

#endif
