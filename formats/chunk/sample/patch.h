/* Patch headers: checks them, and turns them into columns of small numbers and back.
 *
 * Pure functions over the caller's memory. Threads: any. */
#ifndef STP_FORMATS_CHUNK_SAMPLE_PATCH_H
#define STP_FORMATS_CHUNK_SAMPLE_PATCH_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/table/table.h"

/* Columns of the table of patch headers; formats/SPEC.md, "Patch columns", lists them. */
#define STP_PATCH_COLUMN_COUNT 45u
#define STP_LINKED_PATCH_COLUMN_COUNT 46u

/* Checks each patch: counts, exponent, child below child_count, flags that agree; and that the
 * levels add up to sample_count. Errors: CORRUPT, naming the patch. */
stp_status stp_patches_check(const stp_patch *patches, uint32_t patch_count,
                             const uint32_t sample_count[STP_LEVEL_COUNT], uint32_t child_count,
                             stp_error *err);
/* Checks that level-0 samples have the kinds that the patches' flags say. Errors: CORRUPT, naming
 * the patch. */
stp_status stp_patches_check_kinds(const stp_chunk *chunk, stp_error *err);
/* Fills level_begin from the patches' counts. */
void stp_patches_place(stp_chunk *chunk);
/* Does both for patches that were read into a chunk, whose level_begin ends with the counts that
 * must be met. Errors: those of stp_patches_check. */
stp_status stp_patches_take(stp_chunk *chunk, uint32_t child_count, stp_error *err);

/* Steps from a patch's origin to the centre of its bounding sphere, along each axis, in most
 * patches: this many, or twice, four times as many and so on. */
#define STP_PATCH_MIDDLE 512

/* If the table has STP_LINKED_PATCH_COLUMN_COUNT columns, the last one is first_below. */
void stp_patches_encode(const stp_patch *patches, const stp_table *table);
void stp_patches_decode(stp_patch *patches, const stp_table *table);

#endif
