/* Addresses of files on web servers: as a request needs them, and as they may be printed.
 * Threads: any. */
#ifndef STP_FORMATS_CHUNK_REMOTE_HTTP_ADDRESS_H
#define STP_FORMATS_CHUNK_REMOTE_HTTP_ADDRESS_H

#include "base/error.h"

/* Behind the host, bytes that an address may not hold (spaces, accents, control characters, a
 * percent sign that begins no code) become percent codes; what is one already stays. Free with
 * free(). Errors: OUT_OF_MEMORY. */
stp_status stp_http_address_encode(const char *address, char **out, stp_error *err);
/* Without user and password; a query, which may be a key as well, becomes "?...". Free with free().
 * Errors: OUT_OF_MEMORY. */
stp_status stp_http_address_name(const char *address, char **out, stp_error *err);

#endif
