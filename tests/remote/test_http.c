/* Tests reads from faulty web servers: each read ends in the right bytes or in one sentence, within
 * its time-outs. */
#include "base/clock.h"
#include "base/pool.h"
#include "formats/chunk/remote/http.h"
#include "formats/chunk/remote/http_address.h"
#include "formats/chunk/remote/http_answer.h"

#define FILE_BYTES 300000u
#include "tests/fixtures/http_fixture.h"

#include <stdatomic.h>
#include <time.h>

/* The time for all tries, their pauses and a busy machine: nothing may hang longer. */
#define LATEST_S 30.0

static stp_byte_source *open_well(const stp_byte_source_params *params)
{
    stp_byte_source *source = NULL;
    fault_server_order(&server, &(fault_orders){.kind = FAULT_NONE});
    check_ok(stp_byte_source_open(&source, server.address, params, err));
    assert_int_equal(fault_server_requests(&server), 1);
    assert_int_equal(stp_byte_source_size(source), FILE_BYTES);
    return source;
}

static void check_sentence(const stp_error *err)
{
    assert_non_null(strstr(err->message, "127.0.0.1"));
    assert_null(strchr(err->message, '\n'));
    assert_true(strlen(err->message) > 30 && strlen(err->message) < 400);
}

/* On a busy machine the server may read a request after the client gave it up: waits for this many.
 */
static unsigned count_requests(unsigned wanted)
{
    const struct timespec pause = {.tv_nsec = 1000000};
    const double begin_s = stp_clock_seconds();
    while (fault_server_requests(&server) < wanted && stp_clock_seconds() - begin_s < LATEST_S)
        nanosleep(&pause, NULL);
    return fault_server_requests(&server);
}

/* Opens a healthy server, then reads a range under the orders. The read must end in `wanted` after
 * this number of requests. */
static void try_read(const fault_orders *orders, stp_status wanted, const char *text,
                     unsigned requests)
{
    static uint8_t got[100000];
    stp_error failure = {0};
    bool stalls = orders->kind <= FAULT_DRIP || orders->kind == FAULT_VAST;
    stp_byte_source *source = open_well(stalls ? &quick : &unhurried);
    fault_server_order(&server, orders);
    double begin_s = stp_clock_seconds();
    stp_status status = stp_byte_source_read(source, 777, got, sizeof got, &failure);
    assert_true(stp_clock_seconds() - begin_s < LATEST_S);
    if (status != wanted)
        fail_msg("fault %d: status %d, expected %d: %s", orders->kind, status, wanted,
                 failure.message);
    if (status == STP_OK) {
        assert_memory_equal(got, file_bytes + 777, sizeof got);
    } else {
        check_sentence(&failure);
        if (strstr(failure.message, text) == NULL)
            fail_msg("fault %d: no '%s' in: %s", orders->kind, text, failure.message);
    }
    const unsigned counted = count_requests(requests);
    if (counted != requests)
        fail_msg("fault %d: %u requests, expected %u", orders->kind, counted, requests);
    stp_byte_source_close(&source);
    assert_null(source);
}

#define ALWAYS 1000u

static void once_is_mended(void **state)
{
    static const fault_kind kinds[] = {FAULT_STALL,      FAULT_STALL_HEADERS, FAULT_STALL_BODY,
                                       FAULT_CUT,        FAULT_CUT_BODY,      FAULT_RANGE_SHORT,
                                       FAULT_BODY_SHORT, FAULT_LENGTH_SHORT};
    static const int codes[] = {429, 500, 502, 503, 504};
    (void)state;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        try_read(&(fault_orders){.kind = kinds[i], .count = 1}, STP_OK, "", 2);
    for (size_t i = 0; i < sizeof codes / sizeof *codes; i++)
        try_read(&(fault_orders){.kind = FAULT_STATUS, .count = 1, .code = codes[i]}, STP_OK, "",
                 2);
}

