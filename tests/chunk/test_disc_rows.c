/* Tests the search among rows of discs against a plain search of all discs, that tangential errors
 * are what some disc asks for and little more, and that they tell of holes under discs. */
#include "formats/chunk/measure/disc_rows.h"
#include "formats/chunk/measure/overhang.h"
#include "tests/fixtures/prep_fixture.h"

#define OUT "test_disc_rows.stipple"

/* A distance that excludes no disc. */
#define FAR 1e30f
/* Errors are rounded up to a code, and go by the first disc whose cost will do. */
#define TIGHT 1.6

enum { COLUMNS = 90, ROWS = 70, COUNT = COLUMNS * ROWS, POINTS = 4000, STRIPES = 31, HOLE = 7 };

static const stp_scan_raster raster = {
    .columns = COLUMNS, .rows = ROWS, .x = -30.0, .y = 800.0, .dx = 2.0, .dy = 2.0};

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

static double aslant(double column, double row)
{
    return 2.0 * (8.0 * column - 5.0 * row) + 0.1 * waves(column, row);
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

/* The least cost of a point over all discs. */
static float least_of_all(const stp_disc_grid *g, const float x[3], const stp_over *over)
{
    stp_disc_best best = {FAR, FAR, FAR};
    stp_disc_columns_least(&g->columns, 0, g->entries, over, x, STP_LANE_ANYWHERE, &best);
    return best.value;
}

/* Returns for how many of POINTS points the rows find the disc of least cost. */
static int count_found(const stp_disc_grid *g, const stp_disc_rows *rows)
{
    stp_over over = {STP_OVER_COST, {0.36f, 0.48f, 0.8f}, 0.0f, 0.0f, 0, 0};
    int found = 0;
    over.error = (float)(0.1 * g->radius);
    for (uint64_t i = 0; i < POINTS; i++) {
        const stp_dvec3 at = point_near(g, i);
        const float x[3] = {(float)at.x, (float)at.y, (float)at.z};
        const float all = least_of_all(g, x, &over);
        uint32_t disc = UINT32_MAX;
        const float least = stp_disc_rows_least(rows, x, &over, -1.0f, &disc);
        assert_true(least >= all);
        found += least == all;
        if (least < STP_DISC_ROWS_NONE)
            assert_true(stp_lane_cost(&g->numbers[disc], &over, x) == least);
        disc = UINT32_MAX; /* any disc will do whose cost is no more than asked for */
        const float some = stp_disc_rows_least(rows, x, &over, 2.0f * least, &disc);
        assert_true(some >= least && some <= 2.0f * least);
    }
    return found;
}

/* The greatest error that the points of a quarter's discs ask for, over the disc of least cost. */
static double asked_by(const stp_disc_grid *g, uint32_t p, int level, unsigned q)
{
    const stp_chunk *chunk = g->chunk;
    const stp_patch *patch = &chunk->patches[p];
    const unsigned end = level == 3 ? 1 : stp_quarter_begin(patch->counts, level, q + 1);
    const double error = stp_error_decode(stp_quarter_error(patch, level, q), patch->exponent);
    stp_over over = {STP_OVER_COST, {0}, (float)(error * STP_STORED_SLACK * g->scale), 0.0f, 0, 0};
    float most = 0.0f;
    for (unsigned i = level == 3 ? 0 : stp_quarter_begin(patch->counts, level, q); i < end; i++) {
        stp_dvec3 points[STP_DISC_POINTS];
        const stp_disc disc =
            stp_disc_from_sample(&chunk->samples[level][chunk->level_begin[level][p] + i], patch);
        const unsigned count = stp_disc_points(&disc, points);
        const vec3s n = stp_dvec3_to_float(disc.normal);
        memcpy(over.normal, n.raw, sizeof over.normal);
        over.begin = chunk->level_begin[0][p] + stp_covered_begin(patch->counts, level, i, 0);
        over.end = chunk->level_begin[0][p] + stp_covered_begin(patch->counts, level, i + 1, 0);
        for (unsigned k = 0; k < count; k++) {
            const stp_dvec3 x = stp_dvec3_scale(points[k], g->scale);
            most =
                fmaxf(most, least_of_all(g, (float[3]){(float)x.x, (float)x.y, (float)x.z}, &over));
        }
    }
    return (double)most / g->scale;
}

/* Every error is at least what the points ask for. Returns how many of the patches have errors
 * hardly greater than this, or than the least one that is told apart. */
static int check_errors(const stp_disc_grid *g, const stp_overhang *own)
{
    const stp_chunk *chunk = g->chunk;
    int tight = 0;
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        const double least =
            stp_radius_decode(patch->radius[0], patch->exponent) / STP_OVERHANG_PARTS;
        double asked = least;
        for (int level = 1; level < STP_LEVEL_COUNT; level++)
            for (unsigned q = 0; q < (level == 3 ? 1 : patch->counts[2]); q++) {
                const double error = level == 3 ? own[p].level[3] : own[p].quarter[level - 1][q];
                const double by_points = asked_by(g, p, level, q);
                assert_true(error >= by_points * (1.0 - 1e-4) - 1e-4 * least);
                asked = fmax(asked, by_points);
            }
        tight += own[p].level[3] <= TIGHT * asked;
    }
    return tight;
}

