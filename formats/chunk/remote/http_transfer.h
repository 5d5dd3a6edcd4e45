/* One try of a range request on one connection, and what became of it. */
#ifndef STP_FORMATS_CHUNK_REMOTE_HTTP_TRANSFER_H
#define STP_FORMATS_CHUNK_REMOTE_HTTP_TRANSFER_H

#include "formats/chunk/remote/curl_library.h"
#include "formats/chunk/remote/http_answer.h"

#include <stdatomic.h>

/* Slower than so many bytes a second is not waited for. */
#define STP_HTTP_SLOWEST_RATE 1024.0

/* What an answer's headers say of it. */
typedef enum stp_http_verdict {
    STP_HTTP_NONE = 0,    /* no whole headers came */
    STP_HTTP_GOOD,        /* the range asked for, or, of an unknown size, the beginning of it */
    STP_HTTP_EMPTY,       /* the file has no bytes */
    STP_HTTP_CHANGED,     /* another state of the file */
    STP_HTTP_WHOLE,       /* 200: the server does not serve ranges */
    STP_HTTP_WRONG_RANGE, /* not the one asked for, or none */
    STP_HTTP_ENCODED,     /* compressed */
    STP_HTTP_REFUSED      /* any other code */
} stp_http_verdict;

/* A kept connection. `easy` has the options that are the same for all requests. */
typedef struct stp_http_connection {
    const stp_curl *curl;
    CURLM *multi;
    CURL *easy;
    char text[CURL_ERROR_SIZE]; /* libcurl's, of the last failure */
    bool busy;
} stp_http_connection;

typedef struct stp_http_transfer {
    /* asked for */
    uint64_t offset;
    uint8_t *data;
    size_t size;
    uint64_t file_bytes;  /* UINT64_MAX: not known yet; then less may come */
    const char *identity; /* of the answers before; NULL: not known yet */
    struct curl_slist *headers;
    unsigned stall_ms, connect_ms;
    bool (*ended)(void *context); /* the read is cancelled */
    void *ended_context;
    atomic_uint_fast64_t *bytes; /* counts good ones as they come */
    /* came of it */
    stp_http_answer answer;
    stp_http_verdict verdict;
    size_t received; /* good bytes in data */
    double heard_s;  /* when a byte last came, or the request was sent; 0: not sent yet */
    size_t header_bytes;
    bool endless; /* more headers or bytes than an answer may have */
    CURLcode result;
} stp_http_transfer;

/* Runs the transfer to its end: an answer, a failure (`result`), or a time-out
 * (CURLE_OPERATION_TIMEDOUT); CURLE_ABORTED_BY_CALLBACK where `ended` said so. */
void stp_http_transfer_run(stp_http_transfer *transfer, stp_http_connection *connection);

#endif
