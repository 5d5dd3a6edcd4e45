/* Tests TIFFs of heights that are turned, mirrored or sheared, and those with masks: each sample
 * lies where the matrix of its file says, the raster tells the same, normals are those of the
 * world, and holes are where the mask is 0. */
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>
#include <tiffio.h>

enum { COLUMNS = 21, ROWS = 13, COUNT = COLUMNS * ROWS };

/* x = m[0] column + m[1] row + m[2], y = m[3] column + m[4] row + m[5], of a pixel's corner. */
typedef double matrix[6];

static void place_of(const double *m, double column, double row, double out[2])
{
    out[0] = m[0] * column + m[1] * row + m[2];
    out[1] = m[3] * column + m[4] * row + m[5];
}

/* A plane over the world. */
static double height_of(const double at[2])
{
    return 0.25 * at[0] - 0.5 * at[1] + 3.0;
}

static TIFF *begin(const char *path, const char *mode, int bits, int kind, uint32_t type)
{
    TIFF *tiff = TIFFOpen(path, mode);
    assert_non_null(tiff);
    TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, type);
    TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, COLUMNS);
    TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, ROWS);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, bits);
    TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, kind);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 5);
    return tiff;
}

/* Writes the heights of the plane. A matrix of NULL: the file has no place. */
static void write_heights(const char *path, const double *m)
{
    TIFF *tiff = begin(path, "w", 64, SAMPLEFORMAT_IEEEFP, 0);
    const double all[16] = {m ? m[0] : 0.0, m ? m[1] : 0.0, 0.0, m ? m[2] : 0.0,
                            m ? m[3] : 0.0, m ? m[4] : 0.0, 0.0, m ? m[5] : 0.0};
    double row[COLUMNS];
    if (m)
        TIFFSetField(tiff, 34264, 16, all);
    for (int r = 0; r < ROWS; r++) {
        for (int c = 0; c < COLUMNS; c++) {
            double at[2] = {c, r};
            if (m)
                place_of(m, c + 0.5, r + 0.5, at);
            row[c] = height_of(at);
        }
        assert_int_equal(TIFFWriteScanline(tiff, row, (uint32_t)r, 0), 1);
    }
    TIFFClose(tiff);
}

/* Checks each of the file's points, of which every step-th column and row is read. */
static void check(const char *path, const double *m, uint32_t step)
{
    const stp_scan_params params = {.grid_step = step};
    const uint32_t columns = (COLUMNS - 1) / step + 1, rows = (ROWS - 1) / step + 1;
    stp_scan_info info;
    stp_point *points = scan_fixture_read(path, &params, &info);
    const stp_scan_raster *r = &info.raster;
    bool seen[COUNT] = {false};
    assert_int_equal(info.point_count, columns * rows);
    assert_int_equal(r->columns * r->rows, columns * rows);
    assert_true(r->dx > 0.0 && r->dy > 0.0);
    for (uint32_t i = 0; i < columns * rows; i++) {
        const uint64_t place = stp_scan_raster_place(r, i);
        double at[2];
        place_of(m, step * (i % columns) + 0.5, step * (i / columns) + 0.5, at);
        const double z = height_of(at);
        const stp_dvec3 told =
            stp_scan_raster_at(r, (double)(place % r->columns), (double)(place / r->columns), z);
        assert_true(place < columns * rows && !seen[place]);
        seen[place] = true;
        scan_fixture_position(&points[i], at[0], at[1], z);
        assert_true(fabs(told.x - at[0]) < 1e-9 && fabs(told.y - at[1]) < 1e-9);
        scan_fixture_normal(&points[i], -0.25 / sqrt(1.3125), 0.5 / sqrt(1.3125),
                            1.0 / sqrt(1.3125));
    }
    free(points);
}

static void matrices(void **state)
{
    static const struct {
        matrix m;
        unsigned order;
        bool turned; /* by no right angle */
    } cases[] = {
        {{2.0, 0.0, 100.0, 0.0, -4.0, 500.0}, 0, false},
        {{2.0, 0.0, 100.0, 0.0, 4.0, 500.0}, STP_RASTER_FROM_BELOW, false},
        {{-2.0, 0.0, 100.0, 0.0, -4.0, 500.0}, STP_RASTER_FROM_RIGHT, false},
        {{-2.0, 0.0, 100.0, 0.0, 4.0, 500.0}, STP_RASTER_FROM_RIGHT | STP_RASTER_FROM_BELOW, false},
        {{0.0, 2.0, 100.0, -4.0, 0.0, 500.0}, STP_RASTER_BY_COLUMN, false},
        {{0.0, -2.0, 100.0, -4.0, 0.0, 500.0}, STP_RASTER_BY_COLUMN | STP_RASTER_FROM_RIGHT, false},
        {{0.0, 2.0, 100.0, 4.0, 0.0, 500.0}, STP_RASTER_BY_COLUMN | STP_RASTER_FROM_BELOW, false},
        {{0.0, -2.0, 100.0, 4.0, 0.0, 500.0},
         STP_RASTER_BY_COLUMN | STP_RASTER_FROM_RIGHT | STP_RASTER_FROM_BELOW,
         false},
        {{2.0, 0.5, 100.0, 0.0, -4.0, 500.0}, 0, true},
        {{1.75, 1.0, -100.0, 1.0, -1.75, 500.0}, 0, true},
        {{1.0, 1.75, 100.0, -1.75, 1.0, -500.0}, STP_RASTER_BY_COLUMN, true},
        {{-1.0, -1.75, 100.0, -1.75, 1.0, 500.0},
         STP_RASTER_BY_COLUMN | STP_RASTER_FROM_RIGHT,
         true},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        stp_scan *scan = NULL;
        write_heights("matrix.tif", cases[k].m);
        assert_int_equal(stp_scan_open(&scan, "matrix.tif", NULL, NULL), STP_OK);
        const stp_scan_raster *r = &stp_scan_get_info(scan)->raster;
        assert_int_equal(r->order, cases[k].order);
        assert_int_equal(r->skew[0] != 0.0 || r->skew[1] != 0.0, cases[k].turned);
        stp_scan_close(&scan);
        for (uint32_t step = 1; step < 5; step++)
            check("matrix.tif", cases[k].m, step);
    }
}

