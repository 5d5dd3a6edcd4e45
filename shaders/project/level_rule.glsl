/* The error rule: how many pixels wrong a level of a patch may look, and whether that is good
 * enough.
 *
 * The shaders include this file; runtime/cut/level_rule.h compiles the same text as C. So only the
 * common subset of C and GLSL is used: scalar floats. Source: Dachsbacher et al. 2003 (sequential
 * point trees); docs/algorithms.md, "Choosing the level".
 *
 *     error(l) = scale * min(e sin(alpha) + e_t,  sqrt(e^2 + e_t^2))       pixels
 *     scale    = f / (z cos(theta))                                        pixels a world unit
 *
 *     e      perpendicular error of level l: along the normal               world units
 *     e_t    tangential error of level l: across the normal                 world units
 *     f      focal length in pixels; orthographic: scale = f, pixels a world unit
 *     z      nearest depth of the patch's bound (a ball)
 *     theta  greatest angle between the camera's axis and a ray through the bound
 *     alpha  greatest angle between an eye ray through the bound and a normal of the patch's cone
 *
 *      n ^      / eye ray      P  a point of a disc that is drawn
 *        |alpha/               D  the nearest place on its nearest level-0 disc
 *      e +----/----* P         P lies e along n and e_t across n away from D.
 *        |   /     |           First bound: the eye sees e shortened to e sin(alpha), and all of
 *        |  /      |           e_t at most. It is the smaller bound where the eye looks along n.
 *        | /       |
 *        |/        |           Second bound (ours): e and e_t are the legs of a right angle
 *        D---------+-->        (formats/chunk/measure/overhang.h), so DP is at most the hypotenuse,
 *                 e_t          and no view makes DP longer. It is the smaller bound at outlines,
 *                              where sin(alpha) = 1.
 *
 * Example: f = 1000 px, z = 10 m, theta = 0, so scale = 100 px/m; e = 5 mm, e_t = 2 mm.
 *     alpha = 30 degrees: min(0.5 * 5 + 2, 5.39) = 4.5 mm:    0.45 px
 *     alpha = 90 degrees: min(5 + 2, 5.39)       = 5.39 mm:   0.54 px */

/* Greatest number of pixels that a world unit covers anywhere in the bound: f / (z cos(theta)).
 * centre_depth: depth of the bound's centre along the camera's axis; centre_distance: distance of
 * that centre from the eye; radius: of the bound. Returns -1 if the bound reaches the near plane or
 * the eye: then the projection has no limit and the patch must be refined. */
STP_RULE float stp_rule_scale(float centre_depth, float centre_distance, float radius, float f,
                              float near_depth, bool orthographic)
{
    float z = centre_depth - radius;
    float sin_beta = radius / centre_distance;
    float cos_beta = STP_SQRT(STP_MAX(0.0f, 1.0f - sin_beta * sin_beta));
    float cos_axis = centre_depth / centre_distance;
    float sin_axis = STP_SQRT(STP_MAX(0.0f, 1.0f - cos_axis * cos_axis));
    float cos_theta = cos_axis * cos_beta - sin_axis * sin_beta;
    float room = STP_MIN(cos_theta - 0.001f, STP_MIN(z - near_depth, centre_distance - radius));
    return orthographic ? f : room > 0.0f ? f / (z * cos_theta) : -1.0f;
}

/* Spread = gamma + beta: gamma is the half-angle of the normal cone; beta is half of the angle
 * under which the eye sees the bound. This returns sin(spread); stp_rule_spread_cos returns
 * cos(spread). */
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

/* Greatest sin(alpha) between an eye ray through the bound and a normal of the cone:
 *
 *     sin(alpha) = sin(phi + gamma + beta), or 1 if that angle reaches 90 degrees
 *
 * cos_phi: phi is the angle between the direction to the bound's centre and the axis of the cone;
 * the sign of cos_phi does not matter. cos_gamma: of the cone's half-angle. sin_beta: radius /
 * distance of the bound; 0 if orthographic. */
STP_RULE float stp_rule_sin_alpha(float cos_phi, float cos_gamma, float sin_beta)
{
    float sin_spread = stp_rule_spread_sin(cos_gamma, sin_beta);
    float cos_spread = stp_rule_spread_cos(cos_gamma, sin_beta);
    float c = STP_ABS(cos_phi);
    float s = STP_SQRT(STP_MAX(0.0f, 1.0f - c * c));
    float cos_alpha = c * cos_spread - s * sin_spread;
    float least = STP_MIN(STP_MIN(cos_gamma, cos_spread), cos_alpha);
    return least <= 0.0f ? 1.0f : STP_MIN(1.0f, s * cos_spread + c * sin_spread);
}

/* Projected error of one level, pixels. */
STP_RULE float stp_rule_error(float scale, float sin_alpha, float error, float tangential_error)
{
    return scale * STP_MIN(error * sin_alpha + tangential_error,
                           STP_SQRT(error * error + tangential_error * tangential_error));
}

/* Whether an eye ray through the bound may be at right angles to a normal of the cone. If so, the
 * patch may show an outline. */
STP_RULE bool stp_rule_is_silhouette(float sin_alpha)
{
    return sin_alpha >= 1.0f;
}

/* Whether a level is fine enough. All three must hold:
 *
 *     error       error_weight * error_px                             <= threshold
 *     radius      radius_px                                           <= cap
 *     colour      colour_weight * variation * max(0, radius_px - 1)   <= threshold
 *
 * radius: reconstruction is good only for discs up to the cap. colour: a disc smears the colours
 * that it averages over its radius. If they differ by the whole range (variation 1) over one pixel,
 * that counts as colour_weight pixels of error. The first pixel of the radius is free, since a
 * pixel averages over that much anyway.
 * error_px: stp_rule_error; radius_px: the level's greatest; variation: 0 to 1
 * (formats/chunk/measure/patch_bounds.h); error_weight: above 1 where outlines may be. Source:
 * docs/algorithms.md, "Choosing the level". */
STP_RULE bool stp_rule_fits(float error_px, float radius_px, float variation, float error_weight,
                            float colour_weight, float threshold, float cap)
{
    return error_weight * error_px <= threshold && radius_px <= cap &&
           colour_weight * variation * STP_MAX(0.0f, radius_px - 1.0f) <= threshold;
}
