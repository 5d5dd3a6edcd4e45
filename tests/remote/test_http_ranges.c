/* Tests reads of several ranges at once, from servers that take such requests, that do not, and
 * that answer wrongly: the bytes are right in the end, and few requests are sent. */
#include "base/pool.h"
#include "formats/chunk/remote/http_parts.h"

#define FILE_BYTES 4000000u
#include "tests/fixtures/http_fixture.h"

#define RANGES 40u
/* Gaps are so wide that each range is a request, if they are not read at once. */
#define STEP 90000u
#define SIZE 3000u
#define ALWAYS 1000u

static void order(const fault_orders *orders)
{
    fault_server_order(&server, orders);
}

static stp_byte_source *open_well(const stp_byte_source_params *params)
{
    stp_byte_source *source = NULL;
    order(&(fault_orders){.kind = FAULT_NONE});
    check_ok(stp_byte_source_open(&source, server.address, params, err));
    return source;
}

/* ---- reading ---- */

/* Ranges with room for their bytes, between guards. */
typedef struct reading {
    stp_byte_range ranges[RANGES];
    uint8_t bytes[RANGES][SIZE + 2];
} reading;

static void begin(reading *r, uint64_t offset)
{
    memset(r, 0xa5, sizeof *r);
    for (unsigned i = 0; i < RANGES; i++)
        r->ranges[i] = (stp_byte_range){
            .offset = offset + (uint64_t)i * STEP, .data = r->bytes[i] + 1, .size = SIZE};
}

/* The first `got` bytes of each range are the file's, and nothing else was written. */
static bool is_right(const reading *r)
{
    bool right = true;
    for (unsigned i = 0; i < RANGES; i++) {
        const stp_byte_range *range = &r->ranges[i];
        right &= range->got <= SIZE && r->bytes[i][0] == 0xa5 && r->bytes[i][SIZE + 1] == 0xa5 &&
                 memcmp(range->data, file_bytes + range->offset, range->got) == 0;
    }
    return right;
}

static bool is_all_there(const reading *r)
{
    for (unsigned i = 0; i < RANGES; i++)
        if (r->ranges[i].got != SIZE)
            return false;
    return is_right(r);
}

/* Reads well, whatever the orders are for requests of several ranges. Returns how many requests
 * that took; *apart: of them for several ranges. */
static unsigned read_all(stp_byte_source *source, const fault_orders *orders, unsigned *apart)
{
    static reading r;
    begin(&r, 5000);
    order(orders);
    check_ok(stp_byte_source_read_ranges(source, r.ranges, RANGES, NULL, err));
    assert_true(is_all_there(&r));
    *apart = fault_server_apart(&server);
    return fault_server_requests(&server);
}

/* ---- servers ---- */

static void one_request_brings_all(void **state)
{
    static const fault_kind kinds[] = {FAULT_NONE, FAULT_PARTS_BACKWARDS, FAULT_NO_TOTAL,
                                       FAULT_LENGTH_LONG};
    (void)state;
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++) {
        unsigned apart = 0;
        stp_byte_source *source = open_well(&unhurried);
        assert_int_equal(stp_byte_source_ranges(source), 2);
        const uint32_t gap = stp_byte_source_gap(source);
        const fault_orders orders = {.kind = kinds[i], .count = ALWAYS, .apart = true};
        for (int round = 0; round < 2; round++) {
            assert_int_equal(read_all(source, &orders, &apart), 1);
            assert_int_equal(apart, 1);
            assert_int_equal(stp_byte_source_ranges(source), STP_SOURCE_RANGES);
            assert_true(stp_byte_source_gap(source) < gap);
            /* each part comes with its headers */
            assert_in_range(fault_server_bytes(&server), RANGES * SIZE, RANGES * (SIZE + 256));
        }
        stp_byte_source_close(&source);
    }
}

