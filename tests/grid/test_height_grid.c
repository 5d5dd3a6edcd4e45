/* Tests grids of heights that stay grids: which samples a patch has, that every sample is stored
 * once at its place with the normal of the surface, holes and cliffs, and the same bytes for any
 * number of threads and any memory. The file's own promises are verified in each case. */
#include "tests/fixtures/prep_fixture.h"

#include <math.h>

#define OUT "test_height_grid.stipple"
#define DEGREE (M_PI / 180.0)

enum { COLUMNS = 300, ROWS = 270, COUNT = COLUMNS * ROWS };

static const stp_scan_raster raster = {
    .columns = COLUMNS, .rows = ROWS, .x = 1000.0, .y = 5000.0, .dx = 2.0, .dy = 3.0};

typedef double surface(double x, double y);

static double waves(double x, double y)
{
    return 20.0 * sin(x / 60.0) * cos(y / 80.0);
}

static double peaks(double x, double y)
{
    return 200.0 * waves(x, y);
}

static stp_dvec3 normal_of_waves(double x, double y)
{
    return stp_dvec3_normalize((stp_dvec3){-20.0 / 60.0 * cos(x / 60.0) * cos(y / 80.0),
                                           20.0 / 80.0 * sin(x / 60.0) * sin(y / 80.0), 1.0});
}

static double plateau(double x, double y)
{
    return x > 1200.0 && x < 1400.0 && y > 4400.0 && y < 4700.0 ? 40.0 : 0.0;
}

typedef bool missing(int column, int row);

static bool nothing(int column, int row)
{
    (void)column;
    (void)row;
    return false;
}

static bool scattered(int column, int row)
{
    return stp_random_unit(7, (uint64_t)row * COLUMNS + (uint64_t)column) < 0.05;
}

static bool a_disc(int column, int row)
{
    const double x = column - 150.0, y = row - 130.0;
    return x * x + y * y <= 420.0; /* no single samples stick out */
}

static bool all_but_one(int column, int row)
{
    return column != 17 || row != 260;
}

/* A sum of twelve even deviations is nearly normal. */
static double deviate(uint64_t i)
{
    double sum = -6.0;
    for (uint64_t k = 0; k < 12; k++)
        sum += stp_random_unit(3, 12 * i + k);
    return sum;
}

static prep_cloud make_grid(surface *height, missing *is_missing, double noise)
{
    prep_cloud out = prep_cloud_make(COUNT);
    out.raster = raster;
    for (int i = 0; i < COUNT; i++) {
        const int column = i % COLUMNS, row = i / COLUMNS;
        const double x = raster.x + column * raster.dx, y = raster.y - row * raster.dy;
        const double z = height(x, y) + noise * deviate((uint64_t)i);
        out.points[i].position = (stp_dvec3){x, y, z};
        out.points[i].normal = (vec3s){{0.0f, 0.0f, 1.0f}}; /* readers give rough ones */
        out.points[i].reject = is_missing(column, row) ? STP_REJECT_INVALID : STP_REJECT_NONE;
    }
    return out;
}

/* Columns turn by half a degree in all, as far as another coordinate system may turn them. side: 1,
 * or -1: mirrored. */
static double bend_radius = 67500.0;

static stp_dvec3 bend(double column, double row, double side)
{
    const double angle = 0.1 + 2.025 / bend_radius * column, radius = bend_radius - raster.dy * row;
    return (stp_dvec3){side * radius * sin(angle), radius * cos(angle), 0.0};
}

static stp_dvec3 nodes[(ROWS / STP_RASTER_NODE + 2) * (COLUMNS / STP_RASTER_NODE + 2)];

