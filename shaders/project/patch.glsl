// Patches and samples as the GPU holds them. Needs layout.glsl.

struct stp_patch {
    vec3 origin;          // relative to the eye, world axes
    float step;           // of the sample lattice
    vec3 bound_centre;    // relative to the eye
    float bound_radius;
    vec3 cone_axis;
    float cone_cos;       // of the half-angle; -1: any direction
    vec2 vertex_error;    // of level 3: perpendicular, tangential; world units
    float radius;         // of level 3
    float variation;      // of level 3: of its colours, 0 to 1 (SPEC.md, colour_error)
    uint finer;           // texel that stp_finer_fetch begins with
    uvec4 first;          // number of each level's first sample (stp_level_numbers)
    uvec4 count;
    uint flags;           // STP_PATCH_*
    uint finest;          // finest resident level
};

// What is stored of the finer levels that are resident; of others it is meaningless. World units.
struct stp_finer {
    vec4 error_2, tangential_2, error_1, tangential_1; // by quarter (formats/chunk/sample/sample.h)
    vec2 error_0;          // perpendicular, tangential
    vec3 radius;           // greatest of levels 0, 1, 2
    vec3 variation;
};

struct stp_chunk {
    vec3 offset;          // origin minus eye, world axes
    uint finest;          // finest level drawn
    uint id;
    uint depth;
    uint order;           // decides between equal depths
};

// How the samples of a patch are packed (runtime/stream/texels.h). Loops over samples need not find it anew.
struct stp_packing {
    uint first;            // texel of the samples after the vertex
    uvec4 vertex;          // words
    uvec2 widths;          // of the fields
    uint bits;             // of a sample
    uvec3 place;           // bits of x, y, z
    uvec3 place_mask;
    uvec3 place_shift;
    uvec3 place_base;      // of the vertex, less what makes differences positive
    uint place_bits;
    uvec3 normal;          // bits of both parts of a normal, and of flags
    uvec3 normal_mask;
    uvec2 normal_base;
    uint radius;           // greatest code of each level, a byte each
    uvec2 finer;           // numbers of the first samples of levels 0 and 1
};

struct stp_disc {
    vec3 position;        // eye space
    vec3 normal;          // eye space, unit; meaningless if unknown
    float radius;
    vec3 colour;
    float intensity;      // 0 to 1
    uint class_id;
    bool outlier;
    uint fit;             // stp_sample_fit: how the normal was found
    uint kind;
    bool has_normal;
    bool oriented;
    bool back_hidden;     // its back is hidden, except at outlines
};

stp_chunk stp_chunk_fetch(uint slot)
{
    uvec4 a = texelFetch(chunk_texture, int(slot) * STP_CHUNK_TEXELS);
    uvec4 b = texelFetch(chunk_texture, int(slot) * STP_CHUNK_TEXELS + 1);
    return stp_chunk(uintBitsToFloat(a.xyz), a.w, b.x, b.y, b.z);
}

// The openings through which the patches of a block may be seen: bit i % 32 of word i / 32 stands for
// openings[i].
uvec4 stp_chunk_openings(uint slot)
{
    return texelFetch(chunk_texture, int(slot) * STP_CHUNK_TEXELS + 2);
}

// The slot of a patch's chunk.
uint stp_patch_slot(uint index)
{
    return texelFetch(patch_texture, int(index) * STP_PATCH_TEXELS).w & 0xffffffu;
}

// The name of sample i of a level.
uint stp_name_of(uint patch_index, int level, uint i)
{
    return (patch_index << STP_NAME_PATCH_SHIFT) + (STP_NAME_FIRST_PLACES >> 2 * level) + i;
}

int stp_name_level(uint name)
{
    uint place = name & (1u << STP_NAME_PATCH_SHIFT) - 1u;
    return int(place < 21u) + int(place < 5u) + int(place < 1u);
}

// The patch of a name, whatever its highest bits are.
uint stp_name_patch(uint name)
{
    return (name & STP_NAME_SAMPLE) >> STP_NAME_PATCH_SHIFT;
}

