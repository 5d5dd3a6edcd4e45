/* Where each chunk of points begins in a LAZ file: its table of chunks. Threads: any. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAZ_CHUNKS_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAZ_CHUNKS_H

#include "base/error.h"
#include "base/file.h"
#include "formats/scan/las/las_header.h"
#include "formats/scan/las/laz/laz_layout.h"

/* The points begin with a u64: where the table lies. */
#define STP_LAZ_TABLE_PLACE_BYTES 8u

typedef struct stp_laz_chunk {
    uint64_t begin; /* in the file */
    uint64_t first; /* point */
    uint64_t end;   /* 0: where the next one begins */
} stp_laz_chunk;

/* Chunks in order, and one more that begins where the last one ends. Without a table, only the
 * chunk that comes next is known. */
typedef struct stp_laz_chunks {
    stp_laz_chunk *list;
    size_t count, capacity; /* with the one more, if complete */
    bool complete;
    uint64_t end; /* of all chunks, in the file */
} stp_laz_chunks;

/* Reads the table of chunks. A file without one, or with one that cannot be read, has the first
 * chunk alone. Errors: CORRUPT (no table where the sizes of chunks vary), OUT_OF_MEMORY. */
stp_status stp_laz_chunks_read(stp_laz_chunks *out, const stp_laz_layout *layout,
                               const stp_las_header *header, int descriptor, uint64_t file_bytes,
                               const char *path, stp_error *err);
/* Adds a chunk. Errors: OUT_OF_MEMORY. */
stp_status stp_laz_chunks_add(stp_laz_chunks *chunks, uint64_t begin, uint64_t first,
                              stp_error *err);
void stp_laz_chunks_free(stp_laz_chunks *chunks);

/* Appends the table of chunks that have equal numbers of points, and so many bytes each. Errors:
 * IO, OUT_OF_MEMORY. */
stp_status stp_laz_chunks_write(const uint32_t *bytes, uint32_t count, stp_output *output,
                                stp_error *err);

#endif
