/* Tests LAZ: chunks found with and without a table, records that lie, seeks, files that are cut and
 * damaged, of every format that we can pack. If STIPPLE_SCANS names real scans, every LAZ file
 * there is read, cut and damaged in the same way, and compared with its unpacked twin. */
#include "formats/scan/las/las_numbers.h"
#include "tests/fixtures/scan/laz_fixture.h"

#include <ftw.h>

/* LASzip's record: way of packing, coder, version, options, points of a chunk, special records,
 * then items of type, bytes and version. */
typedef struct packing {
    unsigned way, coder, chunk_points, item_count;
    unsigned items[6][3];
} packing;

static size_t make_record(unsigned char *out, const packing *p)
{
    las_file f = {.size = 0};
    las_put(&f, 0, 2, p->way);
    las_put(&f, 2, 2, p->coder);
    las_put(&f, 12, 4, p->chunk_points);
    las_put(&f, 32, 2, p->item_count);
    for (unsigned i = 0; i < p->item_count && i < 6; i++)
        for (unsigned k = 0; k < 3; k++)
            las_put(&f, 34 + 6 * i + 2 * k, 2, p->items[i][k]);
    const size_t size = 34 + 6 * (size_t)(p->item_count < 6 ? p->item_count : 6);
    memcpy(out, f.bytes, size);
    return size;
}

/* Makes a file of format 1 that says it is packed in this way. */
static void make_file(las_file *f, const packing *p)
{
    unsigned char record[128];
    las_begin(f, 2, 1, 28);
    las_add_vlr(f, "laszip encoded", 22204, record, make_record(record, p));
    f->bytes[104] |= 0x80;
    las_set_count(f, 300);
    las_put(f, f->size, 8, UINT64_MAX);
    f->size += 8 + (size_t)300 * 28;
}

/* Without a table of chunks, points are found chunk by chunk, and so is the place where the file
 * was cut. */
static void check_no_table(const laz_way *way, size_t count, const char *words)
{
    static const uint64_t places[] = {UINT64_MAX, 0, 1, 500, UINT64_MAX / 2};
    stp_error err = {0};
    size_t size;
    unsigned char *records = laz_make_records(way->format, way->record_bytes, count, true);
    laz_write("a.laz", way, records, count);
    unsigned char *file = scan_fixture_load("a.laz", &size);
    const size_t at = las_bytes_get(file + 96, 4), end = las_bytes_get(file + at, 8);
    assert_true(end < size);
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        laz_unpacked u = {0};
        las_bytes_put(file + at, 8, places[i]);
        scan_fixture_bytes("a.laz", file, end);
        if (laz_unpack(&u, "a.laz", true, &err) != STP_OK)
            fail_msg("%s", err.message);
        assert_memory_equal(u.bytes, records, u.size);
        laz_unpacked_free(&u);
    }
    scan_fixture_bytes("a.laz", file, end - 14);
    scan_fixture_fails("a.laz", NULL, STP_CORRUPT, words);
    free(file);
    free(records);
}

static void no_table(void **state)
{
    (void)state;
    const laz_way by_points = {.format = 1, .record_bytes = 28, .chunk_points = 100};
    const laz_way in_layers = {.format = 7, .record_bytes = 40, .chunk_points = 100};
    const laz_way single = {.format = 1, .record_bytes = 28, .chunk_points = 1};
    check_no_table(&by_points, 350, "of 350: its chunk ends too early");
    check_no_table(&in_layers, 350, "of 350: a layer of its chunk is longer than the chunk");
    check_no_table(&single, 30, "point 29 of 30: its chunk ends too early");
}

