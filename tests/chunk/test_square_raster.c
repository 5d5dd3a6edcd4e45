/* Tests which of a chunk's tilted grids a square of few samples belongs to: by chance, a sample may
 * lie on several. It is the one that the samples are nearest to, whichever comes first. And tests
 * the bytes of rasters. */
#include "formats/chunk/codec/square/camera_raster.h"
#include "formats/chunk/codec/square/square.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Bytes of the number of rasters, of a tilted one, of what it has besides if it spreads, of one
 * whose numbers are short, and of the least camera's. */
enum {
    COUNT_BYTES = 2,
    TILTED_BYTES = 49,
    SPREAD_BYTES = 16,
    SHORT_BYTES = 29,
    CAMERA_BYTES_LEAST = 22
};
enum { SAMPLES = 2, STEPS = 64 };

/* A grid whose columns are `by` columns off, on planes that lean. */
static stp_raster grid(double by)
{
    return (stp_raster){.axis = 2, .across = {{by, 1.0, 0.0, 0.25}, {0.0, 0.0, 1.0, -0.5}}};
}

static void nearest_grid(void **state)
{
    (void)state;
    stp_patch patch = {.exponent = -6, .counts = {SAMPLES, 1, 1, 1}};
    stp_sample samples[SAMPLES] = {0};
    uint32_t begin[2] = {0, SAMPLES};
    stp_raster rasters[2];
    stp_square square;
    for (unsigned i = 0; i < SAMPLES; i++) { /* columns 9 and 10 of row 12, at heights 8 and 4 */
        const double height = 8.0 - 4.0 * i;
        samples[i].position[0] = (uint16_t)lrint(STEPS * (9.0 + i + 0.25 * height));
        samples[i].position[1] = (uint16_t)lrint(STEPS * (12.0 - 0.5 * height));
        samples[i].position[2] = (uint16_t)lrint(STEPS * height);
    }
    const stp_chunk chunk = {.patch_count = 1,
                             .patches = &patch,
                             .samples = {samples},
                             .level_begin = {begin},
                             .rasters = rasters,
                             .raster_count = 2};
    for (uint32_t right = 0; right < 2; right++) {
        rasters[right] = grid(0.0);
        rasters[1 - right] = grid(0.1);
        assert_true(stp_squares_find(&chunk, &square));
        assert_int_equal(square.raster, right);
        assert_int_equal(square.column, 1);
        assert_int_equal(square.row, 1);
    }
    rasters[0] = rasters[1] = grid(0.2);
    assert_false(stp_squares_find(&chunk, &square));
}

/* Writes a raster whose first square is given. Returns its bytes. */
static size_t put(stp_raster *raster, uint32_t column, uint32_t row, uint8_t *out)
{
    const stp_chunk chunk = {.patch_count = 1, .rasters = raster, .raster_count = 1};
    const stp_square square = {.samples = 1, .column = column, .row = row};
    stp_bytes bytes = {0};
    stp_table table;
    assert_int_equal(stp_squares_encode(&chunk, &square, &bytes, &table, NULL), STP_OK);
    const size_t size = bytes.size - COUNT_BYTES;
    assert_in_range(size, CAMERA_BYTES_LEAST, TILTED_BYTES + SPREAD_BYTES);
    memcpy(out, bytes.data, bytes.size);
    free(bytes.data);
    free(table.values);
    return size;
}

static stp_status get(const uint8_t *bytes, size_t size, stp_raster *raster, stp_square *first)
{
    stp_chunk chunk = {.patch_count = 1};
    stp_cursor cursor = {.bytes = bytes, .left = COUNT_BYTES + size};
    stp_square *squares = NULL;
    const stp_status status = stp_rasters_decode(&cursor, true, &chunk, &squares, NULL);
    if (status == STP_OK) {
        assert_int_equal(cursor.left, 0);
        *raster = chunk.rasters[0];
        *first = squares[0];
    }
    free(chunk.rasters);
    free(squares);
    return status;
}

