/* Tests points beyond 2^32: points and records of a small cloud are numbered from there on, or from
 * shortly before, so that every number that counts all points passes 2^32. The file must have the
 * bytes that it has with numbers from 0. */
#include "formats/scan/source.h"
#include "preprocess/orient/sheets.h"
#include "tests/fixtures/prep_fixture.h"
#include "tests/fixtures/rank_pipes.h"

#include <signal.h>

#define OUT "test_offsets.stipple"
#define POINTS 72000u
#define STRAYS 40u
#define COLUMNS 160u
#define ROWS 120u

/* Where numbers begin: the cloud passes 2^32, or lies beyond. */
static const uint64_t firsts[] = {(UINT64_C(1) << 32) - 1000, UINT64_C(1) << 33};
#define FIRST_COUNT (sizeof firsts / sizeof *firsts)

/* A source of points in memory, which each have their number as an attribute. */
typedef struct input {
    prep_cloud cloud;
    uint32_t *numbers, *next;
    size_t end;
    bool normals, is_image; /* normals are told; the records are an image's */
    uint64_t rejected,
        sum; /* records that were told to be rejected, and the sum of their numbers */
} input;

static stp_status read_input(void *context, stp_point *points, size_t capacity, size_t *count,
                             stp_error *err)
{
    input *in = context;
    (void)err;
    const size_t left = in->end - in->cloud.given;
    *count = left < capacity ? left : capacity;
    memcpy(points, in->cloud.points + in->cloud.given, *count * sizeof *points);
    for (size_t i = 0; i < *count && !in->normals; i++)
        points[i].normal = (vec3s){{0.0f, 0.0f, 0.0f}};
    in->next = in->numbers + in->cloud.given;
    in->cloud.given += *count;
    return STP_OK;
}

static const uint8_t *numbers_of(void *context)
{
    return (const uint8_t *)((input *)context)->next;
}

/* An image is read by one rank. */
static uint64_t part_begin(void *context, uint64_t place)
{
    const input *in = context;
    return in->is_image ? 0 : place;
}

static stp_status read_part(void *context, uint64_t begin, uint64_t end, stp_error *err)
{
    input *in = context;
    (void)err;
    in->cloud.given = (size_t)begin;
    in->end = end < in->cloud.count ? (size_t)end : in->cloud.count;
    return STP_OK;
}

static stp_status note_reject(void *context, uint64_t place, stp_reject reason, stp_error *err)
{
    input *in = context;
    (void)reason;
    (void)err;
    in->rejected++;
    in->sum += place;
    return STP_OK;
}

/* One way to prepare the input. */
typedef struct run {
    input *in;
    stp_prep_params params;
    unsigned threads;
    bool kept; /* numbers of the input are */
    bool told; /* the records of an image tell their pixels */
    const stp_dvec3 *stations;
    stp_prep_stats stats;
} run;

static stp_status prepare(run *r, stp_error *err)
{
    static const stp_attribute_list kept = {
        .items = {{.name = "number", .type = STP_ATTRIBUTE_U32, .scale = 1.0}}, .count = 1};
    stp_scan_image image = {
        .count = r->in->cloud.count, .columns = COLUMNS, .rows = ROWS, .station = 1};
    stp_prep_file file = {.name = "a known surface",
                          .point_count = r->in->cloud.count,
                          .pixels_told = r->told,
                          .station_count = r->stations ? 1 : 0};
    if (r->told) {
        file.images = &image;
        file.image_count = 1;
    } else if (r->in->is_image) {
        file.grid = (stp_scan_grid){.columns = COLUMNS, .rows = ROWS};
    }
    const stp_prep_source source = {.context = r->in,
                                    .read = read_input,
                                    .part_begin = part_begin,
                                    .read_part = read_part,
                                    .rejected = note_reject,
                                    .kept = r->kept ? &kept : NULL,
                                    .numbers = numbers_of,
                                    .point_count = r->in->cloud.count,
                                    .attributes = STP_POINT_HAS_COLOUR | STP_POINT_HAS_INTENSITY |
                                                  (r->in->normals ? STP_POINT_HAS_NORMAL : 0u) |
                                                  (r->stations ? STP_POINT_HAS_STATION : 0u),
                                    .stations = r->stations,
                                    .station_count = r->stations ? 1 : 0,
                                    .files = &file,
                                    .file_count = 1};
    stp_pool *pool = NULL;
    r->in->cloud.given = 0;
    r->in->end = r->in->cloud.count;
    r->in->rejected = r->in->sum = 0;
    r->params.force = true;
    r->stats = (stp_prep_stats){0};
    stp_status status = stp_pool_create(&pool, r->threads, err);
    if (status == STP_OK)
        status = stp_prep_run(OUT, &source, &r->params, pool, NULL, &r->stats, err);
    stp_pool_destroy(&pool);
    return status;
}

