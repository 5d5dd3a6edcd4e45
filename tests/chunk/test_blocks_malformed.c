/* Tests invalid files of version 2: wrong numbers in both copies of the header, sections, records
 * and indices of blocks, all under right checksums. verify must refuse each with a sentence, and no
 * reader may come to harm. What files of both versions share, test_chunk_malformed.c tests. */
#include "formats/chunk/block/block.h"
#include "formats/chunk/verify/verify.h"
#include "tests/fixtures/chunk_fixture.h"
#include "tests/fixtures/chunk_reseal.h"

#include <setjmp.h>
#include <stdarg.h>

#include <cmocka.h>

typedef struct sample_file {
    uint8_t *bytes;
    size_t size;
} sample_file;

/* Two inner chunks of two leaves each; a leaf has two blocks. */
static sample_file small_file(stp_codec codec)
{
    sample_file out;
    fixture_tree tree;
    const char *path = fixture_path("small.stipple");
    fixture_tree_of_seven(&tree, 10, 6);
    assert_int_equal(fixture_write(&tree, path, codec, NULL), STP_OK);
    out.bytes = fixture_read_file(path, &out.size);
    fixture_destroy(&tree);
    return out;
}

/* Decodes a block at all levels. */
static stp_status read_block(stp_chunk_file *file, const stp_block *block, stp_error *err)
{
    stp_status status = STP_OK;
    uint8_t *payload = malloc((size_t)stp_block_payload_bytes(block, 0) + 1);
    assert_non_null(payload);
    for (int level = 2; status == STP_OK && level >= 0; level--) {
        stp_chunk *chunk = NULL;
        status =
            stp_block_fetch(file, block, 0, stp_block_payload_bytes(block, level), payload, err);
        if (status == STP_OK)
            status = stp_block_decode(file, block, level, payload, NULL, &chunk, err);
        stp_chunk_destroy(&chunk);
    }
    free(payload);
    return status;
}

/* Decodes each block of a chunk; returns the last failure. */
static stp_status read_blocks(stp_chunk_file *file, uint32_t id, uint32_t *failed, stp_error *err)
{
    uint32_t count = 0;
    stp_status status = stp_chunk_file_block_count(file, id, &count, err);
    if (status != STP_OK)
        return status;
    stp_block *blocks = calloc(count, sizeof *blocks);
    assert_non_null(blocks);
    status = stp_chunk_file_blocks(file, id, blocks, err);
    stp_status last = status;
    for (uint32_t b = 0; status == STP_OK && b < count; b++) {
        const stp_status one = read_block(file, &blocks[b], err);
        *failed += one != STP_OK;
        last = one != STP_OK ? one : last;
    }
    free(blocks);
    return last;
}

/* Opens, decodes all chunks and all blocks, and verifies. Returns what verify says. */
static stp_status read_all(const uint8_t *bytes, size_t size, stp_error *err)
{
    const char *path = fixture_path("changed.stipple");
    stp_chunk_file *file = NULL;
    stp_pool *pool = NULL;
    uint32_t failed = 0;
    fixture_write_file(path, bytes, size);
    stp_status status = stp_chunk_file_open(&file, path, err);
    if (status != STP_OK)
        return status;
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk *chunk = NULL;
        (void)stp_chunk_file_read(file, id, 0, &chunk, NULL);
        stp_chunk_destroy(&chunk);
        (void)read_blocks(file, id, &failed, NULL);
    }
    assert_int_equal(stp_pool_create(&pool, 1, NULL), STP_OK);
    status = stp_chunk_file_verify(file, pool, NULL, err);
    assert_true(status != STP_OK || failed == 0);
    stp_pool_destroy(&pool);
    stp_chunk_file_close(&file);
    return status;
}

/* ---- wrong numbers ---- */

typedef enum part { HEADER, ENTRY, RECORD, INDEX_0, COUNTS_0, INDEX_1 } part;

typedef struct wrong_number {
    part part;
    unsigned place; /* byte of the part; entry, first record and indices are those of chunk 3 */
    int bytes;
    uint64_t value;
} wrong_number;

