/* Merges touching parts as long as the cone holds and they are a height field (part_field.h): the
 * pair first whose union adds least to the sum of all parts' errors (stp_part_error).
 *
 * Parts of one cell are merged first (part_within.h), then those of all cells, by all ranks alike.
 * Ranks know all these parts, but only their own points, so whether two parts fit is for one of
 * them to say (part_field.h): they ask for many pairs at a time.
 * Threads: one. */
#ifndef STP_PREPROCESS_MAPS_PARTS_PART_MERGE_H
#define STP_PREPROCESS_MAPS_PARTS_PART_MERGE_H

#include "preprocess/maps/parts/part_field.h"

/* Most points of a merged part. */
#define STP_PART_POINTS_MOST 65536u
/* The spacings of parts that are merged differ by this factor at most: a map has one grid. */
#define STP_PART_SPACINGS 2.0

/* Merges parts; those that become part of another lose their corners. pairs: sorted, a < b.
 * cosine: of the cone's angle. field: of these parts, none joined yet. *out: by part, the number of
 * the part that it became part of, or its own; free with free(). Errors: OUT_OF_MEMORY. */
stp_status stp_parts_merge(stp_part *parts, uint32_t part_count, const stp_part_pair *pairs,
                           size_t pair_count, double cosine, stp_part_field *field, uint32_t **out,
                           stp_error *err);

#endif
