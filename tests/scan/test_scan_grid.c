/* Tests grids of heights and depths. One grid is written in every format by the test itself or by
 * libtiff and libpng, and must become the same points. Then cameras, places, holes, colours, what
 * is refused, and files cut at every length. With real scans: an AL3D file against its depths and
 * texture, which another reader took out of it. */
#include "tests/fixtures/scan/grid_fixture.h"

#include <math.h>

/* Every second column and row of the grid, at their places in the whole one. */
static void check_thinned(const char *path, const stp_grid_params *grid, stp_dvec3 first, double dx,
                          double dy, bool holes)
{
    enum { COLUMNS = (WIDTH + 1) / 2, ROWS = (HEIGHT + 1) / 2 };
    const stp_scan_params params = {.grid = grid, .grid_step = 2};
    stp_scan_info info;
    stp_point *points = scan_fixture_read(path, &params, &info);
    assert_int_equal(info.point_count, COLUMNS * ROWS);
    assert_int_equal(info.raster.columns, COLUMNS);
    assert_true(info.raster.dx == 2.0 * dx && info.raster.dy == 2.0 * dy);
    for (int i = 0; i < COLUMNS * ROWS; i++) {
        const int column = 2 * (i % COLUMNS), row = 2 * (i / COLUMNS), at = row * WIDTH + column;
        if (holes && at == NONE_AT)
            assert_int_equal(points[i].reject, STP_REJECT_INVALID);
        else
            scan_fixture_position(&points[i], first.x + column * dx, first.y - row * dy,
                                  height_at(at));
    }
    free(points);
}

/* The points must be the grid's, placed by spacing and the first pixel's place. Those of number
 * NONE are invalid if they are `holes`. */
static void check_points(const char *path, const stp_grid_params *grid, stp_dvec3 first, double dx,
                         double dy, bool holes)
{
    const stp_scan_params params = {.grid = grid};
    stp_scan_info info;
    stp_point *points = scan_fixture_read(path, &params, &info);
    assert_int_equal(info.point_count, COUNT);
    assert_true(info.heights && info.attributes & STP_POINT_HAS_NORMAL);
    for (int i = 0; i < COUNT; i++) {
        if (holes && i == NONE_AT) {
            assert_int_equal(points[i].reject, STP_REJECT_INVALID);
            continue;
        }
        assert_int_equal(points[i].reject, STP_REJECT_NONE);
        scan_fixture_position(&points[i], first.x + i % WIDTH * dx, first.y - i / WIDTH * dy,
                              height_at(i));
    }
    free(points);
    check_thinned(path, grid, first, dx, dy, holes);
}

#define TOP ((stp_dvec3){0.0, HEIGHT - 1, 0.0})

