// Bindings and packed layouts of all shaders. runtime/gl/gpu_layout.h has the same as C structs;
// tests/gl/test_gl_layout.c compares the two.

// A software driver gathers a member of a block lane by lane at each use, which costs more than the
// arithmetic around it. A shader that loops over samples defines STP_FRAME_HELD and begins with
// stp_frame_hold(): then the members are variables, read once.
#ifdef STP_FRAME_HELD
#define STP_FRAME_BLOCK frame_block
#else
#define STP_FRAME_BLOCK
#endif

// The values of a whole frame. Lengths in the scan's units, angles as cosines, image in pixels.
layout(std140, binding = 0) uniform stp_frame {
    // xyz: take a place relative to the eye to eye space. They are its axes in the world if nothing is
    // exaggerated; otherwise z is multiplied. w of the three: direction back to the eye where the view
    // looks, unit, in the world.
    vec4 axis_right;
    vec4 axis_up;
    vec4 axis_back;
    vec4 viewport;      // width, height, f, near depth
    vec4 centre;        // window coordinates of the camera's axis; how many times as high heights are
                        // drawn; 1 / its square
    vec4 frustum[2];    // side planes: left, right, then low, high: (cos, sin) each; for the CPU
    vec4 quality;       // threshold in pixels, radius cap in pixels, ball near, ball far
    vec4 terms;         // error rule: weight of colours, of errors at outlines (1: as elsewhere);
                        // contours: step, the eye's height over a multiple of 5 steps
    vec4 colour_range;  // low end (elevation: relative to the eye), 1 / (high - low); overlay, edl
    vec4 light;         // xyz: unit vector towards the light in eye space; number of planes
    // x: 1 if orthographic. y: flags of samples whose backs are hidden (0: none) | STP_BACKS_DRAWN.
    // z: 1 if clipped. w: number of openings. All but y have macros, too.
    ivec4 modes;
    vec4 clip_min;      // xyz: of the clip box, relative to the eye; w: light from the eye
    vec4 clip_max;
    vec4 planes[6];     // drawn: dot(xyz, place relative to the eye) + w >= 0; STP_PLANES of them
    uvec4 hidden[2];    // bit set of classes that are not drawn
    vec4 openings[128]; // balls that show backs: centre relative to the eye, radius
} STP_FRAME_BLOCK;

#ifdef STP_FRAME_HELD
vec4 axis_right, axis_up, axis_back, viewport, centre, quality, terms, colour_range, clip_min, clip_max;
vec4 planes[6];
ivec4 modes;
uvec4 hidden[2];
#define STP_OPENING(i) frame_block.openings[i] // too many to hold

void stp_frame_hold()
{
    axis_right = frame_block.axis_right;
    axis_up = frame_block.axis_up;
    axis_back = frame_block.axis_back;
    viewport = frame_block.viewport;
    centre = frame_block.centre;
    quality = frame_block.quality;
    terms = frame_block.terms;
    colour_range = frame_block.colour_range;
    clip_min = frame_block.clip_min;
    clip_max = frame_block.clip_max;
#if STP_PLANES
    planes = frame_block.planes;
#endif
    modes = frame_block.modes;
    hidden = frame_block.hidden;
}
#else
#define STP_OPENING(i) openings[i]
#endif

#define STP_BACKS_DRAWN 256 // no back is left out, even if hidden

