/* Runs every real scan through the program. It must be read, or refused with the right sentence.
 * Counts must equal those of the file's own header and of another reader. `export` must give
 * surveys back point by point. This test reads headers, records and exported points itself, by the
 * formats' tables. Skips unless STIPPLE_SCANS names a folder of scans: the project may not
 * distribute them. */
#include "tests/fixtures/byte_fixture.h"
#include "tests/fixtures/scan/scan_fixture.h"

#include <math.h>
#include <stdbool.h>
#include <sys/wait.h>

/* How the points of a survey are compared, one by one. */
typedef enum survey {
    NO_SURVEY,
    LAS_EXACT,     /* rounded to the header's scale, the points equal the records */
    LAS_NEAR,      /* each point is less than the scale from a record of its own (SPEC: bounds) */
    PCD_HUNDREDTHS /* floats that are hundredths */
} survey;

typedef struct real_file {
    const char *name;
    uint64_t points, no_return, not_finite, invalid; /* counted by another reader */
    survey survey;
    const char *refused; /* part of the sentence; NULL: the file is read */
    bool large;          /* left to long_scan_table.sh: a smaller file is of the same kind */
} real_file;

#define COLOURS "is a picture of colours (3 channels), not of heights"

static const real_file files[] = {
    {"stanford-dragon/dragon_vrip.ply", 437645, 0, 0, 0, NO_SURVEY, NULL, true},
    {"stanford/bunny_raw10_362k_n_bigendian.ply", 362272, 0, 0, 0, NO_SURVEY, NULL, true},
    {"stanford/bun_zipper.ply", 35947, 0, 0, 0, NO_SURVEY, NULL, false},
    {"stanford/bun000.ply", 40256, 0, 0, 0, NO_SURVEY, NULL, false},
    {"lion/lion_takanawa_342k_rgb_n.ply", 341989, 0, 0, 0, NO_SURVEY, NULL, true},
    {"objects/armadillo.obj", 43243, 0, 0, 0, NO_SURVEY, NULL, false},
    {"meshlab-rangemaps/lato315.ply", 62702, 0, 0, 0, NO_SURVEY, NULL, false},
    {"open3d/fragment.pcd", 113662, 0, 0, 0, NO_SURVEY, NULL, false},
    {"rooms/room-3.23M-rgb.ply", 3234126, 0, 0, 0, NO_SURVEY, NULL, true},
    {"grids/milk_cartoon_all_small_clorox.pcd", 307200, 65793, 0, 0, NO_SURVEY, NULL, false},
    {"grids/office1.pcd", 307200, 52744, 0, 0, NO_SURVEY, NULL, true},
    {"tree/eztree_oak_large.obj", 30104, 0, 0, 0, NO_SURVEY, NULL, false},
    {"tree/tls-spruce-83k.las", 83392, 0, 0, 0, LAS_EXACT, NULL, false},
    {"lidar/autzen_trim_7.las", 110000, 0, 0, 0, LAS_EXACT, NULL, false},
    {"lidar/CSite2_orig-utm.pcd", 486800, 0, 0, 0, PCD_HUNDREDTHS, NULL, true},
    {"lidar/FSite8_orig-utm.pcd", 345966, 0, 0, 0, PCD_HUNDREDTHS, NULL, false},
    {"autzen/autzen-10.65M-rgb-pf2.las", 10653336, 0, 0, 0, LAS_EXACT, NULL, true},
    {"odd/pdal_1.2-with-color.las", 1065, 0, 0, 0, LAS_NEAR, NULL, false},
    {"odd/pdal_extrabytes.las", 1065, 0, 0, 0, LAS_NEAR, NULL, false},
    {"odd/ColouredCubeFloat.e57", 7680, 0, 0, 0, NO_SURVEY, NULL, false},
    {"odd/bunny_nan_inf_dup.ply", 42947, 0, 300, 0, NO_SURVEY, NULL, false},
    {"odd/pdal_autzen.pts", 10, 0, 0, 0, NO_SURVEY, NULL, false},
    {"odd/pdal_simple_binary.ply", 3, 0, 0, 0, NO_SURVEY, NULL, false},
    {"odd/pdal_simple_text.ply", 3, 0, 0, 0, NO_SURVEY, NULL, false},
    {"odd/empty.ply", 0, 0, 0, 0, NO_SURVEY, "has no points: there is nothing to write", false},
    {"odd/pdal_no-points.las", 0, 0, 0, 0, NO_SURVEY, "has no points: there is nothing to write",
     false},
    {"odd/pdal_epsg_4326.las", 5380, 0, 0, 0, NO_SURVEY, NULL, false},
    {"odd/bunny16k.pts", 16130, 0, 0, 0, NO_SURVEY, NULL, false},
    {"grids/al3d-1.al3d", 59200, 0, 0, 0, NO_SURVEY, NULL, false},
    {"grids/al3d-1_depth_m.pfm", 59200, 0, 0, 0, NO_SURVEY, NULL, false},
    {"grids/al3d-1_texture.png", 59200, 0, 0, 0, NO_SURVEY, COLOURS, false},
    {"grids/aloeGT_disparity.png", 1423020, 0, 0, 0, NO_SURVEY, NULL, true},
    {"grids/aloeL.jpg", 0, 0, 0, 0, NO_SURVEY,
     "(JPEG), which is not read here: heights are read as TIFF", false},
    {"grids/qgis_dem_f32.tif", 130550, 0, 0, 0, NO_SURVEY, NULL, false},
    {"grids/tum_color.png", 307200, 0, 0, 0, NO_SURVEY, COLOURS, false},
    {"grids/tum_depth16.png", 307200, 0, 0, 58950, NO_SURVEY, NULL, false},
};

