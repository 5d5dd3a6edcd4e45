/* Finds the pieces of a patch. */
#include "preprocess/patch/pieces.h"

#include "base/wide.h"

#include <math.h>
#include <stdbool.h>

/* A surface joins two places if their normals differ by at most 60 degrees and
 *
 *     d^2 + 8 h^2 <= (3 s)^2
 *
 * d: distance; h: height over the other's plane, the greater of the two; s: spacing, the greater of
 * the two. Since d^2 contains h^2, heights count threefold. */
#define LINK_SPACINGS 3.0f
#define HEIGHT_WEIGHT 8.0f /* of squares, in addition to the 1 in d^2 */
#define LINK_COSINE 0.5f

_Static_assert(STP_PATCH_SAMPLES == 64, "a bit for each place");

/* Places that are taken at a time. */
#define STEP 8u

/* The places of a patch, by column, in whole steps. */
typedef struct lanes {
    uint32_t count;
    float key[6][STP_PATCH_SAMPLES], spacing[STP_PATCH_SAMPLES];
    float cosine[STP_PATCH_SAMPLES]; /* least cosine to other normals; -1, which all meet, if it has
                                        no normal */
} lanes;

static void lanes_fill(lanes *l, const stp_place *places, const uint32_t *order, uint32_t count)
{
    l->count = (count + STEP - 1) / STEP * STEP;
    for (uint32_t i = 0; i < l->count; i++) {
        const stp_place *p = &places[order[i < count ? i : 0]];
        bool known = p->key[3] != 0.0f || p->key[4] != 0.0f || p->key[5] != 0.0f;
        for (int c = 0; c < 6; c++)
            l->key[c][i] = p->key[c];
        l->spacing[i] = p->spacing;
        l->cosine[i] = known ? LINK_COSINE : -1.0f;
    }
}

/* One bit for each place that a surface joins to place `a`. */
STP_WIDE
static uint64_t linked_to(const lanes *l, unsigned a)
{
    float p[6];
    uint32_t joined[STP_PATCH_SAMPLES];
    const unsigned count = l->count & ~(STEP - 1); /* tells the compiler that steps are whole */
    const float spacing = l->spacing[a], least = l->cosine[a];
    uint64_t bits = 0;
    for (int c = 0; c < 6; c++)
        p[c] = l->key[c][a];
    for (unsigned i = 0; i < count; i++) {
        float squared = 0.0f, over_a = 0.0f, over_i = 0.0f, cosine = 0.0f;
        for (int axis = 0; axis < 3; axis++) {
            float d = l->key[axis][i] - p[axis], n = l->key[3 + axis][i];
            squared += d * d;
            over_a += d * p[3 + axis];
            over_i += d * n;
            cosine += p[3 + axis] * n;
        }
        over_a = fabsf(over_a);
        over_i = fabsf(over_i);
        float height = over_a > over_i ? over_a : over_i;
        float reach = LINK_SPACINGS * (spacing > l->spacing[i] ? spacing : l->spacing[i]);
        float asked = least < l->cosine[i] ? least : l->cosine[i];
        joined[i] =
            (squared + HEIGHT_WEIGHT * height * height <= reach * reach) & (fabsf(cosine) >= asked);
    }
    for (unsigned i = 0; i < count; i++)
        bits |= (uint64_t)joined[i] << i;
    return bits;
}

/* Joins those of the pieces that meet the places `joined` to the first of them. Returns how many
 * pieces are left. */
static unsigned join(uint64_t *pieces, unsigned count, uint64_t joined)
{
    unsigned left = 0, to = count;
    for (unsigned i = 0; i < count; i++) {
        const uint64_t piece = pieces[i];
        if (!(piece & joined))
            pieces[left++] = piece;
        else if (to < count)
            pieces[to] |= piece;
        else {
            to = left;
            pieces[left++] = piece;
        }
    }
    return left;
}

/* Asks places outside the first piece what they are joined to: few places suffice to show that a
 * patch is one piece. */
unsigned stp_pieces_count(const stp_place *places, const uint32_t *order, uint32_t count,
                          uint64_t *first)
{
    lanes l;
    const uint64_t all = ~(uint64_t)0 >> (STP_PATCH_SAMPLES - count);
    uint64_t pieces[STP_PATCH_SAMPLES], open = all;
    unsigned piece_count = count;
    lanes_fill(&l, places, order, count);
    pieces[0] = 1;
    for (uint32_t i = 1; i < count; i++)
        pieces[i] = (uint64_t)1 << i;
    for (uint64_t ask = 1; ask; ask = open & ~pieces[0]) {
        const unsigned at = (unsigned)__builtin_ctzll(ask);
        const uint64_t own = (uint64_t)1 << at;
        open &= ~own;
        piece_count = join(pieces, piece_count, (linked_to(&l, at) & all) | own);
    }
    *first = pieces[0];
    return piece_count;
}
