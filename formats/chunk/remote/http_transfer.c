/* One try of a request: libcurl's callbacks, the clock of stalls, and the judgement of the
 * answer before any of its bytes is taken. */
#include "formats/chunk/remote/http_transfer.h"

#include "base/clock.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#define HEADERS_LIMIT 65536u
#define POLL_MS 100
/* Some servers count their bytes wrong by less than this, and still send the right ones. */
#define LENGTH_SLACK 65536u

/* ---- judging ---- */

static bool has_changed(const stp_http_transfer *t)
{
    const stp_http_answer *a = &t->answer;
    if (t->identity == NULL)
        return false;
    return strcmp(stp_http_answer_identity(a), t->identity) != 0 ||
           (a->has_total && a->total != t->file_bytes);
}

/* The most bytes that a body may have: headers of parts and gaps between them included. */
static size_t most_bytes(const stp_http_transfer *t)
{
    return t->apart ? t->size + t->range_count * 2 * STP_HTTP_PART_BYTES
                    : (size_t)(t->answer.last - t->answer.begin) + 1;
}

/* Judges an answer to a request for several ranges. Whatever is not right may be so because the
 * server does not know such requests: those for one range will tell. */
static stp_http_verdict judge_apart(const stp_http_transfer *t)
{
    const stp_http_answer *a = &t->answer;
    if (a->code != 206 && a->code != 416)
        return a->code == 200 ? STP_HTTP_WHOLE : STP_HTTP_REFUSED;
    /* some servers answer with one range that holds all, or with the first */
    const bool good = a->parts || a->has_range;
    return good && a->code == 206 && !a->encoded && !has_changed(t) ? STP_HTTP_GOOD
                                                                    : STP_HTTP_WRONG_RANGE;
}

static stp_http_verdict judge_range(const stp_http_transfer *t)
{
    const stp_http_answer *a = &t->answer;
    if (a->encoded)
        return STP_HTTP_ENCODED;
    if (!a->has_range || a->begin != t->offset || a->last >= t->offset + t->size)
        return STP_HTTP_WRONG_RANGE;
    if (t->identity == NULL) { /* the first answer tells the file's size */
        uint64_t end = t->offset + t->size;
        if (!a->has_total || a->last + 1 != (end < a->total ? end : a->total))
            return STP_HTTP_WRONG_RANGE;
    }
    return STP_HTTP_GOOD;
}

static stp_http_verdict judge(const stp_http_transfer *t)
{
    const stp_http_answer *a = &t->answer;
    if (t->apart)
        return judge_apart(t);
    switch (a->code) {
    case 206:
        return has_changed(t) ? STP_HTTP_CHANGED : judge_range(t);
    case 200:
        if (t->identity == NULL && a->has_length && a->length == 0)
            return STP_HTTP_EMPTY;
        return has_changed(t) ||
                       (t->identity != NULL && a->has_length && a->length != t->file_bytes)
                   ? STP_HTTP_CHANGED
                   : STP_HTTP_WHOLE;
    case 416: /* the range is not there: there never was one, or there is none any more */
        if (t->identity != NULL)
            return STP_HTTP_CHANGED;
        return a->has_total && a->total == 0 ? STP_HTTP_EMPTY : STP_HTTP_WRONG_RANGE;
    default:
        return STP_HTTP_REFUSED;
    }
}

/* ---- libcurl's callbacks ---- */

static void hear(stp_http_transfer *t)
{
    t->heard_s = stp_clock_seconds();
}

/* Ends the transfer if the headers alone rule it out. Redirections and errors may have bodies. */
static void refuse_early(stp_http_transfer *t)
{
    const stp_http_answer *a = &t->answer;
    if (a->code != 200 && a->code != 206)
        return;
    const stp_http_verdict verdict = judge(t);
    if (verdict != STP_HTTP_GOOD)
        t->verdict = verdict;
    else if (a->has_length && a->length > most_bytes(t) + LENGTH_SLACK)
        t->endless = true;
}

static size_t take_header(char *line, size_t one, size_t size, void *context)
{
    stp_http_transfer *t = context;
    (void)one; /* it is 1 */
    hear(t);
    t->header_bytes += size;
    t->endless = t->header_bytes > HEADERS_LIMIT;
    stp_http_answer_line(&t->answer, line, size);
    if (line[0] == '\r' || line[0] == '\n') /* the last line of the headers */
        refuse_early(t);
    return t->endless || t->verdict != STP_HTTP_NONE ? 0 : size;
}

static size_t take_body(char *bytes, size_t one, size_t size, void *context)
{
    stp_http_transfer *t = context;
    (void)one;
    hear(t);
    if (t->verdict == STP_HTTP_NONE)
        t->verdict = judge(t);
    if (t->verdict != STP_HTTP_GOOD)
        return 0;
    t->endless = size > most_bytes(t) - t->received;
    if (t->endless)
        return 0;
    if (t->received == 0 && t->answer.has_range) {
        t->parts.at = t->answer.begin;
        t->parts.end = t->answer.last + 1;
    }
    t->received += size;
    atomic_fetch_add(t->bytes, size);
    if (stp_http_parts_take(&t->parts, bytes, size))
        return size;
    t->verdict = STP_HTTP_WRONG_RANGE;
    return 0;
}