// A program is compiled for one variant (runtime/gl/shader.h): it has a macro for each member, 0 or 1,
// or a number. Code that a picture does not need is not compiled, since software rasterisers run both
// sides of a branch. A program has only the macros that its text mentions, so do not name them here.
#define STP_SHADE_PHONG 0
#define STP_SHADE_LAMBERT 1
#define STP_SHADE_UNLIT 2
#define STP_SHADE_NORMAL 3
#define STP_SHADE_DEPTH 4
#define STP_SHADE_LEVEL 5
#define STP_SHADE_CHUNK 6
#define STP_SHADE_ERROR 7
#define STP_SHADE_CONFIDENCE 8
#define STP_SHADE_PRIMITIVE 9
#define STP_COLOUR_RGB 0
#define STP_COLOUR_NONE 1
#define STP_COLOUR_INTENSITY 2
#define STP_COLOUR_CLASS 3
#define STP_COLOUR_ELEVATION 4
#define STP_COLOUR_OUTLIERS 5
#define STP_COLOUR_FIT 6
#define STP_MAPS_SPLATS 2
#define STP_MAPS_BLEND 3
#define STP_MAPS_PLAIN 4
#define STP_PALETTE_GREY 1
#define STP_PALETTE_VIRIDIS 2
#define STP_PALETTE_HEAT 3

// The Object Texture: the samples of patches, packed (patch.glsl).
layout(binding = 0) uniform usamplerBuffer object_texture;
// Two texels a patch, STP_PATCH_TEXELS: see patch.glsl.
layout(binding = 1) uniform usamplerBuffer patch_texture;
// Three texels a resident block, by slot: see patch.glsl.
layout(binding = 2) uniform usamplerBuffer chunk_texture;

// Eight texels a square that is drawn as triangles or as splats, STP_SQUARE_TEXELS: see square.glsl.
layout(binding = 12) uniform usamplerBuffer square_texture;
// What each code of the file stands for: error, radius, both in steps; cosine of a cone's angle.
layout(binding = 13) uniform samplerBuffer code_texture;

#define STP_PATCH_TEXELS 2
#define STP_CHUNK_TEXELS 3
#define STP_SQUARE_TEXELS 8
#define STP_LEVELS 4
#define STP_QUARTERS 4
#define STP_NO_SAMPLE 0xffffffffu

// The name of a sample, which pixels hold: its patch << 7 | its place in the patch. Level 3 has place 0;
// levels 2, 1 and 0 begin at places 1, 5 and 21.
#define STP_NAME_PATCH_SHIFT 7
#define STP_NAME_FIRST_PLACES 21u // >> 2 * level

// The highest bits of a pixel's name say what is nearest: the segment from this vertex to the next;
// the triangle of this corner and the next two; with both bits the segment as a flat piece of a
// ribbon.
#define STP_NAME_SEGMENT 0x80000000u
#define STP_NAME_TRIANGLE 0x40000000u
#define STP_NAME_RIBBON 0xc0000000u
#define STP_NAME_SAMPLE 0x1fffffffu
#define STP_NAME_BITS 29
// A triangle of a grid's cell (square.glsl). 19 bits: the number of the square among those drawn; 6 bits:
// a sample's place in the square. STP_SQUARE_WHOLE: the triangle is of the whole cell, not of the sample's
// quarter. STP_SQUARE_SECOND: it is the second triangle. STP_SQUARE_SPLAT: it is the sample's splat instead.
// STP_SQUARE_BORDER: some neighbour of the sample is missing.
#define STP_NAME_SQUARE 0x60000000u
#define STP_NAME_SQUARE_SHIFT 10
#define STP_NAME_PLACE_SHIFT 4
#define STP_SQUARE_WHOLE 4u
#define STP_SQUARE_SPLAT 1u
#define STP_SQUARE_BORDER 2u
#define STP_SQUARE_SECOND 8u
// Flags of a square: other surfaces go on at its borders; it is one of a map, whose cells are all surface.
#define STP_SQUARE_OVERLAPS 1u
#define STP_SQUARE_OF_MAP 2u

// Flags of a patch (formats/chunk/sample/sample.h).
#define STP_PATCH_STRIP 2u
#define STP_PATCH_APART 64u // the centre of its bound is not where its vertex is
#define STP_PATCH_TRIANGLES 4u

// The level of the pyramid that the pass draws.
layout(location = 2) uniform int pyramid_level;