/* The bytes give the raster and its first square back, and none of them may lack. */
static void check_back(const uint8_t *bytes, size_t size, const stp_raster *raster, uint32_t column,
                       uint32_t row)
{
    stp_raster back = {0};
    stp_square first = {0};
    assert_int_equal(get(bytes, size, &back, &first), STP_OK);
    assert_memory_equal(&back, raster, sizeof back);
    assert_int_equal(first.column, column);
    assert_int_equal(first.row, row);
    for (size_t cut = 0; cut < size; cut++)
        assert_int_equal(get(bytes, cut, &back, &first), STP_CORRUPT);
}

/* A raster of numbers with few bits. */
static stp_raster short_grid(void)
{
    return (stp_raster){.axis = 1,
                        .across = {{0x1.fffffep5, 0x1.fffep-3, -0x1.0002p1, 0x1.8002p-1},
                                   {-0x1.000002p9, 0x1.8p0, 0x1.aaaap2, 0.0}}};
}

/* Every raster comes back as it is; it is short if that loses nothing. */
static void bytes_of_rasters(void **state)
{
    (void)state;
    uint8_t bytes[COUNT_BYTES + TILTED_BYTES];
    for (unsigned i = 0; i < 11; i++) { /* one number at a time has a bit too many */
        stp_raster raster = short_grid();
        if (i > 0 && i < 9)
            raster.across[(i - 1) / 4][(i - 1) % 4] += i % 4 == 1 ? 0x1p-30 : 0x1p-20;
        const uint32_t column = i == 9 ? 256 : 255, row = i == 10 ? 256 : 254;
        const size_t size = put(&raster, column, row, bytes);
        assert_int_equal(size, i == 0 || i == 8 ? SHORT_BYTES : TILTED_BYTES); /* 8: 0 + 2^-20 */
        check_back(bytes, size, &raster, column, row);
    }
}

/* Numbers are rounded to the nearest with 16 bits. */
static void short_numbers(void **state)
{
    (void)state;
    assert_true(stp_raster_short(0.0) == 0.0);
    assert_true(stp_raster_short(-0x1.fffep7) == -0x1.fffep7);
    assert_true(stp_raster_short(0x1.00011p0) == 0x1.0002p0);
    assert_true(stp_raster_short(-0x1.0000fp-9) == -0x1p-9);
    assert_true(stp_raster_short(0x1.ffffp0) == 2.0);
    assert_true(stp_raster_short(0x1.abp-140) == 0x1.8p-140); /* fewer bits than a float has */
    assert_true(isnan(stp_raster_short(NAN)));
}

/* Bytes of a short raster that say what no raster is are refused. */
static void damaged_short(void **state)
{
    (void)state;
    const uint8_t kinds[] = {8 + 3, 16 + 8 + 1}, nan[] = {0xff, 0x7f}, far[] = {0x60};
    uint8_t bytes[COUNT_BYTES + TILTED_BYTES], bad[sizeof bytes];
    stp_raster raster = short_grid();
    stp_square first;
    assert_int_equal(put(&raster, 3, 5, bytes), SHORT_BYTES);
    assert_int_equal(bytes[COUNT_BYTES], 8 + 1);
    for (unsigned i = 0; i < sizeof kinds; i++) {
        memcpy(bad, bytes, sizeof bad);
        bad[COUNT_BYTES] = kinds[i];
        assert_int_equal(get(bad, SHORT_BYTES, &raster, &first), STP_CORRUPT);
    }
    for (unsigned i = 0; i < 8; i++) { /* each number as NaN, and as 2^65 */
        uint8_t *end = bad + COUNT_BYTES + 1 + 13 * (i / 4) + 4 + 3 * (i % 4);
        memcpy(bad, bytes, sizeof bad);
        memcpy(end - 2, nan, 2);
        assert_int_equal(get(bad, SHORT_BYTES, &raster, &first), STP_CORRUPT);
        memcpy(end - 1, far, 1);
        assert_int_equal(get(bad, SHORT_BYTES, &raster, &first), STP_CORRUPT);
    }
    memcpy(bad, bytes, sizeof bad);
    memset(bad + COUNT_BYTES + 5, 0, 6); /* no area */
    assert_int_equal(get(bad, SHORT_BYTES, &raster, &first), STP_CORRUPT);
}