#define SHORT_ROWS 0x80000000u
#define NAN32 0x7fc00000u
#define INF32 0x7f800000u
#define FAR32 0x5ae35fa9u /* 3.2e16 */

static const wrong_number wrong_numbers[] = {
    {HEADER, 8, 2, 1},
    {HEADER, 12, 4, 256},
    {HEADER, 12, 4, 1023},
    {HEADER, 12, 4, 1025},
    {HEADER, 12, 4, UINT32_MAX},
    {HEADER, 40, 8, 0},
    {HEADER, 40, 8, 2047},
    {HEADER, 48, 8, UINT64_MAX},
    {HEADER, 144, 8, UINT64_MAX},
    {HEADER, 152, 8, 0},
    {HEADER, 160, 4, 0},
    {HEADER, 160, 4, 2},
    {HEADER, 160, 4, 17},
    {HEADER, 160, 4, UINT32_MAX},
    {HEADER, 168, 8, 0},
    {HEADER, 176, 8, 0},
    {HEADER, 176, 8, 2047},
    {HEADER, 176, 8, UINT64_MAX},
    {HEADER, 184, 8, 0},
    {HEADER, 184, 8, STP_BLOCK_BYTES},
    {HEADER, 184, 8, UINT64_MAX},
    {ENTRY, 0, 8, 0},
    {ENTRY, 0, 8, STP_HEADER_BYTES_2},
    {ENTRY, 76, 1, STP_CODEC_RAW},
    {ENTRY, 76, 1, STP_CODEC_DRACO},
    {ENTRY, 76, 1, STP_CODEC_ZSTD},
    {ENTRY, 76, 1, STP_CODEC_COUNT},
    {ENTRY, 208, 4, 0},
    {ENTRY, 208, 4, UINT32_MAX},
    {ENTRY, 212, 4, 0},
    {ENTRY, 212, 4, 1},
    {ENTRY, 212, 4, 3},
    {ENTRY, 212, 4, UINT32_MAX},
    {RECORD, 0, 2, 0},
    {RECORD, 0, 2, 8},
    {RECORD, 0, 2, 65535},
    {RECORD, 2, 2, 0},
    {RECORD, 2, 2, 65535},
    {RECORD, 4, 2, 0},
    {RECORD, 6, 2, 65535},
    {RECORD, 8, 3, 0},
    {RECORD, 11, 3, 0xffffff},
    {RECORD, 14, 3, 1},
    {RECORD, 17, 1, 0},
    {RECORD, 21, 1, 0},
    {RECORD, 22, 2, 201},
    {RECORD, 22, 2, 0xff37},
    {RECORD, 22, 2, 0xff38},
    {RECORD, 24, 1, 0},
    {RECORD, 27, 1, 0},
    {RECORD, 29, 1, 0},
    {RECORD, 33, 1, 0},
    {RECORD, 48, 8, 0},
    {RECORD, 48, 8, UINT64_MAX >> 4},
    {RECORD, 48, 4, 0x3fffffff},
    {INDEX_0, 0, 4, 0},
    {INDEX_0, 0, 4, 1},
    {INDEX_0, 0, 4, 2},
    {INDEX_0, 0, 4, UINT32_MAX},
    {INDEX_0, 0, 4, SHORT_ROWS},
    {INDEX_0, 0, 4, SHORT_ROWS | 1},
    {INDEX_0, 0, 4, SHORT_ROWS | 3},
    {INDEX_0, 4, 1, 0},
    {INDEX_0, 4, 1, 255},
    {INDEX_0, 4, 4, UINT32_MAX},
    {INDEX_0, 4, 8, UINT64_MAX},
    {COUNTS_0, 0, 1, 0},
    {COUNTS_0, 0, 1, 127},
    {COUNTS_0, 0, 1, 255},
    {COUNTS_0, 0, 4, 0x7fffff},
    {COUNTS_0, 1, 1, 0},
    {COUNTS_0, 1, 2, 0x7fff},
    {COUNTS_0, 3, 1, 127},
    {COUNTS_0, 3, 2, 0x7fff},
    {COUNTS_0, 4, 1, 127},
    {INDEX_1, 0, 4, 0},
    {INDEX_1, 0, 4, 1},
    {INDEX_1, 0, 4, 2},
    {INDEX_1, 0, 4, UINT32_MAX},
    {INDEX_1, 0, 4, SHORT_ROWS},
    {INDEX_1, 0, 4, SHORT_ROWS | 1},
    {INDEX_1, 0, 4, SHORT_ROWS | 3},
    {INDEX_1, 4, 1, 0},
    {INDEX_1, 4, 1, 255},
    {INDEX_1, 4, 4, UINT32_MAX},
};

