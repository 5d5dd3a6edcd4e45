/* Tells whether two parts together are a height field over the axis of their cone, before they are
 * merged. Parts that fold over each other, or that are beside each other at unequal heights, are
 * none:
 *
 *        ____             the axis goes up; seen from above, b lies over a. Their normals may
 *       b    \            keep one cone, for what turns over is of another part.
 *      ______/
 *     a
 *
 * All points are put on a grid over the plane, each with its height, moved along its tangent plane
 * to the middle of its square. Heights in a square, and the means of squares beside each other, may
 * differ by no more than those of neighbours in a map (map_make.h). That is not exact; what is no
 * height field after all is halved later (map_try.h). Threads: one. */
#ifndef STP_PREPROCESS_MAPS_PART_FIELD_H
#define STP_PREPROCESS_MAPS_PART_FIELD_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/maps/part.h"

typedef struct stp_part_field {
    const stp_cloud *cloud;
    double cone_rad;       /* that all cones keep */
    uint32_t *places;      /* in the cloud, part after part; in the cloud's spill */
    uint32_t *begins;      /* by part: where its places begin; then their number */
    uint32_t *next, *last; /* by part: the next that it was merged with; the last of them */
    struct stp_field_square *squares; /* of the grid */
    size_t capacity;
} stp_part_field;

/* numbers: by place in the cloud, the point's part, or STP_PART_NONE; read here only. Errors:
 * OUT_OF_MEMORY, IO. Free with stp_part_field_clear. */
stp_status stp_part_field_create(stp_part_field *out, const stp_cloud *cloud,
                                 const uint32_t *numbers, uint32_t part_count, double cone_rad,
                                 stp_error *err);
void stp_part_field_clear(stp_part_field *field);
/* Whether a and b, each with what it was joined with, are one height field over the cone's axis.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_part_field_fits(stp_part_field *field, uint32_t a, uint32_t b,
                               const stp_normal_cone *cone, bool *fits, stp_error *err);
/* Joins b to a. */
void stp_part_field_join(stp_part_field *field, uint32_t a, uint32_t b);

#endif
