/* Tests picture comparison: figures known by hand, and images through files byte for byte. */
#include "formats/image/image.h"
#include "tests/fixtures/scan/scan_fixture.h"
#include "tools/compare/compare_metrics.h"

#include <math.h>

static stp_image blank(int width, int height)
{
    stp_image image = {width, height, calloc((size_t)width * (size_t)height, 4)};
    assert_non_null(image.rgba);
    return image;
}

static void set(stp_image *image, int x, int y, unsigned grey, unsigned alpha)
{
    uint8_t *p = image->rgba + 4 * (y * image->width + x);
    p[0] = p[1] = p[2] = (uint8_t)grey;
    p[3] = (uint8_t)alpha;
}

static void fill(stp_image *image, int x0, int y0, int x1, int y1, unsigned grey)
{
    for (int y = y0; y < y1; y++)
        for (int x = x0; x < x1; x++)
            set(image, x, y, grey, 255);
}

static compare_metrics compare(const stp_image *a, const stp_image *b)
{
    compare_metrics metrics;
    stp_error err = {0};
    if (compare_metrics_compute(a, b, &metrics, &err) != STP_OK)
        fail_msg("%s", err.message);
    return metrics;
}

static void near(double value, double expected)
{
    if (!(fabs(value - expected) < 1e-9))
        fail_msg("%.12g, expected %.12g", value, expected);
}

static void identical(void **state)
{
    (void)state;
    stp_image a = blank(40, 30);
    fill(&a, 5, 5, 30, 20, 77);
    set(&a, 8, 8, 200, 1);
    const compare_metrics m = compare(&a, &a);
    near(m.psnr_db, COMPARE_PSNR_IDENTICAL);
    near(m.psnr_inside_db, COMPARE_PSNR_IDENTICAL);
    near(m.ssim, 1.0);
    near(m.coverage_a, 375.0 / 1200.0);
    near(m.coverage_b, m.coverage_a);
    assert_int_equal(m.holes, 0);
    assert_int_equal(m.spill, 0);
    stp_image_destroy(&a);
    assert_null(a.rgba);
}