static void formats_agree(void **state)
{
    (void)state;
    const stp_grid_params none = {.has_invalid = true, .invalid = NONE};
    static const tiff_recipe recipes[] = {
        {"w", 16, SAMPLEFORMAT_UINT, false, COMPRESSION_NONE, 0},
        {"w", 16, SAMPLEFORMAT_INT, true, COMPRESSION_LZW, 0},
        {"wb", 16, SAMPLEFORMAT_UINT, false, COMPRESSION_NONE, 0},
        {"wb", 32, SAMPLEFORMAT_IEEEFP, true, COMPRESSION_NONE, 0},
        {"w8", 32, SAMPLEFORMAT_IEEEFP, false, COMPRESSION_ADOBE_DEFLATE, 0},
        {"w", 32, SAMPLEFORMAT_UINT, true, COMPRESSION_NONE, 0},
        {"w", 32, SAMPLEFORMAT_INT, false, COMPRESSION_PACKBITS, 0},
        {"w", 64, SAMPLEFORMAT_IEEEFP, false, COMPRESSION_NONE, 0},
        {"w", 16, SAMPLEFORMAT_INT, true, COMPRESSION_LZW, PREDICTOR_HORIZONTAL},
        {"w", 32, SAMPLEFORMAT_UINT, true, COMPRESSION_ADOBE_DEFLATE, PREDICTOR_HORIZONTAL},
        {"wb", 32, SAMPLEFORMAT_UINT, true, COMPRESSION_ADOBE_DEFLATE, PREDICTOR_HORIZONTAL},
        {"w", 32, SAMPLEFORMAT_IEEEFP, true, COMPRESSION_ADOBE_DEFLATE, PREDICTOR_FLOATINGPOINT},
        {"w", 64, SAMPLEFORMAT_IEEEFP, true, COMPRESSION_LZW, PREDICTOR_FLOATINGPOINT},
        {"w", 32, SAMPLEFORMAT_IEEEFP, false, COMPRESSION_LZW, PREDICTOR_FLOATINGPOINT},
    };
    write_pgm();
    write_pgm_digits();
    write_pfm("little.pfm", true);
    write_pfm("big.pfm", false);
    write_png("grid.png", PNG_INTERLACE_NONE);
    write_png("interlaced.png", PNG_INTERLACE_ADAM7);
    write_exr();
    static const char *const names[] = {"grid.pgm", "digits.pgm",     "little.pfm", "big.pfm",
                                        "grid.png", "interlaced.png", "grid.exr"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        check_points(names[i], NULL, TOP, 1.0, 1.0, false);
        check_points(names[i], &none, TOP, 1.0, 1.0, true);
    }
    for (size_t i = 0; i < sizeof recipes / sizeof *recipes; i++) {
        end_tiff(begin_tiff("grid.tif", &recipes[i]), &recipes[i]);
        check_points("grid.tif", &none, TOP, 1.0, 1.0, true);
    }
    const stp_grid_params spaced = {.dx = 0.5, .dy = 2.0};
    check_points("grid.png", &spaced, (stp_dvec3){0.0, 2.0 * (HEIGHT - 1), 0.0}, 0.5, 2.0, false);
}

/* Files that say where they lie and how far their pixels are apart. */
static void files_have_places(void **state)
{
    (void)state;
    write_esri("ncols 7\nnrows 5\nxllcorner 1000\nyllcorner 2000\ncellsize 10\nNODATA_value 999\n");
    check_points("grid.asc", NULL, (stp_dvec3){1005.0, 2045.0, 0.0}, 10.0, 10.0, true);
    write_esri("NCOLS 7\r\nNROWS 5\r\nXLLCENTER 1\r\nYLLCENTER 2\r\nDX 0.5\r\nDY 0.25\r\n");
    check_points("grid.asc", NULL, (stp_dvec3){1.0, 3.0, 0.0}, 0.5, 0.25, false);
    write_esri("  Nrows\t5\nNcols 7\nxllcenter 1\nyllcenter 2\ncellsize 1\n");
    check_points("grid.asc", NULL, (stp_dvec3){1.0, 6.0, 0.0}, 1.0, 1.0, false);
    write_al3d();
    check_points("grid.al3d", NULL, (stp_dvec3){0.0, 1.0, 0.0}, 0.5, 0.25, true);
    for (int is_point = 0; is_point < 2; is_point++) {
        const tiff_recipe recipe = {"w", 32, SAMPLEFORMAT_IEEEFP, false, COMPRESSION_NONE, 0};
        const uint16_t keys[] = {1, 1, 0, 2, 1024, 0, 1, 1, 1025, 0, 1, (uint16_t)(1 + is_point)};
        const double scale[] = {2.0, 4.0, 0.0}, tie[] = {1.0, 1.0, 0.0, 500.0, 600.0, 0.0};
        /* our reader has named these tags to libtiff, when it read the first TIFF */
        TIFF *tiff = begin_tiff("place.tif", &recipe);
        TIFFSetField(tiff, 33550, 3, scale);
        TIFFSetField(tiff, 33922, 6, tie);
        TIFFSetField(tiff, 34735, 12, keys);
        TIFFSetField(tiff, 42113, "999 ");
        end_tiff(tiff, &recipe);
        const double half = is_point ? 0.0 : 0.5;
        const stp_dvec3 first = {500.0 + (half - 1.0) * 2.0, 600.0 - (half - 1.0) * 4.0, 0.0};
        check_points("place.tif", NULL, first, 2.0, 4.0, true);
    }
}