/* A server that answers anything else is asked once, and for one range at a time from then on. */
static void other_answers_are_noticed(void **state)
{
    static const fault_orders orders[] = {
        {.kind = FAULT_WHOLE},
        {.kind = FAULT_PARTS_FIRST},
        {.kind = FAULT_PARTS_JOINED}, /* would be all of the file */
        {.kind = FAULT_STATUS, .code = 400},
        {.kind = FAULT_STATUS, .code = 403},
        {.kind = FAULT_STATUS, .code = 416},
        {.kind = FAULT_STATUS, .code = 501},
        {.kind = FAULT_ENCODED},
        {.kind = FAULT_RANGE_NONE},
        {.kind = FAULT_RANGE_JUNK},
        {.kind = FAULT_RANGE_OTHER},
        {.kind = FAULT_RANGE_SHORT},
        {.kind = FAULT_TOTAL},
        {.kind = FAULT_GARBAGE},
        {.kind = FAULT_ENDLESS},
        {.kind = FAULT_HUGE_HEADER},
        {.kind = FAULT_VAST},
        {.kind = FAULT_BODY_LONG},
    };
    (void)state;
    for (size_t i = 0; i < 2 * sizeof orders / sizeof *orders; i++) {
        unsigned apart = 0;
        fault_orders o = orders[i / 2];
        stp_byte_source *source = open_well(&unhurried);
        if (i % 2 == 1) /* it took such a request before */
            read_all(source, &(fault_orders){.kind = FAULT_NONE}, &apart);
        o.apart = true;
        o.count = ALWAYS;
        const unsigned requests = read_all(source, &o, &apart);
        const unsigned all = o.kind == FAULT_BODY_LONG ? 0 : RANGES; /* came before what is wrong */
        /* the first range may have come */
        if (apart != 1 || requests > all + 1 || requests < all)
            fail_msg("fault %d: %u requests, %u for several ranges", o.kind, requests, apart);
        assert_int_equal(stp_byte_source_ranges(source), 1);
        assert_int_equal(read_all(source, &o, &apart), RANGES);
        assert_int_equal(apart, 0);
        stp_byte_source_close(&source);
    }
}

/* What fails for a while is asked for again, at most three times in a row. What came is kept. */
static void passing_faults_are_asked_again(void **state)
{
    static const fault_orders orders[] = {{.kind = FAULT_CUT},
                                          {.kind = FAULT_CUT_BODY},
                                          {.kind = FAULT_STALL},
                                          {.kind = FAULT_STALL_BODY},
                                          {.kind = FAULT_STATUS, .code = 503}};
    (void)state;
    for (size_t i = 0; i < sizeof orders / sizeof *orders; i++) {
        unsigned apart = 0;
        fault_orders o = orders[i];
        stp_byte_source *source = open_well(&quick);
        o.apart = true;
        for (int round = 0; round < 3; round++) { /* a good answer between them */
            o.count = ALWAYS;
            const unsigned requests = read_all(source, &o, &apart);
            const bool half = o.kind == FAULT_CUT_BODY || o.kind == FAULT_STALL_BODY;
            assert_in_range(requests - apart, RANGES / 2, half ? RANGES / 2 + 1 : RANGES);
            o.count = 0;
            assert_int_equal(read_all(source, &o, &apart), 1);
        }
        o.count = ALWAYS;
        for (int round = 0; round < 3; round++) {
            assert_true(stp_byte_source_ranges(source) > 1);
            read_all(source, &o, &apart);
            assert_true(apart > 0);
        }
        read_all(source, &o, &apart);
        read_all(source, &o, &apart);
        assert_int_equal(apart, 0);
        stp_byte_source_close(&source);
    }
}

static void a_file_that_changes_is_noticed(void **state)
{
    static reading r;
    unsigned apart = 0;
    stp_error failure = {0};
    stp_byte_source *source = open_well(&unhurried);
    (void)state;
    read_all(source, &(fault_orders){.kind = FAULT_NONE}, &apart);
    order(&(fault_orders){.kind = FAULT_CHANGED, .count = 1});
    begin(&r, 5000);
    assert_int_equal(stp_byte_source_read_ranges(source, r.ranges, RANGES, NULL, &failure), STP_IO);
    assert_non_null(strstr(failure.message, "changed on the server"));
    assert_true(is_right(&r) && !is_all_there(&r));
    assert_int_equal(fault_server_requests(&server), 2);
    stp_byte_source_close(&source);
}

