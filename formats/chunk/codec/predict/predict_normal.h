/* Predicts a child's normal from its parent's normal, the siblings before it, and how the surface
 * turns from parent to parent. Inlined into predict.c's loops. formats/SPEC.md, "Normals of
 * children", has the arithmetic. All values are whole numbers; roots and quotients go through
 * doubles only where a double gives the exact floor. Threads: any. */
#ifndef STP_FORMATS_CHUNK_CODEC_PREDICT_PREDICT_NORMAL_H
#define STP_FORMATS_CHUNK_CODEC_PREDICT_PREDICT_NORMAL_H

#include "formats/chunk/codec/inline.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>

/* The greatest octahedral code, which is also the L1 length of an integer normal. */
#define STP_NORMAL_CODE_MAX 4095
/* A unit vector's length is 2^14. */
#define STP_UNIT_SHIFT 14
#define STP_UNIT (1 << STP_UNIT_SHIFT)
/* Fraction bits of turnings; bits of offsets between parents. */
#define STP_TURN_SHIFT 12
#define STP_TURN_OFFSET_BITS 12
/* Greatest turn between a parent and its child: two units. */
#define STP_TURN_LIMIT (2 * STP_UNIT - 1)

typedef struct stp_ivec3 {
    int32_t v[3];
} stp_ivec3;

STP_INLINE int32_t stp_sign_not_zero(int32_t v)
{
    return v < 0 ? -1 : 1;
}

/* 0, 1 or 2: the greatest absolute component, the first of equals. */
STP_INLINE int stp_main_axis(stp_ivec3 n)
{
    int axis = abs(n.v[1]) > abs(n.v[0]) ? 1 : 0;
    return abs(n.v[2]) > abs(n.v[axis]) ? 2 : axis;
}

/* The octahedral code u, v as a vector of L1 length 4095; its greatest component is at least 1365.
 */
STP_INLINE stp_ivec3 stp_integer_normal(int32_t u, int32_t v)
{
    int32_t x = 2 * u - STP_NORMAL_CODE_MAX;
    int32_t y = 2 * v - STP_NORMAL_CODE_MAX;
    int32_t z = STP_NORMAL_CODE_MAX - abs(x) - abs(y);
    if (z >= 0)
        return (stp_ivec3){{x, y, z}};
    return (stp_ivec3){{(STP_NORMAL_CODE_MAX - abs(y)) * stp_sign_not_zero(x),
                        (STP_NORMAL_CODE_MAX - abs(x)) * stp_sign_not_zero(y), z}};
}

/* An integer normal made a unit vector. */
STP_INLINE stp_ivec3 stp_unit_normal(stp_ivec3 n)
{
    int32_t square = n.v[0] * n.v[0] + n.v[1] * n.v[1] + n.v[2] * n.v[2];
    int32_t length = (int32_t)sqrt(65536.0 * square); /* 256 times the length */
    int32_t scale = (int32_t)(0x1p38 / length);
    for (int i = 0; i < 3; i++)
        n.v[i] = (n.v[i] * scale + (1 << 15)) >> 16;
    return n;
}

/* The code of a direction of any length; leaves `code` as it is if d is zero. |components| < 2^29.
 */
STP_INLINE void stp_direction_code(stp_ivec3 d, int32_t code[2])
{
    int32_t length = abs(d.v[0]) + abs(d.v[1]) + abs(d.v[2]);
    bool folded = d.v[2] < 0;
    if (length == 0)
        return;
    for (int i = 0; i < 2; i++) {
        int32_t x = folded ? (length - abs(d.v[1 - i])) * stp_sign_not_zero(d.v[i]) : d.v[i];
        double steps = ((double)x + length) * STP_NORMAL_CODE_MAX + length;
        code[i] = (int32_t)(steps / (2.0 * length));
    }
}

/* How normals turn from sibling to sibling among the parents, along two axes. */
typedef struct stp_turning {
    int axis[2];
    unsigned shift;
    int64_t turn[2][3]; /* by axis, of each component, for a step of 2^shift */
} stp_turning;

/* One to four siblings. */
typedef struct stp_siblings {
    unsigned count;
    stp_ivec3 position[4], normal[4];
} stp_siblings;

