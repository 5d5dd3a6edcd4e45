/* Tests the packer of LAZ: what it packs, our reader unpacks to the same bytes. If STIPPLE_SCANS
 * names real scans, the chunks of LAZ files there, which others wrote, are unpacked and packed
 * again, and must get the same bytes. */
#include "formats/scan/las/laz/laz_chunks.h"
#include "tests/fixtures/scan/laz_fixture.h"

static void round_trip(const laz_way *way, size_t count, bool smooth)
{
    stp_error err = {0};
    laz_unpacked u = {0};
    unsigned char *records = laz_make_records(way->format, way->record_bytes, count, smooth);
    laz_write("a.laz", way, records, count);
    if (laz_unpack(&u, "a.laz", true, &err) != STP_OK)
        fail_msg("format %u, %zu points: %s", way->format, count, err.message);
    assert_int_equal(u.size, count * way->record_bytes);
    for (size_t i = 0; i < u.size; i++)
        if (u.bytes[i] != records[i])
            fail_msg("format %u, %s, record %zu of %zu: byte %zu differs", way->format,
                     smooth ? "smooth" : "random", i / way->record_bytes, count,
                     i % way->record_bytes);
    laz_unpacked_free(&u);
    free(records);
}

static const unsigned formats[] = {0, 1, 2, 3, 6, 7, 8};
#define FORMATS (sizeof formats / sizeof *formats)

static void formats_come_back(void **state)
{
    (void)state;
    static const unsigned extra[] = {0, 1, 13};
    for (size_t f = 0; f < FORMATS; f++)
        for (size_t e = 0; e < 3; e++)
            for (int kind = 0; kind < 4; kind++) {
                const laz_way way = {.format = formats[f],
                                     .record_bytes = las_record_bytes[formats[f]] + extra[e],
                                     .chunk_points = e == 1 ? 1000 : STP_LAZ_CHUNK_POINTS,
                                     .version_4 = formats[f] >= 6 && kind & 2};
                round_trip(&way, 9000, kind & 1);
            }
}

/* Around the ends of chunks. */
static void counts_come_back(void **state)
{
    (void)state;
    static const size_t counts[] = {0, 1, 2, 49999, 50000, 50001, 100000};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
        for (size_t f = 0; f < FORMATS; f += 3) { /* 0, 3, 8 */
            const laz_way way = {.format = formats[f],
                                 .record_bytes = las_record_bytes[formats[f]],
                                 .chunk_points = STP_LAZ_CHUNK_POINTS};
            round_trip(&way, counts[c], true);
        }
    for (size_t f = 0; f < FORMATS; f++) {
        const laz_way way = {.format = formats[f],
                             .record_bytes = las_record_bytes[formats[f]] + 2,
                             .chunk_points = 1};
        round_trip(&way, 70, false);
    }
}

/* Points that are equal take less than a byte each. Layers that say nothing are left out. */
static void equal_points(void **state)
{
    (void)state;
    stp_error err = {0};
    enum { COUNT = 3000 };
    for (size_t f = 0; f < FORMATS; f++) {
        const unsigned bytes = las_record_bytes[formats[f]] + 3;
        const laz_way way = {.format = formats[f], .record_bytes = bytes, .chunk_points = 50000};
        unsigned char *records = laz_make_records(formats[f], bytes, COUNT, false);
        laz_unpacked u = {0};
        for (size_t i = 1; i < COUNT; i++)
            memcpy(records + i * bytes, records, bytes);
        laz_write("e.laz", &way, records, COUNT);
        assert_int_equal(laz_unpack(&u, "e.laz", true, &err), STP_OK);
        assert_memory_equal(u.bytes, records, u.size);
        assert_true(u.source.size - u.header.point_offset < COUNT);
        if (formats[f] >= 6) { /* behind the first record and the count: positions, then no more */
            size_t size;
            unsigned char *file = scan_fixture_load("e.laz", &size);
            const unsigned char *sizes = file + u.header.point_offset + 8 + bytes + 4;
            for (unsigned layer = 0; layer < STP_LAZ_POINT14_LAYERS; layer++)
                assert_int_equal(las_bytes_get(sizes + 4 * (size_t)layer, 4) > 0, layer < 2);
            free(file);
        }
        laz_unpacked_free(&u);
        free(records);
    }
}

/* The same bytes as when laz-perf, another decoder, unpacked them: where packing and unpacking
 * change together, records still come back, but not from the files of others. */
