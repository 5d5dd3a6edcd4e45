/* Rebuilds lost directory entries from the payloads and from the chunks around them. */
#ifndef STP_FORMATS_CHUNK_REPAIR_LOST_ENTRIES_H
#define STP_FORMATS_CHUNK_REPAIR_LOST_ENTRIES_H

#include "formats/chunk/repair/damaged.h"

/* For each page whose checksum fails: keeps the entries that agree with their payloads and with the
 * tree, finds the payloads of others, and makes their entries known. Errors: IO, OUT_OF_MEMORY. */
stp_status stp_lost_entries_find(stp_damaged *d, stp_error *err);

#endif
