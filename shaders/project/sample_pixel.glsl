// Turns a sample into a pixel of the pyramid: its disc ("Projection" in README.md) and its colour.
// Needs layout.glsl, patch.glsl, project.glsl, shape.glsl, square.glsl, choose.glsl, palette.glsl,
// pixel.glsl, ellipse.glsl.

#define STP_SLOPE_LIMIT 5.0

// Pixels: a depth interval covers at least the surface's descent over this distance.
#define STP_EXTENT_FLOOR 1.25

// Radii are chosen so that pull and push leave no holes. If a pixel sees all ellipses around it,
// less is enough.
#if STP_SPLAT || STP_TEMPLATE
#define STP_RADIUS_PART 0.85
#else
#define STP_RADIUS_PART 1.0
#endif

// Perpendicular and tangential error of the quarter that a sample is in, at the sample's level.
vec2 stp_error_of(uint id, stp_patch p, int level)
{
    stp_finer f = stp_finer_fetch(stp_name_patch(id), p);
    if (level == 0 || level == 3)
        return level == 0 ? f.error_0 : p.vertex_error;
    uvec4 end = uvec4(1u, 2u, 3u, 4u);
    if (level == 1)
        end = stp_children_end(end, p.count[2], p.count[1]);
    uint i = id - stp_name_of(stp_name_patch(id), level, 0u);
    int q = int(i >= end.x) + int(i >= end.y) + int(i >= end.z);
    return level == 1 ? vec2(f.error_1[q], f.tangential_1[q]) : vec2(f.error_2[q], f.tangential_2[q]);
}

// Seven bits that change if the same surface is drawn at another level of the tree or of the chunk.
int stp_mark_of(uint id, stp_chunk chunk)
{
    return (4 * int(chunk.depth) + STP_LEVELS - stp_name_level(id)) & 127;
}

// The projected error, in pixels, of a patch with this perpendicular and tangential error.
float stp_patch_error(stp_patch p, vec2 error)
{
    stp_aspect a = stp_patch_aspect(p);
    float scale = stp_rule_scale(-stp_to_eye(p.bound_centre).z, a.range, p.bound_radius, viewport.z,
                                 viewport.w, STP_ORTHOGRAPHIC != 0);
    if (scale < 0.0)
        return 0.0;
    float sin_alpha = stp_rule_sin_alpha(a.cos_phi, p.cone_cos, a.sin_beta);
    return stp_rule_error(scale * stp_stretch(), sin_alpha, error.x, error.y);
}

// The colour that STP_COLOUR gives a sample. Elevation is looked up for each pixel (shade.glsl).
vec3 stp_own_colour(stp_disc disc)
{
#if STP_COLOUR == STP_COLOUR_NONE
    return vec3(0.8);
#elif STP_COLOUR == STP_COLOUR_INTENSITY
    return stp_palette_ramp((disc.intensity - colour_range.x) * colour_range.y);
#elif STP_COLOUR == STP_COLOUR_CLASS
    return stp_palette_class(disc.class_id);
#elif STP_COLOUR == STP_COLOUR_ELEVATION
    return vec3(0.0);
#elif STP_COLOUR == STP_COLOUR_OUTLIERS
    return stp_palette_outlier(disc.outlier, disc.colour);
#elif STP_COLOUR == STP_COLOUR_FIT
    return stp_palette_fit(disc.fit);
#else
    return disc.colour;
#endif
}

// The colour that pull and push carry. name: what is drawn; id: the name of its sample.
vec3 stp_sample_colour(stp_disc disc, uint name, uint id)
{
#if STP_SHADE == STP_SHADE_CHUNK || STP_SHADE == STP_SHADE_LEVEL || STP_SHADE == STP_SHADE_ERROR
    stp_chunk chunk = stp_chunk_fetch(stp_patch_slot(stp_name_patch(id)));
#endif
#if STP_SHADE == STP_SHADE_CHUNK
    vec3 shown = stp_palette_hash(chunk.id);
#elif STP_SHADE == STP_SHADE_LEVEL
    vec3 shown = stp_palette_level(stp_name_level(id), int(chunk.depth));
#elif STP_SHADE == STP_SHADE_ERROR
    stp_patch p = stp_patch_fetch(stp_name_patch(id), chunk);
    vec2 error = stp_error_of(id, p, stp_name_level(id));
    vec3 shown = stp_palette_heat(stp_patch_error(p, error) / max(quality.x, 1e-6));
#elif STP_SHADE == STP_SHADE_PRIMITIVE
    vec3 shown = stp_palette_primitive(name);
#else
    return stp_own_colour(disc);
#endif
#if STP_SHADE == STP_SHADE_CHUNK || STP_SHADE == STP_SHADE_LEVEL || STP_SHADE == STP_SHADE_ERROR ||                     \
    STP_SHADE == STP_SHADE_PRIMITIVE
#if STP_OVERLAY && STP_COLOUR != STP_COLOUR_ELEVATION
    shown = mix(stp_own_colour(disc), shown, colour_range.z);
#endif
    return shown;
#endif
}

