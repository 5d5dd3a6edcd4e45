/* Tests the search among rows of discs against a plain search of all discs, that tangential errors
 * are as without rows but for the order of the search, and that they tell of holes under discs. */
#include "formats/chunk/measure/disc_rows.h"
#include "formats/chunk/measure/overhang.h"
#include "tests/fixtures/prep_fixture.h"

#define OUT "test_disc_rows.stipple"

enum { COLUMNS = 90, ROWS = 70, COUNT = COLUMNS * ROWS, POINTS = 4000, STRIPES = 31, HOLE = 7 };

static const stp_scan_raster raster = {COLUMNS, ROWS, -30.0, 800.0, 2.0, 2.0};

typedef double surface(double column, double row);

static double flat(double column, double row)
{
    return 0.01 * (column + row);
}

static double waves(double column, double row)
{
    return 6.0 * sin(column / 9.0) * cos(row / 7.0);
}

static double steep(double column, double row)
{
    return 6.0 * waves(column, row);
}

static double steps(double column, double row)
{
    return waves(column, row) + 15.0 * ((int)(column / 11.0) + (int)(row / 13.0));
}

static double random_at(uint64_t seed, uint64_t i)
{
    return stp_random_unit(seed, i);
}

/* The chunk of a grid whose heights have noise up to `noise`, and of whose samples so many are
 * missing, and HOLE of STRIPES rows if it has holes. */
static stp_chunk *make_chunk(surface *height, double noise, double missing, bool holes)
{
    const stp_prep_params params = {.codec = STP_CODEC_DRACO, .precision = raster.dx / 32.0};
    stp_prep_stats stats;
    stp_chunk_entry entry;
    prep_cloud cloud = prep_cloud_make(COUNT);
    cloud.raster = raster;
    for (int i = 0; i < COUNT; i++) {
        const int column = i % COLUMNS, row = i / COLUMNS;
        const double z = height(column, row) + noise * (2.0 * random_at(1, (uint64_t)i) - 1.0);
        cloud.points[i].position =
            (stp_dvec3){raster.x + column * raster.dx, raster.y - row * raster.dy, z};
        cloud.points[i].normal = (vec3s){{0.0f, 0.0f, 1.0f}};
        if (random_at(2, (uint64_t)i) < missing || (holes && (row + column / 8) % STRIPES < HOLE))
            cloud.points[i].reject = STP_REJECT_INVALID;
    }
    assert_int_equal(prep_cloud_run(&cloud, OUT, 1, &params, &stats, NULL), STP_OK);
    stp_chunk_file *file = prep_open_verified(OUT);
    assert_int_equal(stp_chunk_file_get_info(file)->chunk_count, 1);
    stp_chunk *chunk = prep_chunk(file, 0, &entry);
    stp_chunk_file_close(&file);
    free(cloud.points);
    assert_int_equal(chunk->raster_count, 1);
    return chunk;
}

/* Discs of a neighbour that go on beside the grid, and one far away. */
static stp_surroundings make_around(const stp_chunk *chunk, stp_flat_disc discs[ROWS + 1])
{
    const double(*a)[6] = chunk->rasters[0].across;
    for (int row = 0; row <= ROWS; row++) {
        const int column = row < ROWS ? COLUMNS + row % 2 : COLUMNS * 50;
        discs[row] = (stp_flat_disc){
            {a[0][0] + column * a[0][1], a[1][0] + row * a[1][2], random_at(3, (uint64_t)row)},
            {0.0, 0.6, 0.8},
            1.0 + random_at(4, (uint64_t)row)};
    }
    return (stp_surroundings){.discs = discs, .count = ROWS + 1};
}

/* A point near a random disc, or far over it. */
static stp_dvec3 point_near(const stp_disc_grid *g, uint64_t i)
{
    const uint32_t disc = (uint32_t)(random_at(5, i) * g->own_count);
    const float *d = g->numbers[disc].numbers;
    const double reach = (i % 8 ? 4.0 : 40.0) * g->radius;
    return (stp_dvec3){(double)d[0] + reach * (random_at(6, i) - 0.5),
                       (double)d[1] + reach * (random_at(7, i) - 0.5),
                       (double)d[2] + 0.2 * reach * (random_at(8, i) - 0.5)};
}

/* Returns how many of POINTS points the rows answer. */
static int count_found(const stp_disc_grid *g, const stp_disc_rows *rows)
{
    const stp_near_enough never = {.squared = -1.0f, .cost = -1.0f, .over.near_squared = -1.0f};
    int found = 0;
    for (uint64_t i = 0; i < POINTS; i++) {
        const stp_dvec3 x = point_near(g, i);
        double least, squared = 0.0;
        uint32_t disc = UINT32_MAX;
        const uint32_t nearest = stp_disc_grid_nearest(g, 0, g->count, x, &least);
        if (!stp_disc_rows_nearest(rows, x, &never, &squared, &disc))
            continue;
        found++;
        assert_true(squared == least);
        if (least > 0.0)
            assert_int_equal(disc, nearest);
    }
    return found;
}

