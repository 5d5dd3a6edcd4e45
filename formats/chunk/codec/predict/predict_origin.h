/* Origins of patches as small numbers. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_PREDICT_PREDICT_ORIGIN_H
#define STP_FORMATS_CHUNK_CODEC_PREDICT_PREDICT_ORIGIN_H

#include "formats/chunk/chunk_file.h"
#include "formats/chunk/codec/predict/predict_normal.h"
#include "formats/chunk/sample/normal_grid.h"

/* Codes a coordinate of an origin in two cells: bits 3 to 18 of the difference, signed; then bits 0
 * to 2, with what is left above bit 18 beside them. predicted is a multiple of 8, and as a rule the
 * value is, too. */
STP_INLINE int32_t stp_code_eighths(int16_t *middle, int16_t *rest, bool decode, int32_t predicted,
                                    int32_t value)
{
    if (decode)
        return (int32_t)((uint32_t)predicted + ((uint32_t)(int32_t)*middle << 3) +
                         ((uint32_t)(*rest >> 3) << 19) + ((uint32_t)*rest & 7u));
    const int32_t difference = (int32_t)((uint32_t)value - (uint32_t)predicted);
    *middle = (int16_t)(difference >> 3);
    *rest = (int16_t)((((difference >> 3) - *middle) >> 16) * 8 + (difference & 7));
    return value;
}

/* Predicts the origin: a place so many steps from the previous patch's origin is at the next one's,
 * on this patch's lattice. */
STP_INLINE int32_t stp_predict_origin(const stp_patch *previous, int exponent, int axis,
                                      int64_t steps)
{
    int64_t origin = previous->origin[axis] + steps;
    int shift = previous->exponent - exponent;
    if (shift > 0)
        origin = shift < 31 ? origin * ((int64_t)1 << shift) : 0;
    else if (shift < 0)
        origin = shift > -31 ? origin / ((int64_t)1 << -shift) : 0;
    return (int32_t)(uint32_t)(uint64_t)origin;
}

STP_INLINE stp_ivec3 stp_cone_axis_of(const stp_patch *p)
{
    int32_t uv[2];
    stp_normal_codes_get(p->cone_axis, uv);
    return stp_integer_normal(uv[0], uv[1]);
}

#endif
