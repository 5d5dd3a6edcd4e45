/* Tests depth cameras' images that stay grids of pixels: every point is stored once, a patch has
 * the pixels of one square and of one surface, whatever way a camera looks, and of a scanner, whose
 * steps are equal angles; images whose points lie on no rays become points, and single points that
 * do not are points beside their image; the same bytes for any
 * number of threads and any memory. The file's own promises are verified in each case. */
#include "formats/chunk/codec/square/square.h"
#include "formats/chunk/sample/normal_grid.h"
#include "preprocess/patch/patch_build.h"
#include "tests/fixtures/prep_fixture.h"

#include <math.h>

#define OUT "test_depth_image.stipple"

enum { COLUMNS = 150, ROWS = 90, COUNT = COLUMNS * ROWS, FOCUS = 120 };

/* A ball before a wall. */
static const stp_dvec3 ball = {0.3, -0.1, 3.0};
#define RADIUS 0.7

/* What a test makes its image of. */
typedef struct recipe {
    int facing;       /* which way the camera looks: 0 to FACINGS - 1 */
    bool apart;       /* most pixels are missing: the others lie apart */
    bool holes;       /* some pixels are missing, and so is a rectangle */
    bool steps;       /* depths come in steps, as those of disparities */
    bool waves;       /* all surfaces have waves, so that normals change from pixel to pixel */
    double distorted; /* how far rays at the left and right are off, in pixels */
    double rough;     /* how far columns of rays are off at most, this way and that, in pixels */
    double turned;    /* the camera is turned in space, radians */
    unsigned told;    /* so many tenths of samples lie where column, row and depth tell, at least */
    bool scanner;     /* steps from pixel to pixel are equal angles */
    size_t no_image;  /* of how many files, the last ones, the pixels are points of no image */
} recipe;

/* Columns, rows and depths go along these axes of the world, 1 to 3, with a sign: as cameras have
 * it, as OpenGL does, as robots do, turned in the image, along y, mirrored. */
enum { FACINGS = 6 };
static const int facings[FACINGS][3] = {{1, 2, 3},  {1, -2, -3}, {-2, -3, 1},
                                        {-2, 1, 3}, {1, -3, 2},  {-1, 2, 3}};
static const stp_dvec3 stations[2] = {{0.0, 0.0, 0.0}, {40.0, -25.0, 8.0}};

/* In pixels. Steps of half a degree are too wide for rays that are linear in 8 x 8 pixels. */
static double focus_of(const recipe *r)
{
    return r->turned > 0.0 || r->scanner ? 2.0 * FOCUS : FOCUS;
}

/* The depth along a ray, and whether it hits the ball. */
static double depth_of(double x, double y, bool *hits)
{
    const double a = x * x + y * y + 1.0, b = x * ball.x + y * ball.y + ball.z;
    const double c = stp_dvec3_dot(ball, ball) - RADIUS * RADIUS, root = b * b - a * c;
    *hits = root > 0.0;
    return *hits ? (b - sqrt(root)) / a : 5.0 / (1.0 - 0.2 * x + 0.1 * y);
}

static bool is_missing(const recipe *r, int column, int row)
{
    if (r->apart)
        return column % 13 != 0 || row % 11 != 0;
    return r->holes && ((column * 7 + row * 13) % 31 == 0 ||
                        (column > 60 && column < 75 && row > 30 && row < 52));
}

