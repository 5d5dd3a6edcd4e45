/* Reads the packets of an E57 scan's compressed vector. */
#include "formats/scan/e57/e57_packets.h"

#include "base/checked.h"

#include <string.h>

#define SECTION_VECTOR 1u

enum { PACKET_INDEX, PACKET_DATA, PACKET_EMPTY };

/* Little-endian, as in the file. */
typedef struct section_header {
    uint8_t id, reserved[7];
    uint64_t size, data_physical, index_physical;
} section_header;

typedef struct packet_header {
    uint8_t type, flags;
    uint16_t size_minus_1;
} packet_header;

#define DATA_HEADER_BYTES 6u /* the packet header and the number of bytestreams */

static stp_status fault(const stp_e57_section *s, uint64_t at, const char *what, uint64_t found,
                        stp_error *err)
{
    return stp_error_set(err, STP_CORRUPT,
                         "%s: byte %llu: a packet of points %s (found %llu): the file is damaged; "
                         "copy or export it again",
                         s->pages->path, (unsigned long long)stp_e57_physical(at), what,
                         (unsigned long long)found);
}

stp_status stp_e57_section_open(stp_e57_section *s, stp_e57_pages *pages, const stp_e57_scan *scan,
                                stp_error *err)
{
    stp_status status = STP_OK;
    section_header h;
    uint64_t begin = 0, first = 0;
    STP_TRY(
        stp_e57_pages_logical(pages, scan->file_offset, "a scan's binary section", &begin, err));
    STP_TRY(stp_e57_pages_read(pages, begin, &h, sizeof h, err));
    if (h.id != SECTION_VECTOR)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: byte %llu: a section of kind %u where the points of a scan (kind "
                             "%u) should begin: the file is damaged; copy or export it again",
                             pages->path, (unsigned long long)scan->file_offset, h.id,
                             SECTION_VECTOR);
    STP_TRY(stp_e57_pages_logical(pages, h.data_physical, "a scan's first packet", &first, err));
    if (!stp_range_inside(begin, h.size, pages->size) || first < begin + sizeof h ||
        first > begin + h.size)
        return stp_error_set(err, STP_CORRUPT,
                             "%s: byte %llu: a section of %llu bytes with its first packet at byte "
                             "%llu: that does not fit; the file is damaged or was cut; copy or "
                             "export it again",
                             pages->path, (unsigned long long)scan->file_offset,
                             (unsigned long long)h.size, (unsigned long long)h.data_physical);
    s->pages = pages;
    s->first = first;
    s->end = begin + h.size;
    s->stream_count = scan->stream_count;
    s->uses = 0;
    for (size_t i = 0; i < s->packet_count; i++)
        s->packets[i].at = s->packets[i].last_used = 0;
done:
    return status;
}

stp_e57_cursor stp_e57_section_start(const stp_e57_section *s, uint32_t stream)
{
    return (stp_e57_cursor){.stream = stream, .packet = s->first};
}

/* Finds the next data packet from *at on: its address and size; size 0 at the section's end. */
static stp_status find_data(stp_e57_section *s, uint64_t *at, uint32_t *size, stp_error *err)
{
    stp_status status = STP_OK;
    packet_header h;
    *size = 0;
    while (s->end - *at >= sizeof h) {
        STP_TRY(stp_e57_pages_read(s->pages, *at, &h, sizeof h, err));
        const uint32_t bytes = h.size_minus_1 + 1u;
        if (h.type > PACKET_EMPTY)
            return fault(s, *at, "is of no known kind", h.type, err);
        if (bytes % 4 != 0 || bytes > s->end - *at)
            return fault(s, *at, "has a size that is no multiple of 4 or leaves its section", bytes,
                         err);
        if (h.type == PACKET_DATA) {
            *size = bytes;
            return STP_OK;
        }
        *at += bytes;
    }
done:
    return status;
}

static uint32_t two_bytes(const unsigned char *bytes)
{
    return bytes[0] | (uint32_t)bytes[1] << 8;
}

/* Checks that there are as many bytestreams as fields and that they fit into the packet. */
static stp_status check_streams(const stp_e57_section *s, const stp_e57_packet *packet,
                                uint32_t size, stp_error *err)
{
    if (size < DATA_HEADER_BYTES)
        return fault(s, packet->at, "is too small for its header", size, err);
    const uint32_t count = two_bytes(packet->bytes + 4);
    uint64_t sum = DATA_HEADER_BYTES + 2 * (uint64_t)count;
    if (count != s->stream_count)
        return fault(s, packet->at, "has not as many bytestreams as the scan has fields", count,
                     err);
    if (sum > size)
        return fault(s, packet->at, "is too small for the sizes of its bytestreams", size, err);
    for (uint32_t i = 0; i < count; i++)
        sum += two_bytes(packet->bytes + DATA_HEADER_BYTES + 2 * i);
    if (sum > size)
        return fault(s, packet->at, "has bytestreams that are longer than it is", sum, err);
    return STP_OK;
}