static void check(surface *height, double noise, double missing, int found_least)
{
    stp_chunk *chunk = make_chunk(height, noise, missing, false);
    stp_flat_disc beside[ROWS + 1];
    const stp_surroundings around = make_around(chunk, beside);
    stp_overhang *own = calloc(chunk->patch_count, sizeof *own);
    stp_disc_grid grid;
    stp_disc_rows rows;
    assert_int_equal(stp_disc_grid_create(&grid, chunk, NULL, &around, NULL), STP_OK);
    assert_int_equal(stp_disc_grid_fill(&grid, NULL), STP_OK);
    assert_int_equal(stp_disc_rows_create(&rows, &grid, NULL), STP_OK);
    assert_true(rows.columns > 0);
    const int found = count_found(&grid, &rows);
    assert_int_equal(stp_overhang_measure(own, chunk, NULL, &around, NULL, NULL), STP_OK);
    const int tight = check_errors(&grid, own);
    print_message("%d of %d points, %d of %u patches\n", found, POINTS, tight, chunk->patch_count);
    assert_true(found >= found_least);
    assert_true(10 * tight >= 9 * (int)chunk->patch_count);
    stp_disc_rows_clear(&rows);
    stp_disc_grid_clear(&grid);
    free(own);
    stp_chunk_destroy(&chunk);
}

static void rows_find_the_least_cost(void **state)
{
    (void)state;
    check(waves, 0.0, 0.0, POINTS * 3 / 4);
    check(waves, 0.4, 0.0, POINTS * 3 / 4);
    check(waves, 2.0, 0.3, POINTS / 4);
    check(steep, 0.5, 0.1, POINTS / 8);
    check(aslant, 1.0, 0.0, 0);
    check(steps, 0.1, 0.5, 0);
}

/* Whether each point of a disc is answered by the disc that it is paired with; as bits. least: by
 * the disc of least cost. */
static uint32_t answered(const stp_disc_grid *g, const stp_disc_rows *rows, const stp_disc *disc,
                         double error, float limit, uint32_t *least)
{
    stp_over over = {STP_OVER_COST, {0}, (float)(error * g->scale), 0.0f, 0, 0};
    stp_paired_lanes lanes;
    stp_disc_steps steps;
    stp_dvec3 points[STP_DISC_POINTS];
    float value[STP_DISC_LANES];
    const vec3s n = stp_dvec3_to_float(disc->normal);
    const unsigned count = stp_disc_points(disc, points);
    memcpy(over.normal, n.raw, sizeof over.normal);
    for (unsigned i = 0; i < STP_DISC_LANES; i++) {
        const stp_dvec3 x = stp_dvec3_scale(points[i < count ? i : 0], g->scale);
        lanes.point[0][i] = (float)x.x;
        lanes.point[1][i] = (float)x.y;
        lanes.point[2][i] = (float)x.z;
    }
    *least = 0;
    for (unsigned i = 0; i < count; i++) {
        const float x[3] = {lanes.point[0][i], lanes.point[1][i], lanes.point[2][i]};
        *least |= (least_of_all(g, x, &over) <= limit ? 1u : 0u) << i;
    }
    stp_disc_rows_steps(rows, over.normal, &steps);
    return ~stp_disc_rows_above(rows, &steps, &over, limit, &lanes, value);
}