// The numbers of the first samples of levels 0 to 3 in a patch. count: its samples of level 0.
uvec4 stp_level_numbers(uint count)
{
    uint of_1 = count + 3u >> 2, of_2 = of_1 + 3u >> 2;
    return uvec4(1u + of_2 + of_1, 1u + of_2, 1u, 0u);
}

// The number of a name's sample in its patch. count: of the patch, of level 0.
uint stp_name_number(uint name, uint count)
{
    uvec4 first = stp_level_numbers(count);
    int level = stp_name_level(name);
    uint begin = level == 3 ? first.w : level == 2 ? first.z : level == 1 ? first.y : first.x;
    return begin + (name & STP_NAME_SAMPLE) - stp_name_of(stp_name_patch(name), level, 0u);
}

// The second texel of a patch.
uvec4 stp_patch_rest(uint patch_index)
{
    return texelFetch(patch_texture, int(patch_index) * STP_PATCH_TEXELS + 1);
}

// Its last byte tells how many samples the patch has at level 0.
uint stp_patch_count(uint patch_index)
{
    return 1u + (stp_patch_rest(patch_index).w >> 24 & 63u);
}

// The words of a patch's vertex (formats/chunk/sample/sample.h), from its first texel on.
uvec4 stp_vertex_words(uint first)
{
    return uvec4(texelFetch(object_texture, int(first)).xy, texelFetch(object_texture, int(first) + 1).xy);
}

// The first texel of a patch's samples.
uint stp_patch_samples(uint patch_index)
{
    return stp_patch_rest(patch_index).x;
}

// The texel after those that every patch has. rest: stp_patch_rest.
uint stp_patch_finer(uvec4 rest)
{
    return rest.x + 2u + (rest.z >> 24 & STP_PATCH_APART) / STP_PATCH_APART;
}

stp_packing stp_packing_make(uint first, uvec4 vertex, uvec2 widths, uint radius, uvec2 finer)
{
    uvec3 place = uvec3(widths.x) >> uvec3(0u, 5u, 10u) & 31u, normal = uvec3(widths.x) >> uvec3(15u, 19u, 23u) & 15u;
    stp_packing p;
    p.first = first;
    p.vertex = vertex;
    p.widths = widths;
    p.place = place;
    p.place_mask = (uvec3(1u) << place) - 1u;
    p.place_shift = uvec3(widths.yy >> 24 & 15u, 0u);
    p.place_base = uvec3(vertex.x, vertex.x >> 16, vertex.y) -
                   (uvec3(2u, 2u, widths.y >> 30) << place >> 2u << p.place_shift);
    p.place_bits = place.x + place.y + place.z;
    p.normal = normal;
    p.normal_mask = (uvec3(1u) << normal) - 1u;
    p.normal_base = uvec2(vertex.z, vertex.z >> 12) -
                    (uvec2(widths.y >> 28 & 3u, 2u) << normal.xy >> 2u << (widths.x >> 27 & 15u));
    p.radius = radius;
    p.finer = finer;
    uvec3 look = uvec3(widths.y) >> uvec3(0u, 8u, 16u) & 15u, after = uvec3(widths.y) >> uvec3(4u, 12u, 20u) & 15u;
    p.bits = p.place_bits + normal.x + normal.y + normal.z + look.x + look.y + look.z + after.x + after.y + after.z;
    return p;
}

stp_packing stp_packing_fetch(uint patch_index)
{
    uvec4 rest = stp_patch_rest(patch_index);
    uint finer = stp_patch_finer(rest), levels = texelFetch(object_texture, int(finer) + 2).x;
    uint samples = finer + (rest.w >> 30 == 2u ? 2u : 4u);
    return stp_packing_make(samples, stp_vertex_words(rest.x), texelFetch(object_texture, int(finer)).xy,
                            levels & 65535u | rest.w << 8 & 0xff0000u, stp_level_numbers(1u + (rest.w >> 24 & 63u)).xy);
}

// Bits of words, from bit `from` on, at most 31. next: the word after them.
uvec4 stp_bits_shift(uvec4 w, uint next, uint from)
{
    return w >> from | uvec4(w.yzw, next) << 1u << 31u - from;
}

