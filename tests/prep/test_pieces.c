/* Tests pieces of a patch: places scattered over folds and creases are parted as by a plain flood
 * fill. */
#include "base/random.h"
#include "preprocess/patch/pieces.h"

#include <limits.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static bool has_normal(const stp_place *p)
{
    return p->key[3] != 0.0f || p->key[4] != 0.0f || p->key[5] != 0.0f;
}

/* Whether a surface joins two places, by the definition. */
static bool is_joined(const stp_place *a, const stp_place *b)
{
    double squared = 0.0, over_a = 0.0, over_b = 0.0, cosine = 0.0;
    for (int i = 0; i < 3; i++) {
        const double d = (double)b->key[i] - (double)a->key[i];
        squared += d * d;
        over_a += d * (double)a->key[3 + i];
        over_b += d * (double)b->key[3 + i];
        cosine += (double)a->key[3 + i] * (double)b->key[3 + i];
    }
    const bool known = has_normal(a) && has_normal(b);
    const double height = fmax(fabs(over_a), fabs(over_b));
    const double reach = 3.0 * fmax((double)a->spacing, (double)b->spacing);
    return squared + 8.0 * height * height <= reach * reach && (!known || fabs(cosine) >= 0.5);
}

/* Fills piece[] with the number of each place's piece. Returns how many there are. */
static unsigned flood(const stp_place *places, const uint32_t *order, uint32_t count,
                      unsigned piece[STP_PATCH_SAMPLES])
{
    uint32_t queue[STP_PATCH_SAMPLES];
    unsigned pieces = 0;
    for (uint32_t i = 0; i < count; i++)
        piece[i] = UINT_MAX;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t end = 0;
        if (piece[i] != UINT_MAX)
            continue;
        piece[i] = pieces;
        queue[end++] = i;
        for (uint32_t at = 0; at < end; at++)
            for (uint32_t j = 0; j < count; j++)
                if (piece[j] == UINT_MAX &&
                    is_joined(&places[order[queue[at]]], &places[order[j]])) {
                    piece[j] = pieces;
                    queue[end++] = j;
                }
        pieces++;
    }
    return pieces;
}

static float unit(uint64_t seed, uint64_t *n)
{
    return (float)stp_random_unit(seed, (*n)++);
}

/* Places in a box that is up to 11 spacings wide, on one of a few sheets at angles, or alone. */
static void scatter(uint64_t seed, uint32_t count, stp_place *places)
{
    static const float normals[4][3] = {
        {0.0f, 0.0f, 1.0f}, {0.8f, 0.0f, 0.6f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, 0.0f}};
    uint64_t n = 0;
    const float side = 1.0f + 10.0f * unit(seed, &n);
    for (uint32_t i = 0; i < count; i++) {
        const unsigned kind = (unsigned)(4.0f * unit(seed, &n));
        stp_place *p = &places[i];
        *p = (stp_place){.spacing = 0.5f + unit(seed, &n)};
        for (int a = 0; a < 3; a++) {
            p->key[a] = side * (a == 2 ? 0.3f : 1.0f) * unit(seed, &n);
            p->key[3 + a] = normals[kind][a];
        }
    }
}

static void pieces_are_found(void **state)
{
    (void)state;
    unsigned alone = 0, several = 0;
    for (uint64_t seed = 0; seed < 4000; seed++) {
        const uint32_t count = 1 + (uint32_t)(seed % STP_PATCH_SAMPLES);
        stp_place places[STP_PATCH_SAMPLES];
        uint32_t order[STP_PATCH_SAMPLES];
        unsigned piece[STP_PATCH_SAMPLES];
        uint64_t first = 0, expected = 0;
        scatter(seed, count, places);
        for (uint32_t i = 0; i < count; i++)
            order[i] = count - 1 - i;
        const unsigned pieces = flood(places, order, count, piece);
        for (uint32_t i = 0; i < count; i++)
            expected |= (uint64_t)(piece[i] == 0) << i;
        assert_int_equal(stp_pieces_count(places, order, count, &first), pieces);
        assert_true(first == expected);
        alone += pieces == 1;
        several += pieces > 2;
    }
    assert_true(alone > 400 && several > 400);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(pieces_are_found)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
