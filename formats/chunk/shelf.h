/* Chunks of a file that threads share: decoded once while many ask, and kept as long as there is
 * room.
 *
 * Threads: any. */
#ifndef STP_FORMATS_CHUNK_SHELF_H
#define STP_FORMATS_CHUNK_SHELF_H

#include "formats/chunk/chunk_file.h"

typedef struct stp_shelf stp_shelf;

/* Keeps `room` chunks, and more while they are taken. file is borrowed. Errors: OUT_OF_MEMORY. */
stp_status stp_shelf_create(stp_shelf **out, stp_chunk_file *file, uint32_t room, stp_error *err);
void stp_shelf_destroy(stp_shelf **shelf);

/* A chunk with all levels, to be given back. Errors: those of stp_chunk_file_read. */
stp_status stp_shelf_take(stp_shelf *shelf, uint32_t id, const stp_chunk **out, stp_error *err);
void stp_shelf_give(stp_shelf *shelf, uint32_t id);

#endif