/* A copy of a TIFF by a half stands for the whole where every second or third column is enough, and
 * every second of its own where every fourth is. Masks and images that are no copies do not. */
static void copies_stand_for_the_whole(void **state)
{
    (void)state;
    enum { SIDE = 16, PLAIN = 0, HALF = 100, PAGE = 200, MASK = 300 };
    static const struct {
        uint32_t type;
        int side, first; /* its first height */
    } images[] = {{0, SIDE, PLAIN},
                  {FILETYPE_PAGE, SIDE / 4, PAGE},
                  {FILETYPE_REDUCEDIMAGE | FILETYPE_MASK, SIDE / 2, MASK},
                  {FILETYPE_REDUCEDIMAGE, SIDE / 2, HALF}};
    static const double scale[] = {2.0, 4.0, 0.0}, tie[] = {0.0, 0.0, 0.0, 500.0, 600.0, 0.0};
    TIFF *tiff = TIFFOpen("copies.tif", "w");
    for (size_t k = 0; k < sizeof images / sizeof *images; k++) {
        float row[SIDE];
        TIFFSetField(tiff, TIFFTAG_SUBFILETYPE, images[k].type);
        TIFFSetField(tiff, TIFFTAG_IMAGEWIDTH, images[k].side);
        TIFFSetField(tiff, TIFFTAG_IMAGELENGTH, images[k].side);
        TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 1);
        TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 32);
        TIFFSetField(tiff, TIFFTAG_SAMPLEFORMAT, SAMPLEFORMAT_IEEEFP);
        TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_MINISBLACK);
        if (k == 0) {
            TIFFSetField(tiff, 33550, 3, scale);
            TIFFSetField(tiff, 33922, 6, tie);
        }
        for (int y = 0; y < images[k].side; y++) {
            for (int x = 0; x < images[k].side; x++)
                row[x] = (float)(images[k].first + x + 0.25 * y);
            assert_int_equal(TIFFWriteScanline(tiff, row, (uint32_t)y, 0), 1);
        }
        assert_true(TIFFWriteDirectory(tiff));
    }
    TIFFClose(tiff);
    for (uint32_t step = 1; step <= 5; step++) {
        const bool half = step > 1;
        const uint32_t of_copy = half ? step / 2 : 1, side = half ? SIDE / 2 : SIDE;
        const stp_scan_params params = {.grid_step = step};
        const double pixel = half ? 2.0 : 1.0, first = half ? HALF : PLAIN;
        stp_scan_info info;
        stp_point *points = scan_fixture_read("copies.tif", &params, &info);
        const uint32_t across = (side - 1) / of_copy + 1;
        assert_int_equal(info.raster.columns, across);
        assert_int_equal(info.point_count, across * across);
        for (uint32_t i = 0; i < across * across; i++) {
            const double x = of_copy * (i % across), y = of_copy * (i / across);
            scan_fixture_position(&points[i], 500.0 + 2.0 * pixel * (x + 0.5),
                                  600.0 - 4.0 * pixel * (y + 0.5), first + x + 0.25 * y);
        }
        free(points);
    }
}

