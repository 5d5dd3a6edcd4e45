/* The connections to one server: kept alive, each with one request at a time.
 *
 * Opens few if few are needed. A server that refuses a request by 429 or 503, or that closes one of
 * several connections without an answer, gets fewer requests at a time from then on, and after some
 * good answers one more. Remembers where the server's last redirection led. Threads: any. */
#ifndef STP_FORMATS_CHUNK_REMOTE_HTTP_CONNECTIONS_H
#define STP_FORMATS_CHUNK_REMOTE_HTTP_CONNECTIONS_H

#include "formats/chunk/remote/http_transfer.h"

#include <pthread.h>

typedef struct stp_http_connections {
    /* Set before the first request; borrowed. */
    const stp_curl *curl;
    const char *address, *name;
    unsigned connect_ms;
    /* The rest is the connections' own. */
    char *moved;           /* target of the server's last redirection; NULL: none */
    unsigned limit, calm;  /* requests in flight at most; good answers since it changed */
    pthread_mutex_t mutex; /* guards all below `curl`, and of each .busy, .answered, .multi;
                              only that of http.c's patience may follow */
    pthread_cond_t freed;  /* a connection is free, or reads are to end; on the monotonic clock */
    stp_http_connection each[STP_SOURCE_CONNECTIONS];
} stp_http_connections;

/* all: zeroed. Clear also before the first request. */
void stp_http_connections_init(stp_http_connections *all);
void stp_http_connections_clear(stp_http_connections *all);

/* Waits for a free connection, one that is open if there is any. *out is NULL if the read is over:
 * it was ended, or nobody wants its bytes. Errors: OUT_OF_MEMORY. */
stp_status stp_http_acquire(stp_http_connections *all, const stp_http_transfer *t,
                            stp_http_connection **out, stp_error *err);
/* Ends a transfer's use of a connection. Sets t->crowded. */
void stp_http_release(stp_http_connections *all, stp_http_connection *c, stp_http_transfer *t);

/* Waits between two tries of a read, or until it is over. */
void stp_http_pause(stp_http_connections *all, const stp_http_transfer *t, double seconds);
/* Makes all who wait look whether their reads are over. */
void stp_http_wake(stp_http_connections *all);

/* Sends the next request straight to the last redirection's target, if there is one. True if so. */
bool stp_http_choose_address(stp_http_connections *all, stp_http_connection *c);
/* Remembers where a good answer came from. */
void stp_http_remember_address(stp_http_connections *all, const stp_http_connection *c);
void stp_http_forget_address(stp_http_connections *all);

#endif
