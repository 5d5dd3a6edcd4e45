/* Tests sublattices: the nearest place is the nearest, none is farther than the reach says, blocks
 * whose radii and positions are coarse come back and are smaller, and prep puts points on them. */
#include "formats/chunk/codec/odds/tight.h"
#include "formats/chunk/codec/predict/predict.h"
#include "formats/chunk/sample/normal_grid.h"
#include "formats/chunk/sample/sublattice.h"
#include "preprocess/patch/patch_build.h"
#include "tests/fixtures/any_chunk.h"

#include <math.h>

static double squared_distance(const double a[3], const double b[3])
{
    double sum = 0.0;
    for (int i = 0; i < 3; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sum;
}

/* Whether a place is one of a sublattice, by its definition. */
static bool is_on(unsigned sublattice, const double place[3])
{
    const double step = ldexp(1.0, (int)(sublattice / 3));
    int odd = 0;
    if (sublattice >= STP_SLANTED)
        return fmod(place[0] + 2.0 * place[1] + 4.0 * place[2], 2.0 * sublattice - 25.0) == 0.0 &&
               fmod(place[0], 1.0) == 0.0 && fmod(place[1], 1.0) == 0.0 &&
               fmod(place[2], 1.0) == 0.0;
    for (int i = 0; i < 3; i++) {
        if (fmod(place[i], step) != 0.0)
            return false;
        odd += fmod(place[i] / step, 2.0) != 0.0;
    }
    return sublattice % 3 == 0 || (sublattice % 3 == 1 ? odd % 2 == 0 : odd == 0 || odd == 3);
}

static void nearest_is_nearest(void **state)
{
    (void)state;
    for (unsigned s = 0; s <= STP_SLANTED_MOST; s++) {
        const double step = s < STP_SLANTED ? ldexp(1.0, (int)(s / 3)) : 1.0;
        const double reach = stp_sublattice_reach(s);
        double farthest = 0.0;
        for (uint64_t n = 0; n < 3000; n++) {
            double place[3], found[3], other[3];
            for (uint64_t i = 0; i < 3; i++)
                place[i] = 200.0 * (stp_random_unit(s, 3 * n + i) - 0.5);
            stp_sublattice_nearest(s, place, found);
            assert_true(is_on(s, found));
            const double off = squared_distance(place, found);
            farthest = fmax(farthest, sqrt(off));
            for (int k = 0; k < 125; k++) {
                for (int i = 0, rest = k; i < 3; i++, rest /= 5)
                    other[i] = found[i] + step * (rest % 5 - 2);
                assert_true(!is_on(s, other) || squared_distance(place, other) >= off - 1e-9);
            }
        }
        assert_true(farthest <= reach && farthest >= 0.9 * reach);
    }
    /* From the one that reaches least to the one that reaches farthest. */
    static const unsigned in_order[] = {0, 1, 2, 15, 16, 17, 18, 3,  4, 5,
                                        6, 7, 8, 9,  10, 11, 12, 13, 14};
    for (unsigned k = 0; k < sizeof in_order / sizeof *in_order; k++) {
        const double reach = stp_sublattice_reach(in_order[k]);
        const unsigned expected =
            in_order[k] == 3 ? 18 : in_order[k]; /* an eleventh, not an eighth */
        assert_int_equal(stp_sublattice_within(reach), expected);
        assert_int_equal(stp_sublattice_within(reach * (1.0 - 1e-9)), k == 0   ? 0
                                                                      : k == 8 ? 18
                                                                               : in_order[k - 1]);
    }
    assert_int_equal(stp_sublattice_within(1e9), STP_SUBLATTICE_MOST);
    assert_int_equal(stp_sublattice_within(0.0), 0);
}

/* Puts positions on sublattices, which the patches have in turn or share; radii on a grid. */
static void coarsen(stp_chunk *chunk, unsigned first, unsigned change, unsigned radius_shift,
                    unsigned wide)
{
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        stp_patch *patch = &chunk->patches[p];
        const unsigned s = (first + p * change) % (STP_SLANTED_MOST + 1);
        for (unsigned k = 0; k < patch->counts[0]; k++) {
            stp_sample *sample = &chunk->samples[0][chunk->level_begin[0][p] + k];
            double at[3], on[3];
            for (int i = 0; i < 3; i++) /* away from the ends of 16 bits */
                at[i] = (double)patch->origin[i] + 100 + sample->position[i] % wide;
            stp_sublattice_nearest(s, at, on);
            for (int i = 0; i < 3; i++)
                sample->position[i] = (uint16_t)(on[i] - patch->origin[i]);
        }
        assert_true(stp_sublattice_has(s, patch, chunk->samples[0] + chunk->level_begin[0][p]));
    }
    for (int level = 0; level < 3; level++)
        for (uint32_t i = 0; i < chunk->level_begin[level][chunk->patch_count]; i++) {
            uint8_t *radius = &chunk->samples[level][i].radius;
            *radius = (uint8_t)(1u + ((unsigned)*radius >> radius_shift << radius_shift));
        }
}