static uint8_t *entry_of(uint8_t *bytes, uint32_t id)
{
    return bytes + stp_get_u64(bytes + 32) + (size_t)id * STP_ENTRY_BYTES;
}

static uint8_t *record_of(uint8_t *bytes, uint32_t id)
{
    return bytes + stp_get_u64(bytes + 176) +
           (size_t)stp_get_u32(entry_of(bytes, id) + 208) * STP_BLOCK_BYTES;
}

/* What follows the first number of a short row. */
static uint8_t *counts_of(uint8_t *row)
{
    while (*row & 128u)
        row++;
    return row + 1;
}

static uint8_t *part_of(uint8_t *bytes, part where)
{
    uint8_t *entry = entry_of(bytes, 3);
    switch (where) {
    case ENTRY:
        return entry;
    case RECORD:
        return record_of(bytes, 3);
    case INDEX_0:
        return bytes + stp_get_u64(entry);
    case COUNTS_0:
        return counts_of(bytes + stp_get_u64(entry) + 4);
    case INDEX_1:
        return bytes + stp_get_u64(entry) + stp_get_u32(entry + 8);
    default:
        return bytes;
    }
}

/* Writes the second copy of the header like the first. */
static void copy_header(uint8_t *bytes)
{
    memcpy(bytes + STP_HEADER_BYTES_2, bytes, STP_HEADER_BYTES_2);
}

static void put_number(uint8_t *to, int bytes, uint64_t value)
{
    for (int i = 0; i < bytes; i++)
        to[i] = (uint8_t)(value >> (8 * i));
}

static void assert_refused(const uint8_t *bytes, size_t size, const wrong_number *wrong)
{
    stp_error err = {0};
    stp_status status = read_all(bytes, size, &err);
    if (status == STP_OK)
        fail_msg("accepted: part %d, place %u, value %llu", (int)wrong->part, wrong->place,
                 (unsigned long long)wrong->value);
    assert_true(status == STP_CORRUPT || status == STP_UNSUPPORTED);
    assert_non_null(strstr(err.message, "changed.stipple: "));
    assert_null(strchr(err.message, '\n'));
}

static void refuse_wrong_numbers(stp_codec codec)
{
    sample_file f = small_file(codec);
    uint8_t *copy = malloc(f.size);
    assert_non_null(copy);
    assert_int_equal(read_all(f.bytes, f.size, NULL), STP_OK);
    for (size_t i = 0; i < sizeof wrong_numbers / sizeof *wrong_numbers; i++) {
        const wrong_number *w = &wrong_numbers[i];
        memcpy(copy, f.bytes, f.size);
        put_number(part_of(copy, w->part) + w->place, w->bytes, w->value);
        copy_header(copy);
        reseal(copy, f.size, false);
        assert_refused(copy, f.size, w);
    }
    free(copy);
    free(f.bytes);
}

static void test_wrong_numbers(void **state)
{
    (void)state;
    refuse_wrong_numbers(STP_CODEC_RAW_BLOCKS);
    refuse_wrong_numbers(STP_CODEC_DRACO_BLOCKS);
    refuse_wrong_numbers(STP_CODEC_ZSTD_BLOCKS);
    refuse_wrong_numbers(STP_CODEC_PAPER);
}

