// Chooses the level of a patch: level_rule.glsl, applied to patch_texture.
// runtime/cut/level_choice.c does the same in C; tests/gl/test_gl_level.c compares the two. Needs
// patch.glsl.

#define STP_RULE
#define STP_SQRT sqrt
#define STP_MAX max
#define STP_MIN min
#define STP_ABS abs
#include "level_rule.glsl"

#define STP_LEVEL_SKIP -1

// How the eye sees a patch.
struct stp_sight {
    float scale, sin_alpha, weight;
};

bool stp_fits(stp_sight s, float error, float tangential_error, float radius, float variation)
{
    return stp_rule_fits(stp_rule_error(s.scale, s.sin_alpha, error, tangential_error), s.scale * radius, variation,
                         s.weight, terms.x, quality.x, quality.y);
}

bvec4 stp_fit(stp_sight s, vec4 error, vec4 tangential_error, float radius, float variation)
{
    return bvec4(stp_fits(s, error.x, tangential_error.x, radius, variation),
                 stp_fits(s, error.y, tangential_error.y, radius, variation),
                 stp_fits(s, error.z, tangential_error.z, radius, variation),
                 stp_fits(s, error.w, tangential_error.w, radius, variation));
}

// How the eye sees the bound of a patch: distance of its centre; sine of half the angle under which
// it is seen; cosine between the cone's axis and the direction to the centre.
struct stp_aspect {
    float range, sin_beta, cos_phi;
};

stp_aspect stp_patch_aspect(stp_patch p)
{
    const bool orthographic = STP_ORTHOGRAPHIC != 0;
    float range = length(stp_to_eye(p.bound_centre));
    float sin_beta = orthographic ? 0.0 : min(1.0, p.bound_radius / max(range, 1e-30));
    vec3 direction = orthographic ? -axis_back.xyz : p.bound_centre / max(range, 1e-30);
#if STP_EXAGGERATED
    return stp_aspect(range, sin_beta, 0.0); // the cone is another: any normal may be
#else
    return stp_aspect(range, sin_beta, clamp(dot(direction, p.cone_axis), -1.0, 1.0));
#endif
}

// The openings through which a place in the bound of a patch may be seen, out of those of its block.
// If every normal of the patch faces the eye, stp_culled drops no sample, and the set is empty.
uvec4 stp_patch_openings(stp_patch p, uint slot)
{
    uvec4 set = uvec4(0u);
#if STP_OPENINGS
    stp_aspect a = stp_patch_aspect(p);
    bool faces = a.cos_phi < 0.0 && stp_rule_sin_alpha(a.cos_phi, p.cone_cos, a.sin_beta) < 1.0;
    uvec4 left = faces || modes.y == 0 ? uvec4(0u) : stp_chunk_openings(slot);
    while (left != uvec4(0u)) {
        int i = stp_set_take(left);
        bool through = stp_seen_through(STP_OPENING(i), p.bound_centre, p.bound_radius * 1.00001);
        uvec4 bit = uvec4(equal(ivec4(i >> 5), ivec4(0, 1, 2, 3))) << uint(i & 31);
        set |= through ? bit : uvec4(0u);
    }
#endif
    return set;
}

