/* Reads attributes of a chunk file: their list at once, their numbers chunk by chunk.
 *
 * A picture that does not ask for attributes reads none of their bytes. Threads: any, one
 * stp_attribute_file each; the chunk file may be shared. */
#ifndef STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_FILE_H
#define STP_FORMATS_CHUNK_ATTRIBUTE_ATTRIBUTE_FILE_H

#include "formats/attribute/attribute.h"
#include "formats/chunk/attribute/attribute_table.h"
#include "formats/chunk/chunk_file.h"

typedef struct stp_attribute_file stp_attribute_file;

/* Reads the list. A file without attributes has an empty one. The chunk file is borrowed. Errors:
 * IO, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_attribute_file_open(stp_attribute_file **out, stp_chunk_file *file, stp_error *err);
const stp_attribute_list *stp_attribute_file_list(const stp_attribute_file *attributes);
/* Reads the numbers of attribute `index` for the samples of level `level` of a chunk that is
 * decoded to that level or finer. words: by sample.
 * Errors: IO, CORRUPT, CANCELLED, OUT_OF_MEMORY. */
stp_status stp_attribute_file_read(stp_attribute_file *attributes, uint32_t index,
                                   const stp_chunk *chunk, int level, uint64_t *words,
                                   stp_error *err);
/* Reads the numbers that a level of a chunk adds, in the stored order (attribute_order.h). count:
 * as many as the level has samples more than the next coarser one. guesses: by number, of a coarse
 * attribute; else NULL. Errors: likewise. */
stp_status stp_attribute_file_part(stp_attribute_file *attributes, uint32_t index, uint32_t id,
                                   int level, const uint64_t *guesses, uint32_t count,
                                   uint64_t *words, stp_error *err);
/* Where the numbers of a chunk lie. Errors: IO, CORRUPT, OUT_OF_MEMORY. */
stp_status stp_attribute_file_row(stp_attribute_file *attributes, uint32_t index, uint32_t id,
                                  stp_attribute_row *out, stp_error *err);
/* Reads all parts of a row, as they are. Errors: IO, CORRUPT (a checksum). */
stp_status stp_attribute_file_parts(stp_attribute_file *attributes, const stp_attribute_row *row,
                                    uint8_t *bytes, stp_error *err);
void stp_attribute_file_close(stp_attribute_file **attributes);

#endif