/* A wavy closed surface with some noise, equal points, and a few points far away. */
static input make_input(double noise)
{
    input in = {.cloud = prep_cloud_wavy(POINTS, (stp_dvec3){1000.0, 2000.0, 30.0}, 10.0)};
    in.numbers = malloc(POINTS * sizeof *in.numbers);
    assert_non_null(in.numbers);
    for (uint32_t i = 0; i < POINTS; i++) {
        stp_point *p = &in.cloud.points[i];
        in.numbers[i] = 7 * i;
        p->station = 1;
        p->position.x += noise * (stp_random_unit(3, i) - 0.5);
        p->position.y += noise * (stp_random_unit(4, i) - 0.5);
        p->position.z += noise * (stp_random_unit(5, i) - 0.5);
        if (i % (POINTS / STRAYS) == 7)
            p->position.z += 5.0 + 20.0 * stp_random_unit(6, i);
        if (i % 1000 == 1)
            p->position = in.cloud.points[i - 1].position;
        const vec3s out =
            stp_dvec3_to_float(stp_dvec3_sub(p->position, (stp_dvec3){1000.0, 2000.0, 30.0}));
        p->normal = glms_vec3_normalize(out);
        for (int a = 0; a < 3; a++)
            p->normal.raw[a] += 0.4f * (float)(stp_random_unit(7 + (uint64_t)a, i) - 0.5);
    }
    return in;
}

static void free_input(input *in)
{
    free(in->cloud.points);
    free(in->numbers);
}

/* The file's hash would do, but bytes tell where they differ. */
static void compare(const uint8_t *bytes, size_t size, uint64_t first, const char *what)
{
    size_t other_size = 0;
    uint8_t *other = prep_file_bytes(OUT, &other_size);
    if (size != other_size || memcmp(bytes, other, size) != 0)
        fail_msg("%s: another file if numbers begin at %llu", what, (unsigned long long)first);
    free(other);
}

/* Prepares with numbers from 0 and from each of `firsts`. */
static void check(run *r, const char *what)
{
    stp_error err = {0};
    size_t size = 0;
    r->params.first_place = 0;
    if (prepare(r, &err) != STP_OK)
        fail_msg("%s: %s", what, err.message);
    uint8_t *bytes = prep_file_bytes(OUT, &size);
    const run zero = *r;
    const uint64_t rejected = r->in->rejected, sum = r->in->sum;
    for (size_t i = 0; i < FIRST_COUNT; i++) {
        r->params.first_place = firsts[i];
        if (prepare(r, &err) != STP_OK)
            fail_msg("%s from %llu: %s", what, (unsigned long long)firsts[i], err.message);
        compare(bytes, size, firsts[i], what);
        assert_int_equal(r->stats.points_out, zero.stats.points_out);
        assert_int_equal(r->stats.closed_count, zero.stats.closed_count);
        assert_int_equal(r->stats.outlier_count, zero.stats.outlier_count);
        assert_int_equal(r->in->rejected, rejected);
        assert_int_equal(r->in->sum, sum);
    }
    free(bytes);
    stp_chunk_file *file = prep_open_verified_of(OUT, what);
    stp_chunk_file_close(&file);
    *r = zero;
}

