/* The relation of two neighbours' normals: whether their signs agree, and how surely. */
#ifndef STP_PREPROCESS_ORIENT_RELATION_H
#define STP_PREPROCESS_ORIENT_RELATION_H

#include "preprocess/cloud/cloud.h"

/* Ranks: smaller is surer. */
#define STP_RANK_PLAIN 50u   /* below: offset up to an eighth of a spacing, and up to 22 degrees */
#define STP_RANK_SURE 100u   /* below: offset up to a quarter of a spacing, and up to 31 degrees */
#define STP_RANK_SMOOTH 200u /* below: inside a sheet; from here on: across a crease */
#define STP_RANK_NONE 256u   /* unknown */

typedef struct stp_relation {
    uint16_t rank;
    bool turned; /* the normals' own signs disagree */
    bool narrow; /* may lead from one sheet to a parallel one */
    /* Of q over p's plane, and of p over q's; set if the rank is below STP_RANK_SMOOTH. */
    float height_p, height_q;
} stp_relation;

/* Relates two points by their normals' own signs, without marks. */
stp_relation stp_relate(const stp_cloud_point *p, const stp_cloud_point *q);
/* Relates two points with the signs that their marks say. */
stp_relation stp_relate_marked(const stp_cloud *cloud, uint64_t a, uint64_t b);
/* Log odds that both signs agree as they are. The rank must be below STP_RANK_NONE. */
float stp_relation_odds(stp_relation relation);

#endif