static prep_cloud make_bent_grid(missing *is_missing, double side)
{
    prep_cloud out = make_grid(waves, is_missing, 0.0);
    const uint32_t across = stp_raster_node_count(COLUMNS), down = stp_raster_node_count(ROWS);
    assert_true(across * down <= sizeof nodes / sizeof *nodes);
    for (uint32_t i = 0; i < across * down; i++)
        nodes[i] = bend(stp_raster_node_column(i % across, COLUMNS),
                        stp_raster_node_column(i / across, ROWS), side);
    for (int i = 0; i < COUNT; i++) {
        stp_dvec3 *p = &out.points[i].position;
        *p = bend(i % COLUMNS, i / COLUMNS, side);
        p->z = waves(p->x, p->y);
    }
    out.raster_nodes = nodes;
    return out;
}

/* What is found in the file. */
typedef struct found {
    const prep_cloud *cloud;
    uint8_t seen[COUNT];
    float radius[COUNT];
    stp_dvec3 normal[COUNT];
    size_t patches, wide_patches; /* wide: of samples that lie in no common square */
} found;

static void note_sample(found *f, const stp_chunk_entry *entry, const stp_patch *patch,
                        const stp_sample *sample)
{
    const uint32_t i = prep_number_of(sample);
    assert_true(i < COUNT);
    const stp_point *point = &f->cloud->points[i];
    const stp_dvec3 p = stp_dvec3_add(entry->origin, stp_sample_position(sample, patch));
    assert_int_equal(point->reject, STP_REJECT_NONE);
    assert_int_equal(f->seen[i]++, 0);
    assert_true(stp_dvec3_length(stp_dvec3_sub(p, point->position)) < 0.1);
    f->radius[i] = (float)stp_sample_radius(sample, patch);
    f->normal[i] = stp_dvec3_from_float(stp_normal_decode(sample->normal));
    assert_int_equal(sample->flags & (STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL),
                     STP_SAMPLE_ORIENTED | STP_SAMPLE_HAS_NORMAL);
}

static uint32_t square_of(const stp_sample *sample)
{
    const uint32_t i = prep_number_of(sample);
    return i / COLUMNS / 8 * COLUMNS + i % COLUMNS / 8;
}

static void note_leaf(found *f, const stp_chunk *chunk, const stp_chunk_entry *entry)
{
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_sample *first = &chunk->samples[0][chunk->level_begin[0][p]];
        bool wide = false;
        for (unsigned i = 0; i < chunk->patches[p].counts[0]; i++) {
            note_sample(f, entry, &chunk->patches[p], &first[i]);
            wide |= square_of(&first[i]) != square_of(first);
        }
        f->wide_patches += wide;
        f->patches++;
    }
}