static void coarse_blocks_come_back(void **state)
{
    (void)state;
    stp_chunk_scratch scratch = {0};
    for (unsigned s = 0; s <= STP_SLANTED_MOST; s++)
        for (uint32_t patches = 1; patches <= 20; patches += 19)
            for (unsigned change = 0; change < 3; change++)
                for (int kind = 0; kind < 3; kind++) {
                    stp_chunk *chunk = any_chunk(patches, 64, 100 * s + change, kind);
                    coarsen(chunk, s, change, 1 + s % 7, 60000);
                    chunk->is_block = true;
                    any_chunk_round_trip(chunk, STP_CODEC_DRACO, &scratch);
                    any_chunk_round_trip(chunk, STP_CODEC_ZSTD, &scratch);
                    stp_chunk_destroy(&chunk);
                }
    stp_chunk_scratch_free(&scratch);
}

static size_t level_bytes(uint32_t patches, unsigned sublattice, unsigned radius_shift,
                          uint32_t *samples)
{
    stp_chunk *chunk = any_chunk(patches, 64, 7, 0);
    stp_bytes bytes = {0};
    chunk->is_block = true;
    coarsen(chunk, sublattice, 0, radius_shift, 1000);
    for (uint32_t i = 0; i < chunk->level_begin[1][chunk->patch_count]; i++)
        for (int a = 0; a < 3; a++)
            chunk->samples[1][i].position[a] = 600;
    assert_int_equal(stp_segment_encode(chunk, 2, STP_CODEC_DRACO, &bytes, NULL), STP_OK);
    *samples = chunk->level_begin[0][chunk->patch_count];
    stp_chunk_destroy(&chunk);
    free(bytes.data);
    return bytes.size;
}

/* Random positions and radii take as many bits less as the sublattice and the grid leave out, or
 * nine tenths of that; 0.65 of it if it is slanted, for last children are known to a few steps. */
static void coarse_blocks_are_smaller(void **state)
{
    (void)state;
    uint32_t samples;
    const double fine = (double)level_bytes(20, 0, 0, &samples);
    for (unsigned s = 1; s <= STP_SLANTED_MOST; s++) {
        const double part = s < STP_SLANTED ? 0.9 : 0.65;
        assert_true((double)level_bytes(20, s, 0, &samples) <=
                    fine - part * stp_sublattice_quarters(s) * samples / 32 + 20);
    }
    for (unsigned r = 1; r <= 6; r++)
        assert_true((double)level_bytes(20, 0, r, &samples) <= fine - 0.9 * r * samples / 8 + 20);
}

/* What precedes the columns of a coarse table of one patch, with this symbol of its sublattice. */
static void put_head(stp_tight_writer *w, bool slanted, unsigned symbol, unsigned shift,
                     unsigned odd)
{
    stp_odds odds; /* formats/SPEC.md, "Coarse levels" */
    for (int i = 0; i < STP_ODDS_SYMBOLS; i++)
        odds.below[i] =
            (int16_t)(i == 0                     ? 0
                      : i <= (slanted ? 18 : 14) ? (1 << 14) + (slanted ? 768 : 1024) * (i - 1)
                                                 : (1 << 15) - 4 * (32 - i));
    assert_int_equal(stp_symbols_reserve(&w->symbols, 40, NULL), STP_OK);
    for (int marks = 1 + slanted; marks > 0; marks--)
        stp_symbol_put_bits(&w->symbols, 0, 15, 4);
    if (odd > 0)
        stp_symbol_put_bits(&w->symbols, 0, 14, 4);
    stp_symbol_put_bits(&w->symbols, 0, shift, 4); /* normals */
    if (odd > 0)
        stp_symbol_put_bits(&w->symbols, 0, odd, 2);
    stp_symbol_put_bits(&w->symbols, 0, 0, 3); /* radii */
    stp_symbol_put_bits(&w->symbols, 0, 0, 1); /* no scale */
    stp_symbol_put_bits(&w->symbols, 0, 1, 1);
    stp_symbol_put(&w->symbols, 0, &odds, 4, symbol, 0, 0);
    const uint8_t *known = stp_known_level(false, 0, false);
    for (unsigned c = 0; c < STP_SAMPLE_COLUMN_COUNT; c++) {
        stp_known_begin(known[STP_KNOWN_COUNT * c + STP_KNOWN_HOW + (c > 0)], &odds);
        stp_symbol_put(&w->symbols, 0, &odds, 5, 1, 0, 0);
    }
}