/* A point on its survey's own grid, with a colour of 8 bits. */
typedef struct grid_point {
    int32_t at[3];
    uint8_t rgb[4]; /* the last is zero */
} grid_point;

typedef struct grid_points {
    grid_point *list;
    size_t count;
} grid_points;

static byte_row read_file(const char *path)
{
    byte_row out = {0};
    out.data = scan_fixture_load(path, &out.size);
    return out;
}

static uint64_t integer_at(const byte_row *file, size_t at, size_t bytes)
{
    uint64_t value = 0;
    assert_true(at + bytes <= file->size);
    for (size_t i = 0; i < bytes; i++)
        value |= (uint64_t)file->data[at + i] << (8 * i);
    return value;
}

static double double_at(const byte_row *file, size_t at)
{
    const uint64_t bits = integer_at(file, at, 8);
    double value;
    memcpy(&value, &bits, sizeof value);
    return value;
}

/* Finds a text in the file's header; NULL: it is not there. */
static const char *find(const byte_row *file, const char *text)
{
    const size_t look = file->size < 4000 ? file->size : 4000;
    return memmem(file->data, look, text, strlen(text));
}

static uint64_t number_after(const byte_row *file, const char *text)
{
    const char *at = find(file, text);
    if (!at) {
        fail_msg("no `%s`", text);
        return 0;
    }
    return strtoull(at + strlen(text), NULL, 10);
}

static bool ends_with(const char *path, const char *ending)
{
    const size_t length = strlen(path), part = strlen(ending);
    return length >= part && strcmp(path + length - part, ending) == 0;
}

static uint64_t count_lines_of(const byte_row *file, const char *begin)
{
    uint64_t count = 0;
    const char *at = (const char *)file->data;
    for (; at; at = strchr(at, '\n'), at = at ? at + 1 : NULL)
        count += strncmp(at, begin, strlen(begin)) == 0;
    return count;
}

/* Counts the records in the XML that the header names, without the checksums of the XML's pages. */
static uint64_t count_e57(const byte_row *file)
{
    static const char attribute[] = "recordCount=\"";
    const size_t length = integer_at(file, 32, 8);
    char *text = calloc(length + 1, 1);
    uint64_t count = 0;
    assert_non_null(text);
    for (size_t i = 0, at = integer_at(file, 24, 8); i < length; i++, at++) {
        at += at % 1024 == 1020 ? 4 : 0;
        text[i] = (char)integer_at(file, at, 1);
    }
    for (const char *at = text; (at = strstr(at, attribute)) != NULL;) {
        at += strlen(attribute);
        count += strtoull(at, NULL, 10);
    }
    free(text);
    return count;
}

static uint64_t big_endian(const byte_row *file, size_t at)
{
    uint64_t value = 0;
    for (size_t i = 0; i < 4; i++)
        value = value << 8 | file->data[at + i];
    return value;
}

/* The number of a tag of an AL3D file: 20 bytes of its name, then 30 of its value. */
static uint64_t text_at(const byte_row *file, const char *name)
{
    size_t at = 17;
    while (at + 52 < file->size && strcmp((const char *)file->data + at, name) != 0)
        at += 52;
    return strtoull((const char *)file->data + at + 20, NULL, 10);
}

