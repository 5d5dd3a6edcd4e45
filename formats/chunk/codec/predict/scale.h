/* The scan's own scale: positions that are multiples of a decimal step, such as 0.01, each rounded
 * to the lattice of its patch.
 *
 * A lattice's step is a power of two below the scan's, so positions could be coded finer than they
 * are. With a scale, cells of positions count the scan's steps. formats/SPEC.md, "The scan's own
 * scale", has the arithmetic: doubles, each step rounded by itself, the same on every machine.
 * Threads: any (pure functions). */
#ifndef STP_FORMATS_CHUNK_CODEC_PREDICT_SCALE_H
#define STP_FORMATS_CHUNK_CODEC_PREDICT_SCALE_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/inline.h"

#include <math.h>

#define STP_SCALE_BYTES 14u
/* No step is greater. */
#define STP_SCALE_LIMIT 1e15
/* A patch is coded by the scale if that is above 1 and at most this many of its lattice's steps. */
#define STP_SCALE_STEPS_MOST 4096.0
/* Phases are in 1 / 2^16 of a step. */
#define STP_SCALE_PHASES 65536.0

typedef struct stp_scale {
    double step;       /* in the scan's unit; 0: no scale */
    uint16_t phase[3]; /* of the multiples, relative to the chunk's origin */
} stp_scale;

/* The scale of one patch's lattice. */
typedef struct stp_patch_scale {
    bool used;
    double lattice_steps; /* in a step of the scale */
    double places;        /* of the scale in a step of the lattice: its reciprocal */
    double offset[3];     /* the place of position 0, along each axis; 0 to 1 */
} stp_patch_scale;

/* Finds a scale that all level-0 positions of a chunk have. step 0: none. */
void stp_scale_find(const stp_chunk *chunk, stp_scale *out);

/* As bytes of a file. Errors: CORRUPT. */
void stp_scale_write(const stp_scale *scale, uint8_t bytes[STP_SCALE_BYTES]);
stp_status stp_scale_read(const uint8_t bytes[STP_SCALE_BYTES], stp_scale *out, stp_error *err);

STP_INLINE stp_patch_scale stp_scale_of_patch(const stp_scale *scale, const stp_patch *patch)
{
    stp_patch_scale out = {.used = false};
    if (!(scale->step > 0.0))
        return out;
    const double lattice = ldexp(1.0, patch->exponent);
    out.lattice_steps = scale->step / lattice;
    out.places = lattice / scale->step;
    out.used = out.lattice_steps > 1.0 && out.lattice_steps <= STP_SCALE_STEPS_MOST;
    for (int i = 0; i < 3 && out.used; i++) {
        const double at = patch->origin[i] * out.places - scale->phase[i] / STP_SCALE_PHASES;
        out.offset[i] = at - floor(at);
    }
    return out;
}

/* The nearest whole number, halves up. -2^16 <= x < 2^30 */
STP_INLINE int32_t stp_scale_nearest(double x)
{
    return (int32_t)(x + (STP_SCALE_PHASES + 0.5)) - (int32_t)STP_SCALE_PHASES;
}

/* The place of a position, 0 to 65535, on the scale. */
STP_INLINE int32_t stp_scale_place(const stp_patch_scale *s, int axis, int32_t position)
{
    return stp_scale_nearest(position * s->places + s->offset[axis]);
}

/* The position at a place; any number modulo 2^16 if the place is outside the patch. */
STP_INLINE int32_t stp_scale_position(const stp_patch_scale *s, int axis, int32_t place)
{
    return stp_scale_nearest((place - s->offset[axis]) * s->lattice_steps) & 0xffff;
}

#endif
