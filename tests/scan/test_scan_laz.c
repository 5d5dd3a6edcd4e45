/* Tests LAZ: chunks found with and without a table, records that lie, files that are cut. If
 * STIPPLE_SCANS names real scans, every LAZ file there is unpacked, cut and damaged, too, and
 * compared with its unpacked twin. */
#include "formats/scan/las/las_numbers.h"
#include "formats/scan/las/laz.h"
#include "tests/fixtures/las_fixture.h"

#include <ftw.h>
#include <unistd.h>

/* LASzip's record: way of packing, coder, version, options, points of a chunk, special records,
 * then items of type, bytes and version. */
typedef struct packing {
    unsigned way, coder, chunk_points, item_count;
    unsigned items[6][3];
} packing;

static const packing by_points = {2, 0, 1, 2, {{6, 20, 2}, {7, 8, 2}}};

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

enum { COUNT = 300 };

/* Makes a file of format 1 whose chunks have one point each, which stands as it is. Its table of
 * chunks lies at `table`. */
static void make_file(las_file *f, const packing *p, uint64_t table)
{
    unsigned char record[128];
    las_begin(f, 2, 1, 28);
    las_add_vlr(f, "laszip encoded", 22204, record, make_record(record, p));
    f->bytes[104] |= 0x80;
    las_set_count(f, COUNT);
    las_put(f, f->size, 8, table);
    f->size += 8;
    for (int i = 0; i < COUNT; i++) {
        const size_t at = las_add_point(f, i * 7919, -i, i / 3);
        las_put(f, at + 12, 2, (uint64_t)i + 1000);
        las_put(f, at + 15, 1, (uint64_t)i % 29);
    }
}

static void check_points(const char *path)
{
    stp_scan_info info;
    stp_point *points = scan_fixture_read(path, NULL, &info);
    assert_int_equal(info.point_count, COUNT);
    for (int i = 0; i < COUNT; i++) {
        scan_fixture_position(&points[i], i * 7919 * 0.5 + 1000.0, -i * 0.25 - 2000.0,
                              i / 3 * 0.125 + 3000.0);
        scan_fixture_scalars(&points[i], (uint16_t)(i + 1000), (uint8_t)(i % 29));
    }
    free(points);
}

/* A file without a table is read chunk by chunk. */
static void no_table(void **state)
{
    (void)state;
    las_file f;
    const uint64_t places[] = {UINT64_MAX, 0, 1, 400, UINT64_MAX / 2};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++) {
        make_file(&f, &by_points, places[i]);
        las_save(&f, "a.laz");
        check_points("a.laz");
    }
    make_file(&f, &by_points, UINT64_MAX);
    f.size -= 14;
    las_save(&f, "a.laz");
    scan_fixture_fails("a.laz", NULL, STP_CORRUPT, "point 299 of 300: its chunk ends too early");
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
        make_file(&f, &cases[i].record, UINT64_MAX);
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

/* ---- real scans ---- */

/* A LAZ file that is open, with all of its points' records. */
typedef struct unpacked {
    stp_source source;
    stp_las_header header;
    stp_las_records records;
    unsigned char *bytes;
    size_t size;
} unpacked;

static void unpacked_free(unpacked *u)
{
    stp_las_records_free(&u->records);
    stp_source_close(&u->source);
    free(u->bytes);
}

static stp_status open_laz(unpacked *u, const char *path, stp_laz **laz, bool all, stp_error *err)
{
    *u = (unpacked){.source.descriptor = -1};
    stp_status status = stp_source_open(&u->source, path, err);
    if (status == STP_OK)
        status = stp_las_header_read(&u->header, &u->source, err);
    if (status == STP_OK)
        status = stp_las_records_read(&u->records, &u->header, &u->source, err);
    const stp_laz_params params = {.source = &u->source,
                                   .header = &u->header,
                                   .record = &u->records.kept[STP_LAS_LASZIP],
                                   .all_fields = all};
    return status == STP_OK ? stp_laz_open(laz, &params, err) : status;
}

