/* Reads ranges of a file on a web server: kept connections, retries, redirections and patience. */
#include "formats/chunk/remote/http.h"

#include "base/clock.h"
#include "base/memory.h"
#include "base/random.h"
#include "formats/chunk/remote/http_address.h"
#include "formats/chunk/remote/http_connections.h"
#include "formats/chunk/remote/http_words.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#define UNKNOWN_SIZE UINT64_MAX
/* Waiting time that each answer earns, for servers far away. */
#define ANSWER_S 1.0

/* Reads over a gap of so many bytes rather than asking twice, if the server takes no requests for
 * several ranges. */
#define GAP_BYTES (8u << 10)
/* After so many failed requests for several ranges in a row, no more are sent. */
#define RANGES_TRIES 3u

/* Whether the server takes requests for several ranges. */
enum ranges_state { RANGES_UNKNOWN = 0, RANGES_ASKED, RANGES_TAKEN, RANGES_REFUSED };

struct stp_http {
    const stp_curl *curl;
    char *address, *name;
    stp_byte_source_params params; /* with the defaults filled in; no strings */
    struct curl_slist *headers, *fresh_headers;
    uint64_t size; /* size, identity and head do not change once the file is open */
    char identity[STP_HTTP_IDENTITY_LIMIT];
    uint8_t head[STP_HTTP_HEAD_BYTES];
    atomic_bool cancelled, changed, given_up;
    pthread_mutex_t patience; /* guards the two below; innermost */
    unsigned waiting;         /* reads that wait for the server now */
    double waited_s, since_s; /* time that reads have waited, and since when one waits now */
    atomic_uint_fast64_t requests, retries, bytes, answers;
    atomic_int ranges;         /* enum ranges_state */
    atomic_uint ranges_failed; /* requests for several ranges, in a row */
    stp_http_connections connections;
};

/* ---- patience ---- */

/* +1: a read begins to wait for the server; -1: a read stops waiting. */
static void count_waiting(stp_http *h, int change)
{
    pthread_mutex_lock(&h->patience);
    if (h->waiting == 0)
        h->since_s = stp_clock_seconds();
    h->waiting = (unsigned)((int)h->waiting + change);
    if (h->waiting == 0)
        h->waited_s += stp_clock_seconds() - h->since_s;
    pthread_mutex_unlock(&h->patience);
}

static double waited_s(stp_http *h)
{
    pthread_mutex_lock(&h->patience);
    double seconds = h->waited_s + (h->waiting > 0 ? stp_clock_seconds() - h->since_s : 0.0);
    pthread_mutex_unlock(&h->patience);
    return seconds;
}

/* Whether reads have waited for the server, in all, longer than its bytes and answers earn. */
static bool is_too_slow(stp_http *h)
{
    if (h->params.patience_ms == 0 || atomic_load(&h->given_up))
        return atomic_load(&h->given_up);
    double worth_s = h->params.patience_ms / 1e3 +
                     (double)atomic_load(&h->bytes) / STP_HTTP_SLOWEST_RATE +
                     ANSWER_S * (double)atomic_load(&h->answers);
    if (waited_s(h) > worth_s)
        atomic_store(&h->given_up, true);
    return atomic_load(&h->given_up);
}

static bool is_ended(void *context)
{
    stp_http *h = context;
    return atomic_load(&h->cancelled) || is_too_slow(h) ||
           (h->params.cancelled != NULL && h->params.cancelled(h->params.cancelled_context));
}

static stp_status say_ended(stp_http *h, stp_error *err)
{
    if (atomic_load(&h->given_up))
        return stp_error_set(err, STP_IO,
                             "%s: the server is too slow: %" PRIu64 " bytes came in %.0f s: try "
                             "again later, or wait longer (--timeout)",
                             h->name, (uint64_t)atomic_load(&h->bytes), waited_s(h));
    return stp_error_set(err, STP_CANCELLED, "%s: reading was interrupted", h->name);
}

/* ---- what became of a try ---- */

/* Failures of libcurl that another try may solve. */
static bool is_passing(CURLcode code)
{
    switch (code) {
    case CURLE_COULDNT_CONNECT:
    case CURLE_OPERATION_TIMEDOUT:
    case CURLE_PARTIAL_FILE:
    case CURLE_GOT_NOTHING:
    case CURLE_RECV_ERROR:
    case CURLE_SEND_ERROR:
    case CURLE_SSL_CONNECT_ERROR:
    case CURLE_HTTP2:
    case CURLE_HTTP2_STREAM:
    case CURLE_WEIRD_SERVER_REPLY:
        return true;
    default:
        return false;
    }
}

