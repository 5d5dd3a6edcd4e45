/* Tests chunk files on a web server: the reader needs few requests and gets the file's bytes;
 * damage on the way is repaired or named. */
#include "tests/fixtures/chunk_fixture.h"

#include "base/clock.h"
#include "formats/chunk/chunk_file.h"
#include "formats/chunk/remote/http.h"
#include "formats/chunk/verify/verify.h"
#include "tests/support/check.h"
#include "tests/support/fault_server.h"

#include <sys/wait.h>

#define BRANCHES 8u
#define CHUNKS (1 + BRANCHES + BRANCHES * BRANCHES) /* more than a directory page holds */

static const stp_byte_source_params quick = {.stall_ms = 2000, .tries = 3, .pause_ms = 2};
static fault_server server;
static stp_chunk_file *local; /* the same file on disk */

static void write_model(const char *path, stp_codec codec)
{
    fixture_tree *tree = calloc(1, sizeof *tree);
    uint32_t inner[BRANCHES];
    assert_non_null(tree);
    tree->box = stp_dbox_empty();
    for (uint32_t i = 0; i < BRANCHES; i++) {
        uint32_t leaf[BRANCHES];
        for (uint32_t k = 0; k < BRANCHES; k++)
            leaf[k] = fixture_add_leaf(tree, 10 * i + k, 3, 20,
                                       (stp_dvec3){40.0 * (BRANCHES * i + k), 0.0, 0.0});
        inner[i] = fixture_add_parent(tree, leaf, BRANCHES);
    }
    fixture_add_parent(tree, inner, BRANCHES);
    check_ok(fixture_write(tree, path, codec, err));
    fixture_destroy(tree);
    free(tree);
}

static int set_up(void **state)
{
    size_t size = 0;
    (void)state;
    const char *path = fixture_path("model.stipple");
    write_model(path, STP_CODEC_DRACO);
    uint8_t *bytes = fixture_read_file(path, &size);
    check_ok(stp_chunk_file_open(&local, path, err));
    bool made = fault_server_create(&server, bytes, size);
    free(bytes);
    return made ? 0 : -1;
}

static int tear_down(void **state)
{
    fault_server_destroy(&server);
    stp_chunk_file_close(&local);
    return fixture_remove_folder(state);
}

static void check_chunk(stp_chunk_file *file, uint32_t id, int finest)
{
    stp_chunk *got = NULL, *wanted = NULL;
    check_ok(stp_chunk_file_read(file, id, finest, &got, err));
    check_ok(stp_chunk_file_read(local, id, finest, &wanted, err));
    for (int l = finest; l < STP_LEVEL_COUNT; l++) {
        uint32_t count = wanted->level_begin[l][wanted->patch_count];
        assert_memory_equal(got->samples[l], wanted->samples[l], count * sizeof(stp_sample));
    }
    stp_chunk_destroy(&got);
    stp_chunk_destroy(&wanted);
}

static void check_all(stp_chunk_file *file)
{
    for (uint32_t id = 0; id < CHUNKS; id++)
        check_chunk(file, id, (int)(id % 3));
}

static void two_requests_open(void **state)
{
    stp_chunk_file *file = NULL;
    stp_chunk_entry entry;
    stp_byte_source_stats stats;
    (void)state;
    fault_server_order(&server, &(fault_orders){.kind = FAULT_NONE});
    check_ok(stp_chunk_file_open_at(&file, server.address, &quick, err));
    assert_string_equal(stp_chunk_file_path(file), server.address);
    for (uint32_t id = 0; id < CHUNKS; id++)
        check_ok(stp_chunk_file_entry(file, id, &entry, err));
    const stp_chunk_file_info *info = stp_chunk_file_get_info(file);
    assert_string_equal(info->metadata_json, FIXTURE_METADATA);
    assert_int_equal(fault_server_requests(&server), 2);
    stp_byte_source_get_stats(stp_chunk_file_source(file), &stats);
    assert_int_equal(stats.requests, 2);
    assert_int_equal(stats.bytes, STP_HTTP_HEAD_BYTES + info->file_bytes - info->payloads_end);
    check_all(file);
    assert_int_equal(fault_server_requests(&server), 2 + CHUNKS);
    stp_chunk_file_close(&file);
}

