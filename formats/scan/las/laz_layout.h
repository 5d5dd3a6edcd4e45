/* How the points of a LAZ file are packed: the record "laszip encoded", and where each chunk of
 * points begins. Threads: any. */
#ifndef STP_FORMATS_SCAN_LAS_LAZ_LAYOUT_H
#define STP_FORMATS_SCAN_LAS_LAZ_LAYOUT_H

#include "base/error.h"
#include "formats/scan/las/las_header.h"
#include "formats/scan/las/las_records.h"
#include "formats/scan/las/laz_item.h"

/* POINT, time, colour, waveform, extra bytes. */
#define STP_LAZ_ITEMS_MOST 5u

typedef struct stp_laz_layout {
    bool layered;          /* each field of a chunk has its own stream */
    bool chunked;          /* else all points are one chunk, without a table */
    uint32_t chunk_points; /* UINT32_MAX: the table says how many each chunk has */
    unsigned item_count;
    struct {
        const stp_laz_coder *coder;
        unsigned bytes;
    } items[STP_LAZ_ITEMS_MOST];
} stp_laz_layout;

/* Reads the record. Errors: CORRUPT, UNSUPPORTED (a coder that is not known). */
stp_status stp_laz_layout_read(stp_laz_layout *out, const stp_las_record *record,
                               const stp_las_header *header, const char *path, stp_error *err);
/* Layers of an item: the streams of it in a chunk. */
unsigned stp_laz_item_layers(const stp_laz_layout *layout, unsigned item);

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

#endif
