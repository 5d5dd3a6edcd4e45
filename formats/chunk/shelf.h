/* A shelf of decoded chunks that threads share. A chunk is decoded once for all who ask at the same
 * time, and kept as long as there is room.
 *
 * Threads: any. */
#ifndef STP_FORMATS_CHUNK_SHELF_H
#define STP_FORMATS_CHUNK_SHELF_H

#include "formats/chunk/chunk_file.h"

typedef struct stp_shelf stp_shelf;

/* Keeps `room` chunks, and more while threads hold them. file is borrowed. Errors: OUT_OF_MEMORY.
 */
stp_status stp_shelf_create(stp_shelf **out, stp_chunk_file *file, uint32_t room, stp_error *err);
void stp_shelf_destroy(stp_shelf **shelf);

/* Takes a chunk with all levels; give it back with stp_shelf_give. Errors: those of
 * stp_chunk_file_read. */
stp_status stp_shelf_take(stp_shelf *shelf, uint32_t id, const stp_chunk **out, stp_error *err);
void stp_shelf_give(stp_shelf *shelf, uint32_t id);

#endif
