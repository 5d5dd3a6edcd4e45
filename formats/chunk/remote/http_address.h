/* Addresses of files on web servers: encoded for a request, and shortened for printing. Threads:
 * any. */
#ifndef STP_FORMATS_CHUNK_REMOTE_HTTP_ADDRESS_H
#define STP_FORMATS_CHUNK_REMOTE_HTTP_ADDRESS_H

#include "base/error.h"

/* Turns bytes behind the host that an address may not hold (spaces, accents, control characters, a
 * percent sign that begins no code) into percent codes. Percent codes stay as they are. Free with
 * free(). Errors: OUT_OF_MEMORY. */
stp_status stp_http_address_encode(const char *address, char **out, stp_error *err);
/* The address without user and password. A query, which may be a key as well, becomes "?...". Free
 * with free(). Errors: OUT_OF_MEMORY. */
stp_status stp_http_address_name(const char *address, char **out, stp_error *err);

#endif
