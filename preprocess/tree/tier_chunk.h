/* A chunk of a tier from its build to its place in the file, and the packets in which ranks give it
 * to each other. */
#ifndef STP_PREPROCESS_TREE_TIER_CHUNK_H
#define STP_PREPROCESS_TREE_TIER_CHUNK_H

#include "preprocess/ranks/ranks.h"
#include "preprocess/tree/chunk_build.h"
#include "preprocess/tree/chunk_numbers.h"

typedef struct stp_tier_chunk {
    stp_built_chunk chunk;
    void *payload;     /* in the spill if several ranks build the tier */
    stp_bytes records; /* of its blocks */
    stp_chunk_entry entry;
    stp_dbox box; /* of a leaf's samples as stored, world */
    stp_chunk_numbers numbers;
} stp_tier_chunk;

void stp_tier_chunk_clear(stp_tier_chunk *c, stp_spill *spill);
/* Frees the sources of the samples: 4 bytes each, needed no longer, while the tier waits long. */
void stp_tier_chunk_forget_sources(stp_tier_chunk *c);

/* Appends, of chunk `index` of a tier, what chunks [part.begin, part.end) are measured against: the
 * patches that reach into their boxes, with samples of level 0. Errors: OUT_OF_MEMORY. */
stp_status stp_tier_chunk_pack_around(stp_bytes *out, const stp_tier_chunk *c, uint32_t index,
                                      const stp_chunk_boxes *boxes, stp_rank_part part,
                                      stp_error *err);
/* Takes such a packet: tier[index] gets a chunk of these patches. Errors: OUT_OF_MEMORY, IO,
 * INTERNAL. */
stp_status stp_tier_chunk_take_around(stp_tier_chunk *tier, stp_cursor *from, stp_spill *spill,
                                      stp_error *err);
/* Gives a finished chunk of rank `owner` to those ranks that need it: its entry, vertices and what
 * is summed up to all, its records and attributes (of the list, NULL: none) to rank 0. All ranks
 * call it; packet is room. Errors: OUT_OF_MEMORY, IO, INTERNAL, CANCELLED. */
stp_status stp_tier_chunk_share(stp_tier_chunk *c, unsigned owner, stp_ranks *ranks,
                                const stp_attribute_list *list, stp_bytes *packet, stp_spill *spill,
                                stp_error *err);

#endif