/* Gets the first data packet at or after this address; NULL at the section's end. */
static stp_status get_packet(stp_e57_section *s, uint64_t at, const stp_e57_packet **out,
                             stp_error *err)
{
    stp_status status = STP_OK;
    stp_e57_packet *oldest = &s->packets[0];
    uint32_t size = 0;
    *out = NULL;
    for (size_t i = 0; i < s->packet_count; i++) {
        if (s->packets[i].at == at) {
            s->packets[i].last_used = ++s->uses;
            *out = &s->packets[i];
            return STP_OK;
        }
        if (s->packets[i].last_used < oldest->last_used)
            oldest = &s->packets[i];
    }
    const uint64_t from = at;
    STP_TRY(find_data(s, &at, &size, err));
    if (size == 0)
        return STP_OK;
    if (at != from)
        return get_packet(s, at, out, err); /* recurses only once: there is a packet at `at` */
    oldest->at = 0;                         /* invalid while it is being filled */
    STP_TRY(stp_e57_pages_read(s->pages, at, oldest->bytes, size, err));
    oldest->at = at;
    oldest->next = at + size;
    status = check_streams(s, oldest, size, err);
    if (status != STP_OK) {
        oldest->at = 0;
        return status;
    }
    oldest->last_used = ++s->uses;
    *out = oldest;
done:
    return status;
}

/* Finds begin and end of a bytestream's part in a packet. */
static void find_stream(const stp_e57_packet *packet, stp_e57_cursor *cursor)
{
    const unsigned char *sizes = packet->bytes + DATA_HEADER_BYTES;
    uint32_t at = DATA_HEADER_BYTES + 2 * two_bytes(packet->bytes + 4);
    for (uint32_t i = 0; i < cursor->stream; i++)
        at += two_bytes(sizes + 2 * i);
    cursor->at = at;
    cursor->end = at + two_bytes(sizes + 2 * cursor->stream);
}

stp_status stp_e57_section_take(stp_e57_section *s, stp_e57_cursor *c, unsigned char *out,
                                size_t size, size_t *got, stp_error *err)
{
    stp_status status = STP_OK;
    size_t taken = 0;
    while (taken < size) {
        const stp_e57_packet *packet;
        STP_TRY(get_packet(s, c->packet, &packet, err));
        if (!packet)
            break;
        if (c->end == 0) {
            c->packet = packet->at;
            find_stream(packet, c);
        }
        size_t part = c->end - c->at;
        part = part < size - taken ? part : size - taken;
        if (out)
            memcpy(out + taken, packet->bytes + c->at, part);
        c->at += (uint32_t)part;
        taken += part;
        if (c->at == c->end) {
            c->packet = packet->next;
            c->at = c->end = 0;
        }
    }
    *got = taken;
done:
    return status;
}

/* Moves on within a packet, or to its end. Returns 1 if that is all. */
static size_t skip_in(const stp_e57_packet *packet, stp_e57_skip *skip)
{
    stp_e57_cursor *c = skip->cursor;
    const uint32_t size = two_bytes(packet->bytes + DATA_HEADER_BYTES + 2 * c->stream);
    if (skip->bytes == 0)
        return 0;
    if (skip->bytes < size) {
        c->packet = packet->at;
        find_stream(packet, c);
        c->at += (uint32_t)skip->bytes;
        skip->bytes = 0;
    } else {
        c->packet = packet->next;
        skip->bytes -= size;
    }
    return skip->bytes == 0;
}

stp_status stp_e57_section_skip(stp_e57_section *s, stp_e57_skip *skips, size_t count,
                                stp_error *err)
{
    stp_status status = STP_OK;
    const stp_e57_packet *packet;
    uint64_t at = s->first;
    size_t left = 0;
    for (size_t i = 0; i < count; i++)
        left += skips[i].bytes > 0;
    while (left > 0) {
        STP_TRY(get_packet(s, at, &packet, err));
        if (!packet)
            return fault(s, at, "is missing: bytestreams end before their points", left, err);
        for (size_t i = 0; i < count; i++)
            left -= skip_in(packet, &skips[i]);
        at = packet->next;
    }
done:
    return status;
}