/* A server that fails is not asked for each range. */
static void a_failure_ends_the_read(void **state)
{
    static reading r;
    stp_error failure = {0};
    stp_byte_source *source = open_well(&unhurried);
    (void)state;
    order(&(fault_orders){.kind = FAULT_STATUS, .count = ALWAYS, .code = 503});
    begin(&r, 5000);
    assert_int_equal(stp_byte_source_read_ranges(source, r.ranges, RANGES, NULL, &failure), STP_IO);
    assert_non_null(strstr(failure.message, "503"));
    assert_int_equal(fault_server_requests(&server), 1 + quick.tries);
    assert_true(is_right(&r) && r.ranges[0].got == 0);
    stp_byte_source_close(&source);
}

/* If one range does as well as several, its answer does not tell what the server takes. */
static void one_range_tells_nothing(void **state)
{
    static uint8_t bytes[2][STP_SOURCE_REQUEST_BYTES];
    stp_byte_range ranges[2];
    stp_byte_source *source = open_well(&unhurried);
    (void)state;
    for (size_t i = 0; i < 2; i++)
        ranges[i] = (stp_byte_range){
            .offset = 5000 + i * sizeof *bytes, .data = bytes[i], .size = sizeof *bytes};
    order(&(fault_orders){.kind = FAULT_NONE});
    check_ok(stp_byte_source_read_ranges(source, ranges, 2, NULL, err));
    assert_memory_equal(bytes, file_bytes + 5000, sizeof bytes);
    assert_int_equal(fault_server_requests(&server), 1);
    assert_int_equal(stp_byte_source_ranges(source), 2);
    stp_byte_source_close(&source);
}

/* ---- threads ---- */

static stp_status read_some(void *context, size_t index, unsigned worker, stp_error *err)
{
    stp_status status = STP_OK;
    reading *r = NULL;
    (void)worker;
    r = malloc(sizeof *r);
    if (r == NULL)
        return STP_OUT_OF_MEMORY;
    begin(r, 3000 + 100 * index);
    status = stp_byte_source_read_ranges(context, r->ranges, RANGES, NULL, err);
    if (status == STP_OK && !is_all_there(r))
        status = stp_error_set(err, STP_INTERNAL, "read %zu: wrong bytes", index);
    free(r);
    return status;
}

/* Until the first answer of several ranges is there, no other thread asks for one; from then on all
 * do. How many reads come before, the machine decides. */
static void one_thread_asks_first(void **state)
{
    stp_pool *pool = NULL;
    (void)state;
    for (int wrong = 0; wrong < 2; wrong++) {
        stp_byte_source *source = open_well(&unhurried);
        order(&(fault_orders){
            .kind = wrong ? FAULT_WHOLE : FAULT_NONE, .count = ALWAYS, .apart = true});
        check_ok(stp_pool_create(&pool, STP_SOURCE_CONNECTIONS, err));
        check_ok(stp_pool_run(pool, 30, read_some, source, err));
        if (wrong)
            assert_int_equal(fault_server_apart(&server), 1);
        else
            assert_in_range(fault_server_apart(&server), 1, 30);
        const size_t apart = (size_t)fault_server_apart(&server);
        check_ok(stp_pool_run(pool, 30, read_some, source, err));
        assert_int_equal(fault_server_apart(&server), wrong ? 1 : apart + 30);
        stp_pool_destroy(&pool);
        stp_byte_source_close(&source);
    }
}

/* ---- what is asked for ---- */

static void check_text(const stp_byte_range *ranges, size_t count, const char *wanted, size_t parts)
{
    static char text[STP_HTTP_RANGES_TEXT];
    text[0] = '\0';
    assert_int_equal(stp_http_missing_write(ranges, count, text), parts);
    assert_string_equal(text, wanted);
}