/* libcurl sets the type: NOLINTNEXTLINE(readability-non-const-parameter) */
static int note_sent(void *context, char *to, char *from, int to_port, int from_port)
{
    stp_http_transfer *t = context;
    (void)to, (void)from, (void)to_port, (void)from_port;
    t->heard_s = stp_clock_seconds();
    return CURL_PREREQFUNC_OK;
}

/* ---- running ---- */

static bool prepare(stp_http_transfer *t, stp_http_connection *c)
{
    char range[STP_HTTP_RANGES_TEXT];
    const stp_http_missing missing = stp_http_missing_of(t->ranges, t->range_count);
    t->offset = missing.begin;
    t->apart = t->apart && stp_http_missing_write(t->ranges, t->range_count, range) > 1;
    t->size = t->apart ? missing.bytes : (size_t)(missing.end - missing.begin);
    t->parts =
        (stp_http_parts){.ranges = t->ranges, .count = t->range_count, .file_bytes = t->file_bytes};
    if (!t->apart)
        snprintf(range, sizeof range, "%" PRIu64 "-%" PRIu64, missing.begin, missing.end - 1);
    c->text[0] = '\0';
    return c->curl->easy_setopt(c->easy, CURLOPT_RANGE, range) == CURLE_OK &&
           c->curl->easy_setopt(c->easy, CURLOPT_HTTPHEADER, t->headers) == CURLE_OK &&
           c->curl->easy_setopt(c->easy, CURLOPT_HEADERFUNCTION, take_header) == CURLE_OK &&
           c->curl->easy_setopt(c->easy, CURLOPT_HEADERDATA, t) == CURLE_OK &&
           c->curl->easy_setopt(c->easy, CURLOPT_WRITEFUNCTION, take_body) == CURLE_OK &&
           c->curl->easy_setopt(c->easy, CURLOPT_WRITEDATA, t) == CURLE_OK &&
           c->curl->easy_setopt(c->easy, CURLOPT_PREREQFUNCTION, note_sent) == CURLE_OK &&
           c->curl->easy_setopt(c->easy, CURLOPT_PREREQDATA, t) == CURLE_OK &&
           c->curl->multi_add_handle(c->multi, c->easy) == CURLM_OK;
}

/* Connecting has libcurl's own time-out; what comes after has ours. */
static bool is_late(const stp_http_transfer *t, double begin_s)
{
    double now_s = stp_clock_seconds();
    double most_s = (t->connect_ms + t->stall_ms) / 1e3 + (double)t->size / STP_HTTP_SLOWEST_RATE;
    return (t->heard_s > 0.0 && now_s - t->heard_s > t->stall_ms / 1e3) || now_s - begin_s > most_s;
}

bool stp_http_transfer_is_whole(const stp_http_transfer *t)
{
    const bool all = t->apart ? stp_http_missing_of(t->ranges, t->range_count).bytes == 0
                              : t->received == t->answer.last - t->answer.begin + 1;
    return t->verdict == STP_HTTP_GOOD && !t->endless && all;
}

bool stp_http_transfer_is_wanted(const stp_http_transfer *t)
{
    return t->wish == NULL || t->wish->is_wanted(t->wish->context);
}

/* Whether nobody has wanted the bytes for long. */
static bool is_given_up(stp_http_transfer *t)
{
    const double now_s = stp_clock_seconds();
    if (stp_http_transfer_is_wanted(t))
        t->unwanted_s = 0.0;
    else if (t->unwanted_s <= 0.0)
        t->unwanted_s = now_s;
    return t->unwanted_s > 0.0 && now_s - t->unwanted_s >= STP_SOURCE_UNWANTED_MS / 1e3;
}

static CURLcode run(stp_http_transfer *t, stp_http_connection *c)
{
    double begin_s = stp_clock_seconds();
    int running = 1, left = 0;
    while (running > 0) {
        if (t->ended(t->ended_context) || is_given_up(t))
            return CURLE_ABORTED_BY_CALLBACK;
        if (c->curl->multi_perform(c->multi, &running) != CURLM_OK)
            return CURLE_FAILED_INIT;
        if (running > 0 && is_late(t, begin_s))
            return CURLE_OPERATION_TIMEDOUT;
        if (running > 0)
            (void)c->curl->multi_poll(c->multi, NULL, 0, POLL_MS, NULL);
    }
    const CURLMsg *message = c->curl->multi_info_read(c->multi, &left);
    return message != NULL ? message->data.result : CURLE_FAILED_INIT;
}

void stp_http_transfer_run(stp_http_transfer *t, stp_http_connection *c)
{
    t->result = prepare(t, c) ? run(t, c) : CURLE_OUT_OF_MEMORY;
    (void)c->curl->multi_remove_handle(c->multi, c->easy);
    /* An answer without a body, or with a body that was refused, is judged by its headers. */
    if (t->verdict == STP_HTTP_NONE && t->result == CURLE_OK)
        t->verdict = judge(t);
}
