/* Tests patches that are predicted by the middles of their lattices: any patches come back, in odds
 * and in streams; those whose centre is the middle are smaller; other tables have no middles. */
#include "formats/chunk/sample/patch.h"
#include "formats/chunk/sample/sample.h"
#include "tests/fixtures/any_chunk.h"

#include <math.h>

static size_t block_bytes(stp_chunk *chunk)
{
    stp_chunk_scratch scratch = {0};
    chunk->is_block = true;
    const size_t bytes = any_chunk_round_trip(chunk, STP_CODEC_DRACO, &scratch);
    stp_chunk_scratch_free(&scratch);
    return bytes;
}

/* Origins of all 32 bits, exponents from -200 to 200, axes in all directions. */
static void any_patches_come_back(void **state)
{
    (void)state;
    static const uint32_t counts[] = {1, 2, 3, 40, 1499, 1500};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++)
        for (uint64_t seed = 0; seed < 6; seed++) {
            stp_chunk *chunk = any_chunk(counts[c], 2, 50 * c + seed, (int)(seed % 3));
            block_bytes(chunk);
            stp_chunk_destroy(&chunk);
        }
}

/* Puts patches on a wavy sheet, some on a lattice twice as fine. scatter: how far a centre lies
 * from the middle. */
static void lay_out(stp_chunk *chunk, uint64_t seed, unsigned scatter)
{
    for (uint32_t p = 0; p < chunk->patch_count; p++) {
        stp_patch *patch = &chunk->patches[p];
        const unsigned fine = stp_random_u64(seed, p) % 4 == 0;
        const int32_t x = 240 * (int32_t)(p % 10), y = 240 * (int32_t)(p / 10);
        const int32_t at[3] = {x, y, x / 2 + (int32_t)(stp_random_u64(seed + 1, p) % 3) * 8};
        const float slope = -1.0f / sqrtf(5.0f);
        patch->exponent = (int16_t)(fine ? -11 : -10);
        stp_normal_encode((vec3s){{slope, 0.0f, -2.0f * slope}}, patch->cone_axis);
        for (int i = 0; i < 3; i++) {
            const int32_t off =
                (int32_t)(stp_random_u64(seed + 2, 3 * p + (unsigned)i) % (scatter + 1));
            patch->bound_centre[i] = (uint16_t)(STP_PATCH_MIDDLE + off);
            patch->origin[i] = (at[i] << fine) - patch->bound_centre[i];
        }
        for (int l = 0; l < STP_LEVEL_COUNT; l++)
            for (uint32_t i = chunk->level_begin[l][p]; i < chunk->level_begin[l][p + 1]; i++)
                memcpy(chunk->samples[l][i].position, patch->bound_centre,
                       sizeof patch->bound_centre);
    }
}

/* A patch of a sheet whose centre is the middle costs less than three bytes, with all other fields.
 * Nine bits beside the middle along each axis cost four more at least. */
static void middles_cost_nothing(void **state)
{
    (void)state;
    stp_chunk *chunk = any_chunk(400, 1, 3, 1);
    lay_out(chunk, 7, 0);
    const size_t bare = block_bytes(chunk);
    lay_out(chunk, 7, 511);
    const size_t scattered = block_bytes(chunk);
    assert_in_range(scattered, bare + 400u * 4u, bare + 400u * 12u);
    assert_in_range(bare, 1, 400u * 3u);
    stp_chunk_destroy(&chunk);
}

/* The mask of a table of samples has no bit of middles: that of level 3, behind the table of
 * patches. The tables are too long for a tight part. */
static void samples_have_no_middles(void **state)
{
    (void)state;
    stp_chunk *chunk = any_chunk(1500, 1, 3, 0), *back = any_chunk_empty_like(chunk);
    stp_chunk_scratch scratch = {0};
    stp_bytes bytes = {0};
    stp_error err = {0};
    chunk->is_block = back->is_block = true;
    assert_int_equal(stp_segment_encode(chunk, 0, STP_CODEC_DRACO, &bytes, &err), STP_OK);
    uint32_t patches;
    memcpy(&patches, bytes.data, sizeof patches);
    bytes.data[4 + patches + 4 + 7] |= 1u; /* bit 56 */
    assert_int_equal(
        stp_segment_decode(bytes.data, bytes.size, 0, STP_CODEC_DRACO, 0, back, &scratch, &err),
        STP_CORRUPT);
    assert_non_null(strstr(err.message, "columns it lacks"));
    free(bytes.data);
    stp_chunk_scratch_free(&scratch);
    stp_chunk_destroy(&back);
    stp_chunk_destroy(&chunk);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_patches_come_back),
        cmocka_unit_test(middles_cost_nothing),
        cmocka_unit_test(samples_have_no_middles),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