/* A bit flips in the n-th answer: the reader must ask again and get the right bytes. */
static void bits_that_flip_once_are_mended(void **state)
{
    (void)state;
    for (unsigned n = 0; n < 6; n++) {
        stp_chunk_file *file = NULL;
        fault_server_order(&server, &(fault_orders){.kind = FAULT_FLIP, .first = n, .count = 1});
        check_ok(stp_chunk_file_open_at(&file, server.address, &quick, err));
        check_all(file);
        /* the second page of the directory may need a request of its own */
        unsigned requests = fault_server_requests(&server);
        assert_true(requests == 3 + CHUNKS || (n == 1 && requests == 4 + CHUNKS));
        stp_chunk_file_close(&file);
    }
}

/* Bits flip in five of six answers: this may cost time and nothing else. */
static void bits_that_flip_often_are_mended(void **state)
{
    stp_chunk_file *file = NULL;
    stp_byte_source_stats stats;
    (void)state;
    fault_server_order(&server, &(fault_orders){.kind = FAULT_NONE});
    check_ok(stp_chunk_file_open_at(&file, server.address, &quick, err));
    for (uint32_t id = 0; id < 3; id++) {
        fault_server_order(&server, &(fault_orders){.kind = FAULT_FLIP, .count = 5});
        check_chunk(file, id, 0);
    }
    stp_byte_source_get_stats(stp_chunk_file_source(file), &stats);
    assert_int_equal(stats.damaged, 15);
    stp_chunk_file_close(&file);
}

static void bits_that_flip_always_are_named(void **state)
{
    stp_chunk_file *file = NULL;
    stp_chunk *chunk = NULL;
    stp_error failure = {0};
    (void)state;
    for (unsigned n = 0; n < 2; n++) { /* header, directory */
        fault_server_order(&server, &(fault_orders){.kind = FAULT_FLIP, .first = n, .count = 1000});
        stp_status status = stp_chunk_file_open_at(&file, server.address, &quick, &failure);
        assert_true(status == STP_CORRUPT);
        assert_non_null(strstr(failure.message, server.address));
        assert_null(file);
    }
    fault_server_order(&server, &(fault_orders){.kind = FAULT_FLIP, .first = 2, .count = 6});
    check_ok(stp_chunk_file_open_at(&file, server.address, &quick, err));
    assert_int_equal(stp_chunk_file_read(file, 5, 0, &chunk, &failure), STP_CORRUPT);
    assert_non_null(strstr(failure.message, "chunk 5"));
    assert_null(chunk);
    check_all(file); /* the other chunks, and this one as soon as the server is well */
    stp_chunk_file_close(&file);
}

/* The file changes at the n-th request: either all bytes are of one state, or an error says so. */
static void a_change_is_never_mixed_in(void **state)
{
    (void)state;
    for (unsigned n = 1; n < 5; n++) {
        stp_chunk_file *file = NULL;
        stp_error failure = {0};
        stp_status status = STP_OK;
        fault_server_order(&server,
                           &(fault_orders){.kind = FAULT_CHANGED, .first = n, .count = 1000});
        status = stp_chunk_file_open_at(&file, server.address, &quick, &failure);
        for (uint32_t id = 0; status == STP_OK && id < CHUNKS; id++) {
            stp_chunk *chunk = NULL;
            status = stp_chunk_file_read(file, id, 0, &chunk, &failure);
            stp_chunk_destroy(&chunk);
        }
        assert_int_equal(status, STP_IO);
        assert_non_null(strstr(failure.message, "changed on the server"));
        assert_int_equal(fault_server_requests(&server), n + 1);
        stp_chunk_file_close(&file);
    }
}

/* A bit flips in one of the two copies of a header of version 2: the reader asks again. */
static void a_copy_of_the_header_is_mended(void **state)
{
    fault_server other;
    stp_chunk_file *file = NULL;
    size_t size = 0;
    (void)state;
    const char *path = fixture_path("blocks.stipple");
    write_model(path, STP_CODEC_DRACO_BLOCKS);
    uint8_t *bytes = fixture_read_file(path, &size);
    assert_true(fault_server_create(&other, bytes, size));
    fault_server_order(&other, &(fault_orders){.kind = FAULT_FLIP, .count = 1});
    check_ok(stp_chunk_file_open_at(&file, other.address, &quick, err));
    assert_int_equal(fault_server_requests(&other), 3);
    assert_false(stp_chunk_file_get_info(file)->header_damaged);
    check_all(file);
    stp_chunk_file_close(&file);
    fault_server_destroy(&other);
    free(bytes);
}

