/* Tests how samples become texels of the Object Texture: which blocks are narrow, that they lose
 * nothing, and where the colours of others are. */
#include "runtime/stream/texels.h"
#include "tests/fixtures/scan/scan_fixture.h"

static const stp_sample widest = {.position = {4095, 4095, 4095},
                                  .radius = 255,
                                  .normal = {255, 255, 255},
                                  .rgb = {255, 255, 255}};

/* Whether a block of one patch with this sample is narrow; if so, it must come back. */
static bool is_narrow(const stp_sample *sample)
{
    uint32_t begin[STP_LEVEL_COUNT][2] = {{0, 1}, {0, 1}, {0, 1}, {0, 1}}, texel[1][3];
    stp_sample plain[3] = {{.radius = 1}, {.radius = 2}, {.radius = 3}}, tested = *sample;
    const stp_chunk chunk = {.patch_count = 1,
                             .level_begin = {begin[0], begin[1], begin[2], begin[3]},
                             .samples = {&plain[0], &tested, &plain[1], &plain[2]}};
    if (!stp_texels_are_narrow(&chunk))
        return false;
    stp_texels_write_narrow(texel, &tested, 1);
    const stp_sample back = stp_texel_widen(texel[0]);
    assert_memory_equal(&back, &tested, sizeof back);
    return true;
}

static void narrow_samples_lose_nothing(void **state)
{
    (void)state;
    int narrow = 0;
    assert_true(is_narrow(&widest));
    for (int k = 0; k < 3; k++) {
        stp_sample s = {.position = {0, 0, 0}};
        assert_true(is_narrow(&s));
        s.position[k] = 4096;
        assert_false(is_narrow(&s));
    }
    for (int flags = 0; flags < 256; flags++) {
        stp_sample s = widest;
        s.flags = (uint8_t)flags;
        narrow += is_narrow(&s);
    }
    assert_int_equal(narrow, 4 * 4); /* what is known of the normal, and how it was found */
    stp_sample s = widest;
    s.class_id = 1;
    assert_false(is_narrow(&s));
    s.class_id = 0;
    s.intensity = 1;
    assert_false(is_narrow(&s));
}

/* The colours of a block follow its samples word by word, wherever it begins. */
static void colours_follow_samples(void **state)
{
    (void)state;
    for (uint32_t begin = 0; begin < 7; begin++)
        for (uint32_t count = 1; count < 9; count++) {
            const uint32_t colours = stp_texels_colours(begin, count), shift = colours >> 30;
            assert_true(shift < 3);
            assert_int_equal(stp_texels_samples((uint32_t)stp_texels_most(count)), count);
            for (uint32_t i = begin; i < begin + count; i++) {
                const uint32_t texel = (colours & 0x3fffffffu) + (i + shift) / 3;
                const uint32_t word = 3 * texel + (i + shift) % 3;
                assert_int_equal(word, 3 * (begin + count) + i - begin);
                assert_true(texel < begin + stp_texels_most(count));
            }
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(narrow_samples_lose_nothing),
                                       cmocka_unit_test(colours_follow_samples)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