static void near_ranges_are_one(void **state)
{
    const uint64_t near = STP_HTTP_PART_BYTES, far = UINT64_MAX - 100;
    char text[100];
    stp_byte_range ranges[] = {{.offset = 0, .size = 10},
                               {.offset = 10, .size = 10},
                               {.offset = 15, .size = 5},
                               {.offset = 20 + near, .size = 1},
                               {.offset = far, .size = 100}};
    (void)state;
    snprintf(text, sizeof text, "0-%u,18446744073709551515-18446744073709551614",
             20 + STP_HTTP_PART_BYTES);
    check_text(ranges, 5, text, 2);
    ranges[3].offset++;
    check_text(ranges, 4, "0-19,277-277", 2);
    for (int i = 0; i < 3; i++)
        ranges[i].got = ranges[i].size;
    check_text(ranges, 4, "277-277", 1);
    ranges[2].got = 2;
    check_text(ranges, 3, "17-19", 1);
    check_text(ranges, 2, "", 0);
    assert_int_equal(stp_http_missing_of(ranges, 2).bytes, 0);
    const stp_http_missing all = stp_http_missing_of(ranges, 5);
    assert_true(all.begin == 17 && all.end == far + 100 && all.bytes == 3 + 1 + 100);
    /* the longest text has room */
    stp_byte_range many[STP_SOURCE_RANGES];
    for (size_t i = 0; i < STP_SOURCE_RANGES; i++)
        many[i] = (stp_byte_range){.offset = far - 1000 * (STP_SOURCE_RANGES - i), .size = 2};
    static char most[STP_HTTP_RANGES_TEXT];
    assert_int_equal(stp_http_missing_write(many, STP_SOURCE_RANGES, most), STP_SOURCE_RANGES);
    assert_true(strlen(most) == STP_SOURCE_RANGES * 42u - 1);
}

/* ---- bodies ---- */

/* Each part has a few bytes more than are wanted. */
#define MORE 50u

static size_t write_body(char *out, const reading *r)
{
    char *at = out;
    for (unsigned i = 0; i < RANGES; i++) {
        const uint64_t offset = r->ranges[i].offset;
        at += sprintf(at, "\r\n--x\r\nContent-Range: bytes %u-%u/%u\r\n\r\n", (unsigned)offset,
                      (unsigned)offset + SIZE + MORE - 1, FILE_BYTES);
        memcpy(at, file_bytes + offset, SIZE + MORE);
        at += SIZE + MORE;
    }
    return (size_t)(at - out) + (size_t)sprintf(at, "\r\n--x--\r\n");
}

/* A body may come in any pieces. If bytes of it are damaged, none is written where it does not
 * belong. */
static void bodies_come_in_pieces(void **state)
{
    static char body[RANGES * (SIZE + 200)];
    static reading r;
    (void)state;
    for (uint64_t round = 0; round < 600; round++) {
        begin(&r, 0);
        const size_t size = write_body(body, &r);
        const bool damaged = round % 2 == 1;
        for (unsigned i = 0; i < 40 && damaged; i++) /* headers are a hundredth of the body */
            body[stp_random_u64(2 * round, i) % (i % 2 ? size : 200)] =
                (char)stp_random_u64(3 * round, i);
        stp_http_parts parts = {.ranges = r.ranges, .count = RANGES, .file_bytes = FILE_BYTES};
        bool good = true;
        for (size_t at = 0, piece; at < size && good; at += piece) {
            piece = 1 + stp_random_u64(round, at) % (round % 3 == 0 ? 3 : 5000);
            piece = piece < size - at ? piece : size - at;
            good = stp_http_parts_take(&parts, body + at, piece);
        }
        assert_true(damaged || (good && is_all_there(&r)));
        for (unsigned i = 0; i < RANGES; i++)
            assert_true(r.ranges[i].got <= SIZE && r.bytes[i][0] == 0xa5 &&
                        r.bytes[i][SIZE + 1] == 0xa5);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_request_brings_all),
        cmocka_unit_test(other_answers_are_noticed),
        cmocka_unit_test(passing_faults_are_asked_again),
        cmocka_unit_test(a_file_that_changes_is_noticed),
        cmocka_unit_test(a_failure_ends_the_read),
        cmocka_unit_test(one_range_tells_nothing),
        cmocka_unit_test(one_thread_asks_first),
        cmocka_unit_test(near_ranges_are_one),
        cmocka_unit_test(bodies_come_in_pieces),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