static void check(surface *height, double noise, double missing, int found_least)
{
    stp_chunk *chunk = make_chunk(height, noise, missing, false);
    stp_flat_disc beside[ROWS + 1];
    const stp_surroundings around = make_around(chunk, beside);
    stp_overhang *own = calloc(2 * (size_t)chunk->patch_count, sizeof *own);
    stp_disc_grid grid;
    stp_disc_rows rows;
    assert_int_equal(stp_disc_grid_create(&grid, chunk, NULL, &around, NULL), STP_OK);
    assert_int_equal(stp_disc_rows_create(&rows, &grid, NULL), STP_OK);
    assert_true(rows.columns > 0);
    const int found = count_found(&grid, &rows);
    print_message("%d of %d points\n", found, POINTS);
    assert_true(found >= found_least);
    stp_disc_rows_clear(&rows);
    stp_disc_grid_clear(&grid);

    assert_int_equal(stp_overhang_measure(own, chunk, NULL, &around, NULL), STP_OK);
    chunk->raster_count = 0;
    assert_int_equal(stp_overhang_measure(own + chunk->patch_count, chunk, NULL, &around, NULL),
                     STP_OK);
    uint32_t same = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_overhang *plain = &own[chunk->patch_count + p];
        bool alike = true;
        for (int l = 0; l < STP_LEVEL_COUNT; l++) {
            alike &= own[p].level[l] == plain->level[l];
            assert_true(own[p].level[l] >= 0.8 * plain->level[l]);
        }
        for (int q = 0; q < 2 * STP_PATCH_QUARTERS; q++)
            alike &= own[p].quarter[q % 2][q / 2] == plain->quarter[q % 2][q / 2];
        same += alike;
    }
    assert_true(10 * same >= 9 * chunk->patch_count); /* but for those near holes and borders */
    free(own);
    stp_chunk_destroy(&chunk);
}

static void rows_find_the_nearest(void **state)
{
    (void)state;
    check(waves, 0.0, 0.0, POINTS * 3 / 4);
    check(waves, 0.4, 0.0, POINTS * 3 / 4);
    check(waves, 2.0, 0.3, POINTS / 4);
    check(steep, 0.5, 0.1, POINTS / 8);
    check(steps, 0.1, 0.5, 0);
}

/* Checks all places of the grid under a merged disc. Returns how many are far from all discs. */
static int check_places(const stp_disc_grid *g, const stp_raster *r, const stp_flat_disc *disc,
                        double error, double tangential_error)
{
    const double most = hypot(error, tangential_error) * STP_STORED_SLACK;
    int far = 0;
    for (int i = 0; i < COUNT; i++) {
        const double x = r->across[0][0] + i % COLUMNS * r->across[0][1] - disc->centre.x;
        const double y = r->across[1][0] + (double)(i / COLUMNS) * r->across[1][2] - disc->centre.y;
        const double z = -(x * disc->normal.x + y * disc->normal.y) / disc->normal.z;
        double least;
        if (x * x + y * y + z * z > disc->radius * disc->radius)
            continue;
        const stp_dvec3 at = stp_dvec3_add(disc->centre, (stp_dvec3){x, y, z});
        stp_disc_grid_nearest(g, 0, g->count, stp_dvec3_scale(at, g->scale), &least);
        assert_true(sqrt(least) / g->scale <= most + 0.5 * raster.dx);
        far += sqrt(least) / g->scale > raster.dx;
    }
    return far;
}

/* Between a disc's centre and its rim there is a hole: no place of it lies farther from all discs
 * than the errors say, and half a cell. */
static void holes_under_discs_are_measured(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(flat, 0.0, 0.0, true);
    stp_overhang *own = calloc(chunk->patch_count, sizeof *own);
    stp_disc_grid grid;
    int far = 0;
    assert_int_equal(stp_overhang_measure(own, chunk, NULL, NULL, NULL), STP_OK);
    assert_int_equal(stp_disc_grid_create(&grid, chunk, NULL, NULL, NULL), STP_OK);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        for (int l = 1; l < STP_LEVEL_COUNT; l++)
            for (uint32_t i = 0; i < patch->counts[l]; i++) {
                const stp_flat_disc disc = stp_flat_disc_from_sample(
                    &chunk->samples[l][chunk->level_begin[l][p] + i], patch);
                far += check_places(&grid, &chunk->rasters[0], &disc,
                                    stp_error_decode(patch->error[l], patch->exponent),
                                    own[p].level[l]);
            }
    }
    print_message("%d places in holes\n", far);
    assert_true(far > 1000);
    stp_disc_grid_clear(&grid);
    free(own);
    stp_chunk_destroy(&chunk);
}

static bool has_rows(const stp_chunk *chunk)
{
    stp_disc_grid grid;
    stp_disc_rows rows;
    assert_int_equal(stp_disc_grid_create(&grid, chunk, NULL, NULL, NULL), STP_OK);
    assert_int_equal(stp_disc_rows_create(&rows, &grid, NULL), STP_OK);
    const bool out = rows.columns > 0;
    stp_disc_rows_clear(&rows);
    stp_disc_grid_clear(&grid);
    return out;
}

static void other_discs_are_in_no_rows(void **state)
{
    (void)state;
    stp_chunk *chunk = make_chunk(waves, 0.1, 0.0, false);
    stp_sample *s = &chunk->samples[0][70], was = *s;
    assert_true(has_rows(chunk));
    s->radius = 255; /* wider than the rows that are tried */
    assert_false(has_rows(chunk));
    *s = was;
    s->position[0] = (uint16_t)(s->position[0] + s[1].position[0]) / 2; /* off its place */
    assert_false(has_rows(chunk));
    *s = was;
    memcpy(s->position, s[1].position, sizeof s->position); /* two in one place */
    assert_false(has_rows(chunk));
    *s = was;
    chunk->patches[0].origin[0] += 1 << 27; /* rows too long */
    assert_false(has_rows(chunk));
    chunk->patches[0].origin[0] -= 1 << 27;
    chunk->rasters[0].level = false;
    assert_false(has_rows(chunk));
    stp_chunk_destroy(&chunk);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(rows_find_the_nearest),
                                       cmocka_unit_test(holes_under_discs_are_measured),
                                       cmocka_unit_test(other_discs_are_in_no_rows)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