/* Offsets of the siblings from their mean along the turning's axes, times count / 2^shift. */
STP_INLINE void stp_sibling_offsets(const stp_siblings *s, int main_axis, int32_t offset[2][4],
                                    stp_turning *out)
{
    int32_t extent = 0;
    for (int j = 0; j < 2; j++) {
        int axis = (main_axis + 1 + j) % 3;
        int32_t sum = 0;
        out->axis[j] = axis;
        for (unsigned k = 0; k < s->count; k++)
            sum += s->position[k].v[axis];
        for (unsigned k = 0; k < s->count; k++) {
            offset[j][k] = (int32_t)s->count * s->position[k].v[axis] - sum;
            extent |= abs(offset[j][k]);
        }
    }
    out->shift = 0;
    while (extent >> out->shift >= 1 << STP_TURN_OFFSET_BITS)
        out->shift++;
    for (int j = 0; j < 2; j++)
        for (unsigned k = 0; k < s->count; k++)
            offset[j][k] >>= out->shift;
}

/* Least squares through the siblings, damped a little, so that an outlier makes no slope. */
STP_INLINE void stp_turning_fit(const stp_siblings *s, stp_turning *out)
{
    stp_ivec3 sum = {{0, 0, 0}};
    int32_t offset[2][4];
    int64_t aa = 0, ab = 0, bb = 0;
    int64_t a[3] = {0}, b[3] = {0};
    for (unsigned k = 0; k < s->count; k++)
        for (int i = 0; i < 3; i++)
            sum.v[i] += s->normal[k].v[i];
    stp_sibling_offsets(s, stp_main_axis(sum), offset, out);
    for (unsigned k = 0; k < s->count; k++) {
        int64_t da = offset[0][k];
        int64_t db = offset[1][k];
        aa += da * da;
        ab += da * db;
        bb += db * db;
        for (int i = 0; i < 3; i++) {
            int32_t change = (int32_t)s->count * s->normal[k].v[i] - sum.v[i];
            a[i] += da * change;
            b[i] += db * change;
        }
    }
    int64_t hold = ((aa + bb) >> 4) + 1;
    aa += hold;
    bb += hold;
    double determinant = (double)(aa * bb - ab * ab);
    double scale = 1 << STP_TURN_SHIFT;
    for (int i = 0; i < 3; i++) {
        out->turn[0][i] = (int64_t)(scale * (double)(a[i] * bb - b[i] * ab) / determinant);
        out->turn[1][i] = (int64_t)(scale * (double)(b[i] * aa - a[i] * ab) / determinant);
    }
}

/* How far the normal turns over the offset from a parent to its child. */
STP_INLINE stp_ivec3 stp_turning_over(const stp_turning *t, const int32_t *offset)
{
    stp_ivec3 out;
    for (int i = 0; i < 3; i++) {
        int64_t turn = t->turn[0][i] * offset[t->axis[0]] + t->turn[1][i] * offset[t->axis[1]];
        turn >>= STP_TURN_SHIFT + t->shift;
        out.v[i] = (int32_t)(turn > STP_TURN_LIMIT    ? STP_TURN_LIMIT
                             : turn < -STP_TURN_LIMIT ? -STP_TURN_LIMIT
                                                      : turn);
    }
    return out;
}

/* A family's normals. */
typedef struct stp_family_normals {
    stp_ivec3 parent;
    stp_ivec3 sum;    /* of weight * unit normal over the elder siblings */
    stp_ivec3 turned; /* of weight * turning to each */
} stp_family_normals;

/* Direction of an elder child: the mean of the children that are left, plus this child's turning.
 * weight_all: of all children; weight_left: of those left. */
STP_INLINE stp_ivec3 stp_elder_direction(const stp_family_normals *f, int32_t weight_all,
                                         int32_t weight_left, stp_ivec3 turning)
{
    stp_ivec3 out;
    for (int i = 0; i < 3; i++)
        out.v[i] =
            weight_all * f->parent.v[i] - f->sum.v[i] + f->turned.v[i] + weight_left * turning.v[i];
    return out;
}

/* Direction of the last child: the unit vector, times the child's weight, that makes the sum of all
 * children point where the parent does. */
STP_INLINE stp_ivec3 stp_last_direction(const stp_family_normals *f, int32_t weight)
{
    int64_t along = 0, square = 0;
    int64_t own = (int64_t)weight << STP_UNIT_SHIFT;
    stp_ivec3 out;
    for (int i = 0; i < 3; i++) {
        along += (int64_t)f->parent.v[i] * f->sum.v[i];
        square += (int64_t)f->sum.v[i] * f->sum.v[i];
    }
    along >>= STP_UNIT_SHIFT;
    int64_t under = along * along - square + own * own;
    int64_t length = along + (under > 0 ? (int64_t)sqrt((double)under) : 0);
    for (int i = 0; i < 3; i++)
        out.v[i] = (int32_t)((length * f->parent.v[i]) >> STP_UNIT_SHIFT) - f->sum.v[i];
    return out;
}

#endif
