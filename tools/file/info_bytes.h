/* What the bytes of a chunk file hold, by attribute. Decodes every chunk, one after the other. */
#ifndef STP_TOOLS_FILE_INFO_BYTES_H
#define STP_TOOLS_FILE_INFO_BYTES_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/shares.h"

struct cJSON;

typedef struct info_bytes {
    stp_shares shares; /* with the attributes, these add up to the file */
    stp_attribute_list attributes;
    uint64_t attribute_bytes[STP_ATTRIBUTES_LIMIT];
    /* Bits of positions beyond those that steps of 1/32 of the local spacing need: what keeping the
     * scan's own scale costs, at most. */
    uint64_t scale_bits;
} info_bytes;

/* Errors: as stp_chunk_file_read. */
stp_status info_bytes_count(stp_chunk_file *file, info_bytes *out, stp_error *err);
void info_bytes_print(const info_bytes *bytes, const stp_chunk_file_info *info);
/* Adds the object "bytes": bytes by attribute; and the number "scale_bytes". */
void info_bytes_json(const info_bytes *bytes, struct cJSON *json);

#endif