// Likewise from a bit up to 63 on, if no word follows.
uvec4 stp_bits_skip(uvec4 w, uint from)
{
    return stp_bits_shift((from & 32u) != 0u ? uvec4(w.yzw, 0u) : w, 0u, from & 31u);
}

// The lowest bits of a word.
uint stp_bits_low(uint word, uint bits)
{
    return word & (1u << bits) - 1u;
}

// The same as a difference from the vertex's value.
uint stp_bits_difference(uint word, uint bits)
{
    return stp_bits_low(word, bits) - (1u << bits >> 1u);
}

// The words of a sample (formats/chunk/sample/sample.h), by its number in the patch. What of it a shader does not use is not
// computed.
uvec4 stp_sample_words(stp_packing p, uint number)
{
    uint at = (max(number, 1u) - 1u) * p.bits, shift = p.widths.x >> 27 & 15u;
    int texel = int(p.first + (at >> 6));
    uvec2 a = texelFetch(object_texture, texel).xy, b = texelFetch(object_texture, texel + 1).xy;
    uvec2 c = texelFetch(object_texture, texel + 2).xy;
    bool second = (at & 32u) != 0u;
    uvec4 w = stp_bits_shift(second ? uvec4(a.y, b, c.x) : uvec4(a, b), second ? c.y : c.x, at & 31u);
    uvec4 after_x = stp_bits_shift(w, 0u, p.place.x), after_y = stp_bits_shift(after_x, 0u, p.place.y);
    uvec3 place = p.place_base + ((uvec3(w.x, after_x.x, after_y.x) & p.place_mask) << p.place_shift) & 65535u;
    w = stp_bits_skip(w, p.place_bits);
    uvec3 normal = uvec3(w.x, w.x >> p.normal.x, w.x >> p.normal.x + p.normal.y) & p.normal_mask;
    uvec2 direction = p.normal_base + (normal.xy << shift) & 4095u;
    uint flags = normal.z << 30 | normal.z << 22 & 0x3f000000u;
    w = stp_bits_skip(w, p.normal.x + p.normal.y + p.normal.z);
    uvec4 look = uvec4(p.widths.y) >> uvec4(0u, 4u, 8u, 12u) & 15u;
    uvec2 kind = uvec2(p.widths.y) >> uvec2(16u, 20u) & 15u;
    int level = number >= p.finer.x ? 0 : number >= p.finer.y ? 8 : 16;
    uint radius = (p.radius >> level) - (stp_bits_low(w.x, look.x) << (p.widths.x >> 31) * 2u) & 255u;
    uint red = p.vertex.w + stp_bits_difference(w.x >> look.x, look.y) & 255u;
    uint green = (p.vertex.w >> 8) + stp_bits_difference(w.x >> look.x + look.y, look.z) & 255u;
    uint blue = (p.vertex.w >> 16) + stp_bits_difference(w.x >> look.x + look.y + look.z, look.w) & 255u;
    w = stp_bits_skip(w, look.x + look.y + look.z + look.w);
    uint class_id = stp_bits_low(w.x, kind.x) << 24 ^ p.vertex.z & 0xff000000u;
    uint intensity = (p.vertex.w >> 24) + stp_bits_difference(w.x >> kind.x, kind.y);
    uvec4 words = uvec4(place.x | place.y << 16, place.z | radius << 16 | (flags ^ p.vertex.y & 0xff000000u),
                        direction.x | direction.y << 12 | class_id, red | green << 8 | blue << 16 | intensity << 24);
    return number == 0u ? p.vertex : words;
}

// A patch's origin relative to the eye, world axes, and its step.
vec4 stp_lattice_fetch(uint index, vec3 chunk_offset)
{
    uvec4 a = texelFetch(patch_texture, int(index) * STP_PATCH_TEXELS);
    float step = uintBitsToFloat(a.w >> 24 << 23);
    return vec4(vec3(ivec3(a.xyz)) * step + chunk_offset, step);
}

// Four bytes of a word, and the errors and radii that four codes stand for, in steps.
uvec4 stp_bytes(uint word)
{
    return uvec4(word & 255u, word >> 8 & 255u, word >> 16 & 255u, word >> 24);
}