/* Width times height of a TIFF's first image: tags 256 and 257, of 16 or 32 bits, little-endian. */
static uint64_t count_tiff(const byte_row *file)
{
    const size_t begin = integer_at(file, 4, 4), tags = integer_at(file, begin, 2);
    uint64_t count = 1;
    for (size_t i = 0; i < tags; i++) {
        const size_t tag = begin + 2 + 12 * i, type = integer_at(file, tag + 2, 2);
        if (integer_at(file, tag, 2) == 256 || integer_at(file, tag, 2) == 257)
            count *= integer_at(file, tag + 8, type == 3 ? 2 : 4);
    }
    return count;
}

/* The number of points by the file's own header. */
static uint64_t own_count(const char *path, const byte_row *file)
{
    if (ends_with(path, ".ply"))
        return number_after(file, "element vertex ");
    if (ends_with(path, ".pcd"))
        return number_after(file, "\nPOINTS ");
    if (ends_with(path, ".las"))
        return file->data[25] >= 4 ? integer_at(file, 247, 8) : integer_at(file, 107, 4);
    if (ends_with(path, ".obj"))
        return count_lines_of(file, "v ");
    if (ends_with(path, ".e57"))
        return count_e57(file);
    if (ends_with(path, ".png"))
        return big_endian(file, 16) * big_endian(file, 20);
    if (ends_with(path, ".tif"))
        return count_tiff(file);
    if (ends_with(path, ".pfm"))
        return number_after(file, "Pf\n") * number_after(file, "Pf\n200 ");
    if (ends_with(path, ".al3d"))
        return text_at(file, "Cols") * text_at(file, "Rows");
    if (file->data[0] == '[') /* Expe's surfels */
        return number_after(file, "\nnofpoints ");
    return strtoull((const char *)file->data, NULL, 10); /* PTS */
}