static void known_bytes(void **state)
{
    (void)state;
    static const uint64_t known[FORMATS] = {
        UINT64_C(0x225a1c84490742f3), UINT64_C(0xe4321dc519e37fea), UINT64_C(0xcf8f4ba4bd16b437),
        UINT64_C(0x1ff8c7426a2d26a9), UINT64_C(0x622c5b6a67f6ff69), UINT64_C(0x88747c74b9d6bac2),
        UINT64_C(0x94c45e4ea1ec40c1)};
    for (size_t f = 0; f < FORMATS; f++) {
        const unsigned bytes = las_record_bytes[formats[f]] + 3;
        const laz_way way = {.format = formats[f], .record_bytes = bytes, .chunk_points = 2000};
        unsigned char *records = laz_make_records(formats[f], bytes, 3000, false);
        size_t size;
        uint64_t hash = UINT64_C(14695981039346656037); /* FNV-1a */
        laz_write("k.laz", &way, records, 3000);
        unsigned char *file = scan_fixture_load("k.laz", &size);
        for (size_t i = 0; i < size; i++)
            hash = (hash ^ file[i]) * UINT64_C(1099511628211);
        if (hash != known[f])
            fail_msg("format %u: other bytes, 0x%016llx", formats[f], (unsigned long long)hash);
        free(file);
        free(records);
    }
}

/* ---- real scans ---- */

/* Packs the records of one chunk. Returns its bytes in a file of its own. Free with free(). */
static unsigned char *pack_chunk(const stp_laz_layout *own, unsigned char *records, size_t count,
                                 size_t *size)
{
    stp_error err = {0};
    stp_laz_layout layout = *own;
    stp_output *output = NULL;
    stp_laz_packer *packer = NULL;
    layout.chunked = true;
    layout.chunk_points = (uint32_t)count;
    assert_int_equal(stp_output_create(&output, "chunk", true, &err), STP_OK);
    if (stp_laz_packer_create(&packer, &layout, output, &err) != STP_OK) {
        stp_output_destroy(&output);
        return NULL;
    }
    assert_int_equal(stp_laz_packer_records(packer, records, count, &err), STP_OK);
    assert_int_equal(stp_laz_packer_finish(packer, &err), STP_OK);
    stp_laz_packer_destroy(&packer);
    assert_int_equal(stp_output_commit(&output, &err), STP_OK);
    unsigned char *bytes = scan_fixture_load("chunk", size);
    *size = las_bytes_get(bytes, 8) - 8;
    memmove(bytes, bytes + 8, *size);
    return bytes;
}

/* Chunks of a file that are the same, packed again. */
static void compare_chunks(const char *path, unsigned *same, unsigned *others)
{
    stp_error err = {0};
    laz_unpacked u = {0};
    stp_laz *laz = NULL;
    stp_laz_layout layout;
    stp_laz_chunks chunks = {0};
    size_t file_size, size = 0;
    *same = *others = 0;
    assert_int_equal(laz_open(&u, path, &laz, true, &err), STP_OK);
    assert_int_equal(
        stp_laz_layout_read(&layout, &u.records.kept[STP_LAS_LASZIP], &u.header, path, &err),
        STP_OK);
    assert_int_equal(stp_laz_chunks_read(&chunks, &layout, &u.header, u.source.descriptor,
                                         u.source.size, path, &err),
                     STP_OK);
    unsigned char *file = scan_fixture_load(path, &file_size);
    for (size_t c = 0; c + 1 < chunks.count; c++) {
        const stp_laz_chunk *chunk = &chunks.list[c];
        const uint64_t count = stp_laz_chunk_at(laz, chunk->first);
        unsigned char *records = malloc((size_t)count * u.header.record_bytes);
        assert_int_equal(stp_laz_read(laz, records, (size_t)count, &err), STP_OK);
        unsigned char *packed = pack_chunk(&layout, records, (size_t)count, &size);
        const bool equal = packed && size == chunk[1].begin - chunk->begin &&
                           memcmp(packed, file + chunk->begin, size) == 0;
        *(equal ? same : others) += 1;
        free(packed);
        free(records);
    }
    free(file);
    stp_laz_chunks_free(&chunks);
    stp_laz_close(&laz);
    laz_unpacked_free(&u);
}

static void real_files(void **state)
{
    (void)state;
    static const struct {
        const char *name;
        unsigned same, others;
    } files[] = {
        {"laz/simple.laz", 1, 0},
        {"laz/autzen_trim.laz", 3, 0},
        {"laz/pdrf7-v4-1.4.laz", 4, 0},
        {"laz/pdrf8-1.4.laz", 4, 0},
        {"laz/1.2-with-color.copc.laz", 65, 0},
        {"laz/ellipsoid.copc.laz", 5, 0},
        {"laz/pdrf4-1.3.laz", 0, 4}, /* has waveforms, which are not packed */
    };
    char path[4096];
    if (!laz_scans_path(path, "laz"))
        skip();
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        unsigned same, others;
        if (!laz_scans_path(path, files[i].name))
            continue;
        compare_chunks(path, &same, &others);
        if (same != files[i].same || others != files[i].others)
            fail_msg("%s: %u chunks are the same, %u are not", path, same, others);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(formats_come_back), cmocka_unit_test(counts_come_back),
        cmocka_unit_test(equal_points),      cmocka_unit_test(known_bytes),
        cmocka_unit_test(real_files),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