/* GDAL says the scale of the heights, and in a text of its own what number means none. */
static void numbers_have_a_meaning(void **state)
{
    (void)state;
    const tiff_recipe whole = {"w", 16, SAMPLEFORMAT_INT, false, COMPRESSION_NONE, 0};
    static const char *const metadata[] = {
        ("<GDALMetadata><Item name=\"OFFSET\" sample=\"0\" role=\"offset\">-7</Item>\n"
         "<Item name=\"SCALE\" sample=\"0\" role=\"scale\">0.25</Item></GDALMetadata>"),
        "<GDALMetadata><Item role=\"scale\" name=\"SCALE\" sample=\"1\">9</Item></GDALMetadata>",
        "role=\"scale\"", "<Item role=\"scale\" sample=\"0\">",
        "<Item sample=\"0\" role=\"scale\">x<"};
    for (size_t m = 0; m < sizeof metadata / sizeof *metadata; m++) {
        TIFF *tiff = begin_tiff("scaled.tif", &whole);
        TIFFSetField(tiff, 42112, metadata[m]);
        end_tiff(tiff, &whole);
        stp_scan_info info;
        stp_point *points = scan_fixture_read("scaled.tif", NULL, &info);
        for (int i = 0; i < COUNT; i++)
            assert_true(points[i].position.z ==
                        (m == 0 ? 0.25 * height_at(i) - 7.0 : height_at(i)));
        free(points);
    }
    const tiff_recipe floats = {"w", 32, SAMPLEFORMAT_IEEEFP, false, COMPRESSION_NONE, 0};
    static const float none[] = {-9999.9f, -3.4028235e38f, -3.4028231e38f, -3.4e38f, 1.70141e38f};
    static const char *const said[] = {"-9999.9", "-3.4028234663852886e+38", NULL, "nan", NULL};
    for (int n = 0; n < 5; n++) {
        float row[WIDTH] = {0.0f, 1.0f, none[n]};
        TIFF *tiff = begin_tiff("none.tif", &floats);
        if (said[n])
            TIFFSetField(tiff, 42113, said[n]);
        for (uint32_t y = 0; y < HEIGHT; y++)
            assert_int_equal(TIFFWriteScanline(tiff, row, y, 0), 1);
        TIFFClose(tiff);
        stp_scan_info info;
        stp_point *points = scan_fixture_read("none.tif", NULL, &info);
        for (int i = 0; i < COUNT; i++)
            assert_int_equal(points[i].reject,
                             i % WIDTH == 2 ? STP_REJECT_INVALID : STP_REJECT_NONE);
        free(points);
    }
}

/* Numbers that programs write for no sample are holes though the file does not say so, but heights
 * of a trench, and whatever --invalid leaves. */
static void usual_numbers_of_none(void **state)
{
    (void)state;
    static const struct {
        float row[4]; /* then 3 */
        uint32_t holes;
        bool told;
    } rows[] = {
        {{5.0f, -9999.0f, -9999.0f, 7.0f}, 6, false},
        {{-32768.0f, 5.0f, 6.0f, -32767.0f}, 9, false},
        {{-99999.0f, -99999.0f, 5.0f, 6.0f}, 3, false},
        {{5.0f, -9998.0f, 5.0f, 5.0f}, 0, false},
        {{-9500.0f, -9999.0f, -9000.0f, 6.0f}, 0, false},
        {{5.0f, -9999.0f, 5.0f, 6.0f}, 0, true},
    };
    const tiff_recipe floats = {"w", 32, SAMPLEFORMAT_IEEEFP, false, COMPRESSION_NONE, 0};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const stp_grid_params grid = {.has_invalid = rows[k].told, .invalid = -1.0};
        const stp_scan_params params = {.grid = &grid};
        float row[WIDTH];
        for (int x = 0; x < WIDTH; x++)
            row[x] = x < 4 ? rows[k].row[x] : 3.0f;
        TIFF *tiff = begin_tiff("usual.tif", &floats);
        for (uint32_t y = 0; y < HEIGHT; y++)
            assert_int_equal(TIFFWriteScanline(tiff, row, y, 0), 1);
        TIFFClose(tiff);
        stp_scan_info info;
        stp_point *points = scan_fixture_read("usual.tif", &params, &info);
        for (int i = 0; i < COUNT; i++) {
            const bool hole = i % WIDTH < 4 && rows[k].holes >> i % WIDTH & 1;
            assert_int_equal(points[i].reject, hole ? STP_REJECT_INVALID : STP_REJECT_NONE);
        }
        free(points);
    }
}

/* A plane z = 3 x - 2 y must have its own normal everywhere, at edges and beside a hole, too. Where
 * a sample has no neighbour in its column or row, it is not known. */
