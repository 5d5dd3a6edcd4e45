/* Reads the pages of an E57 file (ASTM E2807): its header, and the bytes without the checksums.
 *
 * The file consists of pages of 1,024 bytes. The last four bytes of a page are the CRC-32C of the
 * others, most significant byte first. A physical address counts the checksums, a logical address
 * does not. Every page that is read is checked. Memory: one block of pages. Threads: one at a time.
 */
#ifndef STP_FORMATS_SCAN_E57_E57_PAGES_H
#define STP_FORMATS_SCAN_E57_E57_PAGES_H

#include "base/error.h"
#include "formats/scan/e57/crc32c.h"

#include <stddef.h>
#include <stdint.h>

#define STP_E57_PAGE_BYTES 1024u
#define STP_E57_PAYLOAD_BYTES 1020u
#define STP_E57_HEADER_BYTES 48u
#define STP_E57_BLOCK_PAGES 64u

typedef struct stp_e57_pages {
    int descriptor;               /* -1: closed */
    const char *path;             /* borrowed; for messages */
    uint64_t size;                /* logical, of the whole file */
    uint64_t xml_begin, xml_size; /* logical, inside the file */
    stp_crc32c crc;
    uint64_t block_first, block_count; /* pages in the block, checked */
    unsigned char block[STP_E57_BLOCK_PAGES * STP_E57_PAGE_BYTES];
} stp_e57_pages;

/* Reads and checks the header. Close *pages even after a failure. path must outlive it. Errors:
 * NOT_FOUND, IO, FORMAT, VERSION, UNSUPPORTED (another page size), CORRUPT. */
stp_status stp_e57_pages_open(stp_e57_pages *pages, const char *path, stp_error *err);
void stp_e57_pages_close(stp_e57_pages *pages);
/* Converts a physical address to a logical one. `what` names the thing in the message. Errors:
 * CORRUPT (the address is in a checksum or beyond the end). */
stp_status stp_e57_pages_logical(const stp_e57_pages *pages, uint64_t physical, const char *what,
                                 uint64_t *logical, stp_error *err);
/* Converts a logical address to a physical one, for messages. */
static inline uint64_t stp_e57_physical(uint64_t logical)
{
    return logical / STP_E57_PAYLOAD_BYTES * STP_E57_PAGE_BYTES + logical % STP_E57_PAYLOAD_BYTES;
}
/* Reads size logical bytes at a logical address. Errors: IO, CORRUPT (with the page's offset). */
stp_status stp_e57_pages_read(stp_e57_pages *pages, uint64_t logical, void *out, size_t size,
                              stp_error *err);

#endif
