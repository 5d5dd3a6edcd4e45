/* Encodes and decodes blocks of squares as Ochotta and Saupe store elevation maps (ELEV06): a
 * height of 16 bits a sample, and its normal as two angles of 16 bits. Nothing is predicted but
 * where a sample lies across its height, and there is no entropy coder. What the paper does not
 * have, such as radii and colours, follows in bytes. The way there and back is without loss. A
 * block that is not of squares is coded as raw.
 *
 * formats/SPEC.md, "Codec 6", has the layout. Treats every byte as hostile. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_PAPER_H
#define STP_FORMATS_CHUNK_CODEC_PAPER_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/shares.h"
#include "formats/chunk/codec/table/column.h"

/* The contract is that of part.h. */
stp_status stp_paper_encode(const stp_chunk *block, int segment, stp_bytes *out, stp_error *err);
stp_status stp_paper_decode(const uint8_t *bytes, size_t size, int segment, uint32_t child_count,
                            stp_chunk *block, stp_shares *shares, stp_error *err);

/* The two angles of a normal's code, and the code of two angles. */
void stp_paper_angles(const uint8_t normal[3], uint16_t out[2]);
void stp_paper_normal(const uint16_t angles[2], uint8_t out[3]);

#endif