vec4 stp_errors_of(uint word)
{
    ivec4 code = ivec4(stp_bytes(word));
    return vec4(texelFetch(code_texture, code.x).x, texelFetch(code_texture, code.y).x,
                texelFetch(code_texture, code.z).x, texelFetch(code_texture, code.w).x);
}

vec4 stp_radii_of(uint word)
{
    ivec4 code = ivec4(stp_bytes(word));
    return vec4(texelFetch(code_texture, code.x).y, texelFetch(code_texture, code.y).y,
                texelFetch(code_texture, code.z).y, texelFetch(code_texture, code.w).y);
}

// How many times as long as it is anything is drawn at most.
float stp_stretch()
{
#if STP_EXAGGERATED
    return max(1.0, centre.z);
#else
    return 1.0;
#endif
}

// Unpacks an octahedral normal of 2 x 12 bits: a vector along it, in the scan's axes (Meyer et al.
// 2010).
vec3 stp_normal_direction(uint code)
{
    vec2 e = vec2(float(code & 4095u), float(code >> 12 & 4095u)) * (2.0 / 4095.0) - 1.0;
    float z = 1.0 - abs(e.x) - abs(e.y);
    float fold = max(-z, 0.0);
    return vec3(e.x + (e.x >= 0.0 ? -fold : fold), e.y + (e.y >= 0.0 ? -fold : fold), z);
}

stp_patch stp_patch_fetch(uint index, stp_chunk chunk)
{
    int base = int(index) * STP_PATCH_TEXELS;
    uvec4 a = texelFetch(patch_texture, base);
    uvec4 b = stp_patch_rest(index);
    uint flags = b.z >> 24;
    uvec2 place = texelFetch(object_texture, int(b.x + ((flags & STP_PATCH_APART) != 0u ? 2u : 0u))).xy;
    ivec3 origin = ivec3(a.xyz), bound = ivec3(place.x & 65535u, place.x >> 16, place.y & 65535u);
    float step = uintBitsToFloat(a.w >> 24 << 23);
    stp_patch p;
    p.origin = vec3(origin) * step + chunk.offset;
    p.step = step;
    p.bound_centre = vec3(origin + bound) * step + chunk.offset;
    p.bound_radius = texelFetch(code_texture, int(b.z >> 16 & 255u)).y * step * stp_stretch();
    p.cone_axis = normalize(stp_normal_direction(b.y));
    p.cone_cos = texelFetch(code_texture, int(b.y >> 24)).z;
    p.vertex_error = vec2(texelFetch(code_texture, int(b.z & 255u)).x, texelFetch(code_texture, int(b.z >> 8 & 255u)).x) * step;
    p.radius = texelFetch(code_texture, int(b.w & 255u)).y * step;
    p.variation = unpackUnorm4x8(b.w).z;
    p.finer = stp_patch_finer(b);
    p.flags = flags;
    p.finest = b.w >> 30;
    p.count.x = 1u + (b.w >> 24 & 63u);
    p.count.y = p.count.x + 3u >> 2;
    p.count.z = p.count.y + 3u >> 2;
    p.count.w = 1u;
    p.first = stp_level_numbers(p.count.x);
    return p;
}

// p: stp_patch_fetch(index, ...).
stp_finer stp_finer_fetch(uint index, stp_patch p)
{
    int at = int(p.finer);
    uvec2 of_2 = texelFetch(object_texture, at + 1).xy, all = texelFetch(object_texture, at + 2).xy;
    uvec2 of_1 = texelFetch(object_texture, at + 3).xy;
    vec4 radii = stp_radii_of(all.x & 65535u | stp_patch_rest(index).w << 8 & 0xff0000u) * p.step;
    vec4 shown = unpackUnorm4x8(all.x);
    stp_finer f;
    f.error_2 = stp_errors_of(of_2.x) * p.step;
    f.tangential_2 = stp_errors_of(of_2.y) * p.step;
    f.error_1 = stp_errors_of(of_1.x) * p.step;
    f.tangential_1 = stp_errors_of(of_1.y) * p.step;
    f.error_0 = (stp_errors_of(all.y) * p.step).yz;
    f.radius = radii.xyz;
    f.variation = vec3(unpackUnorm4x8(all.y).x, shown.w, shown.z);
    return f;
}

