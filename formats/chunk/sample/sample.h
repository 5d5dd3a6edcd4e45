/* The 16-byte sample, and the patch that holds its lattice.
 *
 * A sample is the same 16 bytes in memory and as a payload decodes; on the GPU it is packed
 * (runtime/stream/texels.h). Sample positions are unsigned steps from the patch's origin; the
 * patch's origin is signed steps from the chunk's origin; a step is 2^exponent world units; the
 * chunk's origin is world coordinates in double. Everything is quantised once: decoding is exact.
 * Axes: the scan's own, right-handed. Units: the scan's own. Threads: any (pure functions).
 *
 * Words, little-endian: x = position x | position y << 16
 *                       y = position z | radius << 16 | flags << 24
 *                       z = octahedral normal (12 bits u, 12 bits v << 12) | class << 24
 *                       w = red | green << 8 | blue << 16 | intensity << 24 */
#ifndef STP_FORMATS_CHUNK_SAMPLE_SAMPLE_H
#define STP_FORMATS_CHUNK_SAMPLE_SAMPLE_H

#include "base/vec.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

/* Level 0 is the finest; level 3 is the patch vertex. */
#define STP_LEVEL_COUNT 4
/* Most samples of a patch at level 0. Each coarser level has ceil(finer / 4). */
#define STP_PATCH_SAMPLES 64
/* A quarter is a level-2 sample and all that it covers: the least part of a patch that takes its
 * level by itself. A patch has counts[2] of them. */
#define STP_PATCH_QUARTERS 4
/* Radius codes an octave: radius = step * 2^((code - 1) / 16), code 0 is 0. */
#define STP_RADIUS_CODES_PER_OCTAVE 16
/* Error codes an octave: error = step * 2^((code - 1) / 8 - 8), code 0 is 0. */
#define STP_ERROR_CODES_PER_OCTAVE 8
#define STP_ERROR_CODE_BIAS_OCTAVES 8

/* Flags of a sample: bit 0 orientation known, bit 1 normal known, bit 2 far from everything else,
 * bit 3 back hidden from outside, bits 4-5 kind, bits 6-7 how the normal was found. A merged sample
 * has bits 2 and 3 if all samples that it stands for have them, and the least of their bits 6-7. */
enum {
    STP_SAMPLE_ORIENTED = 1u << 0,
    STP_SAMPLE_HAS_NORMAL = 1u << 1,
    STP_SAMPLE_OUTLIER = 1u << 2,
    STP_SAMPLE_CLOSED = 1u << 3, /* docs/closed.md; its orientation and normal are known */
    STP_SAMPLE_KIND_SHIFT = 4,
    STP_SAMPLE_KIND_MASK = 3u << 4,
    STP_SAMPLE_FIT_SHIFT = 6,
    STP_SAMPLE_FIT_MASK = 3u << 6
};

/* What a sample is a piece of: bits 4-5 of its flags. */
typedef enum stp_sample_kind {
    STP_KIND_SURFACE = 0, /* a disc across its normal */
    STP_KIND_RIBBON = 1,  /* a disc across its normal; the radius is half the ribbon's width */
    STP_KIND_TUBE = 2,    /* the normal is the tube's tangent: the disc faces the eye */
    STP_KIND_POLYGON = 3  /* a corner of a triangle */
} stp_sample_kind;

/* How a sample's normal was found: bits 6-7 of its flags. More noise needs a wider plane. */
typedef enum stp_sample_fit {
    STP_FIT_NEAREST = 0, /* a plane through the nearest neighbours; or no plane, or not told */
    STP_FIT_WIDE = 1,   /* that plane joined with those of the neighbours, noise of 0.04 spacings or
                           more; or an average of the input's normals */
    STP_FIT_WIDEST = 2, /* joined again, noise of 0.12 spacings or more; or a window of an image */
    STP_FIT_GIVEN = 3   /* the input's normal */
} stp_sample_fit;

typedef struct stp_sample {
    uint16_t position[3];
    uint8_t radius;
    uint8_t flags;
    uint8_t normal[3];
    uint8_t class_id;
    uint8_t rgb[3];
    uint8_t intensity;
} stp_sample;

