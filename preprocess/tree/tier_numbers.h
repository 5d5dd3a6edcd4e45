/* The attributes of a tier's chunks, also if the ranks read a part of the points each. */
#ifndef STP_PREPROCESS_TREE_TIER_NUMBERS_H
#define STP_PREPROCESS_TREE_TIER_NUMBERS_H

#include "preprocess/tree/tier_chunk.h"

/* Encodes the attributes of built chunks and frees their sources. Numbers that other ranks read
 * come from there: all ranks call it, with chunks of their own or none. Errors: OUT_OF_MEMORY, IO,
 * INTERNAL, CANCELLED. */
stp_status stp_tier_numbers_make(stp_tier_chunk *chunks, uint32_t count,
                                 const stp_tree_params *params, const stp_cloud *cloud,
                                 stp_pool *pool, stp_error *err);

#endif