/* Signs that spread, closed surfaces, crumbs, attributes. */
static void spread_signs(void **state)
{
    (void)state;
    input in = make_input(0.15);
    run r = {.in = &in, .threads = 2, .kept = true};
    check(&r, "signs that spread");
    assert_true(r.stats.closed_count > POINTS / 2);
    r.params.orient = STP_ORIENT_NONE;
    check(&r, "no signs");
    free_input(&in);
}

/* Normals of the input, which are noisy, and a scanner's position. */
static void told_signs(void **state)
{
    (void)state;
    input in = make_input(0.05);
    run r = {.in = &in, .threads = 2};
    in.normals = true;
    check(&r, "normals of the input");
    assert_true(r.stats.normals_wide.averaged > 0);
    in.normals = false;
    r.params.orient = STP_ORIENT_POSITION;
    r.params.orient_position = (stp_dvec3){1000.0, 2000.0, 90.0};
    check(&r, "a scanner's position");
    r.params.orient = STP_ORIENT_AUTO;
    r.stations = &r.params.orient_position;
    check(&r, "a station");
    assert_int_equal(r.stats.station_count, 1);
    free_input(&in);
}

/* Outliers are marked or dropped, layers joined. */
static void treated_points(void **state)
{
    (void)state;
    input in = make_input(0.1);
    run r = {.in = &in, .threads = 2, .params.outliers = STP_OUTLIERS_MARK};
    check(&r, "marked outliers");
    assert_in_range(r.stats.outlier_count, STRAYS / 2, POINTS / 2);
    r.params.outliers = STP_OUTLIERS_DROP;
    check(&r, "dropped outliers");
    assert_true(in.rejected > 0);
    r.params.outliers = STP_OUTLIERS_KEEP;
    r.params.join_layers = true;
    check(&r, "joined layers");
    free_input(&in);
}

/* More points at one position than a cell has, which only their records put in order, and lists of
 * 64 neighbours, in temporary files. */
static void piles_in_files(void **state)
{
    (void)state;
    input in = make_input(0.0);
    for (uint32_t i = 0; i < 70000; i++)
        in.cloud.points[i].position = (stp_dvec3){1003.0, 2004.0, 31.0};
    run r = {.in = &in, .threads = 1, .kept = true};
    r.params.neighbour_count = 64;
    r.params.memory_bytes = UINT64_C(90) << 20;
    r.params.temp_folder = ".";
    check(&r, "a pile in temporary files");
    assert_true(r.stats.temporary_bytes > 0);
    free_input(&in);
}

/* A ball before a wall, as a depth camera sees them, with noise. shuffled: records are in another
 * order than pixels. */
static input make_image(stp_dvec3 station, bool shuffled)
{
    const uint32_t count = COLUMNS * ROWS;
    input in = {.cloud = prep_cloud_make(count),
                .numbers = malloc(count * sizeof *in.numbers),
                .is_image = true};
    assert_non_null(in.numbers);
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t pixel = shuffled ? (uint32_t)((uint64_t)i * 7919 % count) : i;
        const double x = (pixel % COLUMNS - 80.0) / 140.0, y = (pixel / COLUMNS - 60.0) / 140.0;
        double z = x * x + y * y < 0.06 ? 4.0 - sqrt(1.0 - 10.0 * (x * x + y * y)) : 5.0;
        z += 0.03 * z * (stp_random_unit(5, i) - 0.5);
        in.numbers[i] = i;
        in.cloud.points[i].position = stp_dvec3_add(station, (stp_dvec3){x * z, y * z, z});
        in.cloud.points[i].station = 1;
        in.cloud.points[i].pixel = pixel;
    }
    return in;
}

