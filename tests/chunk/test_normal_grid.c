/* Tests grids of normal codes: rounding stays within its angle, and codecs of blocks bring back any
 * samples on any grid, in fewer bytes, whatever hostile bytes say. */
#include "formats/chunk/sample/normal_grid.h"

#include "formats/chunk/layout.h"
#include "tests/fixtures/any_chunk.h"

#include <math.h>

static int32_t coordinate(const uint8_t code[3], int which)
{
    const uint32_t word = (uint32_t)code[0] | (uint32_t)code[1] << 8 | (uint32_t)code[2] << 16;
    return (int32_t)(word >> (12 * which) & 4095u);
}

static void set_code(uint8_t code[3], int32_t u, int32_t v)
{
    const uint32_t word = (uint32_t)u | (uint32_t)v << 12;
    for (int i = 0; i < 3; i++)
        code[i] = (uint8_t)(word >> (8 * i));
}

static vec3s random_direction(uint64_t which)
{
    const double z = 2.0 * stp_random_unit(1, which) - 1.0;
    const double around = 2.0 * M_PI * stp_random_unit(2, which), r = sqrt(1.0 - z * z);
    return (vec3s){{(float)(r * cos(around)), (float)(r * sin(around)), (float)z}};
}

static double angle_between(vec3s a, vec3s b)
{
    return 2.0 * asin(0.5 * (double)glms_vec3_norm(glms_vec3_sub(a, b)));
}

/* The angle holds, and some directions come near it. */
static void test_angles(void **state)
{
    (void)state;
    for (unsigned bits = STP_NORMAL_BITS_LEAST; bits < STP_NORMAL_BITS; bits++) {
        const unsigned shift = STP_NORMAL_BITS - bits;
        double greatest = 0.0;
        for (uint64_t i = 0; i < 200000; i++) {
            uint8_t code[3];
            const vec3s n = random_direction(i);
            stp_normal_encode_on(n, bits, code);
            for (int c = 0; c < 2; c++)
                assert_int_equal(
                    stp_normal_grid_code(stp_normal_grid_place(coordinate(code, c), shift), shift),
                    coordinate(code, c));
            greatest = fmax(greatest, angle_between(stp_normal_decode(code), n));
        }
        print_message("%u bits: %.4f degrees, bound %.4f\n", bits, greatest * 180.0 / M_PI,
                      stp_normal_grid_angle(bits) * 180.0 / M_PI);
        assert_true(greatest <= stp_normal_grid_angle(bits));
        assert_true(greatest >= 0.9 * stp_normal_grid_angle(bits));
    }
}

/* The same of any step, whose codes come back from their places. */
static void test_steps(void **state)
{
    (void)state;
    for (unsigned shift = 0; shift <= 3; shift++)
        for (unsigned odd = 1; odd <= STP_NORMAL_ODD_MOST; odd++) {
            const unsigned step = stp_normal_step(shift, odd);
            const stp_normal_grid grid = stp_normal_grid_of(step);
            double greatest = 0.0;
            for (uint64_t i = 0; i < 100000; i++) {
                uint8_t code[3];
                const vec3s n = random_direction(i);
                stp_normal_encode_by(n, step, code);
                for (int c = 0; c < 2; c++) {
                    const int32_t at = coordinate(code, c);
                    assert_true(at == 0 || at == 4095 || (at - 2048) % (int32_t)step == 0);
                    assert_int_equal(stp_normal_code_at(&grid, stp_normal_place_of(&grid, at)), at);
                }
                greatest = fmax(greatest, angle_between(stp_normal_decode(code), n));
            }
            assert_true(greatest <= stp_normal_step_angle(step));
            assert_true(greatest >= 0.9 * stp_normal_step_angle(step));
        }
}

/* Places are quotients, of all steps and of all numbers up to 64. */
static void test_places(void **state)
{
    (void)state;
    for (int32_t step = 1; step <= 3584; step++) {
        const int32_t odd = step >> __builtin_ctz((unsigned)step);
        if (step > 64 && odd > 7)
            continue;
        const stp_normal_grid grid = stp_normal_grid_of((unsigned)step);
        assert_true(grid.before >= 0 && (grid.before + 2048) % step == 0);
        for (int32_t code = 0; code < 4096; code++)
            assert_int_equal(stp_normal_place_near(&grid, code),
                             (code + grid.before + step / 2) / step);
    }
}