static void normals_are_the_grids(void **state)
{
    (void)state;
    FILE *file = begin("plane.asc", "ncols 4\nnrows 4\ncellsize 0.5\nnodata_value -9\n");
    for (int i = 0; i < 16; i++)
        fprintf(file, "%g ", i == 6 ? -9.0 : 3.0 * 0.5 * (i % 4) - 2.0 * 0.5 * (3 - i / 4));
    fclose(file);
    stp_scan_info info;
    stp_point *points = scan_fixture_read("plane.asc", NULL, &info);
    const double length = sqrt(9.0 + 4.0 + 1.0);
    scan_fixture_normal(&points[2], 0.0, 0.0, 0.0);
    scan_fixture_normal(&points[7], 0.0, 0.0, 0.0);
    for (int i = 0; i < 16; i++)
        if (i != 6 && i != 2 && i != 7)
            scan_fixture_normal(&points[i], -3.0 / length, 2.0 / length, 1.0 / length);
    free(points);
}

/* Depths along the axis, along the ray, and disparities of one wall across the view at z = 2. */
static void cameras(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        const stp_grid_params grid = {.fx = 10.0,
                                      .fy = 20.0,
                                      .cx = 3.0,
                                      .cy = 1.0,
                                      .along_ray = kind == 1,
                                      .scale = kind == 0 ? 0.5 : 0.0,
                                      .disparity_focal = kind == 2 ? 8.0 : 0.0,
                                      .disparity_base = kind == 2 ? 0.25 : 0.0};
        const stp_scan_params params = {.grid = &grid};
        FILE *file = begin("depth.pfm", "Pf\n7 5\n-1\n");
        for (int row = HEIGHT - 1; row >= 0; row--)
            for (int column = 0; column < WIDTH; column++) {
                const double x = (column - 3) / 10.0, y = (row - 1) / 20.0;
                float value = (float)(kind == 0   ? 4.0
                                      : kind == 1 ? 2.0 * sqrt(x * x + y * y + 1.0)
                                                  : 1.0);
                if (row == 2 && column < 2)
                    value = column == 0 ? 0.0f : -1.0f; /* no samples */
                fwrite(&value, sizeof value, 1, file);
            }
        fclose(file);
        stp_scan_info info;
        stp_point *points = scan_fixture_read("depth.pfm", &params, &info);
        assert_int_equal(info.grid.columns, WIDTH);
        assert_int_equal(info.grid.rows, HEIGHT);
        assert_int_equal(info.station_count, 1);
        assert_false(info.heights);
        for (int i = 0; i < COUNT; i++) {
            if (i == 2 * WIDTH || i == 2 * WIDTH + 1) {
                assert_int_equal(points[i].reject, STP_REJECT_INVALID);
                continue;
            }
            const stp_dvec3 wanted = {2.0 * (i % WIDTH - 3) / 10.0, 2.0 * (i / WIDTH - 1) / 20.0,
                                      2.0};
            assert_int_equal(points[i].station, 1);
            assert_true(stp_dvec3_length(stp_dvec3_sub(points[i].position, wanted)) < 1e-6);
        }
        free(points);
    }
}

/* ---- colours ---- */

static void write_colours(const char *path, int width, int height, int channels)
{
    png_image png = {.version = PNG_IMAGE_VERSION,
                     .width = (png_uint_32)width,
                     .height = (png_uint_32)height,
                     .format = channels == 4 ? PNG_FORMAT_RGBA : PNG_FORMAT_RGB};
    unsigned char pixels[4 * COUNT];
    for (int i = 0; i < channels * width * height; i++)
        pixels[i] = (unsigned char)(channels == 4 && i % 4 == 3 ? (i / 4 == 9 ? 0 : 255) : 3 * i);
    assert_true(png_image_write_to_file(&png, path, 0, pixels, 0, NULL));
}

