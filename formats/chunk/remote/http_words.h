/* What is said of a request that failed: one sentence, with what to do. name: of the file, fit to
 * be printed. Threads: any. */
#ifndef STP_FORMATS_CHUNK_REMOTE_HTTP_WORDS_H
#define STP_FORMATS_CHUNK_REMOTE_HTTP_WORDS_H

#include "base/error.h"
#include "formats/chunk/remote/http_transfer.h"

#define STP_HTTP_REDIRECTIONS_LIMIT 5L

/* Each returns the status that it says. */
stp_status stp_http_say_changed(const char *name, stp_error *err);
/* Of an answer that is not what was asked for. */
stp_status stp_http_say_verdict(const char *name, const stp_http_transfer *transfer,
                                stp_error *err);
/* Of one that did not come, or not whole. */
stp_status stp_http_say_failure(const char *name, const stp_http_transfer *transfer,
                                const stp_http_connection *connection, stp_error *err);

#endif
