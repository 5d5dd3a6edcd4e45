/* The error rule: how large a patch's stored error looks on the screen.
 *
 * One source for both sides: included by the shaders, and by runtime/cut/level_rule.h as C. Written in
 * the common subset of C and GLSL: scalar floats only. Source: Dachsbacher et al. 2003 (sequential
 * point trees); docs/algorithms.md, "Choosing the level":
 *
 *     error(l) = f min(e_l sin(alpha) + e_t,l, |(e_l, e_t,l)|) / (z cos(theta))          pixels
 *
 * The second bound is ours: the way from a drawn point to its nearest disc has the two errors as
 * legs at a right angle (formats/chunk/measure/overhang.h), so that is its length at most, and on the screen
 * it is no longer, however it lies. At outlines, where sin(alpha) is 1, it is the lesser.
 * e_l, e_t,l are the perpendicular and tangential error of level l; f pixels times units (pixels a
 * unit when orthographic); z the nearest depth of the patch's bound and theta its greatest angle off
 * the camera's axis; alpha the angle between eye ray and normal that is worst over bound and cone. */

/* Pixels a world unit covers at most anywhere in the bound: f / (z cos theta).
 * centre_depth: depth of the bound's centre along the camera's axis; centre_distance: its distance
 * from the eye; radius: the bound's. Returns -1 where the bound reaches the near plane or the eye:
 * then nothing bounds the projection and the patch must be refined. */
STP_RULE float stp_rule_scale(float centre_depth, float centre_distance, float radius, float f,
                              float near_depth, bool orthographic)
{
    if (orthographic)
        return f;
    float z = centre_depth - radius;
    if (z <= near_depth || centre_distance <= radius)
        return -1.0f;
    float sin_beta = radius / centre_distance;
    float cos_beta = STP_SQRT(STP_MAX(0.0f, 1.0f - sin_beta * sin_beta));
    float cos_axis = centre_depth / centre_distance;
    float sin_axis = STP_SQRT(STP_MAX(0.0f, 1.0f - cos_axis * cos_axis));
    float cos_theta = cos_axis * cos_beta - sin_axis * sin_beta;
    if (cos_theta <= 0.001f)
        return -1.0f;
    return f / (z * cos_theta);
}

/* Sine and cosine of (cone half-angle gamma + half the angle beta under which the eye sees the
 * bound): .x of the pair is returned by the first, .y by the second. */
STP_RULE float stp_rule_spread_sin(float cos_gamma, float sin_beta)
{
    float sin_gamma = STP_SQRT(STP_MAX(0.0f, 1.0f - cos_gamma * cos_gamma));
    float cos_beta = STP_SQRT(STP_MAX(0.0f, 1.0f - sin_beta * sin_beta));
    return sin_gamma * cos_beta + cos_gamma * sin_beta;
}

STP_RULE float stp_rule_spread_cos(float cos_gamma, float sin_beta)
{
    float sin_gamma = STP_SQRT(STP_MAX(0.0f, 1.0f - cos_gamma * cos_gamma));
    float cos_beta = STP_SQRT(STP_MAX(0.0f, 1.0f - sin_beta * sin_beta));
    return cos_gamma * cos_beta - sin_gamma * sin_beta;
}

/* Greatest sine of the angle between an eye ray through the bound and a normal of the cone.
 * cos_phi: cosine between the direction to the bound's centre and the cone's axis; cos_gamma of the
 * cone's half-angle; sin_beta: radius / distance of the bound, 0 when orthographic. */
STP_RULE float stp_rule_sin_alpha(float cos_phi, float cos_gamma, float sin_beta)
{
    float sin_spread = stp_rule_spread_sin(cos_gamma, sin_beta);
    float cos_spread = stp_rule_spread_cos(cos_gamma, sin_beta);
    float c = STP_ABS(cos_phi);
    float s = STP_SQRT(STP_MAX(0.0f, 1.0f - c * c));
    if (cos_gamma <= 0.0f || cos_spread <= 0.0f || c * cos_spread - s * sin_spread <= 0.0f)
        return 1.0f;
    return STP_MIN(1.0f, s * cos_spread + c * sin_spread);
}

/* Projected error of one level, pixels. */
STP_RULE float stp_rule_error(float scale, float sin_alpha, float error, float tangential_error)
{
    return scale * STP_MIN(error * sin_alpha + tangential_error,
                           STP_SQRT(error * error + tangential_error * tangential_error));
}

/* Whether an eye ray through the bound may graze a normal of the cone: the patch may show an outline. */
STP_RULE bool stp_rule_is_silhouette(float sin_alpha)
{
    return sin_alpha >= 1.0f;
}

/* Whether a level does: its error is within the threshold, its discs are not larger than what
 * reconstruction is good for, and the colours that they average, smeared over their radius, are no
 * worse than an error: a difference of the whole range over one pixel counts as colour_weight pixels.
 * The first pixel of the radius is free: what discs average there, a pixel averages, too.
 * error_px: stp_rule_error; radius_px: the greatest of the level; variation: 0 to 1
 * (formats/chunk/measure/patch_bounds.h); error_weight: more than 1 where outlines may be. docs/algorithms.md,
 * "Choosing the level". */
STP_RULE bool stp_rule_fits(float error_px, float radius_px, float variation, float error_weight,
                            float colour_weight, float threshold, float cap)
{
    return error_weight * error_px <= threshold && radius_px <= cap &&
           colour_weight * variation * STP_MAX(0.0f, radius_px - 1.0f) <= threshold;
}