/* The bytes before a cut are kept: the second request asks only for the rest. */
static void cut_bodies_are_continued(void **state)
{
    (void)state;
    try_read(&(fault_orders){.kind = FAULT_CUT_BODY, .count = 1}, STP_OK, "", 2);
    assert_int_equal(fault_server_bytes(&server), 100000);
    try_read(&(fault_orders){.kind = FAULT_STALL_BODY, .count = 1}, STP_OK, "", 2);
    assert_int_equal(fault_server_bytes(&server), 100000);
}

static void for_ever_is_given_up(void **state)
{
    (void)state;
    try_read(&(fault_orders){.kind = FAULT_STALL, .count = ALWAYS}, STP_IO, "in time", TRIES);
    try_read(&(fault_orders){.kind = FAULT_STALL_HEADERS, .count = ALWAYS}, STP_IO, "in time",
             TRIES);
    try_read(&(fault_orders){.kind = FAULT_STALL_BODY, .count = ALWAYS}, STP_IO, "in time", TRIES);
    /* if a kept connection is dead, libcurl makes a new one by itself: one more request */
    try_read(&(fault_orders){.kind = FAULT_CUT, .count = ALWAYS}, STP_IO, "try again later",
             TRIES + 1);
    try_read(&(fault_orders){.kind = FAULT_CUT_BODY, .count = ALWAYS}, STP_IO, "try again later",
             TRIES);
    try_read(&(fault_orders){.kind = FAULT_RANGE_SHORT, .count = ALWAYS}, STP_IO, "less than",
             TRIES);
    try_read(&(fault_orders){.kind = FAULT_BODY_SHORT, .count = ALWAYS}, STP_IO, "cut its answer",
             TRIES);
    try_read(&(fault_orders){.kind = FAULT_STATUS, .count = ALWAYS, .code = 503}, STP_IO,
             "answers 503", TRIES);
}

static void lies_are_not_followed(void **state)
{
    (void)state;
    try_read(&(fault_orders){.kind = FAULT_GARBAGE, .count = ALWAYS}, STP_IO, "HTTP/0.9", 1);
    try_read(&(fault_orders){.kind = FAULT_ENDLESS, .count = 1}, STP_IO, "sends more", 1);
    try_read(&(fault_orders){.kind = FAULT_RANGE_NONE, .count = 1}, STP_IO, "Content-Range", 1);
    try_read(&(fault_orders){.kind = FAULT_RANGE_JUNK, .count = 1}, STP_IO, "Content-Range", 1);
    try_read(&(fault_orders){.kind = FAULT_RANGE_OTHER, .count = 1}, STP_IO,
             "sent bytes 778 to 100777 where 777 to 100776", 1);
    try_read(&(fault_orders){.kind = FAULT_RANGE_LONG, .count = 1}, STP_IO, "sent bytes", 1);
    try_read(&(fault_orders){.kind = FAULT_TOTAL, .count = 1}, STP_IO, "changed", 1);
    try_read(&(fault_orders){.kind = FAULT_ENCODED, .count = 1}, STP_UNSUPPORTED, "compressed", 1);
    try_read(&(fault_orders){.kind = FAULT_BODY_LONG, .count = 1}, STP_IO, "sends more", 1);
    /* the server promised more, but sent all that was asked for */
    try_read(&(fault_orders){.kind = FAULT_LENGTH_LONG, .count = 1}, STP_OK, "", 1);
}

static void refusals_are_final(void **state)
{
    (void)state;
    try_read(&(fault_orders){.kind = FAULT_STATUS, .count = 1, .code = 404}, STP_NOT_FOUND,
             "no such file (404)", 1);
    try_read(&(fault_orders){.kind = FAULT_STATUS, .count = 1, .code = 403}, STP_IO,
             "refuses access (403)", 1);
    try_read(&(fault_orders){.kind = FAULT_STATUS, .count = 1, .code = 401}, STP_IO,
             "refuses access (401)", 1);
    try_read(&(fault_orders){.kind = FAULT_STATUS, .count = 1, .code = 418}, STP_IO, "418", 1);
    /* the reader waits for a second, but not for an hour */
    try_read(&(fault_orders){.kind = FAULT_STATUS, .count = 1, .code = 429, .retry_after = 1},
             STP_OK, "", 2);
    try_read(&(fault_orders){.kind = FAULT_STATUS, .count = 1, .code = 429, .retry_after = 3600},
             STP_IO, "429", 1);
}

