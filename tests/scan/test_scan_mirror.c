/* Tests scans on a web server: a COPC is read by ranges, everything else is copied, and servers
 * that fail give one sentence with the address. */
#include "formats/scan/remote/mirror.h"
#include "tests/fixtures/scan/ept_fixture.h"
#include "tests/support/fault_server.h"

#include <math.h>

/* Bytes between the points and the hierarchy that nobody needs. */
#define PAD ((size_t)4 << 20)

static const stp_byte_source_params quick = {
    .connect_ms = 2000, .stall_ms = 500, .tries = 2, .pause_ms = 2};
static las_file file;
static unsigned char *bytes;
static size_t size;

/* A COPC whose hierarchy lies far behind its points. */
static int enter(void **state)
{
    const size_t page = copc_make(&file), hierarchy = page - 60;
    las_put(&file, 235, 8, hierarchy + PAD);
    las_put(&file, COPC_INFO_AT + 40, 8, page + PAD);
    las_put(&file, page + 32 * 64 + 16, 8, page + 32 * 65 + PAD);
    size = file.size + PAD;
    bytes = calloc(size, 1);
    if (!bytes)
        return -1;
    memcpy(bytes, file.bytes, hierarchy);
    memcpy(bytes + hierarchy + PAD, file.bytes + hierarchy, file.size - hierarchy);
    return scan_fixture_enter(state);
}

static int leave(void **state)
{
    free(bytes);
    return scan_fixture_leave(state);
}

static stp_file_mirror *open_mirror(const char *address)
{
    stp_error err = {0};
    stp_file_mirror *mirror = NULL;
    const stp_mirror_params params = {.folder = ".", .web = &quick};
    if (stp_mirror_open(&mirror, address, &params, &err) != STP_OK)
        fail_msg("%s", err.message);
    return mirror;
}

static void needs(void **state)
{
    (void)state;
    fault_server server;
    stp_error err = {0};
    unsigned char got[3];
    assert_true(fault_server_create(&server, bytes, size));
    stp_file_mirror *mirror = open_mirror(server.address);
    assert_int_equal(stp_mirror_size(mirror), size);
    assert_int_equal(stp_mirror_need(mirror, size - 3, UINT64_MAX, &err), STP_OK);
    const uint64_t once = stp_mirror_fetched(mirror);
    assert_true(once > 0 && once <= STP_MIRROR_BLOCK_BYTES);
    assert_int_equal(stp_mirror_need(mirror, size - 2, size, &err), STP_OK);
    assert_int_equal(stp_mirror_need(mirror, size, size + 9, &err), STP_OK);
    assert_int_equal(stp_mirror_need(mirror, 9, 9, &err), STP_OK);
    assert_int_equal(stp_mirror_fetched(mirror), once);
    FILE *f = fopen(stp_mirror_path(mirror), "rb");
    assert_non_null(f);
    assert_int_equal(fseek(f, -3, SEEK_END), 0);
    assert_int_equal(fread(got, 1, 3, f), 3);
    assert_memory_equal(got, bytes + size - 3, 3);
    fclose(f);
    assert_int_equal(stp_mirror_need(mirror, 0, size, &err), STP_OK);
    assert_int_equal(stp_mirror_fetched(mirror), size);
    stp_mirror_close(&mirror);
    fault_server_destroy(&server);
}

static void copc_by_ranges(void **state)
{
    (void)state;
    fault_server server;
    stp_scan_info info;
    const stp_scan_region region = {.resolution = 2.5};
    assert_true(fault_server_create(&server, bytes, size));
    stp_file_mirror *mirror = open_mirror(server.address);
    const stp_scan_params part = {.region = &region, .mirror = mirror};
    free(scan_fixture_read(server.address, &part, &info));
    assert_int_equal(info.point_count, 9);
    assert_true(stp_mirror_fetched(mirror) < PAD / 2);
    const stp_scan_params whole = {.mirror = mirror};
    stp_point *points = scan_fixture_read(server.address, &whole, &info);
    assert_int_equal(info.point_count, COPC_NODES);
    assert_int_equal(points[COPC_NODES - 1].intensity, 1000 + COPC_NODES - 1);
    free(points);
    stp_mirror_close(&mirror);
    fault_server_destroy(&server);
}

static void servers_that_fail(void **state)
{
    (void)state;
    fault_server server;
    stp_error err = {0};
    stp_scan *scan = NULL;
    assert_true(fault_server_create(&server, bytes, size));
    stp_file_mirror *mirror = open_mirror(server.address);
    const stp_scan_params whole = {.mirror = mirror};
    fault_server_order(&server, &(fault_orders){.kind = FAULT_STATUS, .count = 1000, .code = 404});
    stp_status status = stp_scan_open(&scan, server.address, &whole, &err);
    assert_true(status != STP_OK && strstr(err.message, "127.0.0.1"));
    assert_null(strstr(err.message, "/proc/"));
    stp_mirror_close(&mirror);
    status = stp_scan_open(&scan, server.address, NULL, &err);
    assert_int_equal(status, STP_INVALID_ARGUMENT);
    fault_server_destroy(&server);

    bytes[size - 2000] ^= 0xff; /* within the hierarchy: the message has the address */
    assert_true(fault_server_create(&server, bytes, size));
    mirror = open_mirror(server.address);
    const stp_scan_region region = {.resolution = 0.1};
    const stp_scan_params part = {.region = &region, .mirror = mirror};
    status = stp_scan_open(&scan, server.address, &part, &err);
    assert_int_equal(status, STP_CORRUPT);
    assert_true(strstr(err.message, "127.0.0.1") && !strstr(err.message, "/proc/"));
    stp_mirror_close(&mirror);
    fault_server_destroy(&server);
    bytes[size - 2000] ^= 0xff;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(needs),
        cmocka_unit_test(copc_by_ranges),
        cmocka_unit_test(servers_that_fail),
    };
    return cmocka_run_group_tests(tests, enter, leave);
}
