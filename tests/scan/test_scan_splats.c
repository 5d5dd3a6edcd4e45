/* Tests packed Gaussian splats: PLY as PlayCanvas and SuperSplat write it. */
#include "tests/fixtures/scan/scan_fixture.h"

#define RANGES                                                                                     \
    "property float min_x\nproperty float min_y\nproperty float min_z\n"                           \
    "property float max_x\nproperty float max_y\nproperty float max_z\n"                           \
    "property float min_scale_x\n"
#define COLOURS                                                                                    \
    "property float min_r\nproperty float min_g\nproperty float min_b\n"                           \
    "property float max_r\nproperty float max_g\nproperty float max_b\n"
#define PACKED                                                                                     \
    "property uint packed_position\nproperty uint packed_rotation\n"                               \
    "property uint packed_scale\nproperty uint packed_color\nend_header\n"

static uint32_t position(uint32_t x, uint32_t y, uint32_t z)
{
    return x << 21 | y << 11 | z;
}

static void positions_and_colours(void **state)
{
    (void)state;
    char text[2048];
    stp_scan_info info;
    snprintf(text, sizeof text,
             "ply\nformat ascii 1.0\nelement chunk 1\n" RANGES "element vertex 3\n" PACKED
             "0 10 -5 2047 1033 2042 9\n"
             "%u 0 0 %u\n%u 0 0 %u\n%u 0 0 255\n",
             position(0, 0, 0), 0xff800080u, position(2047, 1023, 2047), 0x0033ff00u,
             position(7, 1, 2));
    scan_fixture_text("ascii.ply", text);
    stp_point *p = scan_fixture_read("ascii.ply", NULL, &info);
    assert_int_equal(info.point_count, 3);
    assert_true(info.y_likely_down);
    scan_fixture_position(&p[0], 0.0, 10.0, -5.0);
    scan_fixture_position(&p[1], 2047.0, 1033.0, 2042.0);
    scan_fixture_position(&p[2], 7.0, 11.0, -3.0);
    scan_fixture_rgb(&p[0], 65535, 128 * 257, 0);
    scan_fixture_rgb(&p[1], 0, 0x33 * 257, 65535);
    free(p);
}

/* The header may lie, and ASCII may have numbers that are no words of 32 bits. */
static void wrong_numbers(void **state)
{
    (void)state;
    stp_scan_info info;
    scan_fixture_text("many.ply", "ply\nformat ascii 1.0\nelement chunk 999999999\n" RANGES
                                  "element vertex 1\n" PACKED "0 0 0 1 1 1 9\n1 0 0 1\n");
    scan_fixture_fails("many.ply", NULL, STP_CORRUPT, "after 0 of 999999999 chunk");
    scan_fixture_text("words.ply",
                      "ply\nformat ascii 1.0\nelement chunk 1\n" RANGES "element vertex 2\n" PACKED
                      "3 4 5 6 7 8 9\n1e300 0 0 -7\nnan 0 0 nan\n");
    stp_point *p = scan_fixture_read("words.ply", NULL, &info);
    for (size_t i = 0; i < 2; i++)
        scan_fixture_position(&p[i], 3.0, 4.0, 5.0);
    free(p);
}

/* 300 splats in two chunks; the colours of the second reach from 1/2 to 1. */
static void write_chunks(void)
{
    static const float chunks[2][13] = {{0, 0, 0, 2047, 1023, 2047, 0, 0, 0, 0, 1, 1, 1},
                                        {5000, 0, 0, 7047, 1023, 2047, 0, .5f, .5f, .5f, 1, 1, 1}};
    FILE *file = fopen("binary.ply", "wb");
    assert_non_null(file);
    fprintf(file, "ply\nformat binary_little_endian 1.0\nelement chunk 2\n" RANGES COLOURS
                  "element vertex 300\n" PACKED);
    assert_int_equal(fwrite(chunks, sizeof chunks, 1, file), 1);
    for (uint32_t i = 0; i < 300; i++) {
        const uint32_t words[4] = {position(i, 1, 2), 0, 0, 0xff00ffffu};
        assert_int_equal(fwrite(words, sizeof words, 1, file), 1);
    }
    fclose(file);
}

static void chunks_follow_vertices(void **state)
{
    (void)state;
    stp_scan_info info;
    write_chunks();
    stp_point *p = scan_fixture_read("binary.ply", NULL, &info);
    for (size_t i = 0; i < 300; i++) {
        scan_fixture_position(&p[i], (double)i + (i < 256 ? 0.0 : 5000.0), 1.0, 2.0);
        scan_fixture_rgb(&p[i], 65535, i < 256 ? 0 : 32768, 65535);
    }
    stp_scan *scan = NULL;
    stp_point one;
    size_t count;
    assert_int_equal(stp_scan_open(&scan, "binary.ply", NULL, NULL), STP_OK);
    assert_int_equal(stp_scan_seek(scan, 280, NULL), STP_OK);
    assert_int_equal(stp_scan_read(scan, &one, 1, &count, NULL), STP_OK);
    assert_memory_equal(&one, &p[280], sizeof one);
    stp_scan_close(&scan);
    free(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(positions_and_colours),
        cmocka_unit_test(chunks_follow_vertices),
        cmocka_unit_test(wrong_numbers),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