/* What is on a grid stays, axes above all, and unknown normals. */
static void test_fixed_points(void **state)
{
    (void)state;
    for (unsigned bits = STP_NORMAL_BITS_LEAST; bits <= STP_NORMAL_BITS; bits++)
        for (int axis = 0; axis < 7; axis++) {
            uint8_t exact[3], code[3];
            vec3s n = {{0.0f, 0.0f, 0.0f}};
            if (axis < 6)
                n.raw[axis / 2] = axis % 2 ? -1.0f : 1.0f;
            stp_normal_encode(n, exact);
            stp_normal_encode_on(n, bits, code);
            assert_true(angle_between(stp_normal_decode(code), stp_normal_decode(exact)) < 1e-6);
        }
    for (unsigned bits = STP_NORMAL_BITS_LEAST; bits < STP_NORMAL_BITS; bits++)
        for (uint64_t i = 0; i < 2000; i++) {
            uint8_t once[3], twice[3], finer[3];
            stp_normal_encode_on(random_direction(i), bits, once);
            stp_normal_encode_on(stp_normal_decode(once), bits, twice);
            stp_normal_encode_on(stp_normal_decode(once), bits + 1, finer);
            /* on the rim a direction has a second code, which may lie one code beside the grid */
            const vec3s n = stp_normal_decode(once);
            const double most = 2.0 * stp_normal_grid_angle(STP_NORMAL_BITS);
            assert_true(angle_between(stp_normal_decode(twice), n) <= most);
            assert_true(angle_between(stp_normal_decode(finer), n) <= most);
        }
}

static void put_on_grid(stp_chunk *chunk, unsigned step)
{
    const stp_normal_grid grid = stp_normal_grid_of(step);
    for (int l = 0; l < STP_LEVEL_COUNT; l++)
        for (uint32_t i = 0; i < chunk->level_begin[l][chunk->patch_count]; i++) {
            uint8_t *code = chunk->samples[l][i].normal;
            int32_t on[2];
            for (int c = 0; c < 2; c++)
                on[c] = stp_normal_code_at(&grid, stp_normal_place_of(&grid, coordinate(code, c)));
            set_code(code, on[0], on[1]);
        }
}

static void test_shift_is_found(void **state)
{
    (void)state;
    stp_sample samples[3] = {{.radius = 0}};
    for (unsigned shift = 0; shift <= STP_NORMAL_SHIFT_MOST; shift++) {
        set_code(samples[0].normal, 4095, 0);
        set_code(samples[1].normal, 0, 4095);
        set_code(samples[2].normal, 2048, 1 << shift);
        assert_int_equal(stp_normal_grid_shift(samples, 3), shift);
    }
    set_code(samples[2].normal, 2048, 4095);
    assert_int_equal(stp_normal_grid_shift(samples, 3), STP_NORMAL_SHIFT_MOST);
    assert_int_equal(stp_normal_grid_shift(samples, 0), STP_NORMAL_SHIFT_MOST);
}

/* Any samples on any grid come back from blocks, and from codecs without blocks as well. Each bit
 * less makes a block smaller. */
static void test_round_trips(void **state)
{
    (void)state;
    static const stp_codec codecs[] = {STP_CODEC_DRACO, STP_CODEC_ZSTD};
    stp_chunk_scratch scratch = {0};
    for (size_t c = 0; c < sizeof codecs / sizeof *codecs; c++)
        for (uint64_t seed = 0; seed < 6; seed++) {
            size_t before = SIZE_MAX;
            for (unsigned shift = 0; shift <= STP_NORMAL_SHIFT_MOST; shift++) {
                stp_chunk *chunk = any_chunk(40, 64, seed, (int)(seed % 3));
                put_on_grid(chunk, stp_normal_step(shift, 0));
                (void)any_chunk_round_trip(chunk, codecs[c], &scratch);
                chunk->is_block = true;
                const size_t bytes = any_chunk_round_trip(chunk, codecs[c], &scratch);
                if (seed % 3 == 0)
                    assert_true(bytes < before);
                before = bytes;
                stp_chunk_destroy(&chunk);
            }
        }
    stp_chunk_scratch_free(&scratch);
}

/* So do those of any step, in small blocks, which are tight, and in large ones. Each coarser grid
 * takes less; Zstandard gains nothing by the finest and the coarsest ones. */
static void test_steps_round_trip(void **state)
{
    (void)state;
    stp_chunk_scratch scratch = {0};
    for (uint64_t seed = 0; seed < 6; seed++) {
        size_t before[2] = {SIZE_MAX, SIZE_MAX};
        for (unsigned step = 1; step <= STP_NORMAL_ODD_MOST << STP_NORMAL_ODD_SHIFT_MOST; step++) {
            const unsigned shift = (unsigned)__builtin_ctz(step), odd = (step >> shift) / 2;
            if (odd > STP_NORMAL_ODD_MOST || (odd > 0 && shift > STP_NORMAL_ODD_SHIFT_MOST))
                continue;
            stp_chunk *chunk = any_chunk(seed < 3 ? 20 : 40, 64, seed, (int)(seed % 3));
            chunk->is_block = true;
            put_on_grid(chunk, step);
            for (int c = 0; c < 2; c++) {
                const stp_codec codec = c == 0 ? STP_CODEC_DRACO : STP_CODEC_ZSTD;
                const size_t bytes = any_chunk_round_trip(chunk, codec, &scratch);
                if (seed % 3 == 0 && (c == 0 ? step <= 512 : step > 4 && step <= 40))
                    assert_true(bytes < before[c]);
                before[c] = bytes;
            }
            stp_chunk_destroy(&chunk);
        }
    }
    stp_chunk_scratch_free(&scratch);
}