/* Pixels without an area have no place; a spacing's sign along y counts for nothing, as for GDAL.
 */
static void no_places(void **state)
{
    static const matrix flat = {2.0, 4.0, 100.0, 1.0, 2.0, 500.0};
    static const double scale[] = {2.0, -4.0, 0.0}, tie[] = {0.0, 0.0, 0.0, 100.0, 500.0, 0.0};
    stp_scan_info info;
    (void)state;
    write_heights("flat.tif", flat);
    free(scan_fixture_read("flat.tif", NULL, &info));
    assert_true(info.raster.dx == 1.0 && info.raster.dy == 1.0 && info.raster.x == 0.0);
    TIFF *tiff = begin("signed.tif", "w", 64, SAMPLEFORMAT_IEEEFP, 0);
    const double row[COLUMNS] = {0.0};
    TIFFSetField(tiff, 33550, 3, scale);
    TIFFSetField(tiff, 33922, 6, tie);
    for (uint32_t r = 0; r < ROWS; r++)
        assert_int_equal(TIFFWriteScanline(tiff, (void *)row, r, 0), 1);
    TIFFClose(tiff);
    free(scan_fixture_read("signed.tif", NULL, &info));
    assert_true(info.raster.dy == 4.0 && info.raster.y == 498.0 && info.raster.order == 0);
}

static bool is_hole(int c, int r)
{
    return (c * 5 + r * 3) % 7 == 2 || r == 4;
}

/* Writes a row of a mask. */
static void write_mask_row(TIFF *tiff, int bits, uint32_t r, int by)
{
    unsigned char row[COLUMNS] = {0};
    for (int c = 0; c * by < COLUMNS; c++)
        if (!is_hole(c * by, (int)r * by))
            row[bits == 1 ? c / 8 : c] |= (unsigned char)(bits == 1 ? 128 >> c % 8 : 255);
    assert_int_equal(TIFFWriteScanline(tiff, row, r, 0), 1);
}

static void write_mask(const char *path, const char *mode, int bits, uint32_t type)
{
    TIFF *tiff = begin(path, mode, bits, SAMPLEFORMAT_UINT, type);
    TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_LZW);
    for (uint32_t r = 0; r < ROWS; r++)
        write_mask_row(tiff, bits, r, 1);
    TIFFClose(tiff);
}

/* Checks that holes are where they must be; none: there are none. */
static void check_holes(const char *path, const stp_grid_params *grid, bool none)
{
    const stp_scan_params params = {.grid = grid};
    stp_scan_info info;
    stp_point *points = scan_fixture_read(path, &params, &info);
    assert_int_equal(info.point_count, COUNT);
    for (int i = 0; i < COUNT; i++) {
        const double at[2] = {i % COLUMNS, i / COLUMNS};
        const bool hole = !none && is_hole(i % COLUMNS, i / COLUMNS);
        assert_int_equal(points[i].reject, hole ? STP_REJECT_INVALID : STP_REJECT_NONE);
        if (!hole)
            assert_true(points[i].position.z == height_of(at));
    }
    free(points);
}

/* Masks inside the file, of 1 and of 8 bits, behind another image; those of other sizes are no
 * masks of the image. A mask of 1 bit beside it. */
static void masks(void **state)
{
    (void)state;
    for (int bits = 1; bits <= 8; bits += 7) {
        write_heights("masked.tif", NULL);
        write_mask("masked.tif", "a", bits, FILETYPE_PAGE);
        check_holes("masked.tif", NULL, true);
        write_mask("masked.tif", "a", bits, FILETYPE_MASK);
        check_holes("masked.tif", NULL, false);
    }
    write_heights("plain.tif", NULL);
    write_mask("bits.tif", "w", 1, 0);
    check_holes("plain.tif", &(stp_grid_params){.mask = "bits.tif"}, false);
}