/* A table of level 0 of one patch that is coarse, with this sublattice. */
static stp_status head_status(bool may_coarsen, bool slanted, unsigned sublattice, unsigned shift,
                              unsigned odd, stp_error *err)
{
    stp_tight_writer w = {0};
    stp_tight_reader r;
    stp_bytes bytes = {0};
    int16_t cells[STP_SAMPLE_COLUMN_COUNT] = {0}, beside[STP_SAMPLE_COLUMN_COUNT] = {0};
    uint8_t sublattices[1] = {99};
    stp_table table = {.values = cells,
                       .stride = 1,
                       .column_count = STP_SAMPLE_COLUMN_COUNT,
                       .row_count = 1,
                       .may_shift = true,
                       .may_scale = true,
                       .may_coarsen = may_coarsen,
                       .sublattices = sublattices,
                       .sublattice_count = 1,
                       .beside = beside,
                       .tight_first = stp_tight_elder,
                       .known = stp_known_level(false, 0, false)};
    put_head(&w, slanted, sublattice, shift, odd);
    assert_int_equal(stp_symbols_write_known(&w.symbols, &bytes, NULL), STP_OK);
    assert_int_equal(stp_tight_read(&r, bytes.data, bytes.size, NULL), STP_OK);
    stp_status status = stp_tight_get(&r, &table, err);
    if (status == STP_OK) {
        assert_int_equal(sublattices[0], sublattice);
        assert_int_equal(table.normal_shift, shift);
        assert_int_equal(table.normal_odd, odd);
    }
    free(bytes.data);
    stp_tight_clear(&w);
    return status;
}

static void wrong_heads_are_refused(void **state)
{
    (void)state;
    stp_error err = {0};
    assert_int_equal(head_status(false, false, 1, 0, 0, &err), STP_CORRUPT);
    assert_non_null(strstr(err.message, "shifted by 15 bits"));
    for (int slanted = 0; slanted < 2; slanted++) {
        const unsigned most = slanted ? STP_SLANTED_MOST : STP_SUBLATTICE_MOST;
        assert_int_equal(head_status(true, slanted, most, 0, 0, &err), STP_OK);
        for (unsigned symbol = most + 1; symbol < STP_ODDS_SYMBOLS; symbol++) {
            assert_int_equal(head_status(true, slanted, symbol, 0, 0, &err), STP_CORRUPT);
            assert_non_null(strstr(err.message, "a sublattice that there is not"));
        }
        for (unsigned odd = 0; odd <= STP_NORMAL_ODD_MOST; odd++)
            for (unsigned shift = 0; shift < 13; shift++) {
                const bool exists = shift <= (odd > 0 ? 9u : 11u);
                assert_int_equal(head_status(true, slanted, 1, shift, odd, &err),
                                 exists ? STP_OK : STP_CORRUPT);
                if (!exists)
                    assert_non_null(strstr(err.message, "a table's normals are shifted by"));
            }
    }
}

#define STEP 0x1p-6

