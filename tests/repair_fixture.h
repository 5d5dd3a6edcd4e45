/* A sound chunk file in memory, its damaged twin, and the repair of that. */
#ifndef STP_TESTS_REPAIR_FIXTURE_H
#define STP_TESTS_REPAIR_FIXTURE_H

#include "formats/chunk/layout.h"
#include "formats/chunk/repair.h"
#include "preprocess/rebuild.h"
#include "tests/chunk_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>

#include <cmocka.h>

#define REPORT_BYTES 16384
/* Chunks of the tree: 0 root, 1 and 2 inner, 3 to 6 leaves; the fixture's leaves are 0 1 3 4. */
#define CHUNKS 7u
#define FIRST_LEAF 3u
static const uint32_t leaf_handle[CHUNKS] = {0, 0, 0, 0, 1, 3, 4};

typedef struct bench {
    fixture_tree tree;
    uint8_t *bytes; /* of the sound file */
    size_t size;
    uint8_t *damaged;
    stp_pool *pool;
    char report[REPORT_BYTES];
    stp_repair_result result;
    stp_error err;
} bench;

static inline bench *setup_bench(void)
{
    bench *b = calloc(1, sizeof *b);
    assert_non_null(b);
    const char *path = fixture_path("sound.stipple");
    fixture_tree_of_seven(&b->tree, 20, 40);
    assert_int_equal(fixture_write(&b->tree, path, STP_CODEC_DRACO, NULL), STP_OK);
    b->bytes = fixture_read_file(path, &b->size);
    b->damaged = malloc(b->size + 16);
    assert_non_null(b->damaged);
    memcpy(b->damaged, b->bytes, b->size);
    assert_int_equal(stp_pool_create(&b->pool, 2, NULL), STP_OK);
    return b;
}

static inline void free_bench(bench *b)
{
    fixture_destroy(&b->tree);
    stp_pool_destroy(&b->pool);
    free(b->bytes);
    free(b->damaged);
    free(b);
}

static inline uint8_t *entry(const bench *b, uint32_t id)
{
    return b->damaged + stp_get_u64(b->bytes + 32) + (size_t)id * STP_ENTRY_BYTES;
}

/* A segment's place, by the sound file's directory. */
static inline uint8_t *segment(const bench *b, uint32_t id, int s, size_t *size)
{
    const uint8_t *e = b->bytes + stp_get_u64(b->bytes + 32) + (size_t)id * STP_ENTRY_BYTES;
    uint32_t begin = s > 0 ? stp_get_u32(e + 4 + 4 * s) : 0;
    *size = stp_get_u32(e + 8 + 4 * s) - begin;
    return b->damaged + stp_get_u64(e) + begin;
}

/* More than a bit: what stands in the middle of it is another. */
static inline void destroy_segment(const bench *b, uint32_t id, int s)
{
    size_t size = 0;
    uint8_t *bytes = segment(b, id, s, &size);
    assert_true(size > 40);
    for (size_t i = 0; i < 16; i++)
        bytes[size / 2 + i] ^= 0xa5;
}

static inline void say(void *context, const char *line)
{
    bench *b = context;
    size_t length = strlen(b->report);
    snprintf(b->report + length, REPORT_BYTES - length, "%s\n", line);
}

static inline stp_status repair_size(bench *b, size_t size, const char *output, bool force)
{
    const char *path = fixture_path("damaged.stipple");
    const stp_repair_params params = {.output = output,
                                      .force = force,
                                      .build_parent = stp_rebuild_parent,
                                      .pool = b->pool,
                                      .say = say,
                                      .context = b};
    fixture_write_file(path, b->damaged, size);
    b->report[0] = '\0';
    b->err.message[0] = '\0';
    return stp_chunk_file_repair(path, &params, &b->result, &b->err);
}

static inline const char *output_path(void)
{
    static char path[256];
    snprintf(path, sizeof path, "%s", fixture_path("repaired.stipple"));
    return path;
}

static inline void repair(bench *b)
{
    unlink(output_path());
    stp_status status = repair_size(b, b->size, output_path(), false);
    if (status != STP_OK)
        print_error("%s\n%s", b->err.message, b->report);
    assert_int_equal(status, STP_OK);
}

#endif