static void colours_and_alpha(void **state)
{
    (void)state;
    stp_scan_info info;
    write_png("grid.png", PNG_INTERLACE_NONE);
    for (int channels = 3; channels <= 4; channels++) {
        write_colours("colour.png", WIDTH, HEIGHT, channels);
        const stp_grid_params grid = {.colour = "colour.png"};
        const stp_scan_params params = {.grid = &grid};
        stp_point *points = scan_fixture_read("grid.png", &params, &info);
        assert_true(info.attributes & STP_POINT_HAS_COLOUR);
        for (int i = 0; i < COUNT; i++) {
            const bool hidden = channels == 4 && i == 9;
            const unsigned k = 3u * (unsigned)(channels * i);
            assert_int_equal(points[i].reject, hidden ? STP_REJECT_INVALID : STP_REJECT_NONE);
            if (!hidden)
                scan_fixture_rgb(&points[i], k % 256 * 257, (k + 3) % 256 * 257,
                                 (k + 6) % 256 * 257);
        }
        free(points);
    }
    write_al3d();
    stp_point *points = scan_fixture_read("grid.al3d", NULL, &info);
    for (unsigned i = 0; i < COUNT; i++)
        if (i != NONE_AT)
            scan_fixture_rgb(&points[i], i * 257, (i + 50) * 257, (i + 100) * 257);
    free(points);
}

/* Orthophotos are TIFF whose colours are packed as JPEG has them. */
static void jpeg_colours(void **state)
{
    const tiff_recipe recipe = {"w", 8, SAMPLEFORMAT_UINT, false, COMPRESSION_JPEG, 0};
    static const int colour[3] = {200, 90, 30};
    unsigned char row[3 * WIDTH];
    (void)state;
    write_png("grid.png", PNG_INTERLACE_NONE);
    TIFF *tiff = begin_tiff("jpeg.tif", &recipe);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 3);
    TIFFSetField(tiff, TIFFTAG_PLANARCONFIG, PLANARCONFIG_CONTIG);
    TIFFSetField(tiff, TIFFTAG_PHOTOMETRIC, PHOTOMETRIC_YCBCR);
    TIFFSetField(tiff, TIFFTAG_ROWSPERSTRIP, 16);
    TIFFSetField(tiff, TIFFTAG_JPEGCOLORMODE, JPEGCOLORMODE_RGB);
    for (int i = 0; i < 3 * WIDTH; i++)
        row[i] = (unsigned char)colour[i % 3];
    for (uint32_t y = 0; y < HEIGHT; y++)
        assert_int_equal(TIFFWriteScanline(tiff, row, y, 0), 1);
    TIFFClose(tiff);
    const stp_grid_params grid = {.colour = "jpeg.tif"};
    const stp_scan_params params = {.grid = &grid};
    stp_scan_info info;
    stp_point *points = scan_fixture_read("grid.png", &params, &info);
    for (int i = 0; i < COUNT; i++)
        for (int k = 0; k < 3; k++)
            assert_in_range(points[i].rgb[k] / 257, colour[k] - 3, colour[k] + 3);
    free(points);
    scan_fixture_fails("jpeg.tif", NULL, STP_UNSUPPORTED, "a picture of colours (3 channels)");
}

/* Black of the mask is no sample, whatever the mask's channels; nor are pixels without alpha. */
static void masks(void **state)
{
    static const png_uint_32 formats[] = {PNG_FORMAT_GRAY, PNG_FORMAT_RGB, PNG_FORMAT_GA};
    static const int channel_counts[] = {1, 3, 2};
    (void)state;
    write_png("grid.png", PNG_INTERLACE_NONE);
    for (int f = 0; f < 3; f++) {
        const int channels = channel_counts[f];
        unsigned char pixels[3 * COUNT] = {0};
        for (int i = 0; i < COUNT; i++) {
            pixels[channels * i + (channels == 3 ? i % 3 : 0)] =
                (unsigned char)(i % 4 == 1 ? 0 : i + 1);
            if (channels == 2)
                pixels[2 * i + 1] = i == 6 ? 0 : 255;
        }
        png_image png = {
            .version = PNG_IMAGE_VERSION, .width = WIDTH, .height = HEIGHT, .format = formats[f]};
        assert_true(png_image_write_to_file(&png, "mask.png", 0, pixels, 0, NULL));
        const stp_grid_params grid = {.mask = "mask.png"};
        const stp_scan_params params = {.grid = &grid};
        stp_scan_info info;
        stp_point *points = scan_fixture_read("grid.png", &params, &info);
        for (int i = 0; i < COUNT; i++)
            assert_int_equal(points[i].reject == STP_REJECT_INVALID,
                             i % 4 == 1 || (channels == 2 && i == 6));
        free(points);
    }
}