static void redirections_are_followed_safely(void **state)
{
    (void)state;
    try_read(&(fault_orders){.kind = FAULT_MOVED, .count = ALWAYS}, STP_OK, "", 2);
    try_read(&(fault_orders){.kind = FAULT_LOOP, .count = ALWAYS}, STP_IO, "more than 5 times", 6);
    try_read(&(fault_orders){.kind = FAULT_ELSEWHERE, .count = ALWAYS}, STP_IO, "not as safe", 1);
}

/* The second read goes to the new address at once. If that address refuses, the reader asks the old
 * one again. */
static void redirections_are_remembered(void **state)
{
    uint8_t got[1000];
    stp_byte_source *source = open_well(&quick);
    (void)state;
    fault_server_order(&server, &(fault_orders){.kind = FAULT_MOVED, .count = ALWAYS});
    for (unsigned i = 0; i < 3; i++) {
        check_ok(stp_byte_source_read(source, 2900, got, sizeof got, err));
        assert_int_equal(fault_server_requests(&server), 2 + i);
    }
    fault_server_order(&server, &(fault_orders){.kind = FAULT_STATUS, .count = 1, .code = 403});
    check_ok(stp_byte_source_read(source, 2900, got, sizeof got, err));
    assert_memory_equal(got, file_bytes + 2900, sizeof got);
    assert_int_equal(fault_server_requests(&server), 2);
    stp_byte_source_close(&source);
}

/* If a server has no ranges, the error says so, and the reader does not take the whole file. */
static void whole_files_are_not_taken(void **state)
{
    stp_error failure = {0};
    stp_byte_source *source = NULL;
    (void)state;
    fault_server_order(&server, &(fault_orders){.kind = FAULT_WHOLE, .count = ALWAYS});
    assert_int_equal(stp_byte_source_open(&source, server.address, &quick, &failure),
                     STP_UNSUPPORTED);
    assert_null(source);
    check_sentence(&failure);
    assert_non_null(strstr(failure.message, "no byte ranges"));
    assert_int_equal(fault_server_requests(&server), 1);
    try_read(&(fault_orders){.kind = FAULT_WHOLE, .count = 1}, STP_UNSUPPORTED, "no byte ranges",
             1);
}

static void a_changed_file_is_noticed(void **state)
{
    static const fault_validator validators[] = {FAULT_ETAG, FAULT_ETAG_WEAK, FAULT_MODIFIED};
    uint8_t got[1000];
    (void)state;
    for (size_t i = 0; i < sizeof validators / sizeof *validators; i++) {
        stp_error failure = {0};
        stp_byte_source *source = NULL;
        fault_server_order(&server, &(fault_orders){.kind = FAULT_CHANGED,
                                                    .first = 2,
                                                    .count = ALWAYS,
                                                    .validator = validators[i]});
        check_ok(stp_byte_source_open(&source, server.address, &quick, err));
        check_ok(stp_byte_source_read(source, 5000, got, sizeof got, err));
        assert_memory_equal(got, file_bytes + 5000, sizeof got);
        for (int again = 0; again < 2; again++) { /* then no more requests are sent */
            assert_int_equal(stp_byte_source_read(source, 5000, got, sizeof got, &failure), STP_IO);
            assert_non_null(strstr(failure.message, "changed on the server"));
            check_sentence(&failure);
        }
        assert_int_equal(fault_server_requests(&server), 3);
        stp_byte_source_close(&source);
    }
}

