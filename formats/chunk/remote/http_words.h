/* Error messages for failed requests: one sentence each, with what to do. name: of the file, fit to
 * be printed. Threads: any. */
#ifndef STP_FORMATS_CHUNK_REMOTE_HTTP_WORDS_H
#define STP_FORMATS_CHUNK_REMOTE_HTTP_WORDS_H

#include "base/error.h"
#include "formats/chunk/remote/http_transfer.h"

#define STP_HTTP_REDIRECTIONS_LIMIT 5L

/* Each function returns the status that it reports. */
stp_status stp_http_say_changed(const char *name, stp_error *err);
/* For an answer that is not the one asked for. */
stp_status stp_http_say_verdict(const char *name, const stp_http_transfer *transfer,
                                stp_error *err);
/* For an answer that did not come, or not whole. */
stp_status stp_http_say_failure(const char *name, const stp_http_transfer *transfer,
                                const stp_http_connection *connection, stp_error *err);

#endif
