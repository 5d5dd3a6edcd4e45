/* Space-filling curves and a keyed permutation. */
#include "tools/gen/curve.h"

#include "base/random.h"

enum { HILBERT_BITS = 21, SIERPINSKI_DEPTH = 26, FEISTEL_ROUNDS = 6 };

/* Source: Skilling 2004, "Programming the Hilbert curve" (AxestoTranspose). */
uint64_t gen_hilbert_index(const uint32_t position[3])
{
    uint32_t x[3] = {position[0], position[1], position[2]};
    for (uint32_t q = 1u << (HILBERT_BITS - 1); q > 1; q >>= 1) {
        uint32_t below = q - 1;
        for (int i = 0; i < 3; i++) {
            if (x[i] & q) {
                x[0] ^= below;
            } else {
                uint32_t t = (x[0] ^ x[i]) & below;
                x[0] ^= t;
                x[i] ^= t;
            }
        }
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    uint32_t t = 0;
    for (uint32_t q = 1u << (HILBERT_BITS - 1); q > 1; q >>= 1)
        if (x[2] & q)
            t ^= q - 1;
    uint64_t index = 0;
    for (int bit = HILBERT_BITS - 1; bit >= 0; bit--)
        for (int i = 0; i < 3; i++)
            index = index << 1 | (((x[i] ^ t) >> bit) & 1u);
    return index;
}

void gen_sierpinski_point(double t, float barycentric[3])
{
    /* Entry a, apex b and exit c, as coordinates along the second and third corner. */
    float ax = 0.0f, ay = 0.0f, bx = 1.0f, by = 0.0f, cx = 0.0f, cy = 1.0f;
    uint32_t bits = (uint32_t)(t * (double)(1u << SIERPINSKI_DEPTH));
    for (int i = SIERPINSKI_DEPTH - 1; i >= 0; i--) {
        float mx = 0.5f * (ax + cx), my = 0.5f * (ay + cy);
        if (bits >> i & 1u) {
            ax = bx;
            ay = by;
        } else {
            cx = bx;
            cy = by;
        }
        bx = mx;
        by = my;
    }
    float third = 1.0f / 3.0f;
    barycentric[1] = (ax + bx + cx) * third;
    barycentric[2] = (ay + by + cy) * third;
    barycentric[0] = 1.0f - barycentric[1] - barycentric[2];
}

void gen_permutation_init(gen_permutation *permutation, uint64_t count, uint64_t seed)
{
    unsigned bits = 2;
    while (bits < 64 && (count - 1) >> bits != 0)
        bits++;
    *permutation = (gen_permutation){
        .count = count, .seed = seed, .low_bits = bits / 2, .high_bits = bits - bits / 2};
}

uint64_t gen_permutation_at(const gen_permutation *p, uint64_t index)
{
    uint64_t low_mask = ((uint64_t)1 << p->low_bits) - 1;
    uint64_t high_mask = ((uint64_t)1 << p->high_bits) - 1;
    /* The network permutes a power of two. Values of count or more are permuted again until they
     * are below count, which keeps the map a bijection. */
    do {
        uint64_t low = index & low_mask, high = index >> p->low_bits;
        for (unsigned round = 0; round < FEISTEL_ROUNDS; round += 2) {
            high ^= stp_random_u64(p->seed + round, low) & high_mask;
            low ^= stp_random_u64(p->seed + round + 1, high) & low_mask;
        }
        index = high << p->low_bits | low;
    } while (index >= p->count);
    return index;
}