static void opening_fails_in_one_sentence(void **state)
{
    static const struct {
        fault_orders orders;
        stp_status status;
    } cases[] = {
        {{.kind = FAULT_STALL, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_STALL_HEADERS, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_STALL_BODY, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_CUT, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_CUT_BODY, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_ENDLESS, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_RANGE_NONE, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_RANGE_JUNK, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_RANGE_OTHER, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_RANGE_LONG, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_RANGE_SHORT, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_ENCODED, .count = ALWAYS}, STP_UNSUPPORTED},
        {{.kind = FAULT_BODY_LONG, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_BODY_SHORT, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_LENGTH_SHORT, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_LOOP, .count = ALWAYS}, STP_IO},
        {{.kind = FAULT_STATUS, .count = ALWAYS, .code = 404}, STP_NOT_FOUND},
        {{.kind = FAULT_STATUS, .count = ALWAYS, .code = 500}, STP_IO},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_error failure = {0};
        stp_byte_source *source = NULL;
        double begin_s = stp_clock_seconds();
        fault_server_order(&server, &cases[i].orders);
        stp_status status = stp_byte_source_open(&source, server.address, &quick, &failure);
        assert_true(stp_clock_seconds() - begin_s < LATEST_S);
        if (status != cases[i].status)
            fail_msg("fault %d: status %d: %s", cases[i].orders.kind, status, failure.message);
        check_sentence(&failure);
        assert_null(source);
    }
}

/* A byte every 20 ms is no stall, but the whole would take minutes. */
static void a_trickle_is_not_waited_for(void **state)
{
    const stp_byte_source_params hasty = {
        .connect_ms = 300, .stall_ms = STALL_MS, .tries = 2, .pause_ms = 2};
    stp_byte_source *source = NULL;
    stp_error failure = {0};
    double begin_s = stp_clock_seconds();
    (void)state;
    fault_server_order(&server, &(fault_orders){.kind = FAULT_TRICKLE, .count = ALWAYS});
    assert_int_equal(stp_byte_source_open(&source, server.address, &hasty, &failure), STP_IO);
    assert_non_null(strstr(failure.message, "in time"));
    assert_true(stp_clock_seconds() - begin_s < LATEST_S);
    assert_int_equal(fault_server_requests(&server), 2);
}

/* Each single read would end in time, but all together may not take longer than the patience; after
 * that no read begins. */
static void a_slow_server_is_given_up(void **state)
{
    static uint8_t got[50000];
    const stp_byte_source_params patient = {.patience_ms = 1000};
    stp_byte_source *source = NULL;
    stp_error failure = {0};
    (void)state;
    fault_server_order(&server,
                       &(fault_orders){.kind = FAULT_TRICKLE, .first = 3, .count = ALWAYS});
    check_ok(stp_byte_source_open(&source, server.address, &patient, err));
    for (int i = 0; i < 2; i++)
        check_ok(stp_byte_source_read(source, 3000, got, 100, err));
    double begin_s = stp_clock_seconds();
    for (int i = 0; i < 20; i++) {
        assert_int_equal(stp_byte_source_read(source, 3000, got, sizeof got, &failure), STP_IO);
        assert_non_null(strstr(failure.message, "too slow"));
        assert_non_null(strstr(failure.message, "--timeout"));
    }
    assert_true(stp_clock_seconds() - begin_s < LATEST_S);
    assert_int_equal(fault_server_requests(&server), 4);
    stp_byte_source_close(&source);
}

/* Messages must say what is wrong, in our words and not in a library's. */
static void words_are_right(void **state)
{
    static const struct {
        fault_orders orders;
        const char *text;
    } cases[] = {
        {{.kind = FAULT_HUGE_HEADER, .count = ALWAYS}, "headers are larger"},
        {{.kind = FAULT_STATUS, .count = ALWAYS, .code = 416}, "no bytes 0 to 2047 (416)"},
        {{.kind = FAULT_NO_TOTAL, .count = ALWAYS}, "does not say how large"},
        {{.kind = FAULT_VAST, .count = ALWAYS}, "more than was asked for"},
    };
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        stp_error failure = {0};
        stp_byte_source *source = NULL;
        fault_server_order(&server, &cases[i].orders);
        assert_int_equal(stp_byte_source_open(&source, server.address, &quick, &failure), STP_IO);
        check_sentence(&failure);
        if (!strstr(failure.message, cases[i].text))
            fail_msg("no '%s' in: %s", cases[i].text, failure.message);
        if (cases[i].orders.kind == FAULT_VAST) /* the headers say it, so nothing is waited for */
            assert_int_equal(fault_server_requests(&server), 1);
    }
}

