/* Asks for what is missing of ranges, and takes it from an answer. */
#include "formats/chunk/remote/http_parts.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

stp_http_missing stp_http_missing_of(const stp_byte_range *ranges, size_t count)
{
    stp_http_missing all = {0};
    for (size_t i = 0; i < count; i++) {
        const stp_byte_range *r = &ranges[i];
        const uint64_t begin = r->offset + r->got, end = r->offset + r->size;
        if (r->got == r->size)
            continue;
        all.begin = all.bytes == 0 || begin < all.begin ? begin : all.begin;
        all.end = end > all.end ? end : all.end;
        all.bytes += r->size - r->got;
    }
    return all;
}

size_t stp_http_missing_write(const stp_byte_range *ranges, size_t count,
                              char out[STP_HTTP_RANGES_TEXT])
{
    size_t written = 0, length = 0;
    stp_http_missing run = {0};
    for (size_t i = 0; i <= count; i++) {
        const stp_http_missing next = stp_http_missing_of(ranges + i, i < count ? 1 : 0);
        if (i < count && next.bytes == 0)
            continue;
        if (run.bytes > 0 && (i == count || next.begin > run.end + STP_HTTP_PART_BYTES)) {
            length += (size_t)snprintf(out + length, STP_HTTP_RANGES_TEXT - length,
                                       "%s%" PRIu64 "-%" PRIu64, written++ > 0 ? "," : "",
                                       run.begin, run.end - 1);
            run = next;
        } else if (run.bytes == 0) {
            run = next;
        } else {
            run.end = next.end > run.end ? next.end : run.end;
        }
    }
    return written;
}

/* Keeps those of the file's next bytes that are wanted. */
static void keep(const stp_http_parts *p, const char *bytes, size_t size)
{
    for (size_t i = 0; i < p->count; i++) {
        stp_byte_range *r = &p->ranges[i];
        const uint64_t next = r->offset + r->got;
        if (next < p->at || next - p->at >= size)
            continue;
        const size_t from = (size_t)(next - p->at), left = r->size - r->got;
        const size_t more = size - from < left ? size - from : left;
        memcpy(r->data + r->got, bytes + from, more);
        r->got += more;
    }
}

/* Takes a line of headers. After an empty one come the bytes of the part. */
static bool take_line(stp_http_parts *p)
{
    const bool empty = p->length == 0 || (p->length == 1 && p->line[0] == '\r');
    if (!empty && p->length < sizeof p->line)
        stp_http_answer_line(&p->part, p->line, p->length);
    p->length = 0;
    if (!empty || !p->part.has_range)
        return true;
    p->at = p->part.begin;
    p->end = p->part.last + 1;
    const bool same = !p->part.has_total || p->part.total == p->file_bytes;
    p->part = (stp_http_answer){0};
    return same;
}

bool stp_http_parts_take(stp_http_parts *p, const char *bytes, size_t size)
{
    while (size > 0) {
        size_t taken = 1;
        if (p->at < p->end) {
            taken = p->end - p->at < size ? (size_t)(p->end - p->at) : size;
            keep(p, bytes, taken);
            p->at += taken;
        } else if (*bytes != '\n') {
            if (p->length < sizeof p->line)
                p->line[p->length++] = *bytes;
        } else if (!take_line(p)) {
            return false;
        }
        bytes += taken;
        size -= taken;
    }
    return true;
}
