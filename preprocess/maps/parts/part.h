/* A part of a surface whose normals keep a cone: what maps are merged from. */
#ifndef STP_PREPROCESS_MAPS_PARTS_PART_H
#define STP_PREPROCESS_MAPS_PARTS_PART_H

#include "preprocess/maps/parts/normal_cone.h"

/* The part of a point that belongs to none. */
#define STP_PART_NONE UINT32_MAX

typedef struct stp_part {
    stp_normal_cone cone;
    vec3s *corners; /* of the hull of its normals (normal_cone.h), owned */
    uint32_t corner_count;
    uint32_t points;
    double area;      /* sum of squared spacings */
    stp_dvec3 facing; /* sum of squared spacings times normals */
} stp_part;

/* Two parts that touch, a < b. */
typedef struct stp_part_pair {
    uint32_t a, b;
} stp_part_pair;

static inline stp_part_pair stp_part_pair_of(uint32_t one, uint32_t other)
{
    return one < other ? (stp_part_pair){one, other} : (stp_part_pair){other, one};
}

/* Sorts pairs and drops repetitions. Returns how many are left. */
size_t stp_part_pairs_sort(stp_part_pair *pairs, size_t count);

/* How much the normals of a part differ from its cone's axis: the integral of |n(x) - axis|^2 over
 * the part. */
static inline double stp_part_error(const stp_normal_cone *cone, double area, stp_dvec3 facing)
{
    return 2.0 * (area - stp_dvec3_dot(facing, cone->axis));
}

#endif
