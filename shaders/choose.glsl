// The level of a patch: level_rule.glsl on what patch_texture holds. runtime/level_choice.c is the
// same in C, and tests/test_gl_level.c compares the two. Needs patch.glsl.

#define STP_RULE
#define STP_SQRT sqrt
#define STP_MAX max
#define STP_MIN min
#define STP_ABS abs
#include "level_rule.glsl"

#define STP_LEVEL_SKIP -1

bool stp_outside_frustum(vec3 centre, float radius)
{
    float depth = -centre.z;
    if (depth + radius <= viewport.w)
        return true;
    vec2 side = STP_ORTHOGRAPHIC != 0 ? abs(centre.xy) - 0.5 * viewport.xy / viewport.z
                             : abs(centre.xy) * frustum.xz - depth * frustum.yw;
    return any(greaterThan(side, vec2(radius)));
}

// Level to draw, or STP_LEVEL_SKIP if the patch is out of sight or its child is drawn instead.
int stp_choose_level(stp_patch p, stp_chunk chunk)
{
    if (p.child < 64u &&
        ((p.child < 32u ? chunk.drawn_children.x : chunk.drawn_children.y) >> (p.child & 31u) & 1u) != 0u)
        return STP_LEVEL_SKIP;
    vec3 centre = stp_to_eye(p.bound_centre);
    if (stp_outside_frustum(centre, p.bound_radius))
        return STP_LEVEL_SKIP;
    const bool orthographic = STP_ORTHOGRAPHIC != 0;
    float range = length(centre);
    float sin_beta = orthographic ? 0.0 : min(1.0, p.bound_radius / max(range, 1e-30));
    vec3 direction = orthographic ? -axis_back.xyz : p.bound_centre / max(range, 1e-30);
    float cos_phi = clamp(dot(direction, p.cone_axis), -1.0, 1.0);
    if (!p.two_sided && STP_KEEP_BACK_FACES == 0 && range > p.bound_radius &&
        stp_rule_backfacing(cos_phi, p.cone_cos, sin_beta))
        return STP_LEVEL_SKIP;
    int finest = int(chunk.finest);
    float scale = stp_rule_scale(-centre.z, range, p.bound_radius, viewport.z, viewport.w,
                                 orthographic);
    if (quality.x <= 0.0 || scale < 0.0)
        return finest;
    float sin_alpha = stp_rule_sin_alpha(cos_phi, p.cone_cos, sin_beta);
    for (int level = STP_LEVELS - 1; level > finest; level--)
        if (stp_rule_error(scale, sin_alpha, p.error[level], p.tangential_error[level]) <= quality.x &&
            p.radius[level] * scale <= quality.y)
            return level;
    return finest;
}
