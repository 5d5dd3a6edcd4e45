/* Tests --holes grow by what the file holds, disc by disc: no disc of any level and tier covers a
 * place without a sample, and the errors of each level hold how far samples lie from what is left
 * of it; of level and bent grids, and of images. Also that the bytes are the same for any number of
 * threads, and what is refused. */
#include "tests/fixtures/hole_fixture.h"

#include <math.h>

#define OUT "test_holes_grow.stipple"

/* Places are rounded to some 1/100 of a cell. */
#define ROUNDED 0.02

static hole_mask *missing;

/* A grid of heights whose cells are squares, one that bends, and images: from a camera that looks
 * along z, from one that is turned, and from two. */
typedef enum kind { LEVEL, BENT, IMAGE, TURNED, TWO } kind;
static kind shape;

/* Pixels are about as wide as the grid's cells. */
enum { FOCUS = 600 };
#define TURN 0.4
static const stp_dvec3 stations[2] = {{10.0, -20.0, 5.0}, {90.0, 40.0, -10.0}};

static bool is_image(void)
{
    return shape >= IMAGE;
}

/* Samples are missing elsewhere in the second image. */
static bool is_missing(uint32_t image, int column, int row)
{
    const int c = image == 0 ? column : HOLE_SIDE - 1 - row, r = image == 0 ? row : column;
    return column < 0 || row < 0 || column >= HOLE_SIDE || row >= HOLE_SIDE || missing(c, r);
}

/* The direction of a pixel, at depth 1 along the camera's axis. */
static stp_dvec3 ray_of(int column, int row)
{
    const stp_dvec3 v = {(column - 255.5) / FOCUS, (row - 240.25) / FOCUS, 1.0},
                    y = {0.0, 1.0, 0.0};
    return shape == TURNED ? stp_dvec3_rotate(v, y, TURN) : v;
}

/* A sample; missing ones lie anywhere. Images have a jump. */
static stp_dvec3 place_of(uint32_t image, int column, int row)
{
    const double height = hole_height(column, row);
    const double depth = (column + row / 2 < 350 ? 500.0 : 700.0) + 3.0 * height + 0.2 * row;
    if (is_image())
        return stp_dvec3_add(stations[image], stp_dvec3_scale(ray_of(column, row), depth));
    if (shape == BENT)
        return (stp_dvec3){1000.0 + column + 2.0 * sin(row / 200.0) + 0.1 * row,
                           500.0 - 1.2 * row + 1.5 * sin(column / 180.0), height};
    return (stp_dvec3){column, -row, height};
}

/* How far a place lies from a missing sample, in the plane, or from its ray. */
static double distance_from(uint32_t image, int column, int row, stp_dvec3 p)
{
    if (is_image()) {
        const stp_dvec3 ray = stp_dvec3_normalize(ray_of(column, row));
        return stp_dvec3_length(stp_dvec3_cross(ray, stp_dvec3_sub(p, stations[image])));
    }
    const stp_dvec3 at = place_of(image, column, row);
    return hypot(p.x - at.x, p.y - at.y);
}

/* About the column and row of a place, and how many cells a length there has at most. */
static double find_cell(uint32_t image, stp_dvec3 p, double length, double at[2])
{
    if (is_image()) {
        const stp_dvec3 y = {0.0, 1.0, 0.0};
        stp_dvec3 v = stp_dvec3_sub(p, stations[image]);
        if (shape == TURNED)
            v = stp_dvec3_rotate(v, y, -TURN);
        at[0] = 255.5 + FOCUS * v.x / v.z;
        at[1] = 240.25 + FOCUS * v.y / v.z;
        return 1.5 * FOCUS * length / v.z + 1.0;
    }
    at[1] = shape == BENT ? (500.0 - p.y) / 1.2 : -p.y;
    at[0] = shape == BENT ? p.x - 1000.0 - 0.1 * at[1] : p.x;
    return shape == BENT ? length + 5.0 : length;
}

