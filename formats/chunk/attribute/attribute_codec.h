/* Codes the numbers of one attribute for the samples of one level of a chunk.
 *
 * A number is predicted, and the difference goes through the column coder in pieces of 16 bits
 * (codec/column.h). Floats that are decimals are coded as whole numbers. formats/SPEC.md, "Numbers
 * of an attribute", has the bytes. Lossless for every word. Threads: any. */
#ifndef STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_CODEC_H
#define STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_CODEC_H

#include "formats/attribute/attribute.h"
#include "formats/chunk/attribute/attribute_steps.h"
#include "formats/chunk/codec/table/column.h"

/* Most numbers of a part: those of a level. */
#define STP_ATTRIBUTE_PART_LIMIT 65536u

/* Finds what steps all numbers of a chunk lie on, for stp_attribute_encode. Errors: OUT_OF_MEMORY.
 */
stp_status stp_attribute_steps(stp_attribute_type type, const uint64_t *words, uint32_t count,
                               stp_steps *out, stp_error *err);
/* Appends the numbers as a part; nothing if count is 0. guesses: what the samples' 8 bits say of
 * each number, or NULL. steps: of the chunk, or NULL. Errors: OUT_OF_MEMORY, INTERNAL (Draco
 * fails). */
stp_status stp_attribute_encode(stp_attribute_type type, const uint64_t *words,
                                const uint64_t *guesses, const stp_steps *steps, uint32_t count,
                                stp_bytes *out, stp_error *err);
/* Decodes a part of exactly `size` bytes. guesses: as for encoding. Errors: CORRUPT,
 * OUT_OF_MEMORY. */
stp_status stp_attribute_decode(stp_attribute_type type, const uint8_t *bytes, size_t size,
                                const uint64_t *guesses, uint32_t count, uint64_t *words,
                                stp_error *err);

#endif
