/* Plans what becomes of each chunk of a damaged file.
 *
 * Memory: some bytes a chunk. Threads: one. */
#ifndef STP_FORMATS_CHUNK_REPAIR_REPAIR_PLAN_H
#define STP_FORMATS_CHUNK_REPAIR_REPAIR_PLAN_H

#include "formats/chunk/repair/damaged.h"

typedef enum stp_fate {
    STP_FATE_GONE,   /* not in the output: neither the chunk nor its parent can be read */
    STP_FATE_KEPT,   /* the payload is copied, unless its errors are raised */
    STP_FATE_COARSE, /* a leaf built from the levels that are left */
    STP_FATE_PARENT, /* a leaf built from what its parent shows in its place */
    STP_FATE_REBUILT /* an inner chunk built from its children */
} stp_fate;

typedef struct stp_repair_node {
    stp_fate fate;
    uint32_t parent; /* STP_CHUNK_NONE for the root, and if nothing tells the parent */
    uint32_t depth;
    uint32_t child_count; /* children that are not gone */
    uint32_t child_index; /* its place among its parent's children in the damaged file */
    stp_chunk *chunk;     /* replaces the payload; NULL: nothing does */
    stp_dvec3 origin;
    stp_carry *carry;           /* of a rebuilt chunk, by level-0 sample */
    bool raised;                /* kept, but some errors are raised */
    uint32_t id;                /* in the output */
    uint64_t points, stand_ins; /* under it in the output */
} stp_repair_node;

typedef struct stp_repair_plan {
    const stp_damaged *damaged;
    uint32_t count;         /* of nodes: chunks of the damaged file */
    uint32_t depth;         /* levels of the tree */
    stp_repair_node *nodes; /* by id */
    stp_chunk_boxes boxes;  /* by id; of a chunk that is gone: empty */
    size_t replaced_bytes;
} stp_repair_plan;

/* Errors: OUT_OF_MEMORY; CORRUPT: not even the root can be shown. */
stp_status stp_repair_plan_make(stp_repair_plan *out, const stp_damaged *d, stp_error *err);
void stp_repair_plan_clear(stp_repair_plan *plan);

#endif