/* Whether a disc of this radius lies over a place without a sample. */
static bool covers_hole(uint32_t image, stp_dvec3 p, double radius)
{
    double at[2];
    const double reach = find_cell(image, p, radius, at);
    for (int row = (int)ceil(at[1] - reach); row <= at[1] + reach; row++)
        for (int column = (int)ceil(at[0] - reach); column <= at[0] + reach; column++)
            if (is_missing(image, column, row) && distance_from(image, column, row, p) < radius)
                return true;
    return false;
}

/* The finest samples under each patch of a chunk: [begins[p], begins[p + 1]) of places, all of an
 * image. */
typedef struct finest {
    stp_dvec3 *places;
    uint32_t *begins, *images;
} finest;

typedef struct model {
    stp_chunk_file *file;
    finest *under; /* by chunk */
    uint32_t discs, limited;
} model;

/* Appends what lies under level-0 sample i of patch p. *image: whose it is. */
static uint32_t gather(const model *m, const stp_chunk_entry *entry, const stp_chunk *chunk,
                       uint32_t p, uint32_t i, stp_dvec3 *out, uint32_t *image)
{
    const stp_patch *patch = &chunk->patches[p];
    if (entry->child_count == 0) {
        const stp_sample *s = &chunk->samples[0][chunk->level_begin[0][p] + i];
        *out = stp_dvec3_add(entry->origin, stp_sample_position(s, patch));
        *image = prep_number_of(s) / HOLE_COUNT;
        return 1;
    }
    const finest *below = &m->under[entry->first_child + patch->child];
    const uint32_t from = below->begins[patch->first_below + i];
    const uint32_t count = below->begins[patch->first_below + i + 1] - from;
    memcpy(out, below->places + from, count * sizeof *out);
    *image = below->images[patch->first_below + i];
    return count;
}

/* How far the place lies from the nearest of a patch's discs. */
static double distance_to(const stp_dvec3 place, const stp_chunk_entry *entry,
                          const stp_chunk *chunk, uint32_t p, int level, unsigned from, unsigned to)
{
    double least = INFINITY;
    for (unsigned j = from; j < to; j++) {
        const stp_sample *s = &chunk->samples[level][chunk->level_begin[level][p] + j];
        const stp_dvec3 c =
            stp_dvec3_add(entry->origin, stp_sample_position(s, &chunk->patches[p]));
        least = fmin(least, stp_dvec3_length(stp_dvec3_sub(place, c)) -
                                stp_sample_radius(s, &chunk->patches[p]));
    }
    return least;
}

/* Judges a level of a quarter. places: of the finest samples under sample i: [begins[i], ...). */
static void judge_left(const stp_chunk_entry *entry, const stp_chunk *chunk, uint32_t p, int level,
                       unsigned q, const stp_dvec3 *places, const uint32_t *begins)
{
    const stp_patch *patch = &chunk->patches[p];
    const bool whole = level % 3 == 0;
    const unsigned from = whole ? 0 : stp_quarter_begin(patch->counts, level, q);
    const unsigned to =
        whole ? patch->counts[level] : stp_quarter_begin(patch->counts, level, q + 1);
    const uint32_t first = whole ? 0 : stp_quarter_begin(patch->counts, 0, q);
    const uint32_t last = whole ? patch->counts[0] : stp_quarter_begin(patch->counts, 0, q + 1);
    const double held =
        stp_error_decode(stp_quarter_error(patch, level, q), patch->exponent) +
        stp_error_decode(stp_quarter_tangential_error(patch, level, q), patch->exponent);
    for (uint32_t i = begins[first]; i < begins[last]; i++) {
        const double off = distance_to(places[i], entry, chunk, p, level, from, to);
        if (off > held + ROUNDED)
            fail_msg("chunk %u, patch %u, level %d: (%g, %g) is %g off, %g held", entry->depth, p,
                     level, places[i].x, places[i].y, off, held);
    }
}

