/* Codes of normals, radii, errors and angles, and the decoding of a sample. */
#include "formats/chunk/sample/sample.h"

#include "base/wide.h"

#define OCT_MAX 4095.0f

static inline float sign_not_zero(float v)
{
    return v < 0.0f ? -1.0f : 1.0f;
}

void stp_normal_encode(vec3s normal, uint8_t out[3])
{
    float sum = fabsf(normal.x) + fabsf(normal.y) + fabsf(normal.z);
    float u = 0.0f;
    float v = 0.0f;
    if (sum > 0.0f && isfinite(sum)) {
        u = normal.x / sum;
        v = normal.y / sum;
        if (normal.z < 0.0f) {
            float folded = (1.0f - fabsf(v)) * sign_not_zero(u);
            v = (1.0f - fabsf(u)) * sign_not_zero(v);
            u = folded;
        }
    }
    uint32_t iu = (uint32_t)lrintf((u * 0.5f + 0.5f) * OCT_MAX);
    uint32_t iv = (uint32_t)lrintf((v * 0.5f + 0.5f) * OCT_MAX);
    uint32_t word = iu | iv << 12;
    out[0] = (uint8_t)(word & 255u);
    out[1] = (uint8_t)(word >> 8 & 255u);
    out[2] = (uint8_t)(word >> 16);
}

/* Unpacks two codes of 12 bits. */
static inline void decode_normal(uint32_t word, float out[3])
{
    float u = (float)(int32_t)(word & 4095u) / OCT_MAX * 2.0f - 1.0f;
    float v = (float)(int32_t)(word >> 12 & 4095u) / OCT_MAX * 2.0f - 1.0f;
    float z = 1.0f - fabsf(u) - fabsf(v);
    float fold = z < 0.0f ? -z : 0.0f;
    u -= sign_not_zero(u) * fold;
    v -= sign_not_zero(v) * fold;
    float scale = 1.0f / sqrtf(u * u + v * v + z * z);
    out[0] = u * scale;
    out[1] = v * scale;
    out[2] = z * scale;
}

static inline uint32_t normal_word(const uint8_t code[3])
{
    return (uint32_t)code[0] | (uint32_t)code[1] << 8 | (uint32_t)code[2] << 16;
}

vec3s stp_normal_decode(const uint8_t code[3])
{
    vec3s n = GLMS_VEC3_ZERO_INIT;
    decode_normal(normal_word(code), n.raw);
    return n;
}

void stp_normals_decode(const uint32_t code[4], float out[3][4])
{
    for (unsigned i = 0; i < 4; i++) {
        float n[3];
        decode_normal(code[i], n);
        for (int a = 0; a < 3; a++)
            out[a][i] = n[a];
    }
}

/* 2^(i / 16), rounded to the nearest double. */
static const double fractions[16] = {
    0x1.0000000000000p+0, 0x1.0b5586cf9890fp+0, 0x1.172b83c7d517bp+0, 0x1.2387a6e756238p+0,
    0x1.306fe0a31b715p+0, 0x1.3dea64c123422p+0, 0x1.4bfdad5362a27p+0, 0x1.5ab07dd485429p+0,
    0x1.6a09e667f3bcdp+0, 0x1.7a11473eb0187p+0, 0x1.8ace5422aa0dbp+0, 0x1.9c49182a3f090p+0,
    0x1.ae89f995ad3adp+0, 0x1.c199bdd85529cp+0, 0x1.d5818dcfba487p+0, 0x1.ea4afa2a490dap+0};

/* A value that exceeds a code's value by at most this part of it still gets that code. */
#define CODE_SLACK 0x1.3p-34

/* The code for which 2^((code - 1) / per_octave - bias) steps >= value; 0 for value 0 or less.
 * per_octave: 8 or 16. */
static uint8_t log_encode(double value, int exponent, int per_octave, int bias)
{
    int octave = 0, part = 0;
    if (!(value > 0.0))
        return 0;
    if (isinf(value))
        return 255;
    const double mantissa = 2.0 * frexp(value, &octave) * (1.0 - CODE_SLACK); /* 1 to 2 */
    for (int i = 0; i < 16; i += 16 / per_octave)
        part += mantissa > fractions[i];
    int64_t code = (int64_t)(octave - 1 - exponent + bias) * per_octave + part + 1;
    return (uint8_t)(code < 1 ? 1 : code > 255 ? 255 : code);
}

/* per_octave: 8 or 16. */
static double log_decode(uint8_t code, int exponent, int per_octave, int bias)
{
    if (code == 0)
        return 0.0;
    int index = code - 1;
    double fraction = fractions[index % per_octave * (16 / per_octave)];
    return fraction * stp_power_of_two(index / per_octave - bias + exponent);
}

uint8_t stp_radius_encode(double radius, int exponent)
{
    return log_encode(radius, exponent, STP_RADIUS_CODES_PER_OCTAVE, 0);
}

double stp_radius_decode(uint8_t code, int exponent)
{
    return log_decode(code, exponent, STP_RADIUS_CODES_PER_OCTAVE, 0);
}

uint8_t stp_error_encode(double error, int exponent)
{
    return log_encode(error, exponent, STP_ERROR_CODES_PER_OCTAVE, STP_ERROR_CODE_BIAS_OCTAVES);
}

double stp_error_decode(uint8_t code, int exponent)
{
    return log_decode(code, exponent, STP_ERROR_CODES_PER_OCTAVE, STP_ERROR_CODE_BIAS_OCTAVES);
}

uint8_t stp_cone_angle_encode(double angle)
{
    double code = ceil(angle * 255.0 / M_PI - 1e-9);
    return (uint8_t)(code <= 0.0 ? 0.0 : code > 255.0 ? 255.0 : code);
}

double stp_cone_angle_decode(uint8_t code)
{
    return (double)code * M_PI / 255.0;
}

double stp_sample_radius(const stp_sample *sample, const stp_patch *patch)
{
    return stp_radius_decode(sample->radius, patch->exponent);
}

/* A sample is described by one word of its normal and whether it has a normal. */
STP_WIDE
static void decode_normals(const uint32_t word[STP_PATCH_SAMPLES],
                           const double known[STP_PATCH_SAMPLES], unsigned count,
                           stp_sample_lanes *out)
{
    for (unsigned i = 0; i < count; i++) {
        float n[3];
        decode_normal(word[i], n);
        double x = (double)n[0], y = (double)n[1], z = (double)n[2];
        double scale = known[i] / sqrt(x * x + y * y + z * z);
        out->normal[0][i] = x * scale;
        out->normal[1][i] = y * scale;
        out->normal[2][i] = z * scale;
    }
}

void stp_samples_decode(const stp_sample *samples, unsigned count, const stp_patch *patch,
                        stp_sample_lanes *out)
{
    const double step = stp_power_of_two(patch->exponent);
    uint32_t word[STP_PATCH_SAMPLES];
    double known[STP_PATCH_SAMPLES];
    for (unsigned i = 0; i < count; i++) {
        const stp_sample *s = &samples[i];
        word[i] = normal_word(s->normal);
        known[i] = stp_sample_is_flat(s) ? 1.0 : 0.0;
        out->radius[i] = stp_radius_decode(s->radius, patch->exponent);
        for (int a = 0; a < 3; a++)
            out->centre[a][i] = ((double)patch->origin[a] + s->position[a]) * step;
    }
    decode_normals(word, known, count, out);
}