static void records_that_lie(void **state)
{
    (void)state;
    las_file f;
    const struct {
        packing record;
        stp_status status;
        const char *words;
    } cases[] = {
        {{0, 0, 1, 2, {{6, 20, 2}, {7, 8, 2}}}, STP_UNSUPPORTED, "packed in way 0"},
        {{4, 0, 1, 2, {{6, 20, 2}, {7, 8, 2}}}, STP_UNSUPPORTED, "packed in way 4"},
        {{2, 1, 1, 2, {{6, 20, 2}, {7, 8, 2}}}, STP_UNSUPPORTED, "with coder 1"},
        {{2, 0, 0, 2, {{6, 20, 2}, {7, 8, 2}}}, STP_CORRUPT, "chunks of 0 points"},
        {{2, 0, 1, 0, {{0}}}, STP_CORRUPT, "names 0 items"},
        {{2, 0, 1, 6, {{6, 20, 2}, {7, 8, 2}}}, STP_CORRUPT, "names 6 items"},
        {{2, 0, 1, 2, {{6, 20, 7}, {7, 8, 2}}}, STP_UNSUPPORTED, "item of type 6 in version 7"},
        {{2, 0, 1, 2, {{6, 21, 2}, {7, 8, 2}}}, STP_CORRUPT, "item of type 6 with 21 bytes"},
        {{2, 0, 1, 1, {{6, 20, 2}}}, STP_CORRUPT, "describes points of 20 bytes"},
        {{2, 0, 1, 2, {{7, 8, 2}, {6, 20, 2}}}, STP_CORRUPT, "points of format 1 with 28 bytes"},
        {{3, 0, 1, 2, {{6, 20, 2}, {7, 8, 2}}}, STP_CORRUPT, "does not belong there"},
        {{2, 0, 1, 2, {{10, 30, 3}, {7, 8, 2}}}, STP_CORRUPT, "does not belong there"},
        {{2, 0, UINT32_MAX, 2, {{6, 20, 2}, {7, 8, 2}}}, STP_CORRUPT, "table of chunks is missing"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        make_file(&f, &cases[i].record);
        las_save(&f, "a.laz");
        scan_fixture_fails("a.laz", NULL, cases[i].status, cases[i].words);
    }
    las_begin(&f, 2, 1, 28);
    f.bytes[104] |= 0x80;
    las_set_count(&f, 1);
    f.size += 100;
    las_save(&f, "a.laz");
    scan_fixture_fails("a.laz", NULL, STP_CORRUPT, "without the record that says how");
}

/* ---- whole files ---- */

static void twins_agree(void **state)
{
    (void)state;
    char packed[4096], plain[4096];
    stp_error err = {0};
    laz_unpacked u = {0};
    if (!laz_scans_path(packed, "laz/simple.laz") ||
        !laz_scans_path(plain, "odd/pdal_1.2-with-color.las"))
        skip();
    assert_int_equal(laz_unpack(&u, packed, true, &err), STP_OK);
    FILE *f = fopen(plain, "rb");
    assert_non_null(f);
    unsigned char *bytes = malloc(u.size);
    unsigned char head[100] = {0};
    assert_int_equal(fread(head, 1, sizeof head, f), sizeof head);
    assert_int_equal(fseek(f, (long)(head[96] | head[97] << 8 | head[98] << 16), SEEK_SET), 0);
    assert_int_equal(fread(bytes, 1, u.size, f), u.size);
    assert_memory_equal(bytes, u.bytes, u.size);
    free(bytes);
    fclose(f);
    laz_unpacked_free(&u);
}

/* Points read after a seek are those of the whole. */
static void check_seeks(const laz_unpacked *whole, const char *path)
{
    stp_error err = {0};
    stp_laz *laz = NULL;
    laz_unpacked u = {0};
    const size_t bytes = whole->header.record_bytes;
    const uint64_t count = whole->size / bytes;
    unsigned char *got = malloc(3 * bytes);
    assert_int_equal(laz_open(&u, path, &laz, true, &err), STP_OK);
    for (uint64_t i = 0; i < 40 && count > 3; i++) {
        const uint64_t point = i * 7919 * 131 % (count - 3);
        assert_int_equal(stp_laz_seek(laz, point, &err), STP_OK);
        assert_int_equal(stp_laz_read(laz, got, 3, &err), STP_OK);
        assert_memory_equal(got, whole->bytes + point * bytes, 3 * bytes);
    }
    free(got);
    stp_laz_close(&laz);
    laz_unpacked_free(&u);
}

/* The attributes of a scan are those of all records, layered or not. */
static void check_numbers(const laz_unpacked *whole, const char *path)
{
    stp_error err = {0};
    const stp_scan_params params = {.numbers = true};
    stp_scan *scan = NULL;
    stp_las_numbers numbers;
    stp_point points[500];
    assert_int_equal(stp_scan_open(&scan, path, &params, &err), STP_OK);
    const bool coloured = stp_scan_get_info(scan)->attributes & STP_POINT_HAS_COLOUR;
    const stp_las_depth depth = {.colour = coloured ? STP_LAS_COLOUR_16 : STP_LAS_COLOUR_NONE};
    stp_las_numbers_of_file(&numbers, &whole->header, &whole->records, &depth, false);
    const size_t bytes = stp_attribute_list_bytes(&numbers.list);
    const size_t record = whole->header.record_bytes, total = whole->size / record;
    uint8_t *wanted = malloc(500 * bytes);
    assert_int_equal(stp_scan_get_info(scan)->extra->count, numbers.list.count);
    for (size_t done = 0, count; done < total; done += count) {
        const size_t part = total - done < 500 ? total - done : 500;
        assert_int_equal(stp_scan_read(scan, points, part, &count, &err), STP_OK);
        assert_true(count > 0);
        stp_las_numbers_pack(&numbers, whole->bytes + done * record, record, count, wanted);
        assert_memory_equal(stp_scan_numbers(scan), wanted, count * bytes);
    }
    free(wanted);
    stp_scan_close(&scan);
}

/* Reads a copy of a file that was damaged: points or a sentence, and no more. */
static void check_damaged(const char *path, const unsigned char *bytes, size_t size)
{
    stp_error err = {0};
    laz_unpacked u = {0};
    scan_fixture_bytes("d.laz", bytes, size);
    if (laz_unpack(&u, "d.laz", true, &err) != STP_OK && !strstr(err.message, "d.laz"))
        fail_msg("%s: %s", path, err.message);
    laz_unpacked_free(&u);
}

static int check_file(const char *path, const struct stat *st, int kind, struct FTW *where)
{
    stp_error err = {0};
    laz_unpacked all = {0}, some = {0};
    (void)where;
    if (kind != FTW_F || !strstr(path, ".laz") || st->st_size > 1 << 20)
        return 0;
    if (laz_unpack(&all, path, true, &err) != STP_OK ||
        laz_unpack(&some, path, false, &err) != STP_OK)
        fail_msg("%s", err.message);
    const size_t bytes = all.header.record_bytes;
    for (size_t i = 0; i < all.size; i += bytes) /* positions, intensity */
        assert_memory_equal(all.bytes + i, some.bytes + i, 14);
    check_seeks(&all, path);
    check_numbers(&all, path);
    laz_unpacked_free(&all);
    laz_unpacked_free(&some);
    size_t size;
    unsigned char *content = scan_fixture_load(path, &size);
    unsigned random = 1;
    for (unsigned i = 0; i < 24; i++) {
        random = random * 1664525u + 1013904223u;
        const size_t at = (i % 2 ? random % 600u : random) % size;
        if (i % 3 == 0) {
            check_damaged(path, content, at);
        } else {
            content[at] ^= (unsigned char)(1u << (random >> 29));
            check_damaged(path, content, size);
            content[at] ^= (unsigned char)(1u << (random >> 29));
        }
    }
    free(content);
    return 0;
}

/* Chunks are small, so that seeks and damage meet many. */
static void packed_files(void **state)
{
    (void)state;
    static const unsigned formats[] = {0, 1, 2, 3, 6, 7, 8};
    const struct stat small = {.st_size = 1};
    for (unsigned i = 0; i < 2 * sizeof formats / sizeof *formats; i++) {
        const unsigned format = formats[i / 2];
        const laz_way way = {.format = format,
                             .record_bytes = las_record_bytes[format] + i % 4,
                             .chunk_points = 300,
                             .version_4 = format >= 6 && i % 2};
        unsigned char *records = laz_make_records(format, way.record_bytes, 1000, i % 2);
        laz_write("p.laz", &way, records, 1000);
        assert_int_equal(check_file("p.laz", &small, FTW_F, NULL), 0);
        free(records);
    }
}

static void real_files(void **state)
{
    (void)state;
    char folder[4096];
    if (!laz_scans_path(folder, "laz"))
        skip();
    assert_int_equal(nftw(folder, check_file, 8, 0), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_table),     cmocka_unit_test(records_that_lie),
        cmocka_unit_test(packed_files), cmocka_unit_test(twins_agree),
        cmocka_unit_test(real_files),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