// The depth of a pixel's interval: the disc's radius, or how far the surface descends under the
// smallest ellipse if that is more. So neighbouring pixels of a grazing surface meet. cosine:
// between normal and ray.
float stp_depth_extent(float radius, float cosine, float ppu)
{
    float k = min(1.0, abs(cosine));
    float slope = min(STP_SLOPE_LIMIT, sqrt(1.0 - k * k) / max(k, 1e-3));
    return max(radius, STP_EXTENT_FLOOR * slope / ppu);
}

// The disc of a vertex that is drawn without the segments beside it. A splat has no kind.
stp_disc stp_disc_alone(stp_disc disc)
{
#if STP_LINES && STP_SPLAT
    bool line = disc.kind == uint(STP_KIND_TUBE) || disc.kind == uint(STP_KIND_RIBBON);
    disc.has_normal = disc.has_normal && disc.kind != uint(STP_KIND_TUBE);
    disc.kind = line ? 0u : disc.kind;
#endif
    return disc;
}

// The numbers of the vertices of a sample's level in its patch: the first, and one past the last.
uvec2 stp_level_ends(uint id, stp_chunk chunk)
{
    stp_patch p = stp_patch_fetch(stp_name_patch(id), chunk);
    int level = stp_name_level(id);
    return uvec2(p.first[level], p.first[level] + p.count[level]);
}

// The name of the sample that a name in nearest_sample stands for, or that its shape begins with.
uint stp_name_id(uint name)
{
    uint index = name & STP_NAME_SAMPLE;
#if STP_SQUARES // all names are of squares
    stp_square s = stp_square_fetch(index >> STP_NAME_SQUARE_SHIFT);
    return stp_name_of(s.patch_index, 0, stp_square_rank(s.mask, index >> STP_NAME_PLACE_SHIFT & 63u));
#endif
    return index;
}

// The disc that a name stands for, seen at a window position. id: of the name; chunk: of its patch.
stp_disc stp_disc_of(uint name, uint id, stp_chunk chunk, vec2 window)
{
#if STP_SQUARES
#if STP_MAPS
    if ((name & STP_SQUARE_SPLAT) != 0u)
        return stp_map_disc(name, window);
#endif
    return stp_square_disc(name, window);
#endif
    stp_packing packing = stp_packing_fetch(stp_name_patch(id));
    uint number = stp_name_number(id, stp_patch_count(stp_name_patch(id)));
    vec4 lattice = stp_lattice_fetch(stp_name_patch(id), chunk.offset);
#if STP_LINES
    if ((name & STP_NAME_SEGMENT) != 0u) {
        stp_disc a = stp_vertex_fetch(packing, number, lattice);
        stp_disc b = stp_vertex_fetch(packing, number + 1u, lattice);
        if ((name & STP_NAME_TRIANGLE) == 0u)
            return stp_segment_disc(a, b, window);
        uvec2 ends = stp_level_ends(id, chunk);
        return stp_ribbon_disc(stp_ribbon_between(a, b, packing, number, ends, lattice), window);
    }
#endif
#if STP_TRIANGLES
    if ((name & STP_NAME_TRIANGLE) != 0u)
        return stp_triangle_disc(packing, number, lattice, window);
#endif
    return stp_disc_alone(stp_vertex_fetch(packing, number, lattice));
}

// The pixel of a disc as seen from a window position. name: what it is drawn as; id: of the name.
stp_pixel stp_disc_pixel(stp_disc disc, uint name, uint id, vec2 window)
{
    disc.radius *= disc.kind == 0u ? STP_RADIUS_PART : 1.0; // a line's radius is its half width
    vec3 w = stp_ray_through(disc.position);
    bool tube = STP_LINES != 0 && disc.kind == uint(STP_KIND_TUBE);
    if (tube && !disc.has_normal) // only a disc that faces the eye
        disc.kind = 0u;
    float away = disc.has_normal ? dot(disc.normal, w) : 0.0;
    if (!disc.has_normal) {
        disc.normal = -w;
    } else if (away > 0.0 && away <= STP_CULL_COSINE && disc.back_hidden) {
        // The disc leans over an outline: its normal is mirrored there.
        disc.normal -= 2.0 * away * w;
    } else if (away > 0.0) { // seen from behind: light that side
        disc.normal = -disc.normal;
        disc.oriented = false;
    }
    float depth = -disc.position.z;
    float ppu = stp_pixels_per_unit(depth);
    int tag = 1 + int(disc.kind) + (disc.oriented ? 0 : 8);
#if STP_FADE
    tag += 512 * stp_mark_of(id, stp_chunk_fetch(stp_patch_slot(stp_name_patch(id))));
#endif
    return stp_pixel(disc.normal, disc.radius, depth,
                     depth + stp_depth_extent(disc.radius, tube ? 1.0 : dot(disc.normal, w), ppu),
                     centre.xy + disc.position.xy * ppu - window,
                     stp_sample_colour(disc, name, id), depth, tag);
}

// The pixel of a name, seen from a window position.
stp_pixel stp_sample_pixel(uint name, vec2 window)
{
    uint id = stp_name_id(name);
    stp_chunk chunk = stp_chunk_fetch(stp_patch_slot(stp_name_patch(id)));
    return stp_disc_pixel(stp_disc_of(name, id, chunk, window), name, id, window);
}