/* The pause before another try, seconds; 0: the usual pause; negative: no other try. */
static double retry_pause(const stp_http_transfer *t, stp_http_connection *c)
{
    curl_off_t asked_s = 0;
    int code = t->answer.code;
    if (t->endless)
        return -1.0;
    if (t->verdict != STP_HTTP_REFUSED)
        return t->verdict == STP_HTTP_GOOD || is_passing(t->result) ? 0.0 : -1.0;
    if (code != 0 && code != 429 && code != 500 && code != 502 && code != 503 && code != 504)
        return -1.0;
    if (c->curl->easy_getinfo(c->easy, CURLINFO_RETRY_AFTER, &asked_s) != CURLE_OK || asked_s <= 0)
        return 0.0;
    return asked_s <= (curl_off_t)(STP_SOURCE_PAUSE_LIMIT_MS / 1000u) ? (double)asked_s : -1.0;
}

/* ---- tries ---- */

/* Turns a try that did not bring everything into a status. moved: the try asked the redirection's
 * target. */
static stp_status take_failure(stp_http *h, const stp_http_transfer *t, stp_http_connection *c,
                               bool moved, double *pause_s, stp_error *err)
{
    if (t->result == CURLE_ABORTED_BY_CALLBACK)
        return say_ended(h, err);
    *pause_s = retry_pause(t, c);
    if (moved && t->verdict != STP_HTTP_GOOD) /* the redirection was only for a time */
        stp_http_forget_address(&h->connections);
    if (moved && t->verdict == STP_HTTP_REFUSED && *pause_s < 0.0)
        *pause_s = 0.0;
    if (t->verdict == STP_HTTP_CHANGED)
        atomic_store(&h->changed, true);
    return t->verdict == STP_HTTP_NONE || t->verdict == STP_HTTP_GOOD
               ? stp_http_say_failure(h->name, t, c, err)
               : stp_http_say_verdict(h->name, t, err);
}

/* Makes one try. *pause_s: retry_pause, if the try failed. */
static stp_status try_once(stp_http *h, stp_http_transfer *t, double *pause_s, stp_error *err)
{
    stp_http_connection *c = NULL;
    stp_status status = stp_http_acquire(&h->connections, t, &c, err);
    *pause_s = -1.0;
    if (status != STP_OK || c == NULL)
        return status != STP_OK ? status : say_ended(h, err);
    bool moved = stp_http_choose_address(&h->connections, c);
    atomic_fetch_add(&h->requests, 1);
    stp_http_transfer_run(t, c);
    /* Whole by its range, even if the server says another length. */
    const bool whole = stp_http_transfer_is_whole(t);
    if (whole) {
        atomic_fetch_add(&h->answers, 1);
        stp_http_remember_address(&h->connections, c);
    }
    if (!whole && t->verdict != STP_HTTP_EMPTY)
        status = take_failure(h, t, c, moved, pause_s, err);
    stp_http_release(&h->connections, c, t);
    return status;
}

/* Waits before try number `tried`, from 1 on. Half of the pause is random, so that many readers do
 * not come back at once. */
static void pause_before(stp_http *h, const stp_http_transfer *t, unsigned tried, double asked_s)
{
    uint64_t chance = stp_random_u64((uint64_t)(uintptr_t)h, atomic_load(&h->requests));
    const double most_s = STP_SOURCE_PAUSE_LIMIT_MS / 1e3;
    double pause_s = h->params.pause_ms / 1e3 * (double)(1u << (tried - 1 < 8 ? tried - 1 : 8));
    pause_s *= 0.5 + 0.5 * (double)(chance >> 32) / 4294967296.0;
    pause_s = pause_s > asked_s ? pause_s : asked_s;
    stp_http_pause(&h->connections, t, pause_s < most_s ? pause_s : most_s);
}

/* Tries until all bytes are there. *t is left with the last try's transfer. */
static stp_status try_on(stp_http *h, stp_http_transfer *t, stp_error *err)
{
    const stp_http_transfer asked = *t;
    bool first = t->identity == NULL;
    double pause_s = 0.0;
    for (unsigned tried = 1;; tried += !t->crowded) {
        if (atomic_load(&h->changed))
            return stp_http_say_changed(h->name, err);
        *t = asked;
        stp_status status = try_once(h, t, &pause_s, err);
        const bool all = stp_http_missing_of(t->ranges, t->range_count).bytes == 0;
        if (status == STP_OK && (first || all))
            return STP_OK;
        if (status == STP_OK) { /* a server may answer with less: the next try asks for the rest */
            pause_s = 0.0;
            status = stp_error_set(err, STP_IO,
                                   "%s: the server sends less than was asked for: copy the file "
                                   "here, or use another server",
                                   h->name);
        }
        if (pause_s < 0.0 || (tried >= h->params.tries && !t->crowded))
            return status;
        if (!t->crowded)
            pause_before(h, t, tried, pause_s);
        atomic_fetch_add(&h->retries, 1);
    }
}