static void no_server_and_no_address(void **state)
{
    stp_error failure = {0};
    stp_byte_source *source = NULL;
    (void)state;
    /* nobody listens at port 1 of the loopback */
    assert_int_equal(
        stp_byte_source_open(&source, "http://127.0.0.1:1/a b.stipple", &quick, &failure), STP_IO);
    check_sentence(&failure);
    assert_int_equal(stp_byte_source_open(&source, "http://", &quick, &failure),
                     STP_INVALID_ARGUMENT);
    assert_int_equal(stp_byte_source_open(&source, "http://me:pa/ss@host/x", &quick, &failure),
                     STP_INVALID_ARGUMENT);
    assert_null(strstr(failure.message, "pa"));
    assert_int_equal(stp_byte_source_open(&source, "/nowhere/at/all", NULL, &failure),
                     STP_NOT_FOUND);
    assert_null(source);
}

static void an_empty_file_has_no_bytes(void **state)
{
    fault_server empty;
    stp_byte_source *source = NULL;
    stp_error failure = {0};
    uint8_t byte;
    (void)state;
    assert_true(fault_server_create(&empty, "", 0));
    check_ok(stp_byte_source_open(&source, empty.address, &quick, err));
    assert_int_equal(stp_byte_source_size(source), 0);
    assert_int_equal(stp_byte_source_read(source, 0, &byte, 1, &failure), STP_CORRUPT);
    assert_int_equal(stp_byte_source_read(source, UINT64_MAX, &byte, 1, &failure), STP_CORRUPT);
    check_ok(stp_byte_source_read(source, 0, &byte, 0, err));
    stp_byte_source_close(&source);
    fault_server_destroy(&empty);
    assert_true(fault_server_create(&empty, "x", 1));
    check_ok(stp_byte_source_open(&source, empty.address, &quick, err));
    check_ok(stp_byte_source_read(source, 0, &byte, 1, err));
    assert_int_equal(byte, 'x');
    stp_byte_source_close(&source);
    fault_server_destroy(&empty);
}

/* ---- several threads ---- */

typedef struct many {
    stp_byte_source *source;
    stp_status wanted;
} many;

static stp_status read_one(void *context, size_t index, unsigned worker, stp_error *err)
{
    const many *m = context;
    uint8_t got[3000];
    uint64_t offset = stp_random_u64(7, index) % (FILE_BYTES - sizeof got);
    (void)worker;
    stp_status status = stp_byte_source_read(m->source, offset, got, sizeof got, err);
    if (status != m->wanted ||
        (status == STP_OK && memcmp(got, file_bytes + offset, sizeof got) != 0))
        return stp_error_set(err, STP_INTERNAL, "read %zu: status %d", index, status);
    return STP_OK;
}

static void many_threads_read_at_once(void **state)
{
    stp_pool *pool = NULL;
    stp_byte_source_stats stats;
    many m = {.source = open_well(&quick), .wanted = STP_OK};
    (void)state;
    assert_int_equal(stp_byte_source_parallel(m.source), STP_SOURCE_CONNECTIONS);
    assert_true(stp_byte_source_is_remote(m.source));
    check_ok(stp_pool_create(&pool, 2 * STP_SOURCE_CONNECTIONS, err));
    /* some answers fail meanwhile */
    fault_server_order(&server, &(fault_orders){.kind = FAULT_CUT_BODY, .first = 50, .count = 2});
    check_ok(stp_pool_run(pool, 300, read_one, &m, err));
    stp_byte_source_get_stats(m.source, &stats);
    assert_int_equal(stats.requests, 1 + 302);
    assert_int_equal(stats.retries, 2);
    assert_int_equal(stats.bytes, STP_HTTP_HEAD_BYTES + 300 * 3000);
    stp_pool_destroy(&pool);
    stp_byte_source_close(&m.source);
}