/* A difference of 10 everywhere. An uncovered pixel counts as black, whatever its bytes. */
static void known_psnr(void **state)
{
    (void)state;
    stp_image a = blank(16, 16), b = blank(16, 16);
    fill(&a, 0, 0, 16, 8, 110);
    fill(&b, 0, 0, 16, 8, 100);
    set(&a, 3, 12, 250, 0);
    set(&b, 3, 12, 20, 0);
    compare_metrics m = compare(&a, &b);
    near(m.psnr_db, 20.0 * log10(255.0 / 10.0));
    near(m.psnr_inside_db, m.psnr_db);
    fill(&b, 0, 8, 16, 16, 100); /* A lacks the other half */
    m = compare(&a, &b);
    near(m.psnr_db, 10.0 * log10(255.0 * 255.0 / ((100.0 + 10000.0) / 2.0)));
    near(m.psnr_inside_db, 20.0 * log10(255.0 / 10.0));
    near(m.coverage_a, 0.5);
    near(m.coverage_b, 1.0);
    assert_int_equal(m.holes, 128);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

/* Two uniform pictures: variances are 0, and SSIM is its luminance term, also at the picture's
 * edges. */
static void known_ssim(void **state)
{
    (void)state;
    stp_image a = blank(20, 25), b = blank(20, 25);
    fill(&a, 0, 0, 20, 25, 120);
    fill(&b, 0, 0, 20, 25, 60);
    const double c1 = 2.55 * 2.55;
    near(compare(&a, &b).ssim, (2.0 * 120.0 * 60.0 + c1) / (120.0 * 120.0 + 60.0 * 60.0 + c1));
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

/* The same formula without rows, rings and separable windows. */
static double slow_ssim(const stp_image *a, const stp_image *b, int x, int y)
{
    double weight = 0.0, s[5] = {0.0};
    for (int v = y - 5; v <= y + 5; v++) {
        for (int u = x - 5; u <= x + 5; u++) {
            if (u < 0 || v < 0 || u >= a->width || v >= a->height)
                continue;
            const double w = exp(-((u - x) * (u - x) + (v - y) * (v - y)) / 4.5);
            const double p = a->rgba[4 * (v * a->width + u)], q = b->rgba[4 * (v * b->width + u)];
            const double values[5] = {p, q, p * p, q * q, p * q};
            weight += w;
            for (int k = 0; k < 5; k++)
                s[k] += w * values[k];
        }
    }
    for (int k = 0; k < 5; k++)
        s[k] /= weight;
    const double c1 = 2.55 * 2.55, c2 = 7.65 * 7.65;
    return (2 * s[0] * s[1] + c1) * (2 * (s[4] - s[0] * s[1]) + c2) /
           ((s[0] * s[0] + s[1] * s[1] + c1) * (s[2] - s[0] * s[0] + s[3] - s[1] * s[1] + c2));
}

static void ssim_by_the_formula(void **state)
{
    (void)state;
    stp_image a = blank(23, 31), b = blank(23, 31);
    double sum = 0.0;
    unsigned seed = 1;
    for (int y = 0; y < 31; y++) {
        for (int x = 0; x < 23; x++) {
            seed = seed * 1664525u + 1013904223u;
            set(&a, x, y, seed >> 24, 255);
            set(&b, x, y, ((seed >> 24) + (seed >> 16 & 63)) & 255, 255);
        }
    }
    for (int y = 0; y < 31; y++)
        for (int x = 0; x < 23; x++)
            sum += slow_ssim(&a, &b, x, y);
    near(compare(&a, &b).ssim, sum / (23.0 * 31.0));
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

static void holes_and_spill(void **state)
{
    (void)state;
    stp_image a = blank(32, 32), b = blank(32, 32);
    fill(&a, 8, 8, 24, 24, 90);
    fill(&b, 8, 8, 24, 24, 90);
    set(&a, 12, 12, 0, 0);    /* a hole */
    set(&a, 8, 15, 0, 0);     /* on the silhouette's border: no hole */
    set(&a, 7, 10, 90, 255);  /* one pixel outside: no spill */
    set(&a, 6, 10, 90, 255);  /* two: spill */
    set(&a, 31, 31, 90, 255); /* far away, in the corner */
    const compare_metrics m = compare(&a, &b);
    assert_int_equal(m.holes, 1);
    assert_int_equal(m.spill, 2);
    assert_true(m.ssim < 1.0 && m.ssim > 0.5);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

static void nothing_in_common(void **state)
{
    (void)state;
    stp_image a = blank(4, 4), b = blank(4, 4), c = blank(4, 5);
    stp_error err = {0};
    compare_metrics m = {.holes = 42};
    assert_int_equal(compare_metrics_compute(&a, &b, &m, &err), STP_EMPTY);
    assert_int_equal(compare_metrics_compute(&a, &c, &m, &err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(err.message, "4x4 and 4x5"));
    assert_int_equal(m.holes, 42);
    set(&a, 0, 0, 255, 255);
    set(&b, 3, 3, 255, 255);
    m = compare(&a, &b);
    near(m.psnr_db, 0.0);
    near(m.psnr_inside_db, 0.0);
    assert_int_equal(m.spill, 1);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
    stp_image_destroy(&c);
}

/* Straight alpha: colours must come back as they were under any alpha, even 0. */
static void images_keep_their_bytes(void **state)
{
    (void)state;
    static const char *const names[] = {"picture.png", "picture.tif"};
    stp_image a = blank(256, 16), b = {0};
    stp_error err = {0};
    for (size_t i = 0; i < 256 * 16 * 4; i++)
        a.rgba[i] = (uint8_t)(i % 4 == 3 ? i / 4 % 256 : i * 37 % 251);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        if (stp_image_save(&a, names[i], false, &err) != STP_OK ||
            stp_image_load(&b, names[i], &err) != STP_OK)
            fail_msg("%s", err.message);
        assert_int_equal(b.width, 256);
        assert_int_equal(b.height, 16);
        assert_memory_equal(a.rgba, b.rgba, 256 * 16 * 4);
        stp_image_destroy(&b);
        assert_int_equal(stp_image_save(&a, names[i], false, &err), STP_EXISTS);
        assert_int_equal(stp_image_save(&a, names[i], true, &err), STP_OK);
    }
    stp_image_destroy(&a);
}

static size_t read_bytes(const char *path, unsigned char *bytes, size_t limit)
{
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    const size_t size = fread(bytes, 1, limit, file);
    fclose(file);
    return size;
}

static void images_that_fail(void **state)
{
    (void)state;
    stp_image a = blank(8, 8), b = {0};
    stp_error err = {0};
    assert_int_equal(stp_image_load(&b, "none.png", &err), STP_NOT_FOUND);
    scan_fixture_text("text.png", "this is no image");
    assert_int_equal(stp_image_load(&b, "text.png", &err), STP_FORMAT);
    assert_non_null(strstr(err.message, "text.png"));
    assert_int_equal(stp_image_save(&a, "picture.unknown", false, &err), STP_UNSUPPORTED);
    assert_int_equal(access("picture.unknown", F_OK), -1);
    assert_int_equal(stp_image_save(&a, "whole.tif", false, &err), STP_OK);
    unsigned char bytes[4096];
    const size_t size = read_bytes("whole.tif", bytes, sizeof bytes);
    scan_fixture_bytes("cut.tif", bytes, size / 2);
    const stp_status status = stp_image_load(&b, "cut.tif", &err);
    assert_true(status == STP_CORRUPT || status == STP_FORMAT);
    assert_null(b.rgba);
    stp_image_destroy(&a);
}

/* However little of a PNG is there, it is named as damaged, and nothing leaks. */
static void cut_pngs_are_damaged(void **state)
{
    (void)state;
    stp_image a = blank(8, 8), b = {0};
    stp_error err = {0};
    unsigned char bytes[4096];
    assert_int_equal(stp_image_save(&a, "whole.png", true, &err), STP_OK);
    const size_t size = read_bytes("whole.png", bytes, sizeof bytes);
    assert_true(size > 60 && size < sizeof bytes);
    for (size_t cut = 8; cut + 12 < size; cut++) { /* the last 12 bytes are IEND */
        scan_fixture_bytes("cut.png", bytes, cut);
        assert_int_equal(stp_image_load(&b, "cut.png", &err), STP_CORRUPT);
        assert_int_equal(strncmp(err.message, "cut.png: the image is damaged", 29), 0);
        assert_null(b.rgba);
    }
    stp_image_destroy(&a);
}

/* Writes a chunk of a PNG: its length, its name and data, and their CRC-32. */
static void png_chunk(FILE *file, const unsigned char *bytes, size_t size)
{
    uint32_t crc = 0xffffffff;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++)
            crc = crc >> 1 ^ (crc & 1 ? 0xedb88320 : 0);
    }
    crc = ~crc;
    const unsigned char length[4] = {0, 0, 0, (unsigned char)(size - 4)};
    const unsigned char check[4] = {(unsigned char)(crc >> 24), (unsigned char)(crc >> 16),
                                    (unsigned char)(crc >> 8), (unsigned char)crc};
    fwrite(length, 1, 4, file);
    fwrite(bytes, 1, size, file);
    fwrite(check, 1, 4, file);
}

/* Pixels of 3, 200, 3 and 200 of 255 grey by four kinds of PNG; zlib stores them as they are. */
static void any_png_is_rgba(void **state)
{
    (void)state;
    static const struct {
        unsigned char header[5]; /* bits, kind, and what is always 0 */
        const char *extra;       /* a chunk between, its length in front */
        size_t extra_bytes;
        unsigned char row[8];
        size_t row_bytes;
    } kinds[] = {
        {{8, 0}, NULL, 0, {3, 200, 3, 200}, 4},                  /* grey */
        {{16, 0}, NULL, 0, {3, 3, 200, 200, 3, 3, 200, 200}, 8}, /* 16 bits */
        {{1, 3}, "PLTE\3\3\3\310\310\310", 10, {0x50}, 1},       /* a palette */
        {{8, 0}, "gAMA\0\0\261\217", 8, {3, 200, 3, 200}, 4},    /* 0.45455 */
    };
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++) {
        stp_image image = {0};
        stp_error err = {0};
        unsigned char header[17] = {'I', 'H', 'D', 'R', 0, 0, 0, 4, 0, 0, 0, 1};
        unsigned char data[32] = {'I', 'D', 'A', 'T', 0x78, 1, 1};
        const size_t raw = kinds[k].row_bytes + 1; /* the row's filter comes first */
        unsigned char *at = data + 7;
        uint32_t a = 1, b = 0; /* Adler-32 */
        memcpy(header + 12, kinds[k].header, 5);
        *at++ = (unsigned char)raw;
        *at++ = 0;
        *at++ = (unsigned char)~raw;
        *at++ = 0xff;
        memcpy(at + 1, kinds[k].row, kinds[k].row_bytes);
        for (size_t i = 0; i < raw; i++)
            b += a += at[i];
        at += raw;
        const unsigned char check[4] = {(unsigned char)(b >> 8), (unsigned char)b,
                                        (unsigned char)(a >> 8), (unsigned char)a};
        memcpy(at, check, 4);
        FILE *file = fopen("kind.png", "wb");
        assert_non_null(file);
        fwrite("\x89PNG\r\n\x1a\n", 1, 8, file);
        png_chunk(file, header, sizeof header);
        if (kinds[k].extra != NULL)
            png_chunk(file, (const unsigned char *)kinds[k].extra, kinds[k].extra_bytes);
        png_chunk(file, data, (size_t)(at + 4 - data));
        png_chunk(file, (const unsigned char *)"IEND", 4);
        fclose(file);
        if (stp_image_load(&image, "kind.png", &err) != STP_OK)
            fail_msg("kind %zu: %s", k, err.message);
        static const uint8_t wanted[16] = {3, 3, 3, 255, 200, 200, 200, 255,
                                           3, 3, 3, 255, 200, 200, 200, 255};
        assert_int_equal(image.width, 4);
        assert_memory_equal(image.rgba, wanted, sizeof wanted);
        stp_image_destroy(&image);
    }
}

/* JPEG has no alpha: what is covered in part is darker by as much as over black. */
static void jpeg_is_over_black(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_image a = blank(16, 16), b = {0};
    for (int i = 0; i < 16 * 16; i++)
        set(&a, i % 16, i / 16, 200, 128);
    assert_int_equal(stp_image_save(&a, "half.jpg", false, &err), STP_OK);
    assert_int_equal(stp_image_load(&b, "half.jpg", &err), STP_OK);
    assert_in_range(b.rgba[0], 97, 103);
    assert_int_equal(b.rgba[3], 255);
    stp_image_destroy(&a);
    stp_image_destroy(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(identical),
        cmocka_unit_test(known_psnr),
        cmocka_unit_test(known_ssim),
        cmocka_unit_test(ssim_by_the_formula),
        cmocka_unit_test(holes_and_spill),
        cmocka_unit_test(nothing_in_common),
        cmocka_unit_test(images_keep_their_bytes),
        cmocka_unit_test(images_that_fail),
        cmocka_unit_test(cut_pngs_are_damaged),
        cmocka_unit_test(any_png_is_rgba),
        cmocka_unit_test(jpeg_is_over_black),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