/* ---- what is refused ---- */

/* A second band of which nobody says what it is. */
static void refuse_bands(void)
{
    static const tiff_recipe recipe = {"w", 16, SAMPLEFORMAT_UINT, false, COMPRESSION_NONE, 0};
    TIFF *tiff = begin_tiff("bands.tif", &recipe);
    TIFFSetField(tiff, TIFFTAG_SAMPLESPERPIXEL, 2);
    TIFFSetField(tiff, TIFFTAG_BITSPERSAMPLE, 8); /* a row has as many bytes */
    end_tiff(tiff, &recipe);
    scan_fixture_fails("bands.tif", NULL, STP_UNSUPPORTED, "has 2 bands");
}

static void refusals(void **state)
{
    (void)state;
    static const scan_malformed cases[] = {
        {"a.asc", "ncols 3\nnrows 2\n1 2 3\n4 5 6\n", STP_CORRUPT, "cellsize"},
        {"b.asc", "ncols 3\nnrows 2\ncellsize x\n", STP_CORRUPT, "line 3: cellsize needs a number"},
        {"c.asc", "ncols 3\nnrows 2\ncellsize 1\n1 2 3\n4 5\n", STP_CORRUPT, "ends in row 2"},
        {"d.asc", "ncols 3\nnrows 2\ncellsize 1\n1 2 3\n4 five 6\n", STP_CORRUPT, "five"},
        {"f.asc", "ncols 3\nnrows 2\n", STP_CORRUPT, "within its header"},
        {"g.asc", "ncols 99999999\nnrows 2\ncellsize 1\n1\n", STP_CORRUPT, "ncols"},
        {"a.pgm", "P5\n3 2\n255\nabc", STP_CORRUPT, "ends early"},
        {"b.pgm", "P5\n3 x\n255\nabcdef", STP_CORRUPT, "says x"},
        {"c.pgm", "P2 2 2 9\n1 2 3\n", STP_CORRUPT, "ends in row 2"},
        {"a.pfm", "Pf\n2 2\n-1.0\n", STP_CORRUPT, "ends early"},
        {"b.pfm", "PF\n2 2\n-1.0\n", STP_UNSUPPORTED, "colours in floats"},
        {"a.al3d", "AliconaImaging", STP_CORRUPT, "a.al3d"},
        {"a.jpg", "\xff\xd8\xff", STP_UNSUPPORTED, "JPEG"},
    };
    scan_fixture_malformed(cases, sizeof cases / sizeof *cases);
    refuse_bands();
    write_png("grid.png", PNG_INTERLACE_NONE);
    write_colours("small.png", 3, 3, 3);
    stp_grid_params grid = {.colour = "small.png"};
    const stp_scan_params params = {.grid = &grid};
    scan_fixture_fails("grid.png", &params, STP_INVALID_ARGUMENT, "small.png is 3 x 3");
    scan_fixture_fails("small.png", NULL, STP_UNSUPPORTED, "a picture of colours (3 channels)");
    grid.mask = "small.png";
    grid.colour = NULL;
    scan_fixture_fails("grid.png", &params, STP_INVALID_ARGUMENT, "--mask small.png is 3 x 3");
    grid.mask = NULL;
    grid.colour = "none.png";
    stp_scan *scan = NULL;
    stp_error err = {0};
    assert_int_equal(stp_scan_open(&scan, "grid.png", &params, &err), STP_NOT_FOUND);
    assert_non_null(strstr(err.message, "none.png"));
    scan_fixture_text("points.xyz", "1 2 3\n4 5 6\n7 8 10\n");
    scan_fixture_fails("points.xyz", &params, STP_INVALID_ARGUMENT, "no grid");
}

