/* A web server of the tests' own that serves one file by ranges, and does wrong where it is told
 * to.
 *
 * It listens on a free port of the loopback; it and each of its connections are processes, which
 * end with the test's or with destroy. Requests count from 0. Threads: one at a time. */
#ifndef STP_TESTS_SUPPORT_FAULT_SERVER_H
#define STP_TESTS_SUPPORT_FAULT_SERVER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

typedef enum fault_kind {
    FAULT_NONE = 0,
    FAULT_STALL,         /* no answer */
    FAULT_STALL_HEADERS, /* half of them */
    FAULT_STALL_BODY,    /* half of it */
    FAULT_TRICKLE,       /* a byte every 20 ms, of headers and body */
    FAULT_DRIP,          /* a byte every second */
    FAULT_CUT,           /* the connection, without an answer */
    FAULT_CUT_BODY,      /* half of it */
    FAULT_GARBAGE,       /* no HTTP */
    FAULT_ENDLESS,       /* headers */
    FAULT_HUGE_HEADER,   /* one, of a megabyte */
    FAULT_NO_TOTAL,      /* Content-Range with a star for the file's size */
    FAULT_VAST,          /* Content-Length of 2^62, and nothing comes */
    FAULT_RANGE_NONE,    /* 206 without Content-Range */
    FAULT_RANGE_JUNK,
    FAULT_RANGE_OTHER, /* it says, and sends, one byte on */
    FAULT_RANGE_LONG,  /* one byte more than asked */
    FAULT_RANGE_SHORT, /* rightly says and sends half of it */
    FAULT_TOTAL,       /* it says the file has a byte more */
    FAULT_WHOLE,       /* 200 and all bytes */
    FAULT_STATUS,      /* `code`, with Retry-After where `retry_after` is not 0 */
    FAULT_CHANGED,     /* from then on the file is another: its ETag and bytes */
    FAULT_FLIP,        /* a bit in the middle */
    FAULT_LENGTH_LONG, /* Content-Length says more than comes */
    FAULT_LENGTH_SHORT,
    FAULT_BODY_LONG,  /* no Content-Length, and more comes than the range says */
    FAULT_BODY_SHORT, /* no Content-Length, and half comes */
    FAULT_ENCODED,    /* Content-Encoding: gzip */
    FAULT_MOVED,      /* 302 to the same file under another name */
    FAULT_LOOP,       /* 302 to itself */
    FAULT_ELSEWHERE   /* 302 to file:///etc/passwd */
} fault_kind;

typedef enum fault_validator {
    FAULT_ETAG = 0, /* strong, and Last-Modified */
    FAULT_ETAG_WEAK,
    FAULT_MODIFIED, /* Last-Modified alone */
    FAULT_NO_VALIDATOR
} fault_validator;

typedef struct fault_orders {
    fault_kind kind;
    unsigned first, count; /* requests that get it, */
    unsigned every;        /* and of these only each so many-th, from the first on; 0: all */
    int code, retry_after;
    fault_validator validator;
} fault_orders;

typedef struct fault_server {
    struct fault_shared *shared;
    size_t shared_bytes;
    pid_t process;
    char address[64]; /* http://127.0.0.1:PORT/model.stipple */
} fault_server;

/* Copies the bytes. False if no server can be had. */
bool fault_server_create(fault_server *out, const void *bytes, size_t size);
void fault_server_destroy(fault_server *server);
/* From now on; requests count from 0 again. */
void fault_server_order(fault_server *server, const fault_orders *orders);
unsigned fault_server_requests(const fault_server *server);
/* Bytes of bodies sent since the last order. */
uint64_t fault_server_bytes(const fault_server *server);

#endif