/* Reads an index of segment 0 in front of parts of 305 bytes. */
static stp_status read_rows(const uint8_t *index, size_t size, stp_block_row rows[2])
{
    uint8_t bytes[400] = {0};
    memcpy(bytes, index, size);
    return stp_block_rows_read(bytes, size + 305, 0, rows, 2, NULL);
}

/* Long and short rows say the same. A number that is longer than it needs to be is refused. */
static void test_rows(void **state)
{
    (void)state;
    static const uint8_t long_rows[] = {2,   0, 0, 0, 44, 1, 0, 0, 2, 0, 10 - 1, 0, 37 - 1, 0,
                                        141, 0, 5, 0, 0,  0, 0, 0, 3, 0, 15,     0, 63,     0};
    static const uint8_t short_rows[] = {2, 0, 0, 128, 128 + 44, 2, 2, 50, 1, 0, 5, 0, 0, 0, 0};
    static const uint8_t padded[] = {2, 0, 0,       128, 128 + 44, 2, 2, 50,
                                     1, 0, 128 + 5, 0,   0,        0, 0, 0};
    static const uint8_t beyond[] = {2, 0, 0,       128, 128 + 44, 2,   2,  50, 1, 0,
                                     5, 0, 128 + 0, 128, 128,      128, 16, 0,  0};
    stp_block_row a[2] = {0}, b[2] = {0};
    assert_int_equal(read_rows(long_rows, sizeof long_rows, a), STP_OK);
    assert_int_equal(read_rows(short_rows, sizeof short_rows, b), STP_OK);
    const uint32_t counts[STP_LEVEL_COUNT] = {142, 37, 10, 3};
    assert_memory_equal(a[0].sample_count, counts, sizeof counts);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(a[i].begin - sizeof long_rows, b[i].begin - sizeof short_rows);
        a[i].begin = b[i].begin;
        assert_memory_equal(&a[i], &b[i], sizeof a[i]);
        assert_true(b[i].patch_count == (i ? 1 : 3) && b[i].bytes == (i ? 5 : 300));
    }
    assert_int_equal(read_rows(padded, sizeof padded, b), STP_CORRUPT);
    assert_int_equal(read_rows(beyond, sizeof beyond, b), STP_CORRUPT);
}

/* Checksums that nothing corrects: of a section, of an entry's records, of a block's part. */
static void test_wrong_checksums(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_DRACO_BLOCKS);
    const wrong_number places[] = {{HEADER, 192, 1, 0},
                                   {ENTRY, 216, 1, 0},
                                   {RECORD, 36, 1, 0},
                                   {RECORD, 40, 1, 0},
                                   {RECORD, 44, 1, 0}};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        uint8_t *copy = malloc(f.size);
        assert_non_null(copy);
        memcpy(copy, f.bytes, f.size);
        part_of(copy, places[i].part)[places[i].place] ^= 1;
        uint8_t *entry = entry_of(copy, 3), *page = entry_of(copy, 0);
        if (places[i].part == RECORD)
            stp_put_u64(entry + 216, stp_hash(record_of(copy, 3), 2 * STP_BLOCK_BYTES));
        stp_put_u64(page + 7 * STP_ENTRY_BYTES, stp_hash(page, 7 * STP_ENTRY_BYTES));
        if (places[i].part != HEADER)
            reseal_sections(copy, copy, f.size);
        stp_put_u64(copy + STP_HEADER_BYTES_2 - STP_HASH_BYTES,
                    stp_hash(copy, STP_HEADER_BYTES_2 - STP_HASH_BYTES));
        copy_header(copy);
        assert_refused(copy, f.size, &places[i]);
        free(copy);
    }
    free(f.bytes);
}

