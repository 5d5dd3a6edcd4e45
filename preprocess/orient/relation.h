/* What two neighbours' normals say of each other: whether their signs agree, and how surely.
 *
 * Threads: any (pure functions). */
#ifndef STP_PREPROCESS_ORIENT_RELATION_H
#define STP_PREPROCESS_ORIENT_RELATION_H

#include "preprocess/cloud/cloud.h"

/* Ranks: smaller is surer. */
#define STP_RANK_SURE 100u   /* below: up to a quarter of a spacing off and 31 degrees */
#define STP_RANK_SMOOTH 200u /* below: inside a sheet; from here on: across creases */
#define STP_RANK_NONE 256u   /* nothing can be said */

typedef struct stp_relation {
    uint16_t rank;
    bool turned; /* the signs of the normals as they are disagree */
    bool narrow; /* may lead from a sheet to one parallel to it */
} stp_relation;

/* Of their normals as they are, without marks. */
stp_relation stp_relate(const stp_cloud_point *p, const stp_cloud_point *q);
/* With the signs their marks say. */
stp_relation stp_relate_marked(const stp_cloud *cloud, uint32_t a, uint32_t b);
/* Logarithm of the odds that the signs of both agree as they are, of a rank below STP_RANK_NONE. */
float stp_relation_odds(stp_relation relation);

#endif