/* Prepares the grid, verifies the file, and reads it back. Free with free(). */
static found *prepare(prep_cloud *cloud, stp_prep_stats *stats)
{
    found *f = calloc(1, sizeof *f);
    stp_error err = {0};
    assert_non_null(f);
    f->cloud = cloud;
    if (prep_cloud_run(cloud, OUT, 2, NULL, stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    assert_true(stats->keeps_grid);
    stp_chunk_file *file = prep_open_verified(OUT);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        if (entry.child_count == 0)
            note_leaf(f, chunk, &entry);
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    size_t valid = 0, stored = 0;
    for (int i = 0; i < COUNT; i++) {
        valid += cloud->points[i].reject == STP_REJECT_NONE;
        stored += f->seen[i];
    }
    assert_int_equal(stored, valid);
    assert_int_equal(stats->points_out, valid);
    assert_int_equal(stats->rejected[STP_REJECT_INVALID], COUNT - valid);
    return f;
}

static double angle_to_waves(const found *f, int i)
{
    const stp_dvec3 p = f->cloud->points[i].position;
    const double cosine = stp_dvec3_dot(f->normal[i], normal_of_waves(p.x, p.y));
    return acos(fmin(cosine, 1.0));
}

static double mean_angle(const found *f)
{
    double sum = 0.0, count = 0.0;
    for (int i = 0; i < COUNT; i++) {
        sum += f->seen[i] ? angle_to_waves(f, i) : 0.0;
        count += f->seen[i];
    }
    return sum / count;
}

static void squares_become_patches(void **state)
{
    stp_prep_stats stats;
    prep_cloud cloud = make_grid(waves, nothing, 0.0);
    found *f = prepare(&cloud, &stats);
    (void)state;
    assert_int_equal(f->patches, ((COLUMNS + 7) / 8) * ((ROWS + 7) / 8));
    assert_int_equal(f->wide_patches, 0);
    for (int i = 0; i < COUNT; i++) /* 10 bits, and the window's own width */
        assert_true(angle_to_waves(f, i) < 1.0 * DEGREE);
    assert_true(mean_angle(f) < 0.15 * DEGREE);
    free(f);
    free(cloud.points);
}

static void check_squares(const stp_chunk *chunk)
{
    assert_non_null(chunk->squares);
    assert_true(chunk->rasters->level);
    assert_true(chunk->rasters->across[0][1] == raster.dx);
    assert_true(chunk->rasters->across[1][2] == -raster.dy);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const uint32_t i = prep_number_of(&chunk->samples[0][chunk->level_begin[0][p]]);
        assert_int_equal(chunk->squares[p].column, i % COLUMNS / 8);
        assert_int_equal(chunk->squares[p].row, i / COLUMNS / 8);
    }
}

static void check_bent(const stp_chunk *chunk)
{
    assert_non_null(chunk->squares);
    assert_false(chunk->rasters->level);
}

/* Prepares with Draco's codec, as precisely as points, and checks the leaves. Returns the file's
 * size. */
static size_t check_leaves(prep_cloud *cloud, void (*check)(const stp_chunk *leaf))
{
    const stp_prep_params params = {.codec = STP_CODEC_DRACO, .precision = raster.dx / 32.0};
    stp_prep_stats stats;
    stp_error err = {0};
    size_t size;
    if (prep_cloud_run(cloud, OUT, 2, &params, &stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_chunk_file *file = prep_open_verified(OUT);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        if (entry.child_count == 0)
            check(chunk);
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    free(prep_file_bytes(OUT, &size));
    return size;
}

/* With Draco's codec, leaves tell columns and rows in place of positions. */
static void leaves_tell_columns_and_rows(void **state)
{
    prep_cloud cloud = make_grid(waves, scattered, 0.1);
    (void)state;
    check_leaves(&cloud, check_squares);
    free(cloud.points);
}

/* A grid that was brought to another coordinate system stays one, and takes little more than one
 * that was not; also if that system mirrors it. */
static void bent_grids_stay_grids(void **state)
{
    prep_cloud straight = make_grid(waves, scattered, 0.0);
    const size_t level = check_leaves(&straight, check_squares);
    (void)state;
    for (int side = -1; side <= 1; side += 2) {
        stp_prep_stats stats;
        prep_cloud bent = make_bent_grid(scattered, side);
        found *f = prepare(&bent, &stats);
        assert_int_equal(f->wide_patches, 0);
        for (int i = 0; i < COUNT; i++)
            assert_true(!f->seen[i] || angle_to_waves(f, i) < 1.5 * DEGREE);
        assert_true(mean_angle(f) < 0.2 * DEGREE);
        const size_t turned = check_leaves(&bent, check_bent);
        print_message("bytes: straight %zu, bent %zu\n", level, turned);
        assert_true(turned < level + level / 5);
        free(f);
        free(bent.points);
    }
    free(straight.points);
}

/* Samples of a grid that is bent by less than 1/512 of a cell are moved to an even lattice, which
 * takes fewer bytes than to store where they are; but not if a precision is asked for. */
static void bent_samples_are_moved(void **state)
{
    stp_prep_stats moved, stored;
    size_t sizes[2];
    (void)state;
    bend_radius = 1e6;
    prep_cloud cloud = make_bent_grid(scattered, 1);
    stp_prep_params params = {.codec = STP_CODEC_DRACO};
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, &params, &moved, NULL), STP_OK);
    free(prep_file_bytes(OUT, &sizes[0]));
    params.precision = moved.resolution.precision;
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, &params, &stored, NULL), STP_OK);
    free(prep_file_bytes(OUT, &sizes[1]));
    const double cell = 2.025, precision = params.precision;
    assert_true(precision > 0.0 && stored.tree.displacement.greatest <= precision);
    assert_true(moved.tree.displacement.greatest > precision);
    assert_true(moved.tree.displacement.greatest <= precision + cell / 512.0);
    assert_int_equal(moved.tree.displacement.beyond, 0);
    assert_true(sizes[0] < sizes[1] - sizes[1] / 10);
    bend_radius = 67500.0;
    free(cloud.points);
}

