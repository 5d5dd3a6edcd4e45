/* How many normals point outward, against the true surface. */
#ifndef STP_TESTS_ORIENTATION_FIXTURE_H
#define STP_TESTS_ORIENTATION_FIXTURE_H

#include "tests/surface_fixture.h"

/* Share of points that are known to point outward and do; prints what the others are. */
static inline double right_share(const surface_cloud *s)
{
    uint32_t right = 0, known = 0;
    for (uint32_t i = 0; i < s->cloud.count; i++) {
        if (!surface_is_oriented(s, i))
            continue;
        known++;
        right += glms_vec3_dot(stp_cloud_normal(&s->cloud, i),
                               s->truth[s->cloud.points[i].source].normal) > 0.0f;
    }
    double count = s->cloud.count;
    print_message("%.4f %% right, %.4f %% wrong, %.4f %% unknown\n", 100.0 * right / count,
                  100.0 * (known - right) / count, 100.0 * (s->cloud.count - known) / count);
    return right / count;
}

/* Samples a closed shape, takes its normals away and wants 99.9 % of them back outward. */
static inline void closed_surface(gen_shape shape, uint32_t samples)
{
    surface_cloud s = surface_scan(shape, samples, 0.1, 0);
    surface_prepare(&s, 16);
    surface_orient(&s, (stp_orient_params){.mode = STP_ORIENT_AUTO});
    double share = right_share(&s);
    print_message("mean error %.3f degrees\n", surface_mean_error(&s));
    assert_true(share >= 0.999);
    surface_clear(&s);
}

#endif
