/* The free space of a cloud: a coarse grid of voxels, each voxel's distance to a surface, and rays
 * through the grid.
 *
 * The longest side has at most STP_SPACE_SIDE voxels. Points far out, one in a hundred at either
 * end of each axis, do not widen the grid, and few points of LAS's classes of noise do not count. A
 * voxel with points is solid. Memory: 12 bytes per voxel, at most 17 MB, and 1 MB. Threads: one at
 * a time. */
#ifndef STP_PREPROCESS_VIEWPOINT_FREE_SPACE_H
#define STP_PREPROCESS_VIEWPOINT_FREE_SPACE_H

#include "preprocess/cloud/cloud.h"

#define STP_SPACE_SIDE 112

typedef struct stp_space {
    stp_dbox all; /* of the points that count, as far as a sample of them tells */
    stp_dbox box; /* of these without those far out */
    stp_dvec3 origin;
    double side; /* of a voxel */
    int size[3];
    uint16_t *count;                 /* points, by voxel, x fastest; then level and upright */
    uint16_t *level[3], *upright[3]; /* points whose normal is along an axis (level) or across it
                                        (upright), for axis 1: y and 2: z; NULL for x */
    bool lacks_noise; /* points that their class calls noise do not count, and there are some */
    uint16_t *room;   /* distance to the nearest solid voxel, in voxels times STP_SPACE_ROOM */
} stp_space;

/* stp_space.room counts this many per voxel. */
#define STP_SPACE_ROOM 8.0

/* What a ray hits. */
typedef struct stp_space_hit {
    bool solid;
    double distance; /* to the hit, or to where the ray leaves the grid */
    size_t voxel;
} stp_space_hit;

/* Makes the grid. The cloud has points. station: only this station's points; 0: all points. within:
 * only points in this box; NULL: all. Errors: OUT_OF_MEMORY, and if ranks share the cloud IO,
 * CANCELLED. */
stp_status stp_space_create(stp_space *out, const stp_cloud *cloud, uint16_t station,
                            const stp_dbox *within, stp_error *err);
void stp_space_clear(stp_space *space);

static inline size_t stp_space_at(const stp_space *s, int x, int y, int z)
{
    return ((size_t)z * (size_t)s->size[1] + (size_t)y) * (size_t)s->size[0] + (size_t)x;
}
/* The voxel of a position. False if it is outside the grid. */
bool stp_space_voxel(const stp_space *s, stp_dvec3 position, int at[3]);
/* The middle of a voxel. */
static inline stp_dvec3 stp_space_middle(const stp_space *s, int x, int y, int z)
{
    return stp_dvec3_add(s->origin,
                         stp_dvec3_scale((stp_dvec3){x + 0.5, y + 0.5, z + 0.5}, s->side));
}
/* Casts a ray from a position inside the grid along a unit direction, in steps of half a voxel. */
stp_space_hit stp_space_cast(const stp_space *space, stp_dvec3 from, stp_dvec3 direction);
/* The i-th of count unit directions that are spread evenly. */
stp_dvec3 stp_space_direction(int i, int count);

#endif
