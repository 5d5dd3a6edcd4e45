/* Tests files of several scans, each an image of its own: E57 scans whose records tell rows and
 * columns, in any order, some missing, some doubled; PTX files of several scans. Every record is
 * stored once, at its own column and row of its own scan; what doubles a pixel is a point beside
 * the image. Without keep_grid there are no images. */
#include "formats/chunk/codec/square/square.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/scan/e57_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>

#define OUT "test_scan_images.stipple"

enum { SCANS = 2, COLUMNS = 180, ROWS = 100, PIXELS = COLUMNS * ROWS, DOUBLED = 30 };
/* Of rows and columns in the file. */
enum { FIRST_ROW = 7, FIRST_COLUMN = 3000 };

/* A scanner: its place, and how far it is turned about z. */
static const struct {
    stp_dvec3 place;
    double turn;
} scanners[SCANS] = {{{0.5, -0.7, 0.2}, 0.6}, {{-2.0, 1.1, 0.4}, -1.3}};

/* What a file's record is. */
typedef struct record {
    stp_dvec3 own; /* in the scanner's coordinates */
    uint32_t column, row;
    bool is_near;
} record;

static double hit(double from, double way, double low, double high)
{
    return way > 0.0 ? (high - from) / way : way < 0.0 ? (low - from) / way : INFINITY;
}

/* A pixel in a room: steps of equal angles. near: so much of the distance. */
static record look(int scan, uint32_t column, uint32_t row, double near)
{
    const double a = column * 0.005, e = row * 0.005 - 0.25;
    const stp_dvec3 from = scanners[scan].place;
    const stp_dvec3 own = {cos(a) * cos(e), sin(a) * cos(e), sin(e)};
    const double c = cos(scanners[scan].turn), s = sin(scanners[scan].turn);
    const double x = c * own.x - s * own.y, y = s * own.x + c * own.y;
    const double t = fmin(hit(from.x, x, -4.0, 4.0),
                          fmin(hit(from.y, y, -3.0, 3.0), hit(from.z, own.z, -1.0, 2.0)));
    return (record){stp_dvec3_scale(own, near * t), column, row, near < 1.0};
}

/* Lists a scan's records: not row by row, each 97th is missing, the last ones of the first scan are
 * those of pixels that have one. Returns how many there are. */
static size_t list_records(int scan, record *out)
{
    size_t count = 0;
    for (uint32_t i = 0; i < PIXELS; i++) {
        const uint32_t pixel = i * 7919u % PIXELS;
        if (pixel % 97 != 5)
            out[count++] = look(scan, pixel % COLUMNS, pixel / COLUMNS, 1.0);
    }
    for (uint32_t i = 0; scan == 0 && i < DOUBLED; i++)
        out[count++] = look(scan, 3 + i, 2 * i, 0.8);
    return count;
}

static void add_scan(e57_file *file, int scan, const record *records, size_t count)
{
    char pose[600];
    const double half = 0.5 * scanners[scan].turn;
    e57_stream s[5] = {0};
    for (size_t i = 0; i < count; i++) {
        bytes_double(&s[0].bytes, records[i].own.x);
        bytes_double(&s[1].bytes, records[i].own.y);
        bytes_double(&s[2].bytes, records[i].own.z);
        bytes_integer(&s[3].bytes, records[i].row + FIRST_ROW, 2);
        bytes_integer(&s[4].bytes, records[i].column + FIRST_COLUMN, 2);
    }
    e57_vector(file, s, 5, false);
    snprintf(pose, sizeof pose,
             "<pose type=\"Structure\"><rotation type=\"Structure\"><w type=\"Float\">%.17g</w>"
             "<z type=\"Float\">%.17g</z></rotation><translation type=\"Structure\">"
             "<x type=\"Float\">%.17g</x><y type=\"Float\">%.17g</y><z type=\"Float\">%.17g</z>"
             "</translation></pose>",
             cos(half), sin(half), scanners[scan].place.x, scanners[scan].place.y,
             scanners[scan].place.z);
    e57_scan(file, pose, count,
             E57_FLOAT("cartesianX", "double") E57_FLOAT("cartesianY", "double")
                 E57_FLOAT("cartesianZ", "double") E57_INTEGER("rowIndex", "0", "65535")
                     E57_INTEGER("columnIndex", "0", "65535"));
    for (int i = 0; i < 5; i++)
        bytes_free(&s[i].bytes);
}

/* Writes the E57 file. all: the records of both scans. Returns their counts. */
static void write_e57(const char *path, record *all, size_t counts[SCANS])
{
    e57_file file;
    e57_begin(&file);
    for (int scan = 0; scan < SCANS; scan++, all += counts[scan - 1]) {
        counts[scan] = list_records(scan, all);
        add_scan(&file, scan, all, counts[scan]);
    }
    e57_end(&file, "");
    e57_write(path, &file);
    e57_free(&file);
}

