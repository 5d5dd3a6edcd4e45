/* The members of an open chunk file, for chunk_reader.c and block.c alone. */
#ifndef STP_FORMATS_CHUNK_CHUNK_READER_H
#define STP_FORMATS_CHUNK_CHUNK_READER_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/layout.h"

#include <pthread.h>

/* If bytes from a server fail their checksum, they are read again so often. */
#define STP_FRESH_TRIES 5

struct stp_directory_page;

struct stp_chunk_file {
    stp_byte_source *source;
    const char *path; /* the source's name */
    char *metadata;
    stp_header header;
    stp_chunk_file_info info;
    uint32_t page_count;
    pthread_mutex_t mutex; /* guards the pointers below, not what they point to; innermost */
    struct stp_directory_page **pages; /* NULL until read; a page never changes once it is there */
    uint8_t *blocks; /* the table of blocks; NULL until read, then it never changes */
};

/* Reads bytes of the file; again: past all caches. Errors: as stp_byte_source_read. */
stp_status stp_chunk_file_bytes(const stp_chunk_file *file, uint64_t offset, void *data,
                                size_t size, bool again, stp_error *err);
/* Whether reading again may help after this status. */
bool stp_chunk_file_may_mend(const stp_chunk_file *file, stp_status status);

/* Checks a decoded chunk, or a block of it, against its entry and the file's attributes. Errors:
 * CORRUPT. */
stp_status stp_chunk_file_check(const stp_chunk_file *file, const stp_chunk_entry *entry,
                                const stp_chunk *chunk, stp_error *err);

#endif
