/* The points on a disc's rim that stand for it: every eighth of pi, from its first axis on. */
#ifndef STP_FORMATS_CHUNK_MEASURE_RIM_H
#define STP_FORMATS_CHUNK_MEASURE_RIM_H

#define STP_RIM_POINTS 16

#define STP_RIM_COS_1 0.92387953251128674 /* of an eighth of pi */
#define STP_RIM_SIN_1 0.38268343236508977
#define STP_RIM_COS_2 0.70710678118654752 /* of a quarter of pi */

/* Along the first and the second axis, in radii. */
static const double stp_rim[2][STP_RIM_POINTS] = {
    {1.0, STP_RIM_COS_1, STP_RIM_COS_2, STP_RIM_SIN_1, 0.0, -STP_RIM_SIN_1, -STP_RIM_COS_2,
     -STP_RIM_COS_1, -1.0, -STP_RIM_COS_1, -STP_RIM_COS_2, -STP_RIM_SIN_1, 0.0, STP_RIM_SIN_1,
     STP_RIM_COS_2, STP_RIM_COS_1},
    {0.0, STP_RIM_SIN_1, STP_RIM_COS_2, STP_RIM_COS_1, 1.0, STP_RIM_COS_1, STP_RIM_COS_2,
     STP_RIM_SIN_1, 0.0, -STP_RIM_SIN_1, -STP_RIM_COS_2, -STP_RIM_COS_1, -1.0, -STP_RIM_COS_1,
     -STP_RIM_COS_2, -STP_RIM_SIN_1}};

#endif
