/* The data that the GPU reads, as C structs with the layout of shaders/layout.glsl and
 * shaders/project/patch.glsl. tests/gl/test_gl_layout.c compares the two. */
#ifndef STP_RUNTIME_GL_GPU_LAYOUT_H
#define STP_RUNTIME_GL_GPU_LAYOUT_H

#include "formats/chunk/outside.h"
#include "formats/chunk/sample/sample.h"

#include <stdint.h>

/* Texture units and uniform locations of shaders/layout.glsl, pixel.glsl and resolve.frag. */
enum {
    STP_UNIT_OBJECT_TEXTURE = 0,
    STP_UNIT_PATCHES = 1,
    STP_UNIT_CHUNKS = 2,
    STP_UNIT_FINE = 4,     /* shape, paint */
    STP_UNIT_COARSE = 6,   /* shape, paint */
    STP_UNIT_NEAREST = 8,  /* while resolving */
    STP_UNIT_FRONT = 8,    /* while splatting: the depth buffer, then the two sums, or the lists */
    STP_UNIT_EDGE = 8,     /* while smoothing edges: the picture, its depths */
    STP_UNIT_SQUARES = 12, /* of square.glsl */
    STP_UNIT_CODES = 13,
    STP_UNIT_COUNT = 14
};
/* The image of contour.glsl; compute shaders have others at its sides. */
#define STP_IMAGE_STEPS 3
enum {
    STP_UNIFORM_SCATTERED = 5, /* scattered.glsl */
    STP_UNIFORM_PYRAMID_LEVEL = 2,
    STP_UNIFORM_READ_SIZE = 3,
    STP_UNIFORM_VERTICES = 4,
    STP_UNIFORM_BLOCKS = 5, /* blocks.glsl */
    STP_UNIFORM_FIRST_PASS = 6,
    STP_UNIFORM_LEVEL_SIZE = 7, /* blocks.glsl */
    STP_UNIFORM_FADE_KEPT = 8,  /* fade.frag */
    STP_UNIFORM_FADE_WAY = 9,
    STP_UNIFORM_FADE_AXES = 10,
    STP_UNIFORM_FADE_F = 11,
    STP_UNIFORM_INCOMPLETE = 12 /* push.glsl */
};

/* The name of sample i of a patch's level: the patch's number << 7 | its place in the patch. Level
 * 3 has place 0; levels 2, 1 and 0 begin at places 1, 5 and 21. */
#define STP_NAME_PATCH_SHIFT 7
#define STP_NAMED_PATCHES_LIMIT (1u << (29 - STP_NAME_PATCH_SHIFT))
static inline uint32_t stp_name_of(uint32_t patch, int level, uint32_t i)
{
    return (patch << STP_NAME_PATCH_SHIFT) + (21u >> 2 * level) + i;
}
static inline int stp_name_level(uint32_t name)
{
    const uint32_t place = name & ((1u << STP_NAME_PATCH_SHIFT) - 1);
    return (place < 21) + (place < 5) + (place < 1);
}

/* The name of a pixel's nearest sample, segment or triangle: that of the (first) sample, plus these
 * bits. A segment goes to the next sample, a triangle over the next two. */
#define STP_NAME_SEGMENT UINT32_C(0x80000000)
#define STP_NAME_TRIANGLE UINT32_C(0x40000000)
#define STP_NAME_RIBBON UINT32_C(0xc0000000)
#define STP_NAME_SAMPLE UINT32_C(0x1fffffff)
#define STP_NAME_BITS 29
/* A triangle of a grid's cell, or a splat of a map. 19 bits: the number of the square among those
 * drawn; 6 bits: a sample's place in the square, in Morton order; 4 bits: which triangle. */
#define STP_NAME_SQUARE UINT32_C(0x60000000)
#define STP_NAME_SQUARE_SHIFT 10
#define STP_NAME_PLACE_SHIFT 4
#define STP_NAMED_SQUARES_LIMIT (1u << (29 - STP_NAME_SQUARE_SHIFT))

/* Flags of a square: other surfaces go on at its borders; it is one of a map, whose cells are all
 * surface. */
#define STP_SQUARE_OVERLAPS 1u
#define STP_SQUARE_OF_MAP 2u

/* Words of a bit set of all classes. */
#define STP_CLASS_WORDS 8

/* Words of a set of openings: bit i % 32 of word i / 32 stands for openings[i] of the frame. */
#define STP_OPENING_WORDS (STP_OPENINGS_LIMIT / 32)

/* A further bit of modes[1], besides the flags: backs are drawn nevertheless. */
#define STP_BACKS_DRAWN 256

