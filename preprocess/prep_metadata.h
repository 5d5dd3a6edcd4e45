/* The metadata of a chunk file: what it says about its making. Threads: any. */
#ifndef STP_PREPROCESS_PREP_METADATA_H
#define STP_PREPROCESS_PREP_METADATA_H

#include "formats/chunk/outside.h"
#include "preprocess/prep.h"

/* The facts that the metadata is made from. */
typedef struct stp_prep_facts {
    const stp_prep_source *source;
    const stp_prep_stats *stats;
    const stp_dvec3 *stations;
    const stp_outside *outside;
    unsigned k;
    double lambda;
    double cone_deg; /* of maps */
    bool unlit;
} stp_prep_facts;

/* Makes the metadata. Free with free(). Returns NULL if out of memory. It has no dates and no
 * folders, so equal runs give equal bytes. context: stp_prep_facts. This is an stp_metadata_maker
 * (stp_tree_write's callback). */
char *stp_prep_metadata(void *context, const stp_tree_stats *tree);

#endif