/* A server closes the connections that are too many for it. No read fails for that, although each
 * has one try alone, and soon no more connections are opened than the server takes. */
static void few_connections_do(void **state)
{
    static const unsigned most[] = {1, 2, 7};
    stp_pool *pool = NULL;
    (void)state;
    for (size_t i = 0; i < sizeof most / sizeof *most; i++) {
        stp_byte_source_stats stats;
        many m = {.source = open_well(&(stp_byte_source_params){.tries = 1})};
        fault_server_order(&server, &(fault_orders){.most = most[i]});
        check_ok(stp_pool_create(&pool, 2 * STP_SOURCE_CONNECTIONS, err));
        check_ok(stp_pool_run(pool, 300, read_one, &m, err));
        stp_byte_source_get_stats(m.source, &stats);
        assert_int_equal(stats.requests - stats.retries, 1 + 300);
        assert_in_range(stats.retries, 1, 2 * STP_SOURCE_CONNECTIONS);
        stp_pool_destroy(&pool);
        stp_byte_source_close(&m.source);
    }
}

/* One thread cancels while all others wait for a silent server. */
static stp_status read_or_cancel(void *context, size_t index, unsigned worker, stp_error *err)
{
    const many *m = context;
    const struct timespec moment = {0, 50000000};
    if (index > 0)
        return read_one(context, index, worker, err);
    nanosleep(&moment, NULL);
    stp_byte_source_cancel(m->source);
    return STP_OK;
}

static void cancelling_ends_all_reads(void **state)
{
    const stp_byte_source_params patient = {.stall_ms = 600000};
    stp_pool *pool = NULL;
    many m = {.wanted = STP_CANCELLED};
    double begin_s = stp_clock_seconds();
    (void)state;
    fault_server_order(&server, &(fault_orders){.kind = FAULT_STALL, .first = 1, .count = ALWAYS});
    check_ok(stp_byte_source_open(&m.source, server.address, &patient, err));
    check_ok(stp_pool_create(&pool, 2 * STP_SOURCE_CONNECTIONS, err));
    check_ok(stp_pool_run(pool, 40, read_or_cancel, &m, err));
    assert_true(stp_clock_seconds() - begin_s < LATEST_S);
    fault_server_order(&server, &(fault_orders){.kind = FAULT_NONE});
    stp_byte_source_resume(m.source);
    m.wanted = STP_OK;
    check_ok(stp_pool_run(pool, 40, read_one, &m, err));
    stp_pool_destroy(&pool);
    stp_byte_source_close(&m.source);
}

static bool asked_often(void *context)
{
    atomic_uint *asked = context;
    return atomic_fetch_add(asked, 1) >= 3;
}

static void a_callback_interrupts(void **state)
{
    atomic_uint asked = 0;
    const stp_byte_source_params params = {
        .stall_ms = 600000, .cancelled = asked_often, .cancelled_context = &asked};
    stp_byte_source *source = NULL;
    stp_error failure = {0};
    (void)state;
    fault_server_order(&server, &(fault_orders){.kind = FAULT_STALL, .count = ALWAYS});
    assert_int_equal(stp_byte_source_open(&source, server.address, &params, &failure),
                     STP_CANCELLED);
    check_sentence(&failure);
    /* the reader can also be cancelled while it pauses between two tries */
    asked = 0;
    fault_server_order(
        &server,
        &(fault_orders){.kind = FAULT_STATUS, .count = ALWAYS, .code = 503, .retry_after = 15});
    assert_int_equal(stp_byte_source_open(&source, server.address, &params, &failure),
                     STP_CANCELLED);
}

/* ---- words ---- */

