/* Two frames ask for the same picture only if no field differs that the picture depends on. */
#include "runtime/draw/draw_params.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

/* Each differs in one field from {0}. */
static const stp_draw_params changed[] = {
    {.lod = STP_LOD_FULL},
    {.reconstruct = STP_RECONSTRUCT_POINTS},
    {.shade = STP_SHADE_NORMAL},
    {.colour = STP_COLOUR_INTENSITY},
    {.palette = STP_PALETTE_GREY},
    {.hidden_models = 1},
    {.threshold_px = 2.0},
    {.radius_cap_px = 2.0},
    {.terms = STP_TERM_NONE},
    {.colour_range = {0.0, 1.0}},
    {.colour_range = {1.0, 0.0}},
    {.overlay = 0.5},
    {.edl = 1.0},
    {.fade = 0.5},
    {.clip = {.enabled = true}},
    {.clip = {.box = {.min = {0.0, 1.0, 0.0}}}},
    {.clip = {.box = {.max = {0.0, 0.0, 1.0}}}},
    {.hidden_classes = {1}},
    {.hidden_classes = {[7] = 1}},
    {.smooth_edges = true},
    {.cull = STP_CULL_BACK},
    {.every_sample = true},
    {.stream = true},
    {.refine = true},
    {.keep_pixels = true},
    {.timed = true},
};

static void every_field_counts(void **state)
{
    const size_t count = sizeof changed / sizeof *changed;
    (void)state;
    for (size_t i = 0; i < count; i++) {
        const stp_draw_params zero = {0}, same = changed[i];
        assert_false(stp_draw_params_equal(&changed[i], &zero));
        assert_false(stp_draw_params_equal(&zero, &changed[i]));
        assert_true(stp_draw_params_equal(&changed[i], &same));
        assert_false(stp_draw_params_equal(&changed[i], &changed[(i + 1) % count]));
    }
}

static void speed_of_fading_does_not(void **state)
{
    const stp_draw_params slow = {.fade = 0.9}, fast = {.fade = 0.1};
    (void)state;
    assert_true(stp_draw_params_equal(&slow, &fast));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(every_field_counts),
                                       cmocka_unit_test(speed_of_fading_does_not)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