static double component(stp_dvec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

/* Turns around (2, 1, 2) / 3. */
static stp_dvec3 turn(stp_dvec3 v, double angle)
{
    const stp_dvec3 axis = {2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0};
    const stp_dvec3 along = stp_dvec3_scale(axis, stp_dvec3_dot(axis, v) * (1.0 - cos(angle)));
    const stp_dvec3 across = stp_dvec3_scale(stp_dvec3_cross(axis, v), sin(angle));
    return stp_dvec3_add(stp_dvec3_add(stp_dvec3_scale(v, cos(angle)), across), along);
}

static stp_dvec3 place_of(const recipe *r, stp_dvec3 camera, stp_dvec3 station)
{
    double out[3];
    camera = turn(camera, r->turned);
    for (int i = 0; i < 3; i++) {
        const int axis = abs(facings[r->facing][i]) - 1;
        out[axis] =
            component(station, axis) + copysign(1.0, facings[r->facing][i]) * component(camera, i);
    }
    return (stp_dvec3){out[0], out[1], out[2]};
}

/* Appends an image to the cloud. */
static void add_image(const recipe *r, stp_dvec3 station, stp_point *points, bool *of_ball)
{
    for (int i = 0; i < COUNT; i++) {
        const int column = i % COLUMNS, row = i / COLUMNS;
        const double bend = (column - 75.0) / 75.0;
        const double rough = r->rough * ((column * 37 + row * 17) % 11 - 5) / 5.0;
        const double off = r->distorted * bend * bend * bend + rough;
        double x = (column - 70.5 + off) / focus_of(r), y = (row - 45.25) / focus_of(r);
        if (r->scanner) {
            y = tan(y) / cos(x);
            x = tan(x);
        }
        double z = depth_of(x, y, &of_ball[i]);
        if (r->waves)
            z *= 1.0 + 0.02 * sin(30.0 * x);
        if (r->steps)
            z = 300.0 / nearbyint(300.0 / z);
        points[i].position = place_of(r, (stp_dvec3){x * z, y * z, z}, station);
        points[i].station = 1;
        points[i].reject = is_missing(r, column, row) ? STP_REJECT_INVALID : STP_REJECT_NONE;
    }
}

/* Images and what is known of them. */
typedef struct images {
    prep_cloud cloud;
    bool *of_ball;
    const recipe *recipe;
    size_t count;
} images;

static images make_images(const recipe *r, size_t count)
{
    images out = {.cloud = prep_cloud_make(count * COUNT), .recipe = r, .count = count};
    out.of_ball = calloc(count * COUNT, sizeof *out.of_ball);
    assert_non_null(out.of_ball);
    for (size_t i = 0; i < count; i++) {
        add_image(r, stations[i], out.cloud.points + i * COUNT, out.of_ball + i * COUNT);
        for (int k = 0; k < COUNT; k++)
            out.cloud.points[i * COUNT + (size_t)k].station = (uint16_t)(i + 1);
    }
    return out;
}

static void clear_images(images *m)
{
    free(m->cloud.points);
    free(m->of_ball);
}

static void run(images *m, unsigned threads, const stp_prep_params *params, stp_prep_stats *stats)
{
    stp_prep_params own = params ? *params : (stp_prep_params){.codec = STP_CODEC_DRACO};
    stp_prep_file files[2] = {0};
    stp_pool *pool = NULL;
    stp_error err = {0};
    for (uint32_t i = 0; i < m->count; i++)
        files[i] = (stp_prep_file){.name = "an image",
                                   .point_count = COUNT,
                                   .grid = {m->count - i > m->recipe->no_image ? COLUMNS : 0, ROWS},
                                   .station_begin = i,
                                   .station_count = 1};
    const stp_prep_source source = {.context = &m->cloud,
                                    .read = prep_cloud_read,
                                    .point_count = m->cloud.count,
                                    .attributes = STP_POINT_HAS_COLOUR | STP_POINT_HAS_CLASS |
                                                  STP_POINT_HAS_STATION,
                                    .stations = stations,
                                    .station_count = (uint32_t)m->count,
                                    .files = files,
                                    .file_count = m->count};
    m->cloud.given = 0;
    own.force = true;
    assert_int_equal(stp_pool_create(&pool, threads, &err), STP_OK);
    if (stp_prep_run(OUT, &source, &own, pool, NULL, stats, &err) != STP_OK)
        fail_msg("%s", err.message);
    stp_pool_destroy(&pool);
}

/* What is found in the file. */
typedef struct found {
    uint8_t seen[2 * COUNT];
    vec3s normals[2 * COUNT];
    size_t patches, leaves, square_leaves;
    size_t wide_patches;  /* of pixels that lie in no common square */
    size_t told, samples; /* of squares: whose places column, row and depth tell to half a step */
    size_t skewed;        /* patches whose columns and rows do not go along axes */
    double off_most;
    double width_off; /* octaves: of a radius from what the stored normal and the distance tell */
} found;

/* The same of a disc seen from a camera that looks along z, at a position from it. */
static double width_off(stp_dvec3 at, vec3s normal, double radius)
{
    const double x = at.x / at.z, y = at.y / at.z, all = 1.0 + x * x + y * y;
    const double side = at.z / FOCUS * sqrt(1.0 + fmax(x * x, y * y)) / sqrt(all);
    const double facing = stp_dvec3_dot(stp_dvec3_from_float(normal), stp_dvec3_normalize(at));
    return fabs(log2(radius / (1.7 * side * sqrt(stp_stretch(facing)))));
}

/* Counts the samples of a square that lie where their raster says. */
static void note_square(found *f, const stp_chunk *chunk, uint32_t p, const stp_sample *samples)
{
    const stp_square *square = &chunk->squares[p];
    const stp_raster *raster = &chunk->rasters[square->raster];
    const double half = 0.501 * ldexp(1.0, chunk->patches[p].exponent);
    assert_true(stp_raster_spreads(raster) && raster->stops);
    unsigned slopes = 0;
    for (unsigned n = 0; n < 4; n++)
        slopes += raster->across[n / 2][4 + n % 2] != 0.0;
    f->skewed += slopes > 2;
    for (unsigned i = 0, k = 0; i < 64; i++) {
        if (!(square->samples >> i & 1u))
            continue;
        const stp_dvec3 at = stp_sample_position(&samples[k++], &chunk->patches[p]);
        const double column = square->column * 8 + stp_square_column(i);
        const double row = square->row * 8 + stp_square_row(i);
        double off = 0.0;
        for (unsigned n = 0; n < 2; n++) {
            const double *a = raster->across[n];
            const double place =
                a[0] + column * a[1] + row * a[2] +
                (a[3] + column * a[4] + row * a[5]) * component(at, (int)raster->axis);
            off = fmax(off, fabs(place - component(at, (int)(raster->axis + 1 + n) % 3)));
        }
        f->told += off <= half;
        f->samples++;
    }
}

/* Errors of merged samples are rounded up to a quarter of an octave. */
static void check_errors(const stp_patch *patch)
{
    for (int l = 1; l < STP_LEVEL_COUNT; l++)
        assert_int_equal((patch->error[l] | patch->tangential_error[l]) & 1, 0);
    for (int l = 0; l < 2; l++)
        for (int q = 0; q < STP_PATCH_QUARTERS; q++)
            assert_int_equal(
                (patch->quarter_error[l][q] | patch->quarter_tangential_error[l][q]) & 1, 0);
}

/* Radii of merged samples are rounded to half octaves. */
static void check_radii(const stp_chunk *chunk, uint32_t p)
{
    for (int l = 1; l < STP_LEVEL_COUNT; l++)
        for (uint32_t i = chunk->level_begin[l][p]; i < chunk->level_begin[l][p + 1]; i++)
            assert_int_equal((chunk->samples[l][i].radius - 1) % 8, 0);
}

static void note_patch(found *f, const images *m, const stp_chunk *chunk, uint32_t p,
                       const stp_chunk_entry *entry)
{
    const stp_patch *patch = &chunk->patches[p];
    const stp_sample *samples = &chunk->samples[0][chunk->level_begin[0][p]];
    const uint32_t first = prep_number_of(samples);
    bool wide = false;
    f->patches++;
    if (chunk->squares) {
        note_square(f, chunk, p, samples);
        check_errors(patch);
        check_radii(chunk, p);
    }
    for (unsigned k = 0; k < patch->counts[0]; k++) {
        const uint32_t i = prep_number_of(&samples[k]), column = i % COUNT % COLUMNS,
                       row = i % COUNT / COLUMNS;
        assert_in_range(i, 0, m->cloud.count - 1);
        assert_int_equal(f->seen[i]++, 0);
        f->normals[i] = stp_normal_decode(samples[k].normal);
        assert_int_equal(m->cloud.points[i].reject, STP_REJECT_NONE);
        const stp_dvec3 at = stp_dvec3_add(entry->origin, stp_sample_position(&samples[k], patch));
        const double off = stp_dvec3_length(stp_dvec3_sub(at, m->cloud.points[i].position));
        f->off_most = fmax(f->off_most, off);
        f->width_off =
            fmax(f->width_off, width_off(stp_dvec3_sub(m->cloud.points[i].position, stations[0]),
                                         f->normals[i], stp_sample_radius(&samples[k], patch)));
        wide |= column / 8 != first % COUNT % COLUMNS / 8 || row / 8 != first % COUNT / COLUMNS / 8;
        if (!chunk->squares)
            continue;
        assert_int_equal(i / COUNT, first / COUNT);
        assert_int_equal(m->of_ball[i], m->of_ball[first]);
        /* discs of neighbours meet, on a surface that faces the camera */
        assert_true(stp_sample_radius(&samples[k], patch) > 0.9 / focus_of(m->recipe) * 2.0);
    }
    f->wide_patches += wide;
}

/* Reads the file back after verifying it. Free with free(). */
static found *read_back(const images *m)
{
    found *f = calloc(1, sizeof *f);
    assert_non_null(f);
    stp_chunk_file *file = prep_open_verified(OUT);
    for (uint32_t id = 0; id < stp_chunk_file_get_info(file)->chunk_count; id++) {
        stp_chunk_entry entry;
        stp_chunk *chunk = prep_chunk(file, id, &entry);
        for (uint32_t p = 0; entry.child_count == 0 && p < chunk->patch_count; p++)
            note_patch(f, m, chunk, p, &entry);
        if (entry.child_count == 0 && chunk->squares) /* blocks of images are large */
            assert_in_range(entry.block_count, 1, 1 + entry.sample_count[0] / 8192);
        f->leaves += entry.child_count == 0;
        f->square_leaves += entry.child_count == 0 && chunk->squares;
        stp_chunk_destroy(&chunk);
    }
    stp_chunk_file_close(&file);
    for (size_t i = 0; i < m->cloud.count; i++)
        assert_int_equal(f->seen[i], m->cloud.points[i].reject == STP_REJECT_NONE);
    return f;
}

static size_t file_size(void)
{
    size_t size;
    free(prep_file_bytes(OUT, &size));
    return size;
}

/* Prepares images, which become squares; returns the file's size. */
static size_t check_squares(const recipe *r, size_t count)
{
    stp_prep_stats stats;
    images m = make_images(r, count);
    run(&m, 2, NULL, &stats);
    found *f = read_back(&m);
    const size_t squares = count * ((COLUMNS + 7) / 8 + 1) * ((ROWS + 7) / 8 + 1);
    assert_int_equal(f->square_leaves, f->leaves);
    assert_int_equal(f->wide_patches, 0);
    if (r->turned == 0.0 && !r->scanner && r->distorted == 0.0)
        assert_int_equal(f->skewed, 0);
    print_message("%zu of %zu samples are told\n", f->told, f->samples);
    assert_true(f->told * 10 > f->samples * r->told);
    assert_in_range(f->patches, 1, squares + squares / 2);
    assert_int_equal(stats.tree.displacement.beyond, 0);
    assert_true(fabs(stats.tree.displacement.greatest - f->off_most) < 1e-12);
    assert_true(f->off_most < 8.0 / FOCUS / 16.0);
    free(f);
    clear_images(&m);
    return file_size();
}

static void patches_are_squares(void **state)
{
    (void)state;
    for (int kind = 0; kind < 3; kind++) {
        size_t least = SIZE_MAX, most = 0;
        for (int facing = 0; facing < FACINGS; facing++) {
            const recipe r = {.facing = facing, .holes = kind > 0, .steps = kind > 1, .told = 9};
            const size_t size = check_squares(&r, 1);
            least = size < least ? size : least;
            most = size > most ? size : most;
        }
        print_message("bytes: %zu to %zu, by how the camera looks\n", least, most);
        assert_true(most < least + least / 20);
    }
}

static void images_of_two_cameras(void **state)
{
    (void)state;
    check_squares(&(recipe){.holes = true, .told = 9}, 2);
}

/* The same points, as those of no image, take a third as much again. */
static void squares_save_bytes(void **state)
{
    stp_prep_stats stats;
    const size_t squares = check_squares(&(recipe){.holes = true, .told = 9}, 1);
    images m = make_images(&(recipe){.holes = true, .no_image = 1}, 1);
    (void)state;
    run(&m, 2, NULL, &stats);
    free(read_back(&m));
    print_message("bytes: squares %zu, points %zu\n", squares, file_size());
    assert_true(file_size() > squares + squares / 3);
    clear_images(&m);
}

/* Prepares a camera's image whose depths come in steps, with so many bits for normals. */
static found *prepare_steps(bool waves, unsigned bits, size_t *bytes)
{
    const recipe r = {.steps = true, .waves = waves};
    const stp_prep_params params = {.codec = STP_CODEC_DRACO, .normal_bits = bits};
    stp_prep_stats stats;
    images m = make_images(&r, 1);
    run(&m, 2, &params, &stats);
    found *f = read_back(&m);
    *bytes = file_size();
    assert_true(stats.normals_seen > 0);
    assert_int_equal(stats.normal_bits, bits ? bits : 8);
    clear_images(&m);
    return f;
}

/* Noisy normals follow from merged ones, unless they are 5 to 10 degrees off, and take fewer bytes;
 * where they change from pixel to pixel they have fewer than 8 bits, but not fewer than 6. If the
 * bits are given, all have them, and their own directions. Discs are as wide as stored normals ask
 * for. */
static void noisy_normals_follow(void **state)
{
    (void)state;
    for (int waves = 0; waves < 2; waves++) {
        size_t bytes[3];
        double sum = 0.0;
        found *fine = prepare_steps(waves, 12, &bytes[0]),
              *own = prepare_steps(waves, 0, &bytes[1]);
        found *given = prepare_steps(waves, 8, &bytes[2]);
        for (size_t i = 0; i < COUNT; i++) {
            const float off = glms_vec3_norm(glms_vec3_sub(fine->normals[i], own->normals[i]));
            const float same = glms_vec3_norm(glms_vec3_sub(fine->normals[i], given->normals[i]));
            assert_true((double)same <= 1.1 * stp_normal_grid_angle(8));
            assert_true((double)off <= 0.175 + 1.1 * stp_normal_grid_angle(6));
            sum += (double)off;
        }
        print_message("%g off, %zu bytes, with 8 bits %zu; radii off by %g octaves\n", sum / COUNT,
                      bytes[1], bytes[2], own->width_off);
        assert_true(own->width_off < 0.19);
        assert_true(sum / COUNT < stp_normal_grid_angle(waves ? 6 : 7));
        assert_in_range(bytes[1], 1, bytes[2] - bytes[2] / (waves ? 5 : 20));
        free(fine);
        free(own);
        free(given);
    }
}

/* Prepares images, which become points, and frees them. */
static void expect_points(images *m)
{
    stp_prep_stats stats;
    run(m, 2, NULL, &stats);
    found *f = read_back(m);
    assert_int_equal(f->square_leaves, 0);
    assert_true(f->wide_patches > f->patches / 4);
    free(f);
    clear_images(m);
}

static void turned_cameras(void **state)
{
    (void)state;
    for (int i = 1; i < 8; i++)
        check_squares(
            &(recipe){.facing = i % FACINGS, .turned = 0.4 * i, .holes = i % 2, .told = 5}, 1);
}

static void scanners(void **state)
{
    (void)state;
    for (int i = 0; i < 4; i++)
        check_squares(&(recipe){.turned = 0.7 * i, .scanner = true, .holes = i % 2, .told = 6}, 2);
    check_squares(&(recipe){.scanner = true, .rough = 0.1}, 1);
}

static void lenses(void **state)
{
    (void)state;
    check_squares(&(recipe){.distorted = 0.01, .told = 9}, 1);
    check_squares(&(recipe){.distorted = 2.0, .told = 7}, 1);
}

static void rough_rays_become_points(void **state)
{
    images m = make_images(&(recipe){.rough = 0.6}, 1);
    (void)state;
    expect_points(&m);
}

/* If a scan is no image, the image beside it becomes points. */
static void other_points_beside_an_image(void **state)
{
    images m = make_images(&(recipe){.holes = true, .no_image = 1}, 2);
    (void)state;
    expect_points(&m);
}

/* Moves so many points of the first image off their rays: behind the camera, to its very place,
 * aside, far away. */
static void move_off(images *m, int count)
{
    static const stp_dvec3 away[4] = {
        {0.0, 0.0, -20.0}, {0.0, 0.0, 0.0}, {0.07, 0.0, 0.0}, {1e4, -3e3, 10.0}};
    for (int i = 0; i < count; i++) {
        stp_dvec3 *at = &m->cloud.points[(75 + i * 997 + 31 * (i % 7)) % COUNT].position;
        *at = i % 4 == 1 ? stations[0] : stp_dvec3_add(*at, away[i % 4]);
    }
}

/* Prepares two images, points of one off their rays. Returns how many points are beside the images.
 * Each point is stored once, and verified (read_back). */
static uint32_t beside(const recipe *r, int off, size_t *square_leaves)
{
    stp_prep_stats stats;
    images m = make_images(r, 2);
    move_off(&m, off);
    run(&m, 2, NULL, &stats);
    found *f = read_back(&m);
    *square_leaves = f->square_leaves;
    assert_int_equal(stats.images, f->square_leaves > 0 ? 2 : 0);
    free(f);
    clear_images(&m);
    return (uint32_t)stats.pixels_loose;
}

/* Pixels off their rays are points beside the image, whose other pixels stay squares: neither fewer
 * than were moved nor more. If they are many, all become points. */
static void points_off_their_rays(void **state)
{
    static const recipe kinds[] = {
        {.facing = 0}, {.facing = 3, .turned = 0.9, .holes = true}, {.scanner = true}};
    size_t leaves;
    (void)state;
    for (size_t k = 0; k < sizeof kinds / sizeof *kinds; k++)
        for (int off = 1; off < 300; off *= 6) {
            const uint32_t loose = beside(&kinds[k], off, &leaves);
            print_message("%d points off their rays, %u beside the images\n", off, loose);
            assert_true(leaves > 0);
            assert_in_range(loose, off - off / 8, off + off / 8);
        }
    beside(&kinds[0], COUNT / 4, &leaves);
    assert_int_equal(leaves, 0);
}

static void pixels_apart_become_points(void **state)
{
    stp_prep_stats stats;
    images m = make_images(&(recipe){.apart = true}, 1);
    (void)state;
    run(&m, 2, NULL, &stats);
    found *f = read_back(&m);
    assert_int_equal(f->square_leaves, 0);
    assert_in_range(f->patches, 1, f->leaves * 10);
    free(f);
    clear_images(&m);
}

static void same_bytes(void **state)
{
    const recipe r = {.holes = true, .steps = true};
    size_t size[2];
    uint8_t *bytes[2];
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        stp_prep_stats stats;
        images m = make_images(&r, 2);
        run(&m, i ? 3 : 1, NULL, &stats);
        bytes[i] = prep_file_bytes(OUT, &size[i]);
        clear_images(&m);
    }
    assert_int_equal(size[0], size[1]);
    assert_memory_equal(bytes[0], bytes[1], size[0]);
    free(bytes[0]);
    free(bytes[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(patches_are_squares),
        cmocka_unit_test(images_of_two_cameras),
        cmocka_unit_test(squares_save_bytes),
        cmocka_unit_test(noisy_normals_follow),
        cmocka_unit_test(rough_rays_become_points),
        cmocka_unit_test(turned_cameras),
        cmocka_unit_test(scanners),
        cmocka_unit_test(lenses),
        cmocka_unit_test(other_points_beside_an_image),
        cmocka_unit_test(points_off_their_rays),
        cmocka_unit_test(same_bytes),
        cmocka_unit_test(pixels_apart_become_points),
    };
    return cmocka_run_group_tests_name("depth images", tests, NULL, NULL);
}
