/* Parses the headers of an answer to a range request.
 *
 * Takes them line by line, as they come; treats every byte as hostile. Threads: any, one answer
 * each. */
#ifndef STP_FORMATS_CHUNK_REMOTE_HTTP_ANSWER_H
#define STP_FORMATS_CHUNK_REMOTE_HTTP_ANSWER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define STP_HTTP_IDENTITY_LIMIT 256

typedef struct stp_http_answer {
    int code;       /* of the last status line; 0: none came */
    bool has_range; /* a whole Content-Range: bytes begin-last/total */
    bool has_total; /* the answer said how many bytes the file has */
    bool has_length;
    bool encoded; /* compressed, or otherwise not the file's bytes */
    bool parts;   /* the body has parts: multipart/byteranges */
    uint64_t begin, last, total;
    uint64_t length;                    /* Content-Length */
    char etag[STP_HTTP_IDENTITY_LIMIT]; /* as sent, cut to this length */
    char modified[64];                  /* Last-Modified, as sent */
} stp_http_answer;

/* Takes a header line, including its end. A status line starts the answer anew. */
void stp_http_answer_line(stp_http_answer *answer, const char *line, size_t size);

/* What tells this state of the file from others: a strong ETag, else Last-Modified. Empty if the
 * server sends neither. */
const char *stp_http_answer_identity(const stp_http_answer *answer);

#endif