// Where the quarters end among the samples of the finer level, computed from the coarser level's
// ends.
uvec4 stp_children_end(uvec4 coarser, uint count, uint finer_count)
{
    return uvec4((vec4(coarser * finer_count) + 0.5) / float(max(count, 1u)));
}

vec3 stp_to_eye(vec3 v)
{
    return vec3(dot(axis_right.xyz, v), dot(axis_up.xyz, v), dot(axis_back.xyz, v));
}

// The inverse: from eye space to the world, relative to the eye.
vec3 stp_from_eye(vec3 v)
{
    vec3 world = axis_right.xyz * v.x + axis_up.xyz * v.y + axis_back.xyz * v.z;
#if STP_EXAGGERATED
    world.z *= centre.w;
#endif
    return world;
}

// Where an orthographic view looks from, in the world.
vec3 stp_back()
{
#if STP_EXAGGERATED
    return vec3(axis_right.w, axis_up.w, axis_back.w);
#else
    return axis_back.xyz;
#endif
}

// A sample's position relative to the eye, world axes.
vec3 stp_sample_position(uvec4 texel, vec3 origin, float step)
{
    return origin + step * vec3(float(texel.x & 65535u), float(texel.x >> 16),
                                float(texel.y & 65535u));
}

// Whether a sample has the flags of those whose backs are hidden (layout.glsl, modes.y).
bool stp_sample_back_hidden(uvec4 texel)
{
    uint flags = uint(modes.y & STP_BACKS_DRAWN - 1);
    return flags != 0u && (texel.y >> 24 & flags) == flags;
}

// Whether the sample is marked: closed, but without a normal (runtime/stream/chosen.h).
bool stp_sample_marked(uvec4 texel)
{
    return STP_CHOSEN != 0 && (texel.y & 0x0a000000u) == 0x08000000u;
}

bool stp_sample_oriented(uvec4 texel)
{
    return (texel.y & 0x03000000u) == 0x03000000u;
}

// A normal in eye space, unit. n: in the scan's axes, of any length.
vec3 stp_normal_to_eye(vec3 n)
{
#if STP_EXAGGERATED
    n.z *= centre.w; // it stays across its surface
#endif
    return normalize(stp_to_eye(n));
}

#if STP_EXAGGERATED
// Stretches a disc as its place is stretched. An ellipse would come of it; it is drawn as the disc with
// the same second moment. n: the normal, or a tube's tangent, in the world.
void stp_disc_exaggerate(inout stp_disc disc, vec3 n)
{
    bool tube = disc.kind == 2u; // STP_KIND_TUBE
    float across = disc.has_normal ? max(1.0 - n.z * n.z, 0.0) : 1.0;
    disc.radius *= tube ? 1.0 : sqrt(1.0 + 0.5 * (centre.z * centre.z - 1.0) * across);
    n.z *= tube ? 1.0 : centre.w; // a normal stays across its surface
    disc.normal = normalize(stp_to_eye(n));
}
#endif

stp_disc stp_disc_decode(uvec4 texel, vec3 origin, float step)
{
    stp_disc disc;
    uint radius = texel.y >> 16 & 255u;
    disc.position = stp_to_eye(stp_sample_position(texel, origin, step));
    disc.intensity = float(texel.w >> 24) / 255.0;
    disc.class_id = texel.z >> 24;
    disc.outlier = (texel.y & 0x04000000u) != 0u;
    disc.fit = texel.y >> 30;
    disc.normal = stp_to_eye(normalize(stp_normal_direction(texel.z)));
    disc.oriented = stp_sample_oriented(texel);
    disc.back_hidden = stp_sample_back_hidden(texel);
    disc.has_normal = (texel.y & 0x02000000u) != 0u;
    disc.radius = radius == 0u ? 0.0 : step * exp2((float(radius) - 1.0) / 16.0);
    disc.kind = texel.y >> 28 & 3u;
    disc.colour = vec3(float(texel.w & 255u), float(texel.w >> 8 & 255u),
                       float(texel.w >> 16 & 255u)) / 255.0;
#if STP_EXAGGERATED
    stp_disc_exaggerate(disc, normalize(stp_normal_direction(texel.z)));
#endif
    return disc;
}
