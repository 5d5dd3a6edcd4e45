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
 * height field after all is halved later (map_try.h).
 *
 * If ranks share the cloud, the rank that has a part's first point judges the part. It gets copies
 * of the parts of other ranks that it needs, once each. Threads: one. */
#ifndef STP_PREPROCESS_MAPS_PARTS_PART_FIELD_H
#define STP_PREPROCESS_MAPS_PARTS_PART_FIELD_H

#include "preprocess/cloud/cloud.h"
#include "preprocess/maps/parts/part.h"
#include "preprocess/ranks/ranks.h"

/* What the field needs of a point. */
typedef struct stp_part_point {
    stp_dvec3 position;
    vec3s normal; /* with its sign */
    float spacing;
} stp_part_point;

/* A part of another rank. */
typedef struct stp_part_copy {
    stp_part_point *points; /* NULL: not here */
    uint32_t count;
} stp_part_copy;

typedef struct stp_part_field {
    const stp_cloud *cloud;
    double cone_rad;        /* that all cones keep */
    uint32_t part_count;    /* of all ranks */
    uint32_t *places;       /* of own points, part after part; in the cloud's spill */
    uint32_t *begins;       /* by part: where its places begin; then their number */
    uint32_t *next, *last;  /* by part: the next that it was merged with; the last of them */
    stp_part_copy *copies;  /* by part; NULL: no ranks share the cloud */
    const uint64_t *firsts; /* by rank: its first part; then the number of parts; borrowed */
    struct stp_field_square *squares; /* of the grid */
    size_t capacity;
    uint64_t seen_points; /* so far */
} stp_part_field;

/* A pair of parts, each with what it was joined with, and the cone of both. */
typedef struct stp_part_question {
    uint32_t a, b; /* a < b */
    stp_normal_cone cone;
    bool fits; /* the answer */
} stp_part_question;

/* points: the places of the parts' points. numbers: by place in the cloud, the point's part, or
 * STP_PART_NONE; read here only. firsts: NULL unless ranks share the parts. Errors: OUT_OF_MEMORY,
 * IO. Free with stp_part_field_clear. */
stp_status stp_part_field_create(stp_part_field *out, const stp_cloud *cloud, stp_rank_part points,
                                 const uint32_t *numbers, uint32_t part_count,
                                 const uint64_t *firsts, double cone_rad, stp_error *err);
void stp_part_field_clear(stp_part_field *field);
/* Answers questions: all ranks ask the same ones. Errors: OUT_OF_MEMORY, IO, CANCELLED. */
stp_status stp_part_field_ask(stp_part_field *field, stp_part_question *questions, uint32_t count,
                              stp_error *err);
/* Whether a and b, each with what it was joined with, are one height field over the cone's axis.
 * Errors: OUT_OF_MEMORY. */
stp_status stp_part_field_fits(stp_part_field *field, uint32_t a, uint32_t b,
                               const stp_normal_cone *cone, bool *fits, stp_error *err);
/* What the field needs of a point of the cloud. */
stp_part_point stp_part_field_point(const stp_part_field *field, uint32_t place);
/* Joins b to a. */
void stp_part_field_join(stp_part_field *field, uint32_t a, uint32_t b);

#endif