/* Records that are the pixels of an image. */
static void pixels(void **state)
{
    (void)state;
    const stp_dvec3 station = {10.0, 20.0, 3.0};
    for (int told = 0; told < 2; told++) {
        input in = make_image(station, told);
        run r = {.in = &in, .threads = 1, .kept = true, .told = told, .stations = &station};
        check(&r, told ? "pixels that are told" : "pixels in order");
        assert_true(r.stats.normals_seen > 0);
        assert_int_equal(r.stats.images, 1);
        free_input(&in);
    }
}

/* Pieces are numbered with 32 bits, but have more points. */
static void many_pieces(void **state)
{
    (void)state;
    stp_error err = {0};
    stp_cell cells[2] = {{0}};
    stp_cloud cloud = {.cells = cells, .cell_count = 2};
    stp_graph *graphs = calloc(2, sizeof *graphs);
    stp_sheets sheets = {0};
    stp_forest forest = {0};
    uint8_t parity = 0;
    assert_non_null(graphs);
    graphs[0].piece_count = UINT32_MAX - 10;
    graphs[1].piece_count = 10;
    assert_int_equal(stp_sheets_create(&sheets, &cloud, 16, &graphs, NULL, &err), STP_LIMIT);
    assert_int_equal(stp_forest_create(&forest, 3, NULL, &err), STP_OK);
    forest.size[0] = forest.size[1] = UINT32_MAX - 5;
    stp_forest_join(&forest, 0, 1, false);
    stp_forest_join(&forest, 1, 2, false);
    assert_int_equal(forest.size[stp_forest_find(&forest, 2, &parity)], UINT32_MAX);
    stp_forest_clear(&forest);
}

/* A header that declares more than 2^32 records may be right. */
static void cut_file(void **state)
{
    (void)state;
    uint64_t count = UINT64_C(5000000000), lost = 0;
    assert_true(stp_salvage_count(&count, 7, &lost));
    assert_true(count == 7 && lost == UINT64_C(5000000000) - 7);
    count = UINT64_C(1) << 39;
    assert_false(stp_salvage_count(&count, 7, &lost));
    assert_true(count == UINT64_C(1) << 39);
}

/* ---- ranks ---- */

static bool prepare_rank(stp_ranks *ranks, void *context)
{
    run *r = context;
    stp_error err = {0};
    r->params.ranks = ranks;
    if (prepare(r, &err) != STP_OK) {
        fprintf(stderr, "rank %u: %s\n", ranks->self, err.message);
        return false;
    }
    return true;
}

static void check_ranks(run *r, const char *what)
{
    stp_error err = {0};
    size_t size = 0;
    r->params.first_place = 0;
    assert_int_equal(prepare(r, &err), STP_OK);
    uint8_t *bytes = prep_file_bytes(OUT, &size);
    for (size_t i = 0; i <= FIRST_COUNT; i++) {
        r->params.first_place = i > 0 ? firsts[i - 1] : 0;
        if (!rank_pipes_run(3, prepare_rank, r))
            fail_msg("%s: ranks fail from %llu on", what,
                     (unsigned long long)r->params.first_place);
        compare(bytes, size, r->params.first_place, what);
    }
    free(bytes);
}

static void ranks_share(void **state)
{
    (void)state;
    input in = make_input(0.15);
    run r = {.in = &in, .threads = 1, .kept = true, .params.outliers = STP_OUTLIERS_DROP};
    (void)signal(SIGPIPE, SIG_IGN);
    check_ranks(&r, "three ranks");
    free_input(&in);
    const stp_dvec3 station = {10.0, 20.0, 3.0};
    in = make_image(station, true);
    r = (run){.in = &in, .threads = 1, .told = true, .stations = &station};
    check_ranks(&r, "three ranks with an image");
    free_input(&in);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(spread_signs),   cmocka_unit_test(told_signs),
        cmocka_unit_test(treated_points), cmocka_unit_test(piles_in_files),
        cmocka_unit_test(pixels),         cmocka_unit_test(many_pieces),
        cmocka_unit_test(cut_file),       cmocka_unit_test(ranks_share)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
