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

/* Appends what every rank needs of a chunk: its entry, its vertices and what is summed up. Errors:
 * OUT_OF_MEMORY. */
stp_status stp_tier_chunk_pack(stp_bytes *out, const stp_tier_chunk *c, stp_error *err);
/* Sets these in place of what was there. Errors: OUT_OF_MEMORY, IO, INTERNAL. */
stp_status stp_tier_chunk_take(stp_tier_chunk *out, stp_cursor from, stp_spill *spill,
                               stp_error *err);
/* Appends, of chunk `index` of a tier, what chunks [part.begin, part.end) are measured against: the
 * patches that reach into their boxes, with samples of level 0. Errors: OUT_OF_MEMORY. */
stp_status stp_tier_chunk_pack_around(stp_bytes *out, const stp_tier_chunk *c, uint32_t index,
                                      const stp_chunk_boxes *boxes, stp_rank_part part,
                                      stp_error *err);
/* Takes such a packet: tier[index] gets a chunk of these patches. Errors: OUT_OF_MEMORY, IO,
 * INTERNAL. */
stp_status stp_tier_chunk_take_around(stp_tier_chunk *tier, stp_cursor *from, stp_spill *spill,
                                      stp_error *err);
/* stp_tier_chunk_pack and _take of what only the file needs: payload, records and attributes,
 * attribute_count of them.
 */
stp_status stp_tier_chunk_pack_file(stp_bytes *out, const stp_tier_chunk *c,
                                    uint32_t attribute_count, stp_error *err);
stp_status stp_tier_chunk_take_file(stp_tier_chunk *out, stp_cursor from, uint32_t attribute_count,
                                    stp_error *err);

#endif