/* Nearly all points whose cost over some disc is small are paired with such a disc, also on slopes,
 * where it stands in another column and row. */
static void points_are_paired_with_discs_beside_them(void **state)
{
    surface *const surfaces[] = {flat, waves, steep, aslant};
    (void)state;
    for (size_t s = 0; s < sizeof surfaces / sizeof *surfaces; s++) {
        stp_chunk *chunk = make_chunk(surfaces[s], 0.0, 0.0, false);
        stp_disc_grid grid;
        stp_disc_rows rows;
        int could = 0, are = 0;
        assert_int_equal(stp_disc_grid_create(&grid, chunk, NULL, NULL, NULL), STP_OK);
        assert_int_equal(stp_disc_grid_fill(&grid, NULL), STP_OK);
        assert_int_equal(stp_disc_rows_create(&rows, &grid, NULL), STP_OK);
        const float limit = 0.05f * (float)grid.radius;
        for (uint32_t p = 0; p < chunk->patch_count; p++)
            for (int l = 1; l <= 2; l++)
                for (uint32_t i = 0; i < chunk->patches[p].counts[l]; i++) {
                    const stp_disc disc = stp_disc_from_sample(
                        &chunk->samples[l][chunk->level_begin[l][p] + i], &chunk->patches[p]);
                    const stp_patch *patch = &chunk->patches[p];
                    const double error = stp_error_decode(patch->error[l], patch->exponent);
                    uint32_t least;
                    const uint32_t paired = answered(&grid, &rows, &disc, error, limit, &least);
                    assert_int_equal(paired & ~least & ((1u << STP_DISC_POINTS) - 1), 0);
                    could += __builtin_popcount(least);
                    are += __builtin_popcount(least & paired);
                }
        print_message("%d of %d points\n", are, could);
        assert_true(could > 5000);
        assert_true(are > 0.9 * could);
        stp_disc_rows_clear(&rows);
        stp_disc_grid_clear(&grid);
        stp_chunk_destroy(&chunk);
    }
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
    assert_int_equal(stp_overhang_measure(own, chunk, NULL, NULL, NULL, NULL), STP_OK);
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

/* Where cells are far longer than wide, steps lead past the last place by more than an integer
 * holds: then the way in memory ends there. */
static void long_cells_have_steps(void **state)
{
    (void)state;
    static const float sides[] = {1.0f, 1e3f, 1e6f, 1e9f, 1e12f};
    const float normal[3] = {0.6f, 0.5f, 0.62f};
    for (size_t i = 0; i < 2 * (sizeof sides / sizeof *sides); i++) {
        const float side = sides[i / 2];
        const stp_disc_rows rows = {
            .columns = 3000, .rows = 400, .side = {i % 2 ? side : 1.0f, i % 2 ? 1.0f : side}};
        stp_disc_steps steps;
        stp_disc_rows_steps(&rows, normal, &steps);
        for (unsigned k = 0; k < STP_LANE_STEP; k++)
            assert_true(abs(steps.around[k]) <= 2 * rows.columns * rows.rows);
        for (unsigned k = 0; k < STP_LANE_STEP && side == 1.0f; k++)
            assert_true(abs(steps.around[k]) <= rows.columns * 2 + 2 && steps.around[k] != 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(rows_find_the_least_cost),
                                       cmocka_unit_test(points_are_paired_with_discs_beside_them),
                                       cmocka_unit_test(long_cells_have_steps),
                                       cmocka_unit_test(holes_under_discs_are_measured),
                                       cmocka_unit_test(other_discs_are_in_no_rows)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
