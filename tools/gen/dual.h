/* Dual numbers: a value and its gradient in space. A shape is written once and its exact normals
 * come with it (forward-mode differentiation, e.g. Griewank and Walther 2008, chapter 3).
 *
 * Single precision in one vector register: lane 0 is the value, lanes 1..3 are the derivatives by
 * x, y, z. Needs only the vector extension of gcc and clang. */
#ifndef STP_TOOLS_GEN_DUAL_H
#define STP_TOOLS_GEN_DUAL_H

#include <math.h>

typedef float gen_dual __attribute__((vector_size(16)));

typedef struct gen_dual3 {
    gen_dual x, y, z;
} gen_dual3;

static inline gen_dual gd_constant(float value)
{
    return (gen_dual){value, 0.0f, 0.0f, 0.0f};
}

/* The three coordinates as functions of themselves. */
static inline gen_dual3 gd_variable(float x, float y, float z)
{
    return (gen_dual3){{x, 1.0f, 0.0f, 0.0f}, {y, 0.0f, 1.0f, 0.0f}, {z, 0.0f, 0.0f, 1.0f}};
}

/* f(a), if f has this value and this derivative at a. */
static inline gen_dual gd_chain(gen_dual a, float value, float derivative)
{
    gen_dual result = a * derivative;
    result[0] = value;
    return result;
}

static inline gen_dual gd_shift(gen_dual a, float offset)
{
    a[0] += offset;
    return a;
}

static inline gen_dual gd_mul(gen_dual a, gen_dual b)
{
    gen_dual result = a * b[0] + b * a[0];
    result[0] = a[0] * b[0];
    return result;
}

static inline gen_dual gd_square(gen_dual a)
{
    return gd_chain(a, a[0] * a[0], 2.0f * a[0]);
}

static inline gen_dual gd_div(gen_dual a, gen_dual b)
{
    float inverse = 1.0f / b[0];
    float quotient = a[0] * inverse;
    gen_dual result = (a - b * quotient) * inverse;
    result[0] = quotient;
    return result;
}

/* Values of 0 and below give 0 with slope 0, so that points on an axis are harmless. */
static inline gen_dual gd_sqrt(gen_dual a)
{
    if (!(a[0] > 1e-20f))
        return gd_constant(0.0f);
    float root = sqrtf(a[0]);
    return gd_chain(a, root, 0.5f / root);
}

static inline gen_dual gd_abs(gen_dual a)
{
    return a[0] < 0.0f ? -a : a;
}

static inline gen_dual gd_sin(gen_dual a)
{
    return gd_chain(a, sinf(a[0]), cosf(a[0]));
}

static inline gen_dual gd_cos(gen_dual a)
{
    return gd_chain(a, cosf(a[0]), -sinf(a[0]));
}

static inline gen_dual gd_atan2(gen_dual y, gen_dual x)
{
    float square = x[0] * x[0] + y[0] * y[0];
    float inverse = square > 1e-20f ? 1.0f / square : 0.0f;
    gen_dual result = (y * x[0] - x * y[0]) * inverse;
    result[0] = atan2f(y[0], x[0]);
    return result;
}

static inline gen_dual gd_min(gen_dual a, gen_dual b)
{
    return a[0] < b[0] ? a : b;
}

static inline gen_dual gd_max(gen_dual a, gen_dual b)
{
    return a[0] > b[0] ? a : b;
}

/* Union with a fillet of width k. Exactly the minimum if a and b differ by k or more, so that far
 * parts may be left out. Source: Quilez, "smooth minimum", the quadratic polynomial. */
static inline gen_dual gd_smooth_min(gen_dual a, gen_dual b, float k)
{
    gen_dual difference = gd_abs(a - b);
    if (difference[0] >= k)
        return gd_min(a, b);
    gen_dual h = gd_shift(-difference, k);
    return gd_min(a, b) - gd_square(h) * (0.25f / k);
}

static inline gen_dual gd_smooth_max(gen_dual a, gen_dual b, float k)
{
    return -gd_smooth_min(-a, -b, k);
}

static inline gen_dual gd_clamp(gen_dual a, float low, float high)
{
    return a[0] < low ? gd_constant(low) : a[0] > high ? gd_constant(high) : a;
}

/* 0 below low, 1 above high, once differentiable between. */
static inline gen_dual gd_smoothstep(float low, float high, gen_dual a)
{
    float t = (a[0] - low) / (high - low);
    if (t <= 0.0f)
        return gd_constant(0.0f);
    if (t >= 1.0f)
        return gd_constant(1.0f);
    return gd_chain(a, t * t * (3.0f - 2.0f * t), 6.0f * t * (1.0f - t) / (high - low));
}

static inline gen_dual gd_mix(gen_dual a, gen_dual b, gen_dual t)
{
    return a + gd_mul(b - a, t);
}

static inline gen_dual gd_length2(gen_dual x, gen_dual y)
{
    return gd_sqrt(gd_square(x) + gd_square(y));
}

static inline gen_dual gd_length3(gen_dual3 p)
{
    return gd_sqrt(gd_square(p.x) + gd_square(p.y) + gd_square(p.z));
}

#endif
