/* A web server for tests that serves one file by ranges and misbehaves on order.
 *
 * It listens on a free port of the loopback. The server and each of its connections are processes;
 * they end with the test or with destroy. Requests count from 0. Threads: one at a time. */
#ifndef STP_TESTS_SUPPORT_FAULT_SERVER_H
#define STP_TESTS_SUPPORT_FAULT_SERVER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

typedef enum fault_kind {
    FAULT_NONE = 0,
    FAULT_STALL,         /* no answer */
    FAULT_STALL_HEADERS, /* half of the headers, then no more */
    FAULT_STALL_BODY,    /* half of the body, then no more */
    FAULT_TRICKLE,       /* a byte every 20 ms, headers and body */
    FAULT_DRIP,          /* a byte every second */
    FAULT_CUT,           /* cuts the connection without an answer */
    FAULT_CUT_BODY,      /* cuts it after half of the body */
    FAULT_GARBAGE,       /* no HTTP */
    FAULT_ENDLESS,       /* endless headers */
    FAULT_HUGE_HEADER,   /* one header of a megabyte */
    FAULT_NO_TOTAL,      /* Content-Range with a star for the file's size */
    FAULT_VAST,          /* Content-Length of 2^62, then nothing */
    FAULT_RANGE_NONE,    /* 206 without Content-Range */
    FAULT_RANGE_JUNK,
    FAULT_RANGE_OTHER, /* names and sends the range one byte later */
    FAULT_RANGE_LONG,  /* one byte more than asked */
    FAULT_RANGE_SHORT, /* names and sends half of the range */
    FAULT_TOTAL,       /* says that the file has a byte more */
    FAULT_WHOLE,       /* 200 and all bytes */
    FAULT_STATUS,      /* `code`, with Retry-After where `retry_after` is not 0 */
    FAULT_CHANGED,     /* from then on it is another file, with another ETag and other bytes */
    FAULT_FLIP,        /* flips a bit in the middle */
    FAULT_LENGTH_LONG, /* Content-Length exceeds the body */
    FAULT_LENGTH_SHORT,
    FAULT_BODY_LONG,  /* no Content-Length, and a body longer than the range */
    FAULT_BODY_SHORT, /* no Content-Length, and half of the body */
    FAULT_ENCODED,    /* Content-Encoding: gzip */
    FAULT_MOVED,      /* 302 to the same file under another name */
    FAULT_LOOP,       /* 302 to itself */
    FAULT_ELSEWHERE,  /* 302 to file:///etc/passwd */
    /* for requests of several ranges */
    FAULT_PARTS_FIRST,    /* the first range alone */
    FAULT_PARTS_JOINED,   /* one range that holds all */
    FAULT_PARTS_BACKWARDS /* the last range first */
} fault_kind;

typedef enum fault_validator {
    FAULT_ETAG = 0, /* a strong ETag and Last-Modified */
    FAULT_ETAG_WEAK,
    FAULT_MODIFIED, /* Last-Modified alone */
    FAULT_NO_VALIDATOR
} fault_validator;

typedef struct fault_orders {
    fault_kind kind;
    unsigned first, count; /* the requests that get the fault, */
    unsigned every;        /* and of these every n-th from the first on; 0: all */
    int code, retry_after;
    bool apart;    /* the fault is for requests of several ranges alone */
    unsigned most; /* connections at a time; others are closed without an answer. 0: no limit */
    fault_validator validator;
} fault_orders;

typedef struct fault_server {
    struct fault_shared *shared;
    size_t shared_bytes;
    pid_t process;
    char address[64]; /* http://127.0.0.1:PORT/model.stipple */
} fault_server;

/* Starts a server with a copy of the bytes. Returns false if it cannot. */
bool fault_server_create(fault_server *out, const void *bytes, size_t size);
void fault_server_destroy(fault_server *server);
/* Sets the orders from now on; requests count from 0 again. */
void fault_server_order(fault_server *server, const fault_orders *orders);
unsigned fault_server_requests(const fault_server *server);
/* Those for several ranges. */
unsigned fault_server_apart(const fault_server *server);
/* The bytes of bodies sent since the last order. */
uint64_t fault_server_bytes(const fault_server *server);

#endif
