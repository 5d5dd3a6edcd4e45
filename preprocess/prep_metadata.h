/* What a chunk file says of its making.
 * Threads: any. */
#ifndef STP_PREPROCESS_PREP_METADATA_H
#define STP_PREPROCESS_PREP_METADATA_H

#include "formats/chunk/outside.h"
#include "preprocess/prep.h"

/* What metadata is made of. */
typedef struct stp_prep_facts {
    const stp_prep_source *source;
    const stp_prep_stats *stats;
    const stp_dvec3 *stations;
    const stp_outside *outside;
    unsigned k;
    double lambda;
    bool unlit;
} stp_prep_facts;

/* The metadata, to free with free(); NULL: no memory. No dates and no folders are in it, so that
 * equal runs give equal bytes. context: stp_prep_facts. The form of stp_tree_write's callback. */
char *stp_prep_metadata(void *context, const stp_tree_stats *tree);

#endif