static stp_status try_often(stp_http *h, stp_http_transfer *t, stp_error *err)
{
    count_waiting(h, 1);
    stp_status status = try_on(h, t, err);
    count_waiting(h, -1);
    return status;
}

static stp_http_transfer begin_transfer(stp_http *h, bool fresh)
{
    bool known = h->size != UNKNOWN_SIZE;
    return (stp_http_transfer){.file_bytes = h->size,
                               .identity = known ? h->identity : NULL,
                               .headers = fresh ? h->fresh_headers : h->headers,
                               .stall_ms = h->params.stall_ms,
                               .connect_ms = h->params.connect_ms,
                               .ended = is_ended,
                               .ended_context = h,
                               .bytes = &h->bytes};
}

/* ---- opening ---- */

static unsigned or_default(unsigned value, unsigned otherwise)
{
    return value != 0 ? value : otherwise;
}

static stp_status fill_headers(stp_http *h, stp_error *err)
{
    static const char plain[] = "Accept-Encoding: identity", *fresh = "Cache-Control: no-cache";
    struct curl_slist *more = NULL;
    h->headers = h->curl->slist_append(NULL, plain);
    h->fresh_headers = h->curl->slist_append(NULL, plain);
    more = h->fresh_headers != NULL ? h->curl->slist_append(h->fresh_headers, fresh) : NULL;
    if (h->headers == NULL || more == NULL)
        return stp_error_set(err, STP_OUT_OF_MEMORY, "%s: no memory for a request", h->name);
    return STP_OK;
}

static stp_status create(stp_http **out, const char *address, const stp_byte_source_params *params,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_http *h = NULL;
    STP_TRY(stp_alloc(&h, 1, sizeof *h, "a web address", err));
    stp_http_connections_init(&h->connections);
    pthread_mutex_init(&h->patience, NULL);
    h->size = UNKNOWN_SIZE;
    h->params = (stp_byte_source_params){.connect_ms = or_default(params->connect_ms, 10000),
                                         .stall_ms = or_default(params->stall_ms, 10000),
                                         .tries = or_default(params->tries, 4),
                                         .pause_ms = or_default(params->pause_ms, 200),
                                         .patience_ms = params->patience_ms,
                                         .cancelled = params->cancelled,
                                         .cancelled_context = params->cancelled_context};
    STP_TRY(stp_http_address_encode(address, &h->address, err));
    STP_TRY(stp_http_address_name(address, &h->name, err));
    h->curl = stp_curl_load();
    if (h->curl == NULL) {
        status = stp_error_set(err, STP_UNSUPPORTED,
                               "%s: addresses are read with libcurl.so.4: install it (libcurl4)",
                               h->name);
        goto done;
    }
    h->connections.curl = h->curl;
    h->connections.address = h->address;
    h->connections.name = h->name;
    h->connections.connect_ms = h->params.connect_ms;
    STP_TRY(fill_headers(h, err));
    *out = h;
    h = NULL;
done:
    stp_http_close(&h);
    return status;
}

stp_status stp_http_open(stp_http **out, const char *address, const stp_byte_source_params *params,
                         stp_error *err)
{
    stp_status status = STP_OK;
    stp_http *h = NULL;
    STP_TRY(create(&h, address, params, err));
    stp_http_transfer t = begin_transfer(h, true);
    t.ranges = &(stp_byte_range){.data = h->head, .size = sizeof h->head};
    t.range_count = 1;
    STP_TRY(try_often(h, &t, err));
    h->size = t.verdict == STP_HTTP_EMPTY ? 0 : t.answer.total;
    memcpy(h->identity, stp_http_answer_identity(&t.answer),
           strlen(stp_http_answer_identity(&t.answer)) + 1);
    *out = h;
    h = NULL;
done:
    stp_http_close(&h);
    return status;
}

void stp_http_close(stp_http **http)
{
    stp_http *h = *http;
    if (h == NULL)
        return;
    stp_http_connections_clear(&h->connections);
    if (h->curl != NULL) {
        h->curl->slist_free_all(h->headers);
        h->curl->slist_free_all(h->fresh_headers);
    }
    pthread_mutex_destroy(&h->patience);
    free(h->address);
    free(h->name);
    free(h);
    *http = NULL;
}

uint64_t stp_http_size(const stp_http *h)
{
    return h->size;
}

const char *stp_http_name(const stp_http *h)
{
    return h->name;
}

const char *stp_http_address(const stp_http *h)
{
    return h->address;
}