_Static_assert(sizeof(stp_sample) == 16, "a sample is one RGBA32UI texel");

/* A patch as stored: up to 64 adjacent level-0 samples and their coarser levels. Index l of the
 * arrays is the level. Error codes are rounded up, so that the decoded bound holds. */
typedef struct stp_patch {
    int32_t origin[3];  /* steps from the chunk's origin */
    int16_t exponent;   /* a step is 2^exponent world units */
    uint8_t child;      /* which child of the chunk refines this patch, 255 = none (leaf) */
    uint8_t cone_angle; /* greatest angle of a level-0 normal off the axis: code * pi / 255 */
    uint8_t counts[STP_LEVEL_COUNT];
    uint8_t error[STP_LEVEL_COUNT];            /* perpendicular, greatest of the level */
    uint8_t tangential_error[STP_LEVEL_COUNT]; /* overhang.h, greatest of the level */
    /* Of levels 1 and 2 by quarter, index level - 1; 0 for quarters that do not exist. */
    uint8_t quarter_error[2][STP_PATCH_QUARTERS];
    uint8_t quarter_tangential_error[2][STP_PATCH_QUARTERS];
    uint8_t colour_error[STP_LEVEL_COUNT]; /* stp_colour_variation, 0..255 */
    uint8_t radius[STP_LEVEL_COUNT];       /* greatest radius code of the level */
    uint16_t bound_centre[3];              /* steps from the origin */
    uint8_t bound_radius; /* radius code: holds the discs of every level and what they stand for */
    uint8_t cone_axis[3]; /* octahedral, 2 x 12 bits */
    uint8_t flags;        /* STP_PATCH_* */
    /* In a linked chunk: level-0 sample i is the patch vertex of the child's patch first_below + i.
     * Else 0. */
    uint16_t first_below;
} stp_patch;

enum {
    STP_PATCH_TWO_SIDED =
        1u << 0, /* some sample's orientation or normal is unknown: never culled */
    /* Level 0 is a polyline, vertex after vertex, all ribbon or all tube. A level of two or more
     * samples is a polyline through some of its vertices, the first and the last among them. A
     * level of one sample is a disc that stands for the whole strip. */
    STP_PATCH_STRIP = 1u << 1,
    STP_PATCH_TRIANGLES = 1u << 2, /* level 0: corners, three a triangle; other levels: discs */
    STP_PATCH_CONTINUES = 1u << 3, /* a strip whose first vertex is another strip's last */
    STP_PATCH_CONTINUED = 1u << 4, /* a strip whose last vertex is another strip's first */
    STP_PATCH_CLOSED = 1u << 5,    /* all samples are closed */
    STP_PATCH_SHAPES = STP_PATCH_STRIP | STP_PATCH_TRIANGLES,
    STP_PATCH_JOINTS = STP_PATCH_CONTINUES | STP_PATCH_CONTINUED
};

#define STP_PATCH_NO_CHILD 255u

static inline stp_sample_kind stp_sample_kind_of(const stp_sample *sample)
{
    return (stp_sample_kind)((sample->flags & STP_SAMPLE_KIND_MASK) >> STP_SAMPLE_KIND_SHIFT);
}

static inline stp_sample_fit stp_sample_fit_of(const stp_sample *sample)
{
    return (stp_sample_fit)(sample->flags >> STP_SAMPLE_FIT_SHIFT);
}

/* The lesser of the sample's fit and `fit`. */
static inline unsigned stp_sample_fit_least(const stp_sample *sample, unsigned fit)
{
    return stp_sample_fit_of(sample) < fit ? stp_sample_fit_of(sample) : fit;
}

/* Whether the normal is the disc's own. If not, the disc faces whoever looks at it. */
static inline bool stp_sample_is_flat(const stp_sample *sample)
{
    return sample->flags & STP_SAMPLE_HAS_NORMAL && stp_sample_kind_of(sample) != STP_KIND_TUBE;
}

/* Number of samples of the level above `finer` samples. */
static inline unsigned stp_level_count_above(unsigned finer)
{
    return (finer + 3u) / 4u;
}

/* Sample j of the coarser level (of count samples) covers [begin(j), begin(j + 1)) of the finer
 * level (of finer_count): at most 4 if count = ceil(finer_count / 4). */