/* std140, binding 0. */
typedef struct stp_gpu_frame {
    /* xyz: take a place relative to the eye to eye space. They are its axes in the world if nothing
     * is exaggerated; otherwise z is multiplied. w of the three: direction back to the eye where
     * the view looks, unit, in the world. */
    float axis_right[4], axis_up[4], axis_back[4];
    float viewport[4];   /* width, height, f, near depth */
    float centre[4];     /* window coordinates of the camera's axis; how many times as high heights
                            are drawn; 1 / its square */
    float frustum[2][4]; /* side planes: left, right, then low, high: (cos, sin) each */
    float quality[4];    /* threshold, radius cap, both in pixels; ball near, far */
    float terms[4];      /* weight of colours, weight of errors at outlines; contours: step, the
                            eye's height over a multiple of 5 steps */
    /* Low end (elevation: relative to the eye), 1 / (high - low); overlay, eye-dome lighting. */
    float colour_range[4];
    float light[4]; /* xyz: unit vector towards the light in eye space; number of planes */
    /* Orthographic; flags of samples whose backs are left out (0: none); clipped; number of
     * openings. */
    int32_t modes[4];
    float clip_min[4], clip_max[4];   /* xyz: of the clip box, relative to the eye; w of the first:
                                         light from the eye */
    float planes[6][4];               /* drawn: dot(xyz, place relative to the eye) + w >= 0 */
    uint32_t hidden[STP_CLASS_WORDS]; /* bit set of classes that are not drawn */
    /* Balls through which backs are seen nevertheless: centre relative to the eye, radius. */
    float openings[STP_OPENINGS_LIMIT][4];
} stp_gpu_frame;

/* Slots have numbers of 24 bits. */
#define STP_GPU_SLOTS_LIMIT (1u << 24)

/* Codes are those of the file (formats/chunk/sample/sample.h); stp_gpu_code has their values. */
typedef struct stp_gpu_patch {
    int32_t origin[3]; /* steps from the chunk's origin */
    uint8_t slot[3];
    uint8_t step;   /* exponent of the float: its bits 23 to 30 */
    uint32_t first; /* of its texels in the Object Texture (runtime/stream/texels.h): the rest */
    uint8_t cone_axis[3], cone_angle;
    uint8_t vertex_error[2]; /* of level 3: perpendicular, tangential */
    uint8_t bound_radius;
    uint8_t flags;        /* STP_PATCH_*, STP_GPU_PATCH_APART */
    uint8_t radius[2];    /* of levels 3 and 2 */
    uint8_t colour_error; /* of level 3 */
    uint8_t count;        /* of level 0, which tells the others, less 1; the finest resident level
                             << STP_GPU_PATCH_FINEST_SHIFT */
} stp_gpu_patch;

/* A further flag of a patch: the centre of its bound is not where its vertex is. */
#define STP_GPU_PATCH_APART 64u
#define STP_GPU_PATCH_FINEST_SHIFT 6

static inline uint32_t stp_gpu_patch_count(const stp_gpu_patch *patch)
{
    return 1 + (patch->count & ((1u << STP_GPU_PATCH_FINEST_SHIFT) - 1));
}

static inline int stp_gpu_patch_finest(const stp_gpu_patch *patch)
{
    return patch->count >> STP_GPU_PATCH_FINEST_SHIFT;
}

/* What a code of the file stands for: errors and radii in steps. */
typedef struct stp_gpu_code {
    float error, radius, cone_cos, unused;
} stp_gpu_code;

enum { STP_GPU_CODES = 256 };

typedef struct stp_gpu_chunk {
    float offset[3]; /* origin minus eye */
    uint32_t finest;
    uint32_t id;
    uint32_t depth;
    uint32_t order; /* the block's number in its model: decides between equal depths */
    uint32_t unused;
    uint32_t openings[STP_OPENING_WORDS]; /* through which its patches may be seen */
} stp_gpu_chunk;

/* A square that is drawn as triangles or as splats (shaders/project/square.glsl). Along axis (axis
 * + 1
 * + k) % 3, the next column is column[k] further, the next row row[k], and a height of 1 up[k]. */
typedef struct stp_gpu_square {
    float origin[3], step; /* of its patch, relative to the eye */
    uint32_t samples[2];   /* bit i % 32 of word i / 32: sample i in Morton order is there */
    uint32_t patch;        /* in the Object Texture */
    uint32_t unused;
    float column[2], row[2], up[2];
    uint32_t axis;
    uint32_t flags; /* STP_SQUARE_* */
    /* The squares around it, by rows, then by columns, as numbers among those drawn; UINT32_MAX:
     * none is drawn. */
    uint32_t beside[8];
    /* Of a map: dot products with a difference of places in eye space tell by how many columns and
     * rows they differ. */
    float to_column[4], to_row[4];
} stp_gpu_square;

_Static_assert(sizeof(stp_gpu_frame) == 352 + 16 * STP_OPENINGS_LIMIT,
               "std140 block of layout.glsl");
_Static_assert(sizeof(stp_gpu_patch) == 32, "STP_PATCH_TEXELS texels");
_Static_assert(sizeof(stp_gpu_chunk) == 48, "STP_CHUNK_TEXELS texels");
_Static_assert(sizeof(stp_gpu_square) == 128, "STP_SQUARE_TEXELS texels");

#endif