/* Two sound copies of one generation that differ; of two generations the greater counts. */
static void test_copies(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_DRACO_BLOCKS);
    stp_error err = {0};
    stp_put_u32(f.bytes + 76, STP_ORIENTATION_UNKNOWN);
    reseal(f.bytes, f.size, false);
    assert_int_equal(read_all(f.bytes, f.size, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "the copy of its header at byte 1024"));
    stp_put_u64(f.bytes + 152, 2);
    for (uint64_t generation = 1; generation <= 3; generation += 2) {
        const char *path = fixture_path("generation.stipple");
        stp_chunk_file *file = NULL;
        stp_put_u64(f.bytes + STP_HEADER_BYTES_2 + 152, generation);
        reseal(f.bytes, f.size, false);
        assert_int_equal(read_all(f.bytes, f.size, NULL), STP_OK);
        fixture_write_file(path, f.bytes, f.size);
        assert_int_equal(stp_chunk_file_open(&file, path, NULL), STP_OK);
        assert_int_equal(stp_chunk_file_get_info(file)->orientation,
                         generation == 3 ? STP_ORIENTATION_FILE : STP_ORIENTATION_UNKNOWN);
        stp_chunk_file_close(&file);
    }
    free(f.bytes);
}

/* ---- sections ---- */

#define SECTION_BYTES 40u

/* Adds a section that this program does not know behind the table of blocks. */
static sample_file with_section(uint32_t flags)
{
    sample_file f = small_file(STP_CODEC_DRACO_BLOCKS), out = {.size = f.size + SECTION_BYTES};
    const uint64_t metadata = stp_get_u64(f.bytes + 40);
    out.bytes = calloc(out.size, 1);
    assert_non_null(out.bytes);
    memcpy(out.bytes, f.bytes, metadata);
    memset(out.bytes + metadata, 0x5a, SECTION_BYTES);
    memcpy(out.bytes + metadata + SECTION_BYTES, f.bytes + metadata, f.size - metadata);
    stp_put_u64(out.bytes + 32, stp_get_u64(f.bytes + 32) + SECTION_BYTES);
    stp_put_u64(out.bytes + 40, metadata + SECTION_BYTES);
    stp_put_u32(out.bytes + 160, 2);
    uint8_t *section = out.bytes + RESEAL_SECTIONS_AT + RESEAL_SECTION_BYTES;
    static const char kind[4] = {'X', 'T', 'R', 'A'};
    memcpy(section, kind, sizeof kind);
    stp_put_u32(section + 4, flags);
    stp_put_u64(section + 8, metadata);
    stp_put_u64(section + 16, SECTION_BYTES);
    copy_header(out.bytes);
    reseal(out.bytes, out.size, true);
    free(f.bytes);
    return out;
}

static void test_unknown_section(void **state)
{
    (void)state;
    stp_error err = {0};
    sample_file f = with_section(STP_SECTION_NEEDED);
    assert_int_equal(read_all(f.bytes, f.size, &err), STP_VERSION);
    assert_non_null(strstr(err.message, "use a newer stipple"));
    free(f.bytes);
    f = with_section(0);
    assert_int_equal(read_all(f.bytes, f.size, NULL), STP_OK);
    f.bytes[stp_get_u64(f.bytes + 40) - 1] ^= 1;
    assert_int_equal(read_all(f.bytes, f.size, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "the checksum of a section (40 bytes at byte"));
    free(f.bytes);
}

/* ---- the frame ---- */

static void test_truncated(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_DRACO_BLOCKS);
    for (size_t size = 0; size < f.size; size++) {
        stp_error err = {0};
        assert_int_equal(read_all(f.bytes, size, &err), size < 7 ? STP_FORMAT : STP_CORRUPT);
        assert_non_null(strstr(err.message, "changed.stipple"));
    }
    free(f.bytes);
}

/* What an interrupted change left behind the end is ignored. */
static void test_extended(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_DRACO_BLOCKS);
    uint8_t *longer = calloc(f.size + 100, 1);
    assert_non_null(longer);
    memcpy(longer, f.bytes, f.size);
    assert_int_equal(read_all(longer, f.size + 100, NULL), STP_OK);
    free(longer);
    free(f.bytes);
}

