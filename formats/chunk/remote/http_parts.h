/* Puts the bytes of an answer where they are wanted: those of one range, or of several, which come
 * in parts (multipart/byteranges: RFC 9110, 14.6).
 *
 * Treats every byte as hostile. Needs no boundary, since each part says which bytes it has.
 * Threads: any, one answer each. */
#ifndef STP_FORMATS_CHUNK_REMOTE_HTTP_PARTS_H
#define STP_FORMATS_CHUNK_REMOTE_HTTP_PARTS_H

#include "formats/chunk/byte_source.h"
#include "formats/chunk/remote/http_answer.h"

/* A part comes with up to so many bytes of headers: 125 are usual. A gap that is smaller is read
 * rather than left out. */
#define STP_HTTP_PART_BYTES 256u
/* Room for the text of a request's ranges. */
#define STP_HTTP_RANGES_TEXT (STP_SOURCE_RANGES * 42u)

/* What is missing of some ranges: bytes [begin, end) of the file hold it all. */
typedef struct stp_http_missing {
    uint64_t begin, end;
    size_t bytes;
} stp_http_missing;

stp_http_missing stp_http_missing_of(const stp_byte_range *ranges, size_t count);
/* Writes what is missing as "0-99,500-599". Returns how many ranges the text has. */
size_t stp_http_missing_write(const stp_byte_range *ranges, size_t count,
                              char out[STP_HTTP_RANGES_TEXT]);

typedef struct stp_http_parts {
    stp_byte_range *ranges; /* what is wanted */
    size_t count;
    uint64_t file_bytes;
    uint64_t at, end; /* the file's bytes that come next; if there are none: a line of headers */
    char line[128];   /* as far as it came; longer ones are none that we need */
    size_t length;
    stp_http_answer part; /* what the headers of the next part say */
} stp_http_parts;

/* Takes bytes of the body, and raises `got` of the ranges. False if a part is of another file. */
bool stp_http_parts_take(stp_http_parts *parts, const char *bytes, size_t size);

#endif