static void judge_discs(model *m, const stp_chunk_entry *entry, const stp_chunk *chunk, uint32_t p,
                        uint32_t image)
{
    for (int level = 0; level < STP_LEVEL_COUNT; level++)
        for (uint32_t i = chunk->level_begin[level][p]; i < chunk->level_begin[level][p + 1]; i++) {
            const stp_sample *s = &chunk->samples[level][i];
            const stp_dvec3 c =
                stp_dvec3_add(entry->origin, stp_sample_position(s, &chunk->patches[p]));
            const double radius = stp_sample_radius(s, &chunk->patches[p]);
            m->discs++;
            m->limited += level > 0 && radius < 0.5 * ldexp(1.0, level);
            if (covers_hole(image, c, radius))
                fail_msg("depth %u, patch %u, level %d: a disc of %g at (%g, %g, %g) covers a hole",
                         entry->depth, p, level, radius, c.x, c.y, c.z);
        }
}

static void judge_chunk(model *m, uint32_t id)
{
    stp_chunk_entry entry;
    stp_chunk *chunk = prep_chunk(m->file, id, &entry);
    finest *own = &m->under[id];
    uint32_t total = 0;
    own->places = calloc((size_t)2 * HOLE_COUNT, sizeof *own->places);
    own->begins = calloc(chunk->patch_count + 1, sizeof *own->begins);
    own->images = calloc(chunk->patch_count, sizeof *own->images);
    assert_true(own->places != NULL && own->begins != NULL && own->images != NULL);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        uint32_t begins[STP_PATCH_SAMPLES + 1] = {total};
        for (uint32_t i = 0; i < patch->counts[0]; i++) {
            uint32_t image = 0;
            total += gather(m, &entry, chunk, p, i, own->places + total, &image);
            begins[i + 1] = total;
            assert_true(i == 0 || image == own->images[p]);
            own->images[p] = image;
        }
        own->begins[p + 1] = total;
        judge_discs(m, &entry, chunk, p, own->images[p]);
        for (int level = 0; level < STP_LEVEL_COUNT; level++)
            for (unsigned q = 0; q < (level % 3 == 0 ? 1 : patch->counts[2]); q++)
                judge_left(&entry, chunk, p, level, q, own->places, begins);
    }
    stp_chunk_destroy(&chunk);
}

static prep_cloud make_cloud(stp_dvec3 *nodes)
{
    const uint32_t images = shape == TWO ? 2 : 1;
    prep_cloud out = prep_cloud_make((size_t)images * HOLE_COUNT);
    for (uint32_t i = 0; i < out.count; i++) {
        const int column = i % HOLE_SIDE, row = (int)(i % HOLE_COUNT / HOLE_SIDE);
        stp_point *p = &out.points[i];
        p->position = place_of(i / HOLE_COUNT, column, row);
        p->reject = is_missing(i / HOLE_COUNT, column, row) ? STP_REJECT_INVALID : STP_REJECT_NONE;
        p->station = is_image() ? (uint16_t)(i / HOLE_COUNT + 1) : 0;
        p->normal.z = is_image() ? 0.0f : 1.0f;
    }
    if (is_image()) {
        out.image_count = images;
        out.image = (stp_scan_grid){.columns = HOLE_SIDE, .rows = HOLE_SIDE};
        out.stations = stations;
        return out;
    }
    out.raster = (stp_scan_raster){.columns = HOLE_SIDE, .rows = HOLE_SIDE, .dx = 1.0, .dy = 1.0};
    const uint32_t across = stp_raster_node_count(HOLE_SIDE);
    for (uint32_t i = 0; nodes && i < across * across; i++) {
        nodes[i] = place_of(0, (int)stp_raster_node_column(i % across, HOLE_SIDE),
                            (int)stp_raster_node_column(i / across, HOLE_SIDE));
        nodes[i].z = 0.0;
    }
    out.raster_nodes = shape == BENT ? nodes : NULL;
    return out;
}