/* Writes the PTX file: column by column, 0 0 0 where no record is. */
static void write_ptx(const char *path, record *all, size_t counts[SCANS])
{
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    for (int scan = 0; scan < SCANS; scan++) {
        const double c = cos(scanners[scan].turn), s = sin(scanners[scan].turn);
        const stp_dvec3 p = scanners[scan].place;
        fprintf(out, "%d\n%d\n%.17g %.17g %.17g\n%.17g %.17g 0\n%.17g %.17g 0\n0 0 1\n", COLUMNS,
                ROWS, p.x, p.y, p.z, c, s, -s, c);
        fprintf(out, "%.17g %.17g 0 0\n%.17g %.17g 0 0\n0 0 1 0\n%.17g %.17g %.17g 1\n", c, s, -s,
                c, p.x, p.y, p.z);
        counts[scan] = PIXELS;
        for (uint32_t i = 0; i < PIXELS; i++) {
            *all = look(scan, i / ROWS, i % ROWS, i % 97 == 5 ? 0.0 : 1.0);
            fprintf(out, "%.17g %.17g %.17g\n", all->own.x, all->own.y, all->own.z);
            all++;
        }
    }
    fclose(out);
}

/* A file that was read. */
typedef struct images {
    prep_cloud cloud;
    stp_dvec3 stations[SCANS];
    stp_prep_file file;
} images;

static images read_images(const char *path, size_t count)
{
    images out = {.cloud = prep_cloud_make(count)};
    const stp_scan_params params = {.keep_grid = true};
    stp_scan *scan = NULL;
    size_t got = 0, part = 1;
    stp_point *points = calloc(count, sizeof *points);
    assert_non_null(points);
    assert_int_equal(stp_scan_open(&scan, path, &params, NULL), STP_OK);
    const stp_scan_info *info = stp_scan_get_info(scan);
    assert_int_equal(info->point_count, count);
    assert_int_equal(info->image_count, SCANS);
    assert_int_equal(info->station_count, SCANS);
    out.file = (stp_prep_file){.name = path,
                               .point_count = count,
                               .image_count = SCANS,
                               .pixels_told = info->pixels_told,
                               .station_word = info->station_word,
                               .station_count = SCANS};
    out.file.images = calloc(SCANS, sizeof *out.file.images);
    assert_non_null(out.file.images);
    memcpy(out.file.images, info->images, SCANS * sizeof *out.file.images);
    memcpy(out.stations, info->stations, sizeof out.stations);
    for (; part > 0; got += part)
        assert_int_equal(stp_scan_read(scan, points + got, count - got, &part, NULL), STP_OK);
    assert_int_equal(got, count);
    for (size_t i = 0; i < count; i++) {
        out.cloud.points[i].position = points[i].position;
        out.cloud.points[i].station = points[i].station;
        out.cloud.points[i].reject = points[i].reject;
        out.cloud.points[i].pixel = points[i].pixel;
    }
    free(points);
    stp_scan_close(&scan);
    return out;
}

static void clear_images(images *m)
{
    free(m->cloud.points);
    free(m->file.images);
}