static void check_address(const char *address, const char *encoded, const char *name)
{
    char *got = NULL;
    check_ok(stp_http_address_encode(address, &got, err));
    assert_string_equal(got, encoded);
    free(got);
    check_ok(stp_http_address_name(address, &got, err));
    assert_string_equal(got, name);
    free(got);
}

static void addresses_are_encoded_and_named(void **state)
{
    (void)state;
    check_address("http://h/a", "http://h/a", "http://h/a");
    check_address("http://h/a b\xc3\xa9%20%zz\n", "http://h/a%20b%C3%A9%20%25zz%0A",
                  "http://h/a b\xc3\xa9%20%zz ");
    check_address("https://me:secret@h:81/a?key=1#x", "https://me:secret@h:81/a?key=1#x",
                  "https://h:81/a?...");
    check_address("https://me:se@cret@h/a@b", "https://me:se@cret@h/a@b", "https://h/a@b");
    check_address("http://me:se/cret@h/a", "http://me:se/cret@h/a", "http://h/a");
    check_address("http://[::1]:8/a@b", "http://[::1]:8/a@b", "http://[::1]:8/a@b");
    check_address("http://", "http://", "http://");
    assert_true(stp_is_address("HTTPS://h") && !stp_is_address("http:/h") &&
                !stp_is_address("ftp://h") && !stp_is_address(""));
}

static stp_http_answer answer_of(const char *const *lines, size_t count)
{
    stp_http_answer a = {0};
    for (size_t i = 0; i < count; i++)
        stp_http_answer_line(&a, lines[i], strlen(lines[i]));
    return a;
}

static void headers_are_read_strictly(void **state)
{
    static const char *const good[] = {"HTTP/1.1 100 Continue\r\n", "ETag: \"old\"\r\n",
                                       "HTTP/2 206 \r\n", "content-range:bytes 5-9/10\r\n",
                                       "LAST-MODIFIED: then \r\n"};
    static const char *const wrong[] = {
        "Content-Range: bytes 9-5/10",
        "Content-Range: bytes 5-10/10",
        "Content-Range: bytes 5-9",
        "Content-Range: bytes -9/10",
        "Content-Range: bytes 5-9/10x",
        "Content-Range: bytes 5-18446744073709551616/*",
        "Content-Range: items 5-9/10",
        "Content-Range: bytes */10",
        "Content-Range:",
        "Content-Range bytes 5-9/10",
    };
    (void)state;
    stp_http_answer a = answer_of(good, 5);
    assert_int_equal(a.code, 206);
    assert_true(a.has_range && a.has_total && a.begin == 5 && a.last == 9 && a.total == 10);
    assert_string_equal(stp_http_answer_identity(&a), "then");
    for (size_t i = 0; i < sizeof wrong / sizeof *wrong; i++)
        assert_false(answer_of(&wrong[i], 1).has_range);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(once_is_mended),
        cmocka_unit_test(cut_bodies_are_continued),
        cmocka_unit_test(for_ever_is_given_up),
        cmocka_unit_test(lies_are_not_followed),
        cmocka_unit_test(refusals_are_final),
        cmocka_unit_test(redirections_are_followed_safely),
        cmocka_unit_test(redirections_are_remembered),
        cmocka_unit_test(whole_files_are_not_taken),
        cmocka_unit_test(a_changed_file_is_noticed),
        cmocka_unit_test(opening_fails_in_one_sentence),
        cmocka_unit_test(a_trickle_is_not_waited_for),
        cmocka_unit_test(a_slow_server_is_given_up),
        cmocka_unit_test(words_are_right),
        cmocka_unit_test(no_server_and_no_address),
        cmocka_unit_test(an_empty_file_has_no_bytes),
        cmocka_unit_test(many_threads_read_at_once),
        cmocka_unit_test(few_connections_do),
        cmocka_unit_test(cancelling_ends_all_reads),
        cmocka_unit_test(a_callback_interrupts),
        cmocka_unit_test(addresses_are_encoded_and_named),
        cmocka_unit_test(headers_are_read_strictly),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