/* Builds a patch of points 20 steps apart that may be off by `loose` steps. */
static void build_patch(double loose, const stp_patch_ground *ground, stp_item *items,
                        stp_patch *patch, stp_patch_samples *samples)
{
    stp_item vertex;
    uint32_t order[STP_PATCH_SAMPLES];
    for (uint32_t k = 0; k < STP_PATCH_SAMPLES; k++) {
        stp_item *item = &items[k];
        order[k] = k;
        item->exponent = -6;
        item->loose = STEP * (k == 5 ? loose : loose + 50.0);
        item->area = 400.0 * STEP * STEP;
        item->disc.centre = (stp_dvec3){STEP * (20.0 * (k % 8) + 9.0 * stp_random_unit(1, k)),
                                        STEP * (20.0 * (k / 8) + 9.0 * stp_random_unit(2, k)),
                                        STEP * 9.0 * stp_random_unit(3, k)};
        item->disc.radius = item->disc.reach = item->disc.bound = 32.0 * STEP;
        const vec3s normal = {{(float)(0.1 + stp_random_unit(6, k)), (float)stp_random_unit(7, k),
                               (float)stp_random_unit(8, k)}};
        stp_normal_encode_on(glms_vec3_normalize(normal), ground->normal_bits, item->normal);
        item->flags = STP_SAMPLE_HAS_NORMAL | STP_SAMPLE_ORIENTED;
    }
    assert_true(stp_patch_build(items, order, STP_PATCH_SAMPLES, ground, patch, samples, &vertex));
}

static void prep_uses_them(void **state)
{
    (void)state;
    static const double loose[] = {0.0, 0.9, 1.05, 1.2, 1.35, 1.4, 1.7, 1.733, 1.9, 9.0};
    static const unsigned expected[] = {0, 0, 1, 2, 15, 16, 17, 18, 18, 11};
    for (size_t n = 0; n < sizeof loose / sizeof *loose; n++) {
        stp_item items[STP_PATCH_SAMPLES] = {0};
        stp_patch patch;
        stp_patch_samples samples;
        const stp_patch_ground ground = {.vertex_least = -14, .normal_bits = 9};
        build_patch(loose[n], &ground, items, &patch, &samples);
        assert_int_equal(stp_sublattice_of(&patch, samples.level[0]), expected[n]);
        const double reach = STEP * stp_sublattice_reach(expected[n]);
        for (uint32_t k = 0; k < STP_PATCH_SAMPLES; k++) {
            const stp_dvec3 at = stp_sample_position(&samples.level[0][k], &patch);
            assert_true(stp_dvec3_length(stp_dvec3_sub(at, items[k].disc.centre)) <= reach + 1e-12);
        }
        assert_true(stp_error_decode(patch.error[0], patch.exponent) >= reach);
    }
}

/* Merged normals are on the grids that SPEC.md names. */
static void merged_normals_are_finer(void **state)
{
    (void)state;
    for (unsigned bits = STP_NORMAL_BITS_LEAST; bits <= STP_NORMAL_BITS; bits++)
        for (int even = 0; even < 2; even++) {
            stp_item items[STP_PATCH_SAMPLES] = {0};
            stp_patch patch;
            stp_patch_samples samples;
            const stp_patch_ground ground = {
                .vertex_least = -14, .normal_bits = bits, .even = even};
            build_patch(0.0, &ground, items, &patch, &samples);
            for (unsigned level = 1; level < 3; level++) {
                const unsigned most = even ? 9 : STP_NORMAL_BITS;
                const unsigned more = bits + level + (even ? 0 : 1);
                const stp_sample *merged = samples.level[level];
                assert_int_equal(STP_NORMAL_BITS -
                                     stp_normal_grid_shift(merged, patch.counts[level]),
                                 more < most ? more : most);
            }
        }
}

static void radii_are_on_their_grid(void **state)
{
    (void)state;
    for (uint64_t i = 0; i < 1000; i++) {
        const double radius = exp2(40.0 * (stp_random_unit(4, i) - 0.5));
        const double least = radius * exp2(stp_random_unit(5, i) - 1.0);
        const double steps = 4.0 * log2(stp_radius_on_grid(radius, least, 4.0));
        assert_true(fabs(steps - round(steps)) < 1e-6);
        assert_true(stp_radius_on_grid(radius, least, 4.0) >= least);
        const double coarse = stp_radius_on_grid(radius, 0.0, 2.0);
        assert_true(fabs(2.0 * log2(radius) - 2.0 * log2(coarse)) < 0.501);
        assert_true(steps < 4.0 * log2(radius) + 1.001);
    }
    assert_true(stp_radius_on_grid(0.0, 0.0, 4.0) == 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nearest_is_nearest),
        cmocka_unit_test(coarse_blocks_come_back),
        cmocka_unit_test(coarse_blocks_are_smaller),
        cmocka_unit_test(wrong_heads_are_refused),
        cmocka_unit_test(prep_uses_them),
        cmocka_unit_test(merged_normals_are_finer),
        cmocka_unit_test(radii_are_on_their_grid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
