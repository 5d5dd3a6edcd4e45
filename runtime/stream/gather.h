/* Reads what is wanted of several blocks in few requests: parts that lie next to each other in the
 * file, or nearly so, are read at once. Threads: any. */
#ifndef STP_RUNTIME_STREAM_GATHER_H
#define STP_RUNTIME_STREAM_GATHER_H

#include "formats/chunk/block/block.h"

#include <stdatomic.h>

/* At most so many blocks at once. */
#define STP_GATHER_BLOCKS 32u

/* Bytes [begin, end) of a block's payload. They begin and end where parts do. */
typedef struct stp_gather_item {
    const stp_block *block; /* as its file knows it */
    uint32_t begin, end;
    uint8_t *out;
    const atomic_bool *unwanted; /* true: nobody wants the item; may change. NULL: it is wanted */
    /* Afterwards. Bytes [begin, got) are there, also if reading failed. */
    uint32_t got;
    stp_status status;
    stp_error error;
} stp_gather_item;

/* Whether reading both at once saves a request. */
bool stp_gather_joins(stp_chunk_file *file, const stp_gather_item *a, const stp_gather_item *b);
/* Reads the items, at most STP_GATHER_BLOCKS. Returns how many bytes of them were read. Errors of
 * an item: as stp_block_fetch, CANCELLED (none of the items is wanted any longer). */
uint64_t stp_gather_read(stp_chunk_file *file, stp_gather_item *items, size_t count);

#endif
