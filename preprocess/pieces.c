/* Pieces of a patch that no surface joins. */
#include "preprocess/pieces.h"

#include <math.h>
#include <stdbool.h>

/* A surface joins two places no farther apart than so many spacings, their heights over each
 * other's planes counted threefold, whose normals differ by at most 60 degrees. */
#define LINK_SPACINGS 3.0f
#define HEIGHT_WEIGHT 8.0f /* of squares, beyond the 1 that is in the distance */
#define LINK_COSINE 0.5f

static bool has_normal(const stp_place *p)
{
    return p->key[3] != 0.0f || p->key[4] != 0.0f || p->key[5] != 0.0f;
}

static bool linked(const stp_place *a, const stp_place *b)
{
    float squared = 0.0f, over_a = 0.0f, over_b = 0.0f, cosine = 0.0f;
    for (int axis = 0; axis < 3; axis++) {
        float d = b->key[axis] - a->key[axis];
        squared += d * d;
        over_a += d * a->key[3 + axis];
        over_b += d * b->key[3 + axis];
        cosine += a->key[3 + axis] * b->key[3 + axis];
    }
    float reach = LINK_SPACINGS * (a->spacing > b->spacing ? a->spacing : b->spacing);
    float height = fmaxf(fabsf(over_a), fabsf(over_b));
    return squared + HEIGHT_WEIGHT * height * height <= reach * reach &&
           (fabsf(cosine) >= LINK_COSINE || !has_normal(a) || !has_normal(b));
}

unsigned stp_pieces_number(const stp_place *places, uint32_t count, uint8_t *piece)
{
    uint8_t queue[STP_PATCH_SAMPLES], left[STP_PATCH_SAMPLES];
    unsigned pieces = 0;
    for (uint32_t i = 0; i < count; i++)
        left[i] = (uint8_t)i;
    for (uint32_t left_count = count; left_count > 0; pieces++) {
        uint32_t queued = 1;
        queue[0] = left[0];
        left[0] = left[--left_count];
        for (uint32_t at = 0; at < queued; at++) {
            piece[queue[at]] = (uint8_t)pieces;
            for (uint32_t i = 0; i < left_count;) {
                if (linked(&places[queue[at]], &places[left[i]])) {
                    queue[queued++] = left[i];
                    left[i] = left[--left_count];
                } else {
                    i++;
                }
            }
        }
    }
    return pieces;
}
