/* Reads ranges of one file on a web server, through libcurl: stp_byte_source reads addresses with
 * it.
 *
 * Keeps up to STP_SOURCE_CONNECTIONS connections alive, each with one request at a time; a further
 * read waits for a free one. A server that refuses a request by 429 or 503, or that closes one of
 * several connections without an answer, gets fewer at a time.
 * Certificates are checked, with the system's authorities or those of CURL_CA_BUNDLE or
 * SSL_CERT_FILE. Proxies are those of the environment, as with curl. At most five redirections are
 * followed, from https to https only; later requests go straight to their target. Threads: as
 * byte_source.h says. */
#ifndef STP_FORMATS_CHUNK_REMOTE_HTTP_H
#define STP_FORMATS_CHUNK_REMOTE_HTTP_H

#include "formats/chunk/byte_source.h"

/* The first bytes of the file, both copies of its header; the request that opens it brings them. */
#define STP_HTTP_HEAD_BYTES 2048u

typedef struct stp_http stp_http;

/* Sends one request for the file's size, its state on the server and its first bytes. Errors: those
 * of stp_byte_source_open. */
stp_status stp_http_open(stp_http **out, const char *address, const stp_byte_source_params *params,
                         stp_error *err);
void stp_http_close(stp_http **http);

uint64_t stp_http_size(const stp_http *http);
const char *stp_http_name(const stp_http *http);
/* The address as requests have it, with percent codes: not to be printed. */
const char *stp_http_address(const stp_http *http);
/* Tells this state of the file from others; empty if the server does not identify states. */
const char *stp_http_identity(const stp_http *http);
/* The first min(size, STP_HTTP_HEAD_BYTES) bytes. */
const uint8_t *stp_http_head(const stp_http *http);

/* How many ranges one request may bring: STP_SOURCE_RANGES; 2, until it is known whether the server
 * takes such requests; 1, if it does not. */
unsigned stp_http_ranges(const stp_http *http);
/* As stp_byte_source_gap. */
uint32_t stp_http_gap(const stp_http *http);
/* As stp_byte_source_read_ranges, for what `got` says is missing; ranges must lie inside the file.
 * fresh: caches on the way must ask the server. */
stp_status stp_http_read_ranges(stp_http *http, stp_byte_range *ranges, size_t count, bool fresh,
                                const stp_read_wish *wish, stp_error *err);
void stp_http_cancel(stp_http *http);
void stp_http_resume(stp_http *http);
/* Adds requests, retries and bytes to stats. */
void stp_http_add_stats(const stp_http *http, stp_byte_source_stats *stats);

#endif
