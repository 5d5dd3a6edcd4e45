/* Tests --holes grow by what the file holds, disc by disc: no disc of any level and tier covers a
 * place without a sample, and the errors of each level hold how far samples lie from what is left
 * of it. Also that the bytes are the same for any number of threads, and what is refused. */
#include "tests/fixtures/hole_fixture.h"

#include <math.h>

#define OUT "test_holes_grow.stipple"

/* Places are rounded to some 1/100 of a cell. */
#define ROUNDED 0.02

static hole_mask *missing;

static bool is_missing(int column, int row)
{
    return column < 0 || row < 0 || column >= HOLE_SIDE || row >= HOLE_SIDE || missing(column, row);
}

/* Whether a place without a sample lies within a distance in the plane. */
static bool covers_hole(stp_dvec3 p, double radius)
{
    for (int row = (int)ceil(-p.y - radius); row <= -p.y + radius; row++)
        for (int column = (int)ceil(p.x - radius); column <= p.x + radius; column++)
            if (hypot(column - p.x, row + p.y) < radius && is_missing(column, row))
                return true;
    return false;
}

/* The finest samples under each patch of a chunk: [begins[p], begins[p + 1]) of places. */
typedef struct finest {
    stp_dvec3 *places;
    uint32_t *begins;
} finest;

typedef struct model {
    stp_chunk_file *file;
    finest *under; /* by chunk */
    uint32_t discs, limited;
} model;

/* Appends what lies under level-0 sample i of patch p. */
static uint32_t gather(const model *m, const stp_chunk_entry *entry, const stp_chunk *chunk,
                       uint32_t p, uint32_t i, stp_dvec3 *out)
{
    const stp_patch *patch = &chunk->patches[p];
    if (entry->child_count == 0) {
        const stp_sample *s = &chunk->samples[0][chunk->level_begin[0][p] + i];
        *out = stp_dvec3_add(entry->origin, stp_sample_position(s, patch));
        return 1;
    }
    const finest *below = &m->under[entry->first_child + patch->child];
    const uint32_t from = below->begins[patch->first_below + i];
    const uint32_t count = below->begins[patch->first_below + i + 1] - from;
    memcpy(out, below->places + from, count * sizeof *out);
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

static void judge_discs(model *m, const stp_chunk_entry *entry, const stp_chunk *chunk, uint32_t p)
{
    for (int level = 0; level < STP_LEVEL_COUNT; level++)
        for (uint32_t i = chunk->level_begin[level][p]; i < chunk->level_begin[level][p + 1]; i++) {
            const stp_sample *s = &chunk->samples[level][i];
            const stp_dvec3 c =
                stp_dvec3_add(entry->origin, stp_sample_position(s, &chunk->patches[p]));
            const double radius = stp_sample_radius(s, &chunk->patches[p]);
            m->discs++;
            m->limited += level > 0 && radius < 0.5 * ldexp(1.0, level);
            if (covers_hole(c, radius))
                fail_msg("depth %u, patch %u, level %d: a disc of %g at (%g, %g) covers a hole",
                         entry->depth, p, level, radius, c.x, c.y);
        }
}

static void judge_chunk(model *m, uint32_t id)
{
    stp_chunk_entry entry;
    stp_chunk *chunk = prep_chunk(m->file, id, &entry);
    finest *own = &m->under[id];
    uint32_t total = 0;
    own->places = calloc(HOLE_COUNT, sizeof *own->places);
    own->begins = calloc(chunk->patch_count + 1, sizeof *own->begins);
    assert_true(own->places != NULL && own->begins != NULL);
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        const stp_patch *patch = &chunk->patches[p];
        uint32_t begins[STP_PATCH_SAMPLES + 1] = {total};
        for (uint32_t i = 0; i < patch->counts[0]; i++) {
            total += gather(m, &entry, chunk, p, i, own->places + total);
            begins[i + 1] = total;
        }
        own->begins[p + 1] = total;
        judge_discs(m, &entry, chunk, p);
        for (int level = 0; level < STP_LEVEL_COUNT; level++)
            for (unsigned q = 0; q < (level % 3 == 0 ? 1 : patch->counts[2]); q++)
                judge_left(&entry, chunk, p, level, q, own->places, begins);
    }
    stp_chunk_destroy(&chunk);
}

static void judge(hole_mask *mask, uint32_t least_limited)
{
    stp_error error, *err = &error;
    stp_prep_stats stats;
    const stp_prep_params params = {.holes_grow = true};
    prep_cloud cloud = hole_cloud(mask);
    size_t sizes[2];
    uint8_t *bytes[2];
    missing = mask;
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
    print_message("%u discs, %u of merged samples much smaller than their cells\n", m.discs,
                  m.limited);
    assert_true(m.limited >= least_limited);
    for (uint32_t id = 0; id < info->chunk_count; id++) {
        free(m.under[id].places);
        free(m.under[id].begins);
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
    judge(hole_scattered, 1000);
}

static void stripes(void **state)
{
    (void)state;
    judge(hole_stripes, 100);
}

static void discs(void **state)
{
    (void)state;
    judge(hole_discs, 100);
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
    judge(none, 0);
}

/* Points, and grids that are bent, have no columns and rows that tell where samples are missing. */
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