static void what_is_no_chunk_file_is_called_so(void **state)
{
    static const char page[] = "<html>a page, not a model, and longer than a header is: "
                               "................................................................"
                               "................................................................"
                               "................................................................";
    fault_server other;
    stp_chunk_file *file = NULL;
    stp_error failure = {0};
    (void)state;
    for (size_t size = 0; size < sizeof page; size += 40) {
        assert_true(fault_server_create(&other, page, size));
        stp_status status = stp_chunk_file_open_at(&file, other.address, &quick, &failure);
        assert_true(status == STP_FORMAT || (size < 40 && status == STP_CORRUPT));
        fault_server_destroy(&other);
    }
}

/* ---- the program ---- */

/* Runs the program with these words; returns the exit code. The output goes into the file
 * "said". */
static int run(const char *before, const char *words)
{
    char command[1200];
    const char *program = getenv("STIPPLE");
    snprintf(command, sizeof command, "cd %s && %s '%s' %s >said 2>&1 </dev/null", fixture_folder,
             before, program, words);
    int code = system(command);
    assert_true(WIFEXITED(code));
    return WEXITSTATUS(code);
}

static bool said(const char *text)
{
    size_t size = 0;
    uint8_t *bytes = fixture_read_file(fixture_path("said"), &size);
    bytes[size] = '\0';
    bool found = strstr((const char *)bytes, text) != NULL;
    if (!found)
        print_error("not '%s' but: %s\n", text, (const char *)bytes);
    free(bytes);
    return found;
}

static const char *with_address(const char *format)
{
    static char words[500];
    char secret[200];
    snprintf(secret, sizeof secret, "http://me:sesame@%s?key=opens", server.address + 7);
    snprintf(words, sizeof words, format, secret);
    return words;
}

static void commands_take_addresses(void **state)
{
    (void)state;
    fault_server_order(&server, &(fault_orders){.kind = FAULT_NONE});
    assert_int_equal(run("", with_address("info '%s'")), 0);
    assert_true(said("73 in 3 levels") && said("model.stipple?..."));
    assert_int_equal(run("! grep -e sesame -e opens said;", with_address("verify '%s'")), 0);
    assert_true(said("sound"));
    assert_int_equal(run("! grep -e sesame -e opens said;", with_address("export '%s' -o far.ply")),
                     0);
    assert_int_equal(run("", "export model.stipple -o near.ply"), 0);
    assert_int_equal(run("cmp far.ply near.ply &&", "--version"), 0);
    assert_int_equal(run("", with_address("verify --repair '%s' -o r.stipple")), 2);
    assert_true(said("copy the file here"));
    fault_server_order(&server, &(fault_orders){.kind = FAULT_STATUS, .count = 1000, .code = 404});
    assert_int_equal(run("", with_address("info '%s'")), 1);
    assert_true(said("check the address"));
    assert_int_equal(run("! grep -e sesame -e opens said;", "--version"), 0);
}

/* Ctrl-C must end a picture from a silent server long before its time-outs. (A second Ctrl-C would
 * kill the program; with --foreground, timeout sends just one.) */
static void drawing_is_interrupted(void **state)
{
    (void)state;
    if (run("", "render --help") != 0)
        skip(); /* built without the renderer */
    for (unsigned n = 0; n < 3; n++) {
        double begin_s = stp_clock_seconds();
        fault_server_order(&server,
                           &(fault_orders){.kind = FAULT_STALL, .first = n, .count = 1000});
        assert_int_equal(run("timeout --foreground --preserve-status -s INT 2",
                             with_address("render '%s' -o i.png")),
                         1);
        assert_true(said("interrupted"));
        assert_true(stp_clock_seconds() - begin_s < 30.0); /* less than four tries of 10 s */
        assert_true(access(fixture_path("i.png"), F_OK) != 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_requests_open),
        cmocka_unit_test(bits_that_flip_once_are_mended),
        cmocka_unit_test(bits_that_flip_often_are_mended),
        cmocka_unit_test(bits_that_flip_always_are_named),
        cmocka_unit_test(a_change_is_never_mixed_in),
        cmocka_unit_test(a_copy_of_the_header_is_mended),
        cmocka_unit_test(what_is_no_chunk_file_is_called_so),
        cmocka_unit_test(commands_take_addresses),
        cmocka_unit_test(drawing_is_interrupted),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
