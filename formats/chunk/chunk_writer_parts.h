/* What the two halves of the chunk file's writer share: chunk_writer.c takes payloads as they come,
 * chunk_writer_end.c writes what follows them. Nobody else includes this. */
#ifndef STP_FORMATS_CHUNK_CHUNK_WRITER_PARTS_H
#define STP_FORMATS_CHUNK_CHUNK_WRITER_PARTS_H

#include "base/file.h"
#include "formats/chunk/attribute/attribute_table.h"
#include "formats/chunk/chunk_file.h"
#include "formats/chunk/layout.h"

#include <xxhash.h>

/* What is written of attributes. */
typedef struct stp_written_numbers {
    const stp_attribute_list *list; /* NULL: none yet */
    stp_attribute_row *rows;        /* by handle, then attribute */
    size_t capacity;
    uint32_t chunk_count; /* that have rows */
    uint64_t offset, bytes;
    XXH3_state_t *hash;
} stp_written_numbers;

struct stp_chunk_writer {
    stp_output *output;
    stp_chunk_writer_params params;
    stp_chunk_entry *entries; /* by handle */
    size_t entry_count, entry_capacity;
    stp_bytes blocks; /* records; entries say which are theirs */
    stp_written_numbers numbers;
    stp_chunk_file *extended; /* the file that is changed in place, borrowed; NULL: a new one */
    uint64_t unused_bytes;    /* of the changed file, among the payloads */
    uint64_t *unused_out;     /* borrowed: finish says it there */
    uint64_t first_header;    /* byte of the copy of its header to write first */
};

/* Files of codecs with blocks have version 2. */
static inline bool stp_chunk_writer_has_blocks(const stp_chunk_writer *writer)
{
    return stp_codec_has_blocks(writer->params.codec);
}

#endif