/* What a camera sees whose station is x, y, z, along z. */
static stp_raster seen_from(double x, double y, double z, const float slopes[4])
{
    const float middle[2] = {-0.61f, 0.457f};
    stp_raster out = {.axis = 2};
    for (unsigned k = 0; k < 2; k++) {
        out.across[k][0] = (k ? y : x) - z * (double)middle[k];
        out.across[k][3] = (double)middle[k];
        for (unsigned i = 0; i < 2; i++) {
            out.across[k][1 + i] = (double)(float)(0.0 - z * (double)slopes[2 * k + i]);
            out.across[k][4 + i] = (double)slopes[2 * k + i];
        }
    }
    return out;
}

/* A camera's raster comes back as it is, and takes few bytes: fewer if columns and rows go along
 * axes. It takes more if it is not one. */
static void cameras(void **state)
{
    (void)state;
    const float turned[4] = {0.0f, -0.0019f, 0.00191f, 0.0f},
                tilted[4] = {0.002f, 1e-5f, -1e-5f, 0.1f};
    uint8_t bytes[COUNT_BYTES + TILTED_BYTES + SPREAD_BYTES];
    for (unsigned i = 0; i < 8; i++) {
        stp_raster raster = i < 2 ? seen_from(0.0, 0.0, 0.0, turned)
                                  : seen_from(1.5, -3.25, -8.0, i == 2 ? tilted : turned);
        if (i == 4)
            raster.across[0][1] += 0x1p-20;
        if (i == 5)
            raster.across[1][0] += 0x1p-40;
        if (i == 7) /* too small for three bytes */
            raster = seen_from(0x1.abp-140, 0.0, 0.0, turned);
        const uint32_t column = i == 6 ? 65536 : 65535, row = 65534;
        const size_t size = put(&raster, column, row, bytes);
        assert_int_equal(size, i > 3    ? TILTED_BYTES + SPREAD_BYTES
                               : i == 2 ? STP_CAMERA_RASTER_BYTES
                                        : STP_CAMERA_RASTER_BYTES - 8);
        check_back(bytes, size, &raster, column, row);
    }
}

/* Bytes of a camera's raster that say what no raster is are refused. */
static void damaged_camera(void **state)
{
    (void)state;
    const float slopes[4] = {0.0f, -0.0019f, 0.00191f, 0.0f};
    const uint8_t nan[] = {0xff, 0x7f}, far[] = {0x60};
    uint8_t bytes[COUNT_BYTES + TILTED_BYTES], bad[sizeof bytes];
    stp_raster raster = seen_from(1.0, 2.0, 3.0, slopes);
    stp_square first;
    const size_t size = put(&raster, 3, 5, bytes);
    assert_int_equal(bytes[COUNT_BYTES], 32 + 64 + 12 + 2);
    memcpy(bad, bytes, sizeof bad);
    bad[COUNT_BYTES] |= 3; /* no axis */
    assert_int_equal(get(bad, size, &raster, &first), STP_CORRUPT);
    for (unsigned i = 0; i < 7; i++) { /* each number as NaN, and as 2^65 */
        uint8_t *end = bad + COUNT_BYTES + 1 + (i < 3 ? 3 * (i + 1) : 9 + 4 * (i - 2));
        memcpy(bad, bytes, sizeof bad);
        memcpy(end - 2, nan, 2);
        assert_int_equal(get(bad, size, &raster, &first), STP_CORRUPT);
        memcpy(end - 1, far, 1);
        assert_int_equal(get(bad, size, &raster, &first), STP_CORRUPT);
    }
    memcpy(bad, bytes, sizeof bad);
    memset(bad + COUNT_BYTES + 1 + 9 + 8, 0, 8); /* it does not spread */
    assert_int_equal(get(bad, size, &raster, &first), STP_CORRUPT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearest_grid),  cmocka_unit_test(bytes_of_rasters),
        cmocka_unit_test(cameras),       cmocka_unit_test(damaged_camera),
        cmocka_unit_test(short_numbers), cmocka_unit_test(damaged_short)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