static void test_odd_is_found(void **state)
{
    (void)state;
    stp_sample samples[3] = {{.radius = 0}};
    for (unsigned shift = 0; shift <= STP_NORMAL_SHIFT_MOST; shift++)
        for (unsigned odd = 0; odd <= STP_NORMAL_ODD_MOST; odd++) {
            const int32_t step = (int32_t)stp_normal_step(shift, odd);
            set_code(samples[0].normal, 4095, 0);
            set_code(samples[1].normal, 2048, step < 2048 ? 2048 - step : 2048);
            set_code(samples[2].normal, step < 1024 ? 2048 + 2 * step : 0, 4095);
            const bool there = shift <= STP_NORMAL_ODD_SHIFT_MOST && step < 2048;
            const unsigned found = stp_normal_grid_odd(samples, 3, shift);
            if (there)
                assert_int_equal(found, odd);
            set_code(samples[0].normal, 2047, 0);
            assert_int_equal(stp_normal_grid_odd(samples, 3, shift), 0);
        }
}

/* Places of the shift in an encoded segment 1: the last byte of the mask of the elder children's
 * table; the byte behind the mask of planes. */
static size_t shift_place(stp_codec codec)
{
    return codec == STP_CODEC_DRACO ? 11 : 4;
}

/* Shifts that do not exist are refused. A false shift gives other normals, and no harm. The elder
 * children are too many for a tight part. */
static void test_false_shifts(void **state)
{
    (void)state;
    static const stp_codec codecs[] = {STP_CODEC_DRACO, STP_CODEC_ZSTD};
    for (size_t c = 0; c < sizeof codecs / sizeof *codecs; c++) {
        stp_chunk_scratch scratch = {0};
        stp_chunk *chunk = any_chunk(400, 64, 3, 0);
        chunk->is_block = true;
        stp_chunk *back = any_chunk_empty_like(chunk);
        for (int s = 0; s < 2; s++) {
            stp_bytes bytes = {0};
            assert_int_equal(stp_segment_encode(chunk, s, codecs[c], &bytes, NULL), STP_OK);
            for (unsigned kind = 0; s == 1 && kind < (c == 0 ? 16 : 256); kind++) {
                uint8_t *at = bytes.data + shift_place(codecs[c]);
                const bool exists = (kind & 15u) <= (kind < 16 ? 11 : 9) && kind < 64;
                *at = (uint8_t)(codecs[c] == STP_CODEC_DRACO ? kind << 4 | (*at & 15u) : kind);
                assert_int_equal(stp_segment_decode(bytes.data, bytes.size, s, codecs[c], 0, back,
                                                    &scratch, NULL),
                                 exists ? STP_OK : STP_CORRUPT);
            }
            if (s == 0)
                assert_int_equal(stp_segment_decode(bytes.data, bytes.size, s, codecs[c], 0, back,
                                                    &scratch, NULL),
                                 STP_OK);
            free(bytes.data);
        }
        stp_chunk_destroy(&chunk);
        stp_chunk_destroy(&back);
        stp_chunk_scratch_free(&scratch);
    }
}

/* Codec 1 has no grids: the mask's high bits are columns that do not exist. */
static void test_none_without_blocks(void **state)
{
    (void)state;
    stp_chunk_scratch scratch = {0};
    stp_chunk *chunk = any_chunk(40, 64, 3, 0), *back = any_chunk_empty_like(chunk);
    for (int s = 0; s < 2; s++) {
        stp_bytes bytes = {0};
        assert_int_equal(stp_segment_encode(chunk, s, STP_CODEC_DRACO, &bytes, NULL), STP_OK);
        if (s == 1)
            bytes.data[shift_place(STP_CODEC_DRACO)] = 1u << 4;
        assert_int_equal(
            stp_segment_decode(bytes.data, bytes.size, s, STP_CODEC_DRACO, 0, back, &scratch, NULL),
            s == 1 ? STP_CORRUPT : STP_OK);
        free(bytes.data);
    }
    stp_chunk_destroy(&chunk);
    stp_chunk_destroy(&back);
    stp_chunk_scratch_free(&scratch);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_angles),         cmocka_unit_test(test_fixed_points),
        cmocka_unit_test(test_shift_is_found), cmocka_unit_test(test_round_trips),
        cmocka_unit_test(test_false_shifts),   cmocka_unit_test(test_none_without_blocks),
        cmocka_unit_test(test_steps),          cmocka_unit_test(test_steps_round_trip),
        cmocka_unit_test(test_odd_is_found),   cmocka_unit_test(test_places),
    };
    return cmocka_run_group_tests_name("normal_grid", tests, NULL, NULL);
}