/* A second channel that is alpha: interleaved, or in strips and tiles of its own. */
static void alphas(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        const bool apart = kind & 1, tiled = kind & 2;
        const uint16_t alpha = EXTRASAMPLE_UNASSALPHA;
        const int wide = tiled ? 32 : COLUMNS, high = tiled ? 16 : 1;
        TIFF *tiff = begin("alpha.tif", "w", 64, SAMPLEFORMAT_IEEEFP, 0);
        TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 2);
        TIFFSetField(tiff, TIFFTAG_EXTRASAMPLES, 1, &alpha);
        TIFFSetField(tiff, TIFFTAG_PLANARCONFIG,
                     apart ? PLANARCONFIG_SEPARATE : PLANARCONFIG_CONTIG);
        TIFFSetField(tiff, TIFFTAG_COMPRESSION, COMPRESSION_ADOBE_DEFLATE);
        if (tiled) {
            TIFFSetField(tiff, TIFFTAG_TILEWIDTH, wide);
            TIFFSetField(tiff, TIFFTAG_TILELENGTH, high);
        }
        for (int s = 0; s < (apart ? 2 : 1); s++)
            for (int r = 0; r < ROWS; r += high) {
                double piece[2 * 32 * 16] = {0.0};
                for (int i = 0; i < wide * high; i++) {
                    const double at[2] = {i % wide, r + i / wide};
                    const double both[2] = {height_of(at),
                                            is_hole(i % wide, r + i / wide) ? 0.0 : 1.0};
                    if (apart)
                        piece[i] = both[s];
                    else
                        memcpy(piece + 2 * (size_t)i, both, sizeof both);
                }
                assert_true((tiled ? (int)TIFFWriteTile(tiff, piece, 0, (uint32_t)r, 0, (uint16_t)s)
                                   : TIFFWriteScanline(tiff, piece, (uint32_t)r, (uint16_t)s)) > 0);
            }
        TIFFClose(tiff);
        check_holes("alpha.tif", NULL, false);
    }
}

/* Of a masked image only a copy with a mask stands for the whole. */
static void masks_of_copies(void **state)
{
    (void)state;
    for (int masked = 0; masked < 2; masked++) {
        write_heights("copies.tif", NULL);
        write_mask("copies.tif", "a", 1, FILETYPE_MASK);
        for (int k = 0; k <= masked; k++) {
            const bool is_mask = k == 1;
            TIFF *tiff = begin("copies.tif", "a", is_mask ? 1 : 64,
                               is_mask ? SAMPLEFORMAT_UINT : SAMPLEFORMAT_IEEEFP,
                               FILETYPE_REDUCEDIMAGE | (is_mask ? FILETYPE_MASK : 0));
            TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, (COLUMNS + 1) / 2);
            TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, (ROWS + 1) / 2);
            for (uint32_t r = 0; r < (ROWS + 1) / 2; r++) {
                double row[COLUMNS];
                for (int c = 0; c < COLUMNS; c++)
                    row[c] = 77.0;
                if (is_mask)
                    write_mask_row(tiff, 1, r, 2);
                else
                    assert_int_equal(TIFFWriteScanline(tiff, row, r, 0), 1);
            }
            TIFFClose(tiff);
        }
        const stp_scan_params params = {.grid_step = 2};
        stp_scan_info info;
        stp_point *points = scan_fixture_read("copies.tif", &params, &info);
        assert_int_equal(info.point_count, (COLUMNS + 1) / 2 * ((ROWS + 1) / 2));
        for (int i = 0; i < (int)info.point_count; i++) {
            const int c = i % ((COLUMNS + 1) / 2) * 2, r = i / ((COLUMNS + 1) / 2) * 2;
            assert_int_equal(points[i].reject == STP_REJECT_INVALID, is_hole(c, r));
            if (!is_hole(c, r))
                assert_true((points[i].position.z == 77.0) == (masked == 1));
        }
        free(points);
    }
}

/* Cut anywhere, a file fails with a sentence or has a place without a mask; nothing is read beyond
 * its end. */
static void cut_masks(void **state)
{
    size_t size;
    (void)state;
    write_heights("whole.tif", NULL);
    write_mask("whole.tif", "a", 1, FILETYPE_MASK);
    unsigned char *bytes = scan_fixture_load("whole.tif", &size);
    for (size_t cut = 8; cut < size; cut += 37) {
        stp_scan *scan = NULL;
        stp_error err = {0};
        scan_fixture_bytes("cut.tif", bytes, cut);
        if (stp_scan_open(&scan, "cut.tif", NULL, &err) != STP_OK) {
            assert_non_null(strstr(err.message, "cut.tif"));
            continue;
        }
        stp_point points[COUNT];
        size_t count = 1;
        while (count > 0 && stp_scan_read(scan, points, COUNT, &count, &err) == STP_OK)
            ;
        stp_scan_close(&scan);
    }
    free(bytes);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(masks), /* its reader names GeoTIFF's tags to libtiff */
        cmocka_unit_test(no_places),       cmocka_unit_test(matrices),  cmocka_unit_test(alphas),
        cmocka_unit_test(masks_of_copies), cmocka_unit_test(cut_masks),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