static stp_status unpack(unpacked *u, const char *path, bool all, stp_error *err)
{
    stp_laz *laz = NULL;
    stp_status status = open_laz(u, path, &laz, all, err);
    const size_t bytes = u->header.record_bytes;
    uint64_t count = status == STP_OK ? u->header.point_count : 0;
    count = count < 200000 ? count : 200000; /* a damaged count has no room */
    u->size = (size_t)count * bytes;
    u->bytes = calloc(u->size + 1, 1);
    for (uint64_t i = 0; status == STP_OK && i < count;) {
        const size_t part = count - i < 997 ? (size_t)(count - i) : 997;
        status = stp_laz_read(laz, u->bytes + i * bytes, part, err);
        i += part;
    }
    stp_laz_close(&laz);
    return status;
}

static const char *scans_path(char out[4096], const char *name)
{
    const char *folder = getenv("STIPPLE_SCANS");
    snprintf(out, 4096, "%s/%s", folder ? folder : "", name);
    return folder && access(out, R_OK) == 0 ? out : NULL;
}

static void twins_agree(void **state)
{
    (void)state;
    char packed[4096], plain[4096];
    stp_error err = {0};
    unpacked u = {0};
    if (!scans_path(packed, "laz/simple.laz") || !scans_path(plain, "odd/pdal_1.2-with-color.las"))
        skip();
    assert_int_equal(unpack(&u, packed, true, &err), STP_OK);
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
    unpacked_free(&u);
}

/* Points read after a seek are those of the whole. */
static void check_seeks(const unpacked *whole, const char *path)
{
    stp_error err = {0};
    stp_laz *laz = NULL;
    unpacked u = {0};
    const size_t bytes = whole->header.record_bytes;
    const uint64_t count = whole->size / bytes;
    unsigned char *got = malloc(3 * bytes);
    assert_int_equal(open_laz(&u, path, &laz, true, &err), STP_OK);
    for (uint64_t i = 0; i < 40 && count > 3; i++) {
        const uint64_t point = i * 7919 * 131 % (count - 3);
        assert_int_equal(stp_laz_seek(laz, point, &err), STP_OK);
        assert_int_equal(stp_laz_read(laz, got, 3, &err), STP_OK);
        assert_memory_equal(got, whole->bytes + point * bytes, 3 * bytes);
    }
    free(got);
    stp_laz_close(&laz);
    unpacked_free(&u);
}

/* The attributes of a scan are those of all records, layered or not. */
static void check_numbers(const unpacked *whole, const char *path)
{
    stp_error err = {0};
    const stp_scan_params params = {.numbers = true};
    stp_scan *scan = NULL;
    stp_las_numbers numbers;
    stp_point points[500];
    assert_int_equal(stp_scan_open(&scan, path, &params, &err), STP_OK);
    const bool coloured = stp_scan_get_info(scan)->attributes & STP_POINT_HAS_COLOUR;
    const stp_las_depth depth = {.colour = coloured ? STP_LAS_COLOUR_16 : STP_LAS_COLOUR_NONE};
    stp_las_numbers_of_file(&numbers, &whole->header, &whole->records, &depth);
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
    unpacked u = {0};
    scan_fixture_bytes("d.laz", bytes, size);
    if (unpack(&u, "d.laz", true, &err) != STP_OK && !strstr(err.message, "d.laz"))
        fail_msg("%s: %s", path, err.message);
    unpacked_free(&u);
}

static int check_file(const char *path, const struct stat *st, int kind, struct FTW *where)
{
    stp_error err = {0};
    unpacked all = {0}, some = {0};
    (void)where;
    if (kind != FTW_F || !strstr(path, ".laz") || st->st_size > 1 << 20)
        return 0;
    if (unpack(&all, path, true, &err) != STP_OK || unpack(&some, path, false, &err) != STP_OK)
        fail_msg("%s", err.message);
    const size_t bytes = all.header.record_bytes;
    for (size_t i = 0; i < all.size; i += bytes) /* positions, intensity */
        assert_memory_equal(all.bytes + i, some.bytes + i, 14);
    check_seeks(&all, path);
    check_numbers(&all, path);
    unpacked_free(&all);
    unpacked_free(&some);
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

static void real_files(void **state)
{
    (void)state;
    char folder[4096];
    if (!scans_path(folder, "laz"))
        skip();
    assert_int_equal(nftw(folder, check_file, 8, 0), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_table),
        cmocka_unit_test(records_that_lie),
        cmocka_unit_test(twins_agree),
        cmocka_unit_test(real_files),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