/* A damaged block loses only itself; without its record, the chunk can still be read whole. */
static void test_damaged_block(void **state)
{
    (void)state;
    sample_file f = small_file(STP_CODEC_DRACO_BLOCKS);
    const char *path = fixture_path("damaged.stipple");
    stp_chunk_file *file = NULL;
    stp_chunk *chunk = NULL;
    stp_error err = {0};
    uint32_t failed = 0;
    const uint8_t *entry = entry_of(f.bytes, 3);
    f.bytes[stp_get_u64(entry) + stp_get_u32(entry + 16) - 1] ^= 4;
    record_of(f.bytes, 4)[50] ^= 1;
    fixture_write_file(path, f.bytes, f.size);
    assert_int_equal(stp_chunk_file_open(&file, path, &err), STP_OK);
    assert_int_equal(read_blocks(file, 3, &failed, &err), STP_CORRUPT);
    assert_int_equal(failed, 1);
    assert_non_null(strstr(err.message, "chunk 3: the checksum of a block"));
    assert_int_equal(read_blocks(file, 4, &failed, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "chunk 4: the checksum of its blocks' records"));
    assert_int_equal(stp_chunk_file_read(file, 4, 0, &chunk, &err), STP_OK);
    stp_chunk_destroy(&chunk);
    assert_int_equal(read_blocks(file, 5, &failed, &err), STP_OK);
    stp_chunk_file_close(&file);
    free(f.bytes);
}

/* No patch may stand for patches of two blocks. */
static void test_cut_inside(void **state)
{
    (void)state;
    for (int linked = 0; linked < 2; linked++) {
        fixture_tree tree;
        stp_error err = {0};
        size_t size = 0;
        const char *path = fixture_path("cut.stipple");
        fixture_tree_of_seven(&tree, 10, 6);
        if (!linked)
            fixture_unlink(tree.chunks[2]);
        tree.chunks[0]->block_ends = malloc(2 * sizeof(uint32_t));
        assert_non_null(tree.chunks[0]->block_ends);
        tree.chunks[0]->block_ends[0] = linked ? 7 : 8;
        tree.chunks[0]->block_ends[1] = 10;
        tree.chunks[0]->block_count = 2;
        assert_int_equal(fixture_write(&tree, path, STP_CODEC_DRACO_BLOCKS, NULL), STP_OK);
        uint8_t *bytes = fixture_read_file(path, &size);
        assert_int_equal(read_all(bytes, size, &err), STP_CORRUPT);
        assert_non_null(strstr(err.message, "patches of two blocks of the child"));
        free(bytes);
        fixture_destroy(&tree);
    }
}

/* Changes any bytes under right checksums: never harm. */
static void test_tampered(void **state)
{
    (void)state;
    for (int codec = STP_CODEC_RAW_BLOCKS; codec < STP_CODEC_COUNT; codec++) {
        sample_file f = small_file((stp_codec)codec);
        uint8_t *copy = malloc(f.size);
        assert_non_null(copy);
        for (uint64_t i = 0; i < 1500; i++) {
            memcpy(copy, f.bytes, f.size);
            for (uint64_t k = 0; k <= i % 3; k++) {
                uint64_t r = stp_random_u64(i, k);
                copy[(r >> 8) % f.size] = (uint8_t)r;
            }
            if (i % 2)
                copy_header(copy);
            reseal(copy, f.size, true);
            (void)read_all(copy, f.size, NULL);
        }
        free(copy);
        free(f.bytes);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_wrong_numbers),   cmocka_unit_test(test_rows),
        cmocka_unit_test(test_wrong_checksums), cmocka_unit_test(test_copies),
        cmocka_unit_test(test_unknown_section), cmocka_unit_test(test_truncated),
        cmocka_unit_test(test_extended),        cmocka_unit_test(test_damaged_block),
        cmocka_unit_test(test_cut_inside),      cmocka_unit_test(test_tampered),
    };
    return cmocka_run_group_tests_name("malformed blocks", tests, NULL, fixture_remove_folder);
}
