/* What the cut asks about the blocks of one child of a chunk. Threads: children may be asked side
 * by side, once their parents are decided and their parents' patches asked. */
#ifndef STP_RUNTIME_CUT_CUT_ASK_H
#define STP_RUNTIME_CUT_CUT_ASK_H

#include "runtime/cut/culling.h"
#include "runtime/cut/cut.h"

typedef enum stp_cut_answer_kind {
    STP_ANSWER_HIDDEN,   /* out of sight */
    STP_ANSWER_OCCLUDED, /* hidden by the picture that the cut was given */
    STP_ANSWER_LEFT,     /* to what is above */
    STP_ANSWER_WANTED
} stp_cut_answer_kind;

/* The answer about a block. Only a wanted block has more than a kind. */
typedef struct stp_cut_answer {
    stp_cut_answer_kind kind;
    int finest, available; /* the finest level needed, and drawable now (stp_cut_source) */
    float limit;           /* the least of the blocks above (stp_cut_block) */
    float gain;            /* of reading what is missing (stp_miss); INFINITY if nothing is */
    bool drawn;            /* whether a block above is */
    bool missing;          /* whether something must be read */
} stp_cut_answer;

/* A child of a chunk that is drawn or missing. */
typedef struct stp_cut_child {
    uint32_t chunk, parent;
    bool complete;           /* of the parent's visit (runtime/cut/cut.c) */
    bool exact;              /* the parent's patches were asked about each block below */
    bool together;           /* several blocks, wanted together or not at all */
    stp_cut_answer_kind all; /* unless WANTED, the answer about all of its blocks */
} stp_cut_child;

/* The box of a block's patches, relative to the eye. */
stp_occluded stp_cut_box(const stp_block *b, stp_dvec3 origin, stp_dvec3 eye);
stp_rule_bound stp_cut_bound(const stp_block *b, stp_dvec3 origin, stp_dvec3 eye);

/* The finest level that any patch of the block can ask for. */
int stp_cut_finest(const stp_gpu_frame *frame, const stp_rule_sight *sight, const stp_block *b);

/* Lets the patches of a chunk's wanted blocks say which blocks below they need. False if they
 * cannot: some block is not resident, or patches name no blocks. */
bool stp_cut_ask_patches(stp_cut *cut, const stp_cut_params *params, uint32_t chunk);

/* Sets the child's `together` and `all` and, if that is WANTED, cut->answers of its blocks. */
void stp_cut_ask_child(stp_cut *cut, const stp_cut_params *params, stp_cut_child *child);

#endif