static void run(images *m, unsigned threads, stp_prep_stats *stats)
{
    const stp_prep_params params = {.codec = STP_CODEC_DRACO, .force = true};
    stp_pool *pool = NULL;
    stp_error err = {0};
    const stp_prep_source source = {.context = &m->cloud,
                                    .read = prep_cloud_read,
                                    .point_count = m->cloud.count,
                                    .attributes = STP_POINT_HAS_COLOUR | STP_POINT_HAS_CLASS |
                                                  STP_POINT_HAS_STATION,
                                    .stations = m->stations,
                                    .station_count = SCANS,
                                    .files = &m->file,
                                    .file_count = 1};
    m->cloud.given = 0;
    assert_int_equal(stp_pool_create(&pool, threads, &err), STP_OK);
    if (stp_prep_run(OUT, &source, &params, pool, NULL, stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_pool_destroy(&pool);
}

/* Counts a patch's samples, and checks their columns and rows, which may be swapped. What is in no
 * square is a later record of its pixel: a near one. Returns whether the patch is a square. */
static bool note_patch(const record *records, const stp_chunk *chunk, uint32_t p, uint8_t *seen)
{
    const stp_sample *samples = chunk->samples[0] + chunk->level_begin[0][p];
    const stp_square *square = chunk->squares ? &chunk->squares[p] : NULL;
    unsigned k = 0;
    for (unsigned i = 0; i < chunk->patches[p].counts[0]; i++) {
        const record *r = &records[prep_number_of(&samples[i])];
        seen[r - records]++;
        assert_true(square || r->is_near);
    }
    for (unsigned i = 0; square && i < 64; i++) {
        if (!(square->samples >> i & 1u))
            continue;
        const record *r = &records[prep_number_of(&samples[k++])];
        const uint32_t column = square->column * 8 + stp_square_column(i);
        const uint32_t row = square->row * 8 + stp_square_row(i);
        assert_true((column == r->column && row == r->row) ||
                    (column == r->row && row == r->column));
    }
    return square;
}

/* Verifies the file. Returns how many points lie in squares. */
static size_t read_back(const images *m, const record *records)
{
    uint8_t *seen = calloc(m->cloud.count, 1);
    size_t in_squares = 0;
    assert_non_null(seen);
    stp_chunk_file *file = prep_open_verified(OUT);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        for (uint32_t p = 0; entry.child_count == 0 && p < chunk->patch_count; p++)
            if (note_patch(records, chunk, p, seen))
                in_squares += chunk->patches[p].counts[0];
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    for (size_t i = 0; i < m->cloud.count; i++)
        assert_int_equal(seen[i], m->cloud.points[i].reject == STP_REJECT_NONE);
    free(seen);
    return in_squares;
}

/* Prepares a file's images with one and with three threads. doubled: records of pixels that have
 * one. */
static void check(const char *path, const record *records, const size_t counts[SCANS],
                  size_t doubled)
{
    images m = read_images(path, counts[0] + counts[1]);
    size_t stored = 0, sizes[2];
    uint8_t *bytes[2];
    for (size_t i = 0; i < m.cloud.count; i++)
        stored += m.cloud.points[i].reject == STP_REJECT_NONE;
    for (int i = 0; i < 2; i++) {
        stp_prep_stats stats;
        run(&m, i ? 3 : 1, &stats);
        assert_int_equal(stats.images, SCANS);
        assert_int_equal(stats.pixels_loose, doubled);
        bytes[i] = prep_file_bytes(OUT, &sizes[i]);
    }
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(bytes[0], bytes[1], sizes[0]);
    const size_t in_squares = read_back(&m, records);
    print_message("%s: %zu of %zu points in squares, %.2f bytes each\n", path, in_squares, stored,
                  (double)sizes[0] / (double)stored);
    assert_int_equal(in_squares, stored - doubled);
    free(bytes[0]);
    free(bytes[1]);
    clear_images(&m);
}

static record *records_of_all(void)
{
    record *out = calloc(SCANS * PIXELS + DOUBLED, sizeof *out);
    assert_non_null(out);
    return out;
}

static void scans_of_an_e57(void **state)
{
    record *records = records_of_all();
    size_t counts[SCANS];
    (void)state;
    write_e57("images.e57", records, counts);
    images m = read_images("images.e57", counts[0] + counts[1]);
    assert_true(m.file.pixels_told);
    for (int scan = 0; scan < SCANS; scan++) {
        const stp_scan_image *image = &m.file.images[scan];
        assert_int_equal(image->first, scan ? counts[0] : 0);
        assert_int_equal(image->count, counts[scan]);
        assert_int_equal(image->columns, COLUMNS);
        assert_int_equal(image->rows, ROWS);
        assert_int_equal(image->station, scan + 1);
    }
    for (size_t i = 0; i < m.cloud.count; i++)
        assert_int_equal(m.cloud.points[i].pixel, records[i].row * COLUMNS + records[i].column);
    clear_images(&m);
    check("images.e57", records, counts, DOUBLED);
    free(records);
}

static void scans_of_a_ptx(void **state)
{
    record *records = records_of_all();
    size_t counts[SCANS];
    (void)state;
    write_ptx("images.ptx", records, counts);
    check("images.ptx", records, counts, 0);
    free(records);
}

static void no_images_unless_wanted(void **state)
{
    static const char *const paths[2] = {"images.e57", "images.ptx"};
    (void)state;
    for (int i = 0; i < 2; i++) {
        stp_scan *scan = NULL;
        assert_int_equal(stp_scan_open(&scan, paths[i], NULL, NULL), STP_OK);
        assert_int_equal(stp_scan_get_info(scan)->image_count, 0);
        assert_false(stp_scan_get_info(scan)->pixels_told);
        stp_scan_close(&scan);
    }
}

/* Writes a scan as a binary PCD file, which is no image; the scanner is at 4 4 4. */
static void write_pcd(const char *path, const record *records, size_t count)
{
    char header[300];
    byte_row bytes = {0};
    snprintf(header, sizeof header,
             "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH %zu\nHEIGHT 1\n"
             "VIEWPOINT 4 4 4 1 0 0 0\nPOINTS %zu\nDATA binary\n",
             count, count);
    bytes_text(&bytes, header);
    for (size_t i = 0; i < count; i++) {
        bytes_float(&bytes, (float)records[i].own.x + 4.0f);
        bytes_float(&bytes, (float)records[i].own.y + 4.0f);
        bytes_float(&bytes, (float)records[i].own.z + 4.0f);
    }
    scan_fixture_bytes(path, bytes.data, bytes.size);
    bytes_free(&bytes);
}

/* With three names, writes files there, for tests that run the program. */
static int write_files(char **paths)
{
    record *records = records_of_all();
    size_t counts[SCANS];
    write_e57(paths[0], records, counts);
    write_ptx(paths[1], records, counts);
    write_pcd(paths[2], records, counts[0]);
    free(records);
    return 0;
}

int main(int argc, char **argv)
{
    if (argc == 4)
        return write_files(argv + 1);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scans_of_an_e57),
        cmocka_unit_test(scans_of_a_ptx),
        cmocka_unit_test(no_images_unless_wanted),
    };
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
