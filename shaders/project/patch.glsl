// Patches and samples as the GPU holds them. Needs layout.glsl.

struct stp_patch {
    vec3 origin;          // relative to the eye, world axes
    float step;           // of the sample lattice
    vec3 bound_centre;    // relative to the eye
    float bound_radius;
    vec3 cone_axis;
    float cone_cos;       // of the half-angle; -1: any direction
    vec2 vertex_error;    // of level 3: perpendicular, tangential; world units
    vec2 finest_error;    // of level 0: perpendicular, tangential
    vec4 radius;          // greatest of each level
    vec4 variation;       // of each level: of its colours, 0 to 1 (SPEC.md, colour_error)
    uvec4 first;          // sample index of each level's first sample
    uvec4 count;
    uint flags;           // STP_PATCH_*
    uint finest;          // finest resident level
};

// Errors of levels 1 and 2, by quarter (formats/chunk/sample.h), world units.
struct stp_quarter_errors {
    vec4 error_2, tangential_2, error_1, tangential_1;
};

struct stp_chunk {
    vec3 offset;          // origin minus eye, world axes
    uint colours;         // where the fourth words of samples are (stp_sample_fetch)
    uint finest;          // finest level drawn
    uint id;
    uint depth;
    uint order;           // decides between equal depths
    uvec4 first;          // sample of each level, less the first patch for level 3
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
    uvec4 first = texelFetch(chunk_texture, int(slot) * STP_CHUNK_TEXELS + 2);
    return stp_chunk(uintBitsToFloat(a.xyz), a.w, b.x, b.y, b.z, b.w, first);
}

// The openings through which the patches of a block may be seen: bit i % 32 of word i / 32 stands for
// openings[i].
uvec4 stp_chunk_openings(uint slot)
{
    return texelFetch(chunk_texture, int(slot) * STP_CHUNK_TEXELS + 3);
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

// Where the levels of a patch begin in the Object Texture. b: its second texel.
uvec4 stp_patch_first(uint patch_index, stp_chunk chunk, uvec4 b)
{
    return chunk.first + uvec4(b.y >> 16, b.z & 65535u, b.z >> 16, patch_index);
}

// Where a sample is in the Object Texture. chunk: of its patch.
uint stp_name_index(uint name, stp_chunk chunk)
{
    uint patch_index = stp_name_patch(name);
    uvec4 first = stp_patch_first(patch_index, chunk, texelFetch(patch_texture, int(patch_index) * STP_PATCH_TEXELS + 1));
    int level = stp_name_level(name);
    uint begin = level == 3 ? first.w : level == 2 ? first.z : level == 1 ? first.y : first.x;
    return begin + (name & STP_NAME_SAMPLE) - stp_name_of(patch_index, level, 0u);
}

// Whether the samples of a block are narrow. colours: of the block.
bool stp_narrow(uint colours)
{
    return colours >> 30 == 3u;
}

// A narrow sample as the words of a sample, the lowest bits first: position x, y 12 each, radius 8; position
// z 12, normal u 12, red 8; normal v 12, normal known, oriented, closed in 2, fit 2, green 8, blue 8. Class and
// intensity are 0, other flags not set.
uvec4 stp_narrow_widen(uvec3 t)
{
    uint flags = 0xb320u >> (t.z >> 10 & 12u) & 15u | (t.z >> 8 & 0xc0u);
    return uvec4(t.x & 4095u | (t.x & 0xfff000u) << 4, t.y & 4095u | t.x >> 8 & 0xff0000u | flags << 24,
                 t.y >> 12 & 4095u | (t.z & 4095u) << 12, t.y >> 24 | t.z >> 8 & 0xffff00u);
}

// The first three words of a sample (formats/chunk/sample.h), which are all that projection reads.
uvec4 stp_sample_words(uint index, bool narrow)
{
    uvec3 t = texelFetch(object_texture, int(index)).xyz;
    return narrow ? stp_narrow_widen(t) : uvec4(t, 0u);
}

// A sample. If the block is not narrow, the fourth words of its samples follow them, three a texel.
uvec4 stp_sample_fetch(uint index, uint colours)
{
    bool narrow = stp_narrow(colours);
    uint place = index + (colours >> 30);
    uint texel = narrow ? 0u : (colours & 0x3fffffffu) + place / 3u;
    uint colour = texelFetch(object_texture, int(texel))[place % 3u];
    uvec4 words = stp_sample_words(index, narrow);
    return narrow ? words : uvec4(words.xyz, colour);
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
    uvec4 b = texelFetch(patch_texture, base + 1);
    uvec4 c = texelFetch(patch_texture, base + 2);
    ivec3 origin = ivec3(a.xyz), bound = ivec3(b.x & 65535u, b.x >> 16, b.y & 65535u);
    float step = uintBitsToFloat(a.w >> 24 << 23);
    stp_patch p;
    p.origin = vec3(origin) * step + chunk.offset;
    p.step = step;
    p.bound_centre = vec3(origin + bound) * step + chunk.offset;
    p.bound_radius = texelFetch(code_texture, int(c.w & 255u)).y * step * stp_stretch();
    p.cone_axis = normalize(stp_normal_direction(b.w));
    p.cone_cos = texelFetch(code_texture, int(b.w >> 24)).z;
    vec4 errors = stp_errors_of(c.z) * step;
    p.vertex_error = errors.xy;
    p.finest_error = errors.zw;
    p.radius = stp_radii_of(c.x) * step;
    p.variation = unpackUnorm4x8(c.y);
    p.flags = c.w >> 8 & 255u;
    p.finest = c.w >> 24;
    p.count.x = c.w >> 16 & 255u;
    p.count.y = p.count.x + 3u >> 2;
    p.count.z = p.count.y + 3u >> 2;
    p.count.w = 1u;
    p.first = stp_patch_first(index, chunk, b);
    return p;
}

stp_quarter_errors stp_quarter_errors_fetch(uint index, float step)
{
    uvec4 codes = texelFetch(patch_texture, int(index) * STP_PATCH_TEXELS + 3);
    return stp_quarter_errors(stp_errors_of(codes.x) * step, stp_errors_of(codes.y) * step,
                              stp_errors_of(codes.z) * step, stp_errors_of(codes.w) * step);
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