/* Prepares a grid of floats, which must be off by at most `most`, and by more than a sixth of it:
 * no bits are wasted. */
static void check_precision(surface *height, double noise, double most)
{
    stp_prep_stats stats;
    prep_cloud cloud = make_grid(height, nothing, noise);
    free(prepare(&cloud, &stats));
    const double off = stats.tree.displacement.greatest;
    print_message("noise %g: off by %g, where %g is allowed\n", noise, off, most);
    assert_true(off <= most && off > most / 6.0);
    assert_int_equal(stats.tree.displacement.beyond, 0);
    free(cloud.points);
}

/* Floats keep a quarter of their noise; smooth ones a 16th bit of their range, or a part of a cell
 * if that is more. The noise that is found may be a tenth more. */
static void floats_keep_what_they_tell(void **state)
{
    (void)state;
    check_precision(waves, 0.0, raster.dx / 2048.0);
    check_precision(peaks, 0.0, 2.0 * 4000.0 / 131072.0);
    check_precision(waves, 0.02, 1.1 * 0.02 / 4.0);
    check_precision(waves, 0.1, 1.1 * 0.1 / 4.0);
}

/* Noise of 0.2 columns turns the normals of 3 x 3 samples by 3 degrees and more. */
static void noise_asks_for_wide_windows(void **state)
{
    stp_prep_stats stats;
    prep_cloud cloud = make_grid(waves, nothing, 0.4);
    found *f = prepare(&cloud, &stats);
    (void)state;
    print_message("noise: normals off by %.2f degrees\n", mean_angle(f) / DEGREE);
    assert_true(mean_angle(f) < 2.5 * DEGREE);
    assert_true(stats.normals_wide.normal_error > 0.5 * mean_angle(f) &&
                stats.normals_wide.normal_error < 2.0 * mean_angle(f));
    free(f);
    free(cloud.points);
}

static void missing_samples_stay_out(void **state)
{
    stp_prep_stats stats;
    prep_cloud cloud = make_grid(waves, scattered, 0.0);
    found *f = prepare(&cloud, &stats);
    (void)state;
    assert_int_equal(f->wide_patches, 0);
    assert_true(mean_angle(f) < 0.2 * DEGREE);
    free(f);
    free(cloud.points);
}

/* Whether a neighbour of sample i is missing. */
static bool is_beside_hole(const prep_cloud *cloud, int i)
{
    for (int j = -1; j <= 1; j++)
        for (int k = -1; k <= 1; k++)
            if (cloud->points[i + j * COLUMNS + k].reject != STP_REJECT_NONE)
                return true;
    return false;
}

/* Discs at a hole's border reach half a diagonal, so the hole is no smaller by more than that. */
static void wide_holes_keep_their_width(void **state)
{
    const double diagonal = sqrt(raster.dx * raster.dx + raster.dy * raster.dy);
    stp_prep_stats stats;
    prep_cloud cloud = make_grid(plateau, a_disc, 0.0);
    found *f = prepare(&cloud, &stats);
    size_t border = 0;
    (void)state;
    for (int i = COUNT / 2 - 30 * COLUMNS; i < COUNT / 2 + 30 * COLUMNS; i++) {
        const int column = i % COLUMNS;
        if (!f->seen[i] || column < 100 || column > 200)
            continue;
        const bool beside = is_beside_hole(&cloud, i);
        const double radius = (double)f->radius[i] / diagonal;
        assert_true(beside ? radius >= 0.5 && radius < 0.6 : radius > 0.9);
        border += beside;
    }
    assert_true(border > 100);
    free(f);
    free(cloud.points);
}

