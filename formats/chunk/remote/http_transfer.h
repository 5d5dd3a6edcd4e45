/* One try of a request on one connection, and what became of it. */
#ifndef STP_FORMATS_CHUNK_REMOTE_HTTP_TRANSFER_H
#define STP_FORMATS_CHUNK_REMOTE_HTTP_TRANSFER_H

#include "formats/chunk/byte_source.h"
#include "formats/chunk/remote/curl_library.h"
#include "formats/chunk/remote/http_parts.h"

#include <stdatomic.h>

/* Transfers slower than this many bytes a second are given up. */
#define STP_HTTP_SLOWEST_RATE 1024.0

/* What an answer's headers say about the answer. */
typedef enum stp_http_verdict {
    STP_HTTP_NONE = 0,    /* no whole headers came */
    STP_HTTP_GOOD,        /* what was asked for, or, if the size is unknown, its beginning */
    STP_HTTP_EMPTY,       /* the file has no bytes */
    STP_HTTP_CHANGED,     /* another state of the file */
    STP_HTTP_WHOLE,       /* 200: the server does not serve ranges */
    STP_HTTP_WRONG_RANGE, /* another range than asked for, or none */
    STP_HTTP_ENCODED,     /* compressed */
    STP_HTTP_REFUSED      /* any other code */
} stp_http_verdict;

/* A kept connection. `easy` has the options that are the same for all requests. */
typedef struct stp_http_connection {
    const stp_curl *curl;
    CURLM *multi;
    CURL *easy;
    char text[CURL_ERROR_SIZE]; /* libcurl's text of the last failure */
    bool busy;
    bool answered; /* so was its last request: the server has it open, most likely */
} stp_http_connection;

typedef struct stp_http_transfer {
    /* the request: what is missing of these ranges, which are in order */
    stp_byte_range *ranges;
    size_t range_count;
    bool apart; /* by several ranges, not by one that holds all; made false if one does as well */
    uint64_t file_bytes;  /* UINT64_MAX: unknown; then less than was asked for may come */
    const char *identity; /* from earlier answers; NULL: not known yet */
    struct curl_slist *headers;
    unsigned stall_ms, connect_ms;
    bool (*ended)(void *context); /* true: the read is cancelled */
    void *ended_context;
    const stp_read_wish *wish;   /* NULL: it is always wanted */
    atomic_uint_fast64_t *bytes; /* counts good bytes as they come */
    /* the result */
    uint64_t offset; /* of what was asked for, */
    size_t size;     /* and its bytes */
    stp_http_answer answer;
    stp_http_verdict verdict;
    size_t received; /* of the body */
    stp_http_parts parts;
    double heard_s; /* when the last byte came, or the request was sent; 0: not sent yet */
    size_t header_bytes;
    double unwanted_s; /* since when nobody wants the bytes; 0: somebody does */
    bool endless;      /* more headers or bytes than an answer may have */
    CURLcode result;
    bool crowded; /* the server closed the connection, but not all others */
} stp_http_transfer;

/* Whether somebody wants the bytes. */
bool stp_http_transfer_is_wanted(const stp_http_transfer *transfer);
/* Whether all bytes came that the answer said it has. */
bool stp_http_transfer_is_whole(const stp_http_transfer *transfer);
/* Runs the transfer to its end: an answer, a failure (`result`), or a time-out
 * (CURLE_OPERATION_TIMEDOUT); CURLE_ABORTED_BY_CALLBACK if `ended` returned true, or nobody wanted
 * the bytes for STP_SOURCE_UNWANTED_MS. */
void stp_http_transfer_run(stp_http_transfer *transfer, stp_http_connection *connection);

#endif