const char *stp_http_identity(const stp_http *h)
{
    return h->identity;
}

const uint8_t *stp_http_head(const stp_http *h)
{
    return h->head;
}

/* ---- reading ---- */

unsigned stp_http_ranges(const stp_http *h)
{
    static const unsigned counts[] = {[RANGES_UNKNOWN] = 2,
                                      [RANGES_ASKED] = 1,
                                      [RANGES_TAKEN] = STP_SOURCE_RANGES,
                                      [RANGES_REFUSED] = 1};
    return counts[atomic_load(&h->ranges)];
}

uint32_t stp_http_gap(const stp_http *h)
{
    return atomic_load(&h->ranges) == RANGES_TAKEN ? STP_HTTP_PART_BYTES : GAP_BYTES;
}

/* Learns from a try whether the server takes requests for several ranges. It does not if it answers
 * anything else, or if several tries in a row fail for other reasons. */
static void learn_ranges(stp_http *h, const stp_http_transfer *t, double pause_s)
{
    int asked = RANGES_ASKED, taken = RANGES_TAKEN;
    const bool whole = t->apart && stp_http_transfer_is_whole(t);
    const bool ended = !t->apart || t->result == CURLE_ABORTED_BY_CALLBACK;
    const bool passing = pause_s >= 0.0 && (t->verdict != STP_HTTP_GOOD || t->result != CURLE_OK);
    if (whole) {
        atomic_store(&h->ranges_failed, 0);
        (void)atomic_compare_exchange_strong(&h->ranges, &asked, RANGES_TAKEN);
    } else if (ended || (passing && atomic_fetch_add(&h->ranges_failed, 1) + 1 < RANGES_TRIES)) {
        (void)atomic_compare_exchange_strong(&h->ranges, &asked, RANGES_UNKNOWN);
    } else if (!atomic_compare_exchange_strong(&h->ranges, &asked, RANGES_REFUSED)) {
        (void)atomic_compare_exchange_strong(&h->ranges, &taken, RANGES_REFUSED);
    }
}

/* Asks for all ranges by one request, as far as the server takes that. Some may still be missing
 * afterwards. The first such request is alone: it shows whether the server answers it. */
static void try_apart(stp_http *h, const stp_http_transfer *asked)
{
    int unknown = RANGES_UNKNOWN;
    double pause_s = 0.0;
    stp_http_transfer t;
    if (atomic_load(&h->ranges) != RANGES_TAKEN &&
        !atomic_compare_exchange_strong(&h->ranges, &unknown, RANGES_ASKED))
        return;
    count_waiting(h, 1);
    do {
        t = *asked;
        t.apart = true;
        (void)try_once(h, &t, &pause_s, NULL);
    } while (t.crowded);
    count_waiting(h, -1);
    learn_ranges(h, &t, pause_s);
}

/* The number of ranges, from the first on, that one range may hold. */
static size_t count_near(const stp_byte_range *ranges, size_t count)
{
    size_t near = 1;
    while (near < count) {
        const stp_http_missing all = stp_http_missing_of(ranges, near);
        const stp_http_missing more = stp_http_missing_of(ranges, near + 1);
        if (more.bytes > all.bytes && (ranges[near].offset > all.end + GAP_BYTES ||
                                       more.end - more.begin > STP_SOURCE_REQUEST_BYTES))
            break;
        near++;
    }
    return near;
}

stp_status stp_http_read_ranges(stp_http *h, stp_byte_range *ranges, size_t count, bool fresh,
                                const stp_read_wish *wish, stp_error *err)
{
    stp_status status = STP_OK;
    stp_http_transfer asked = begin_transfer(h, fresh);
    asked.wish = wish;
    asked.ranges = ranges;
    asked.range_count = count;
    if (!is_ended(h) && count_near(ranges, count) < count)
        try_apart(h, &asked);
    for (size_t i = 0, near; i < count && status == STP_OK; i += near) {
        near = count_near(ranges + i, count - i);
        stp_http_transfer t = asked;
        t.ranges = ranges + i;
        t.range_count = near;
        if (stp_http_missing_of(t.ranges, near).bytes > 0)
            status = is_ended(h) ? say_ended(h, err) : try_often(h, &t, err);
    }
    return status;
}

void stp_http_cancel(stp_http *h)
{
    atomic_store(&h->cancelled, true);
    stp_http_wake(&h->connections);
}

void stp_http_resume(stp_http *h)
{
    atomic_store(&h->cancelled, false);
}

void stp_http_add_stats(const stp_http *h, stp_byte_source_stats *stats)
{
    stats->requests += atomic_load(&h->requests);
    stats->retries += atomic_load(&h->retries);
    stats->bytes += atomic_load(&h->bytes);
}
