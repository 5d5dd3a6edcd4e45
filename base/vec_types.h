/* Positions, directions and boxes of the world, in double: georeferenced scans keep their
 * millimetres. base/vec.h computes with them. */
#ifndef STP_BASE_VEC_TYPES_H
#define STP_BASE_VEC_TYPES_H

typedef struct stp_dvec3 {
    double x, y, z;
} stp_dvec3;

/* Empty when min > max on any axis. */
typedef struct stp_dbox {
    stp_dvec3 min, max;
} stp_dbox;

#endif