/* Reads the records; colours have 8 bits: values above 255 are stored times 256. */
static grid_points las_records(const byte_row *file)
{
    static const size_t rgb_at[] = {0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
    const size_t begin = integer_at(file, 96, 4), length = integer_at(file, 105, 2);
    const size_t rgb = rgb_at[file->data[104]];
    const size_t count = own_count("a.las", file);
    grid_points out = {calloc(count + 1, sizeof *out.list), count};
    unsigned greatest = 0;
    assert_non_null(out.list);
    for (size_t i = 0; rgb && i < 3 * count; i++) {
        const unsigned c = (unsigned)integer_at(file, begin + i / 3 * length + rgb + i % 3 * 2, 2);
        greatest = c > greatest ? c : greatest;
    }
    for (size_t i = 0; i < 3 * count; i++) {
        const size_t record = begin + i / 3 * length;
        out.list[i / 3].at[i % 3] = (int32_t)(uint32_t)integer_at(file, record + i % 3 * 4, 4);
        if (rgb)
            out.list[i / 3].rgb[i % 3] = (uint8_t)(integer_at(file, record + rgb + i % 3 * 2, 2) >>
                                                   (greatest > 255 ? 8 : 0));
    }
    return out;
}

/* Decodes LZF: runs of literals, and copies of what came before. */
static byte_row decode_lzf(const unsigned char *in, size_t in_size, size_t out_size)
{
    byte_row out = {.data = calloc(out_size + 300, 1)};
    const unsigned char *end = in + in_size;
    assert_non_null(out.data);
    while (in < end && out.size < out_size) {
        const size_t control = *in++;
        size_t length = control < 32 ? control + 1 : (control >> 5) + 2;
        if (control < 32) {
            memcpy(out.data + out.size, in, length);
            in += length;
            out.size += length;
            continue;
        }
        if (length == 9)
            length += *in++;
        const size_t back = ((control & 31) << 8) + *in++ + 1;
        assert_true(back <= out.size && out.size + length <= out_size + 264);
        for (; length > 0; length--, out.size++)
            out.data[out.size] = out.data[out.size - back];
    }
    assert_int_equal(out.size, out_size);
    return out;
}

/* Reads compressed floats of all x, then all y, then all z; keeps their bits. */
static grid_points pcd_floats(const byte_row *file)
{
    static const char data[] = "\nDATA binary_compressed\n";
    const size_t count = own_count("a.pcd", file);
    const char *end = find(file, data);
    assert_non_null(end);
    const size_t begin = (size_t)(end - (const char *)file->data) + strlen(data);
    assert_int_equal(integer_at(file, begin + 4, 4), 12 * count);
    byte_row xyz = decode_lzf(file->data + begin + 8, integer_at(file, begin, 4), 12 * count);
    grid_points out = {calloc(count + 1, sizeof *out.list), count};
    assert_non_null(out.list);
    for (size_t i = 0; i < 3 * count; i++)
        out.list[i % count].at[i / count] = (int32_t)(uint32_t)integer_at(&xyz, 4 * i, 4);
    bytes_free(&xyz);
    return out;
}

/* The exported PLY file. Its vertices begin with the position; colours are optional. */
typedef struct exported {
    byte_row file;
    bool is_double;
    size_t begin, stride, rgb; /* rgb 0: none */
    size_t count;
} exported;

static exported open_exported(const char *path)
{
    exported out = {.file = read_file(path)};
    const char *end = find(&out.file, "end_header\n");
    assert_non_null(end);
    out.begin = (size_t)(end - (const char *)out.file.data) + strlen("end_header\n");
    out.count = number_after(&out.file, "element vertex ");
    out.is_double = find(&out.file, "property double x\n") != NULL;
    const struct {
        const char *text;
        size_t bytes;
    } properties[] = {{"property double x\n", 24},        {"property float x\n", 12},
                      {"property float nx\n", 12},        {"property uchar red\n", 3},
                      {"property ushort intensity\n", 2}, {"property uchar classification\n", 1}};
    for (size_t i = 0; i < sizeof properties / sizeof *properties; i++) {
        if (!find(&out.file, properties[i].text))
            continue;
        out.rgb = properties[i].bytes == 3 ? out.stride : out.rgb;
        out.stride += properties[i].bytes;
    }
    assert_int_equal(out.file.size, out.begin + out.count * out.stride);
    return out;
}

static double coordinate(const exported *e, size_t point, int axis)
{
    const size_t at = e->begin + point * e->stride;
    if (e->is_double)
        return double_at(&e->file, at + 8 * (size_t)axis);
    const uint32_t bits = (uint32_t)integer_at(&e->file, at + 4 * (size_t)axis, 4);
    float value;
    memcpy(&value, &bits, sizeof value);
    return (double)value;
}

/* Puts the exported points on the source's grid. */
static grid_points on_grid(const char *name, const exported *e, const byte_row *source, survey kind)
{
    grid_points out = {calloc(e->count, sizeof *out.list), e->count};
    assert_non_null(out.list);
    for (size_t i = 0; i < e->count; i++) {
        for (int axis = 0; axis < 3; axis++) {
            const double value = coordinate(e, i, axis);
            if (kind == PCD_HUNDREDTHS) {
                const float nearest = (float)(round(value * 100.0) / 100.0);
                memcpy(&out.list[i].at[axis], &nearest, sizeof nearest);
                continue;
            }
            const double scale = double_at(source, 131 + 8 * (size_t)axis);
            const double steps = (value - double_at(source, 155 + 8 * (size_t)axis)) / scale;
            out.list[i].at[axis] = (int32_t)lround(steps);
            if (kind == LAS_EXACT && !(fabs(steps - round(steps)) < 0.49))
                fail_msg("%s: point %zu is %g steps from the next one", name, i,
                         steps - round(steps));
        }
        if (e->rgb)
            memcpy(out.list[i].rgb, e->file.data + e->begin + i * e->stride + e->rgb, 3);
    }
    return out;
}

static int compare_points(const void *a, const void *b)
{
    return memcmp(a, b, sizeof(grid_point));
}

static void expect_same(const char *name, grid_points *a, grid_points *b)
{
    assert_int_equal(a->count, b->count);
    qsort(a->list, a->count, sizeof *a->list, compare_points);
    qsort(b->list, b->count, sizeof *b->list, compare_points);
    for (size_t i = 0; i < a->count; i++)
        if (compare_points(&a->list[i], &b->list[i]) != 0)
            fail_msg("%s: of the exported points the %zuth, sorted, is not the source's", name, i);
}

/* Each exported point must find a record of its colour less than a step away; takes the record. */
static void expect_near(const char *name, const exported *e, const byte_row *source,
                        grid_points *records)
{
    for (size_t i = 0; i < e->count; i++) {
        size_t k = 0;
        for (; k < records->count; k++) {
            const grid_point *record = &records->list[k];
            bool near =
                memcmp(record->rgb, e->file.data + e->begin + i * e->stride + e->rgb, 3) == 0;
            for (int axis = 0; axis < 3 && near; axis++) {
                const double scale = double_at(source, 131 + 8 * (size_t)axis);
                const double offset = double_at(source, 155 + 8 * (size_t)axis);
                near = fabs(coordinate(e, i, axis) - record->at[axis] * scale - offset) < scale;
            }
            if (near)
                break;
        }
        if (k == records->count)
            fail_msg("%s: exported point %zu is none of the source's", name, i);
        records->list[k] = records->list[--records->count];
    }
    assert_int_equal(records->count, 0);
}

static void check_survey(const real_file *expected, const byte_row *source, const exported *e)
{
    if (expected->survey == NO_SURVEY)
        return;
    grid_points records =
        expected->survey == PCD_HUNDREDTHS ? pcd_floats(source) : las_records(source);
    if (expected->survey == LAS_NEAR) {
        expect_near(expected->name, e, source, &records);
    } else {
        grid_points points = on_grid(expected->name, e, source, expected->survey);
        expect_same(expected->name, &records, &points);
        free(points.list);
    }
    free(records.list);
}

/* Returns the program's exit code; its output goes into the file `said`. */
static int run(const char *arguments, const char *path)
{
    char command[10000];
    snprintf(command, sizeof command, "'%s' %s %s >said 2>&1", getenv("STIPPLE"), arguments, path);
    const int status = system(command);
    assert_true(WIFEXITED(status));
    return WEXITSTATUS(status);
}

static void check_refused(const real_file *expected, const char *path)
{
    const int code = run("prep -o m.stipple --quiet", path);
    byte_row said = read_file("said");
    const char *text = (const char *)said.data;
    if (code != 1 || !strstr(text, expected->refused) || !strstr(text, expected->name) ||
        strchr(text, '\n') != text + said.size - 1)
        fail_msg("%s: exit %d, expected 1 and `%s`: %s", expected->name, code, expected->refused,
                 text);
    assert_int_not_equal(access("m.stipple", F_OK), 0);
    bytes_free(&said);
}

static void check_read(const real_file *expected, const char *path)
{
    const uint64_t stored =
        expected->points - expected->no_return - expected->not_finite - expected->invalid;
    byte_row source = read_file(path);
    assert_int_equal(own_count(path, &source), expected->points);
    if (run("prep -o m.stipple --sample none --force --quiet --stats stats.json --rejects "
            "rejects.csv",
            path) ||
        run("export --force --quiet -o m.ply", "m.stipple"))
        fail_msg("%s: %s", expected->name, (const char *)read_file("said").data);
    byte_row stats = read_file("stats.json"), rejects = read_file("rejects.csv");
    assert_int_equal(number_after(&stats, "\"points_in\":"), expected->points);
    assert_int_equal(number_after(&stats, "\"points_out\":"), stored);
    assert_int_equal(number_after(&stats, "\"no_return\":"), expected->no_return);
    assert_int_equal(number_after(&stats, "\"not_finite\":"), expected->not_finite);
    assert_int_equal(number_after(&stats, "\"invalid\":"), expected->invalid);
    assert_int_equal(count_lines_of(&rejects, "\""), expected->points - stored);
    exported e = open_exported("m.ply");
    assert_int_equal(e.count, stored);
    check_survey(expected, &source, &e);
    bytes_free(&e.file);
    bytes_free(&stats);
    bytes_free(&rejects);
    bytes_free(&source);
    remove("m.stipple");
}

static void every_file(void **state)
{
    const bool *large = *state;
    for (size_t i = 0; i < sizeof files / sizeof *files; i++) {
        char path[4096];
        if (files[i].large != *large || !scan_fixture_real(files[i].name, path))
            continue;
        if (files[i].refused)
            check_refused(&files[i], path);
        else
            check_read(&files[i], path);
    }
}

/* With the argument `large` tests the large files alone, otherwise all others. */
int main(int argc, char **argv)
{
    bool large = argc > 1 && strcmp(argv[1], "large") == 0;
    const struct CMUnitTest tests[] = {cmocka_unit_test_prestate(every_file, &large)};
    if (!scan_fixture_has_real())
        return 77;
    if (!getenv("STIPPLE")) {
        puts("skipped: STIPPLE names no program");
        return 77;
    }
    return cmocka_run_group_tests(tests, scan_fixture_enter, scan_fixture_leave);
}