/* Both sides of a cliff are level. */
static void cliffs_turn_no_normals(void **state)
{
    stp_prep_stats stats;
    prep_cloud cloud = make_grid(plateau, nothing, 0.0);
    found *f = prepare(&cloud, &stats);
    (void)state;
    for (int i = 0; i < COUNT; i++)
        assert_true(f->normal[i].z > cos(0.5 * DEGREE));
    free(f);
    free(cloud.points);
}

static void a_single_sample_is_a_model(void **state)
{
    stp_prep_stats stats;
    (void)state;
    for (int bent = 0; bent < 2; bent++) {
        prep_cloud cloud =
            bent ? make_bent_grid(all_but_one, 1.0) : make_grid(waves, all_but_one, 0.0);
        found *f = prepare(&cloud, &stats);
        assert_int_equal(f->patches, 1);
        free(f);
        free(cloud.points);
    }
}

static bool everything(int column, int row)
{
    return column >= 0 && row >= 0;
}

static void no_sample_is_refused(void **state)
{
    stp_prep_stats stats;
    stp_error err = {0};
    prep_cloud cloud = make_grid(waves, everything, 0.0);
    (void)state;
    assert_int_equal(prep_cloud_run(&cloud, OUT, 2, NULL, &stats, &err), STP_EMPTY);
    free(cloud.points);
}

static void bytes_are_the_same(void **state)
{
    static const struct {
        unsigned threads;
        uint64_t memory;
    } runs[] = {{1, 0}, {2, 0}, {5, 0}, {2, 130u << 20}};
    size_t sizes[2];
    uint8_t *first = NULL;
    stp_error err = {0};
    prep_cloud cloud = make_grid(waves, scattered, 0.1);
    (void)state;
    for (size_t i = 0; i < sizeof runs / sizeof *runs; i++) {
        stp_prep_stats stats;
        const stp_prep_params params = {.memory_bytes = runs[i].memory};
        if (prep_cloud_run(&cloud, OUT, runs[i].threads, &params, &stats, &err) != STP_OK)
            fail_msg("%s", err.message);
        uint8_t *bytes = prep_file_bytes(OUT, &sizes[i > 0]);
        if (first) {
            assert_int_equal(sizes[0], sizes[1]);
            assert_memory_equal(first, bytes, sizes[0]);
            free(bytes);
        } else {
            first = bytes;
        }
    }
    free(first);
    free(cloud.points);
}

/* Files that are read one after the other; file k breaks off after most[k] records. */
typedef struct broken_files {
    const prep_cloud *files[2];
    size_t most[2], file, given;
} broken_files;

static stp_status read_files(void *context, stp_point *points, size_t capacity, size_t *count,
                             stp_error *err)
{
    broken_files *b = context;
    if (b->file < 2 && b->given == b->files[b->file]->count) {
        b->file++;
        b->given = 0;
    }
    if (b->file < 2 && b->given == b->most[b->file])
        return stp_error_set(err, STP_CORRUPT, "breaks off");
    for (*count = 0; b->file < 2 && *count < capacity && b->given < b->most[b->file]; ++*count)
        points[*count] = b->files[b->file]->points[b->given++];
    return STP_OK;
}

static bool leave_file_out(void *context, const stp_error *why, size_t *file)
{
    broken_files *b = context;
    (void)why;
    *file = b->file++;
    b->given = 0;
    return true;
}

