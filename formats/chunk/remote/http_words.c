/* Writes the error messages for failed requests. */
#include "formats/chunk/remote/http_words.h"

#include <inttypes.h>

static stp_status say_refused(const char *name, int code, stp_error *err)
{
    if (code == 404 || code == 410)
        return stp_error_set(err, STP_NOT_FOUND,
                             "%s: the server has no such file (%d): check the address", name, code);
    if (code == 401 || code == 403 || code == 407)
        return stp_error_set(err, STP_IO,
                             "%s: the server refuses access (%d): ask for it, or check user, "
                             "password or key in the address",
                             name, code);
    return stp_error_set(err, STP_IO, "%s: the server answers %d: try again later", name, code);
}

stp_status stp_http_say_changed(const char *name, stp_error *err)
{
    return stp_error_set(
        err, STP_IO, "%s: the file changed on the server while it was read: open it again", name);
}

stp_status stp_http_say_verdict(const char *name, const stp_http_transfer *t, stp_error *err)
{
    const stp_http_answer *a = &t->answer;
    switch (t->verdict) {
    case STP_HTTP_CHANGED:
        return stp_http_say_changed(name, err);
    case STP_HTTP_WHOLE:
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: the server does not serve parts of files (no byte ranges): copy "
                             "the file here, or use a server that does",
                             name);
    case STP_HTTP_ENCODED:
        return stp_error_set(err, STP_UNSUPPORTED,
                             "%s: the server sends the file compressed: turn that off for "
                             ".stipple files there, or copy the file here",
                             name);
    case STP_HTTP_WRONG_RANGE:
        if (a->code == 416)
            return stp_error_set(err, STP_IO,
                                 "%s: the server says that the file has no bytes %" PRIu64
                                 " to %" PRIu64 " (416): copy the file here, or use another server",
                                 name, t->offset, t->offset + t->size - 1);
        if (a->has_range && !a->has_total && t->identity == NULL)
            return stp_error_set(err, STP_IO,
                                 "%s: the server does not say how large the file is "
                                 "(Content-Range): copy the file here, or use another server",
                                 name);
        if (a->has_range)
            return stp_error_set(err, STP_IO,
                                 "%s: the server sent bytes %" PRIu64 " to %" PRIu64
                                 " where %" PRIu64 " to %" PRIu64
                                 " were asked for: copy the file here, or use another server",
                                 name, a->begin, a->last, t->offset, t->offset + t->size - 1);
        return stp_error_set(err, STP_IO,
                             "%s: the server does not say which bytes it sends (Content-Range): "
                             "copy the file here, or use another server",
                             name);
    default:
        return say_refused(name, a->code, err);
    }
}

stp_status stp_http_say_failure(const char *name, const stp_http_transfer *t,
                                const stp_http_connection *c, stp_error *err)
{
    if (t->endless)
        return stp_error_set(err, STP_IO,
                             "%s: the server sends more than was asked for: copy the file here, or "
                             "use another server",
                             name);
    if (t->result == CURLE_UNSUPPORTED_PROTOCOL && t->answer.code / 100 == 3)
        return stp_error_set(err, STP_IO,
                             "%s: the server leads elsewhere, to what is not as safe: give the "
                             "address it leads to",
                             name);
    switch (t->result) {
    case CURLE_OUT_OF_MEMORY:
        if (t->heard_s > 0.0) /* an answer began: libcurl has no room for one of its lines */
            return stp_error_set(err, STP_IO,
                                 "%s: the server's headers are larger than any should be: copy the "
                                 "file here, or use another server",
                                 name);
        return stp_error_set(err, STP_OUT_OF_MEMORY, "%s: no memory for a request", name);
    case CURLE_URL_MALFORMAT:
        return stp_error_set(err, STP_INVALID_ARGUMENT,
                             "%s: this is no web address: write it like https://host/file", name);
    case CURLE_COULDNT_RESOLVE_HOST:
        return stp_error_set(err, STP_IO, "%s: no such host: check the address and the network",
                             name);
    case CURLE_TOO_MANY_REDIRECTS:
        return stp_error_set(err, STP_IO,
                             "%s: the server leads elsewhere more than %ld times: check the "
                             "address",
                             name, STP_HTTP_REDIRECTIONS_LIMIT);
    case CURLE_PEER_FAILED_VERIFICATION:
    case CURLE_SSL_CACERT_BADFILE:
        return stp_error_set(err, STP_IO,
                             "%s: the server's certificate is not trusted: %s: check the address, "
                             "or name its authority in CURL_CA_BUNDLE",
                             name, c->text);
    case CURLE_OPERATION_TIMEDOUT:
        return stp_error_set(err, STP_IO,
                             "%s: the server did not answer in time: check the network, or try "
                             "again later",
                             name);
    case CURLE_OK:
        return stp_error_set(err, STP_IO,
                             "%s: the server cut its answer short: check the network, or try again "
                             "later",
                             name);
    default:
        return stp_error_set(err, STP_IO, "%s: reading from the server failed: %s: try again later",
                             name,
                             c->text[0] != '\0' ? c->text : c->curl->easy_strerror(t->result));
    }
}