/* A grid in degrees has no normals and says its system. With a spacing it is one in the plane. */
static void degrees(void **state)
{
    const tiff_recipe recipe = {"w", 32, SAMPLEFORMAT_IEEEFP, false, COMPRESSION_NONE, 0};
    const uint16_t keys[] = {1, 1, 0, 2, 1024, 0, 1, 2, 2048, 0, 1, 4326};
    const double scale[] = {2.0, 4.0, 0.0};
    const stp_grid_params grid = {.dx = 1.0, .dy = 1.0};
    TIFF *tiff = begin_tiff("degrees.tif", &recipe);
    stp_error err = {0};
    stp_scan *scan = NULL;
    (void)state;
    TIFFSetField(tiff, 33550, 3, scale);
    TIFFSetField(tiff, 34735, 12, keys);
    end_tiff(tiff, &recipe);
    assert_int_equal(stp_scan_open(&scan, "degrees.tif", NULL, &err), STP_OK);
    const stp_scan_info *info = stp_scan_get_info(scan);
    assert_int_equal(info->attributes & STP_POINT_HAS_NORMAL, 0);
    assert_int_equal(info->note_count, 1);
    assert_string_equal(info->notes[0].name, "geokeys");
    assert_string_equal(info->notes[0].text, "GTModelTypeGeoKey=2\nGeographicTypeGeoKey=4326");
    stp_scan_close(&scan);
    check_points("degrees.tif", &grid, TOP, 1.0, 1.0, false);
}

/* A cut file fails with a sentence, or has all its points: never fewer, never a crash. */
static void cut_files(void **state)
{
    (void)state;
    static const char *const names[] = {"grid.pgm",       "digits.pgm", "little.pfm", "grid.png",
                                        "interlaced.png", "grid.tif",   "grid.al3d",  "grid.asc"};
    static unsigned char bytes[8192];
    for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
        FILE *file = fopen(names[n], "rb");
        assert_non_null(file);
        const size_t size = fread(bytes, 1, sizeof bytes, file);
        fclose(file);
        assert_true(size > 0 && size < sizeof bytes);
        for (size_t cut = 0; cut < size; cut++) {
            stp_error err = {0};
            stp_scan *scan = NULL;
            stp_point points[COUNT];
            size_t count = 1, total = 0;
            scan_fixture_bytes("cut.grid", bytes, cut);
            stp_status status = stp_scan_open(&scan, "cut.grid", NULL, &err);
            while (status == STP_OK && count > 0) {
                status = stp_scan_read(scan, points, COUNT, &count, &err);
                total += status == STP_OK ? count : 0;
            }
            stp_scan_close(&scan);
            if (status == STP_OK ? total != COUNT : strstr(err.message, "cut.grid") == NULL)
                fail_msg("%s cut to %zu bytes: %zu points, %s", names[n], cut, total, err.message);
        }
    }
}

static void real_al3d(void **state)
{
    (void)state;
    static const char *const names[] = {"grids/al3d-1.al3d", "grids/al3d-1_depth_m.pfm",
                                        "grids/al3d-1_texture.png"};
    char paths[3][4096];
    for (int i = 0; i < 3; i++)
        if (!scan_fixture_has_real() || !scan_fixture_real(names[i], paths[i]))
            skip();
    const stp_grid_params grid = {.dx = 4.38027e-07, .dy = 4.38027e-07, .colour = paths[2]};
    const stp_scan_params params = {.grid = &grid};
    stp_scan_info info[2];
    stp_point *own = scan_fixture_read(paths[0], NULL, &info[0]);
    stp_point *other = scan_fixture_read(paths[1], &params, &info[1]);
    assert_int_equal(info[0].point_count, 59200);
    assert_int_equal(info[1].point_count, 59200);
    assert_memory_equal(own, other, 59200 * sizeof *own);
    free(own);
    free(other);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(formats_agree),
        cmocka_unit_test(files_have_places),
        cmocka_unit_test(copies_stand_for_the_whole),
        cmocka_unit_test(numbers_have_a_meaning),
        cmocka_unit_test(usual_numbers_of_none),
        cmocka_unit_test(normals_are_the_grids),
        cmocka_unit_test(cameras),
        cmocka_unit_test(colours_and_alpha),
        cmocka_unit_test(jpeg_colours),
        cmocka_unit_test(masks),
        cmocka_unit_test(refusals),
        cmocka_unit_test(degrees),

        cmocka_unit_test(cut_files),
        cmocka_unit_test(real_al3d),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
