/* Reads a file forwards in large blocks: bytes for binary formats, lines for text.
 *
 * A source knows its place (byte and line), so that messages can name it. Memory: one block, which
 * grows only to hold a longer line or request, at most STP_SOURCE_REQUEST_MAX. Threads: one at a
 * time. */
#ifndef STP_FORMATS_SCAN_SOURCE_H
#define STP_FORMATS_SCAN_SOURCE_H

#include "base/error.h"

#include <ctype.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_SOURCE_REQUEST_MAX ((size_t)1 << 26)

typedef struct stp_source {
    int descriptor;   /* -1: closed */
    const char *path; /* borrowed; for messages */
    uint64_t size;    /* of the file, bytes */
    uint64_t offset;  /* of the next byte in the file */
    uint64_t line;    /* number of the line read last, 1 for the first */
    unsigned char *buffer;
    size_t begin, end; /* unread bytes in buffer */
    size_t capacity;
    struct stp_file_mirror
        *mirror;   /* fetches what is read (remote/mirror.h); NULL: it is all there */
    bool cr_lines; /* lines end in \r alone */
    uint8_t wide;  /* UTF-16: the high byte of a character is its first (1) or its second (2); 0:
                      none.  Then size, offset and buffer count characters */
    bool narrow;   /* reads no more than is asked for: after seeks to single records */
} stp_source;

/* path must outlive the source. Errors: NOT_FOUND, IO, OUT_OF_MEMORY. */
stp_status stp_source_open(stp_source *source, const char *path, stp_error *err);
void stp_source_close(stp_source *source);
/* Whether bytes begin UTF-16, by its mark or as plain characters: as stp_source.wide. *begin: the
 * mark's length in characters. Needs STP_WIDE_BYTES to know it without a mark. */
#define STP_WIDE_BYTES 32u
uint8_t stp_source_is_wide(const unsigned char *bytes, size_t length, size_t *begin);
/* Takes one byte of each character of UTF-16 and so makes Latin 1; what that lacks becomes `?`.
 * The result may lie where the characters lay. */
void stp_source_narrow(unsigned char *out, const unsigned char *characters, size_t count,
                       uint8_t wide);
/* Reads on from the begin as UTF-16. */
void stp_source_widen(stp_source *source, uint8_t wide);
/* Continues at this byte. line is the number of the line before the byte; later line numbers go on
 * from there. */
void stp_source_seek(stp_source *source, uint64_t offset, uint64_t line);
/* Gives the next size bytes, valid until the next call. Gives fewer (*available < size) only at the
 * end of the file. Does not consume. Errors: IO, LIMIT, OUT_OF_MEMORY. */
stp_status stp_source_peek(stp_source *source, size_t size, const unsigned char **bytes,
                           size_t *available, stp_error *err);
/* Consumes size bytes that were peeked. */
static inline void stp_source_consume(stp_source *source, size_t size)
{
    source->begin += size;
    source->offset += size;
}
/* Consumes size bytes, peeked or not. The caller knows that the file has them. */
void stp_source_skip(stp_source *source, uint64_t size);
/* Gives the next line without its \n or \r\n (of cr_lines its \r), valid until the next call, and
 * consumes it. *begin is NULL at the end of the file. Errors: IO, LIMIT (line too long),
 * OUT_OF_MEMORY. */
stp_status stp_source_line(stp_source *source, const char **begin, const char **end,
                           stp_error *err);

/* Enough for any model. */
#define STP_SALVAGE_RECORDS_MOST (UINT64_C(1) << 38)

/* For salvage: lowers a count that a header declares to the `fit` that the file has room for, and
 * sets *lost to the difference. False, and nothing changes, if the count is more than any model
 * holds: then the header is wrong, and not only the file cut. */
static inline bool stp_salvage_count(uint64_t *count, uint64_t fit, uint64_t *lost)
{
    if (*count > STP_SALVAGE_RECORDS_MOST)
        return false;
    *lost = *count - fit;
    *count = fit;
    return true;
}

/* Finds the next run of characters other than space and tab in [*at, end). Moves *at to its end and
 * returns its begin; NULL if there is none. */
static inline const char *stp_token(const char **at, const char *end)
{
    const char *begin = *at;
    while (begin < end && (*begin == ' ' || *begin == '\t'))
        begin++;
    const char *stop = begin;
    while (stop < end && *stop != ' ' && *stop != '\t')
        stop++;
    *at = stop;
    return begin < stop ? begin : NULL;
}

/* Leaves out spaces at both ends of a text. */
static inline void stp_trim(const char **begin, const char **end)
{
    while (*begin < *end && isspace((unsigned char)**begin))
        ++*begin;
    while (*end > *begin && isspace((unsigned char)(*end)[-1]))
        --*end;
}

#endif