static void judge(hole_mask *mask, kind of, uint32_t least_limited)
{
    stp_error error, *err = &error;
    stp_prep_stats stats;
    stp_dvec3 nodes[(HOLE_SIDE / STP_RASTER_NODE + 2) * (HOLE_SIDE / STP_RASTER_NODE + 2)];
    const stp_prep_params params = {.holes_grow = true};
    missing = mask;
    shape = of;
    prep_cloud cloud = make_cloud(nodes);
    size_t sizes[2];
    uint8_t *bytes[2];
    for (unsigned k = 0; k < 2; k++) {
        assert_int_equal(prep_cloud_run(&cloud, OUT, 1 + 2 * k, &params, &stats, err), STP_OK);
        bytes[k] = prep_file_bytes(OUT, &sizes[k]);
    }
    assert_int_equal(sizes[0], sizes[1]);
    assert_memory_equal(bytes[0], bytes[1], sizes[0]);
    model m = {.file = prep_open_verified(OUT)};
    const stp_chunk_file_info *info = stp_chunk_file_get_info(m.file);
    assert_non_null(strstr(info->metadata_json, "\"holes\":\"grow\""));
    m.under = calloc(info->chunk_count, sizeof *m.under);
    assert_non_null(m.under);
    for (uint32_t id = info->chunk_count; id-- > 0;) /* children before parents */
        judge_chunk(&m, id);
    print_message("kind %d: %u discs, %u of merged samples much smaller than their cells\n",
                  (int)of, m.discs, m.limited);
    assert_true(m.limited >= least_limited);
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        free(m.under[id].places);
        free(m.under[id].begins);
        free(m.under[id].images);
    }
    free(m.under);
    stp_chunk_file_close(&m.file);
    for (unsigned k = 0; k < 2; k++)
        free(bytes[k]);
    free(cloud.points);
}

static void scattered(void **state)
{
    (void)state;
    judge(hole_scattered, LEVEL, 1000);
    judge(hole_scattered, BENT, 1000);
    judge(hole_scattered, TURNED, 1000);
}

static void stripes(void **state)
{
    (void)state;
    judge(hole_stripes, LEVEL, 100);
    judge(hole_stripes, IMAGE, 100);
}

static void discs(void **state)
{
    (void)state;
    judge(hole_discs, LEVEL, 100);
    judge(hole_discs, TWO, 100);
}

static bool none(int column, int row)
{
    (void)column;
    (void)row;
    return false;
}

static void whole(void **state)
{
    (void)state;
    judge(none, LEVEL, 0);
    judge(none, TURNED, 0);
}

/* Points, and images that become points, do not tell where samples are missing. */
static void others_are_refused(void **state)
{
    (void)state;
    stp_error error, *err = &error;
    stp_prep_stats stats;
    const stp_prep_params params = {.holes_grow = true};
    prep_cloud cloud = prep_cloud_wavy(1000, (stp_dvec3){0.0, 0.0, 0.0}, 1.0);
    assert_int_equal(prep_cloud_run(&cloud, OUT, 1, &params, &stats, err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "--holes grow"));
    free(cloud.points);
    missing = none;
    shape = IMAGE;
    cloud = make_cloud(NULL);
    for (size_t i = 0; i < cloud.count; i++)
        cloud.points[i].position.x += 20.0 * stp_random_unit(3, i);
    assert_int_equal(prep_cloud_run(&cloud, OUT, 1, &params, &stats, err), STP_INVALID_ARGUMENT);
    assert_non_null(strstr(error.message, "--holes grow"));
    free(cloud.points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scattered),
        cmocka_unit_test(stripes),
        cmocka_unit_test(discs),
        cmocka_unit_test(whole),
        cmocka_unit_test(others_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