static inline unsigned stp_level_children_begin(unsigned j, unsigned count, unsigned finer_count)
{
    /* the analyser cannot tell what arrays of counts hold: */
    return count ? j * finer_count / count : 0; // NOLINT(clang-analyzer-core.*)
}

/* First sample of level `to` under sample i of level `from`. `from` is no finer than `to`. */
static inline unsigned stp_covered_begin(const uint8_t counts[STP_LEVEL_COUNT], int from,
                                         unsigned i, int to)
{
    for (int l = from; l > to; l--)
        i = stp_level_children_begin(i, counts[l], counts[l - 1]);
    return i;
}

/* First sample of quarter q at a level; for q = counts[2], the level's end. Level 3 stands for the
 * whole patch and is in quarter 0. */
static inline unsigned stp_quarter_begin(const uint8_t counts[STP_LEVEL_COUNT], int level,
                                         unsigned q)
{
    return level == 3 ? q > 0 : stp_covered_begin(counts, 2, q, level);
}

/* Codes of a quarter's errors at a level. Levels 0 and 3 have the patch's. */
static inline uint8_t stp_quarter_error(const stp_patch *patch, int level, unsigned q)
{
    return level == 1 || level == 2 ? patch->quarter_error[level - 1][q] : patch->error[level];
}

static inline uint8_t stp_quarter_tangential_error(const stp_patch *patch, int level, unsigned q)
{
    return level == 1 || level == 2 ? patch->quarter_tangential_error[level - 1][q]
                                    : patch->tangential_error[level];
}

/* Octahedral map (Meyer et al. 2010) to 2 x 12 bits; the zero vector becomes +z. decode(encode(n))
 * is within 0.04 degrees of n and is a unit vector. Components are the scan's axes. */
void stp_normal_encode(vec3s normal, uint8_t out[3]);
vec3s stp_normal_decode(const uint8_t code[3]);
/* The same of four codes in lanes, by axis. A code here is u | v << 12. */
void stp_normals_decode(const uint32_t code[4], float out[3][4]);

/* World units. Encoding rounds up; a value beyond the range gets code 255. */
uint8_t stp_radius_encode(double radius, int exponent);
double stp_radius_decode(uint8_t code, int exponent);
uint8_t stp_error_encode(double error, int exponent);
double stp_error_decode(uint8_t code, int exponent);
/* Radians, rounded up. */
uint8_t stp_cone_angle_encode(double angle);
double stp_cone_angle_decode(uint8_t code);

/* 2^exponent; avoids the call of ldexp if a double holds the power as a normal number. */
static inline double stp_power_of_two(int exponent)
{
    if (exponent < -1022 || exponent > 1023)
        return ldexp(1.0, exponent);
    const uint64_t bits = (uint64_t)(exponent + 1023) << 52;
    double out;
    memcpy(&out, &bits, sizeof out);
    return out;
}

/* Position of a sample relative to the chunk's origin, world units, exact in double. */
static inline stp_dvec3 stp_sample_position(const stp_sample *sample, const stp_patch *patch)
{
    const double step = stp_power_of_two(patch->exponent);
    return (stp_dvec3){((double)patch->origin[0] + sample->position[0]) * step,
                       ((double)patch->origin[1] + sample->position[1]) * step,
                       ((double)patch->origin[2] + sample->position[2]) * step};
}

/* Radius of a sample, world units. */
double stp_sample_radius(const stp_sample *sample, const stp_patch *patch);

/* Decoded samples of a patch as columns: world units relative to the chunk's origin. Normals are
 * unit, or zero if the disc faces whoever looks at it. */
typedef struct stp_sample_lanes {
    double centre[3][STP_PATCH_SAMPLES], normal[3][STP_PATCH_SAMPLES], radius[STP_PATCH_SAMPLES];
} stp_sample_lanes;

/* Decodes up to STP_PATCH_SAMPLES samples. Each gets what the functions above give, several times
 * as fast. Columns from `count` on are undefined. */
void stp_samples_decode(const stp_sample *samples, unsigned count, const stp_patch *patch,
                        stp_sample_lanes *out);

#endif
