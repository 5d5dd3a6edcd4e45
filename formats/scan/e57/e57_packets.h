/* Reads the compressed vector of an E57 scan: the packets of its section, and the bytestreams that
 * are cut up into the packets.
 *
 * A section is a header and packets of at most 64 KiB: data, index or empty. A data packet has the
 * next bytes of every field's bytestream. The writer chooses how many of each, so the fields are
 * not in step and each field has a cursor of its own. As many packets are kept as there may
 * be cursors, so that each packet is read about once. Memory: those packets, 64 KiB each. Threads:
 * one at a time. */
#ifndef STP_FORMATS_SCAN_E57_E57_PACKETS_H
#define STP_FORMATS_SCAN_E57_E57_PACKETS_H

#include "base/error.h"
#include "formats/scan/e57/e57_pages.h"
#include "formats/scan/e57/e57_xml.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_E57_PACKET_BYTES 65536u

/* A data packet. */
typedef struct stp_e57_packet {
    uint64_t at, next;  /* logical addresses of the packet and of what follows; at 0: no packet */
    uint64_t last_used; /* number of the last use */
    unsigned char bytes[STP_E57_PACKET_BYTES];
} stp_e57_packet;

typedef struct stp_e57_section {
    stp_e57_pages *pages; /* borrowed */
    uint64_t first, end;  /* logical addresses of the first packet and of the end of the last */
    uint32_t stream_count;
    uint64_t uses;
    stp_e57_packet *packets; /* owned by the vector */
    size_t packet_count;
} stp_e57_section;

/* The place where a bytestream is read. */
typedef struct stp_e57_cursor {
    uint32_t stream;
    uint64_t packet;  /* logical address; if size is 0, search for a packet from here on */
    uint32_t at, end; /* unread bytes in the packet */
} stp_e57_cursor;

/* Reads the section's header and finds its first packet. *section may still hold another section's
 * packets. Errors: IO, CORRUPT. */
stp_status stp_e57_section_open(stp_e57_section *section, stp_e57_pages *pages,
                                const stp_e57_scan *scan, stp_error *err);
/* Returns a cursor at the begin of a bytestream. */
stp_e57_cursor stp_e57_section_start(const stp_e57_section *section, uint32_t stream);
/* Takes up to size bytes of the bytestream into out, or drops them if out is NULL. Takes fewer
 * (*got < size) only at its end. Errors: IO, CORRUPT. */
stp_status stp_e57_section_take(stp_e57_section *section, stp_e57_cursor *cursor,
                                unsigned char *out, size_t size, size_t *got, stp_error *err);

/* A cursor at the begin of its bytestream, and by how many bytes it is moved on. */
typedef struct stp_e57_skip {
    stp_e57_cursor *cursor;
    uint64_t bytes;
} stp_e57_skip;

/* Moves cursors on, and sets all bytes to 0: reads the packets up to there once. Errors: IO,
 * CORRUPT (a bytestream ends before). */
stp_status stp_e57_section_skip(stp_e57_section *section, stp_e57_skip *skips, size_t count,
                                stp_error *err);

#endif