/* Makes a model of two files that lie over each other. */
static uint8_t *model_of(const prep_cloud *first, const prep_cloud *second, size_t most_first,
                         size_t most_second, size_t *size)
{
    const stp_prep_file files[2] = {{.name = "first", .raster = raster},
                                    {.name = "second", .raster = raster}};
    const stp_prep_params params = {.force = true};
    broken_files context = {{first, second}, {most_first, most_second}, 0, 0};
    const stp_prep_source source = {.context = &context,
                                    .read = read_files,
                                    .leaves_out = leave_file_out,
                                    .file = &context.file,
                                    .point_count = 2 * (uint64_t)COUNT,
                                    .attributes = STP_POINT_HAS_COLOUR | STP_POINT_HAS_NORMAL,
                                    .raster = raster,
                                    .files = files,
                                    .file_count = 2};
    stp_pool *pool = NULL;
    stp_prep_stats stats;
    assert_int_equal(stp_pool_create(&pool, 2, NULL), STP_OK);
    assert_int_equal(stp_prep_run(OUT, &source, &params, pool, NULL, &stats, NULL), STP_OK);
    stp_pool_destroy(&pool);
    return prep_file_bytes(OUT, size);
}

/* A file whose samples stand in another order gives the same model. */
static void order_is_nothing(void **state)
{
    prep_cloud grid = make_grid(waves, scattered, 0.0), other = make_grid(waves, scattered, 0.0);
    stp_prep_stats stats;
    size_t sizes[2];
    (void)state;
    assert_int_equal(prep_cloud_run(&grid, OUT, 2, NULL, &stats, NULL), STP_OK);
    uint8_t *expected = prep_file_bytes(OUT, &sizes[0]);
    for (unsigned order = 1; order < 8; order++) {
        other.raster.order = order;
        for (size_t i = 0; i < COUNT; i++)
            other.points[i] = grid.points[stp_scan_raster_place(&other.raster, i)];
        assert_int_equal(prep_cloud_run(&other, OUT, 2, NULL, &stats, NULL), STP_OK);
        uint8_t *bytes = prep_file_bytes(OUT, &sizes[1]);
        assert_int_equal(sizes[0], sizes[1]);
        assert_memory_equal(bytes, expected, sizes[0]);
        free(bytes);
    }
    free(expected);
    free(grid.points);
    free(other.points);
}

/* Neither a file before it nor one behind it notices a file that breaks off. */
static void files_that_break_off_leave_nothing(void **state)
{
    prep_cloud holes = make_grid(waves, scattered, 0.0), whole = make_grid(peaks, nothing, 0.0);
    (void)state;
    for (int k = 0; k < 2; k++) {
        const prep_cloud *first = k == 0 ? &holes : &whole, *second = k == 0 ? &whole : &holes;
        const size_t part = COUNT - 1000;
        size_t size = 0, expected_size = 0;
        uint8_t *expected =
            model_of(first, second, k == 0 ? COUNT : 0, k == 0 ? 0 : COUNT, &expected_size);
        uint8_t *bytes =
            model_of(first, second, k == 0 ? COUNT : part, k == 0 ? part : COUNT, &size);
        assert_int_equal(size, expected_size);
        assert_memory_equal(bytes, expected, size);
        free(expected);
        free(bytes);
    }
    free(holes.points);
    free(whole.points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(squares_become_patches),
        cmocka_unit_test(noise_asks_for_wide_windows),
        cmocka_unit_test(missing_samples_stay_out),
        cmocka_unit_test(wide_holes_keep_their_width),
        cmocka_unit_test(cliffs_turn_no_normals),
        cmocka_unit_test(a_single_sample_is_a_model),
        cmocka_unit_test(no_sample_is_refused),
        cmocka_unit_test(bytes_are_the_same),
        cmocka_unit_test(files_that_break_off_leave_nothing),
        cmocka_unit_test(leaves_tell_columns_and_rows),
        cmocka_unit_test(bent_grids_stay_grids),
        cmocka_unit_test(bent_samples_are_moved),
        cmocka_unit_test(floats_keep_what_they_tell),
        cmocka_unit_test(order_is_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