// The level of each quarter of a patch in sight, no finer than the finest resident level;
// STP_LEVEL_SKIP for absent quarters. Level 3 stands for the whole patch, in quarter 0.
ivec4 stp_choose_levels(uint index, stp_patch p, stp_chunk chunk)
{
    const ivec4 skip = ivec4(STP_LEVEL_SKIP);
    const bool orthographic = STP_ORTHOGRAPHIC != 0;
    stp_aspect a = stp_patch_aspect(p);
    uint least = max(chunk.finest, p.finest);
    bvec4 absent = greaterThanEqual(uvec4(0u, 1u, 2u, 3u), uvec4(least == 3u ? 1u : p.count[2]));
    ivec4 finest = mix(ivec4(least), skip, absent);
    float scale = stp_rule_scale(-stp_to_eye(p.bound_centre).z, a.range, p.bound_radius, viewport.z, viewport.w,
                                 orthographic);
    if (quality.x <= 0.0 || scale < 0.0)
        return finest;
    float sin_alpha = stp_rule_sin_alpha(a.cos_phi, p.cone_cos, a.sin_beta);
    stp_sight sight = stp_sight(scale * stp_stretch(), sin_alpha, stp_rule_is_silhouette(sin_alpha) ? terms.y : 1.0);
    if (stp_fits(sight, p.vertex_error.x, p.vertex_error.y, p.radius, p.variation))
        return ivec4(3, STP_LEVEL_SKIP, STP_LEVEL_SKIP, STP_LEVEL_SKIP);
    stp_finer f = stp_finer_fetch(index, p);
    ivec4 levels = mix(ivec4(0), ivec4(1), stp_fit(sight, f.error_1, f.tangential_1, f.radius[1], f.variation[1]));
    levels = mix(levels, ivec4(2), stp_fit(sight, f.error_2, f.tangential_2, f.radius[2], f.variation[2]));
    return max(levels, finest) * ivec4(not(absent)) + skip * ivec4(absent);
}

// What a patch with these levels is drawn as: segments, triangles, or 0 (points). All quarters of a
// strip or of triangles choose the same level.
uint stp_shape_of(stp_patch p, int level)
{
#if STP_LINES
    if ((p.flags & STP_PATCH_STRIP) != 0u && p.count[max(level, 0)] >= 2u)
        return STP_PATCH_STRIP;
#endif
#if STP_TRIANGLES
    if ((p.flags & STP_PATCH_TRIANGLES) != 0u && level == 0)
        return STP_PATCH_TRIANGLES;
#endif
    return 0u;
}

// Fetches a patch and chooses its levels. Returns whether the patch is then drawn as `shape`.
bool stp_choose_shape(uint index, uint shape, out stp_patch p, out ivec4 levels)
{
    stp_chunk chunk = stp_chunk_fetch(stp_patch_slot(index));
    p = stp_patch_fetch(index, chunk);
    levels = stp_choose_levels(index, p, chunk);
    return stp_shape_of(p, levels.x) == shape;
}

// The samples of a patch at the chosen levels. first[q] is the number of the first one of quarter q in the patch;
// quarters 0 to q have end[q] samples together.
struct stp_selection {
    uvec4 first, end;
};

stp_selection stp_select(stp_patch p, ivec4 levels)
{
    if (levels.x == 3)
        return stp_selection(uvec4(p.first[3]), uvec4(1u)); // the other quarters have none
    uvec4 end_2 = uvec4(1u, 2u, 3u, 4u);
    uvec4 end_1 = stp_children_end(end_2, p.count[2], p.count[1]);
    uvec4 end_0 = stp_children_end(end_1, p.count[1], p.count[0]);
    bvec4 at_1 = equal(levels, ivec4(1)), at_2 = equal(levels, ivec4(2));
    uvec4 end = mix(mix(end_0, end_1, at_1), end_2, at_2);
    uvec4 begin = mix(mix(uvec4(0u, end_0.xyz), uvec4(0u, end_1.xyz), at_1), uvec4(0u, end_2.xyz), at_2);
    uvec4 count = mix(end - begin, uvec4(0u), lessThan(levels, ivec4(0)));
    uvec4 first = begin + mix(mix(uvec4(p.first[0]), uvec4(p.first[1]), at_1), uvec4(p.first[2]), at_2);
    count.y += count.x;
    count.zw += count.y;
    count.w += count.z - count.y;
    return stp_selection(first, count);
}

// The names of the quarters' first samples.
uvec4 stp_selection_names(stp_selection s, uint patch_index, stp_patch p, ivec4 levels)
{
    uvec4 names;
    for (int q = 0; q < STP_QUARTERS; q++) {
        int level = max(levels[q], 0);
        names[q] = stp_name_of(patch_index, level, s.first[q] - p.first[level]);
    }
    return names;
}
