/* Lists of places as steps of few bytes. */
#include "preprocess/cloud/place_list.h"

#include "preprocess/cloud/cloud.h"
#include "preprocess/cloud/nearest_list.h"

_Static_assert(STP_PLACE_BITS + 1 <= 7 * STP_PLACE_BYTES, "a step takes no more");

/* A place is stored as the step to it from `self`, since neighbours are usually near. A byte holds
 * STEP_BITS bits, lowest first; its top bit says that more follow. The lowest bit of the whole says
 * that the step goes down. No point is its own neighbour, so step 0 stands for none. */
#define STEP_BITS 7u

uint8_t *stp_place_list_write(uint8_t *at, uint64_t self, uint64_t place)
{
    int64_t step = place == STP_PLACE_NONE ? 0 : (int64_t)place - (int64_t)self;
    uint64_t left = step < 0 ? 2 * (uint64_t)-step - 1 : 2 * (uint64_t)step;
    for (; left >> STEP_BITS; left >>= STEP_BITS)
        *at++ = (uint8_t)(left | 1u << STEP_BITS);
    *at++ = (uint8_t)left;
    return at;
}

const uint8_t *stp_place_list_next(const uint8_t *at, uint64_t self, unsigned k, uint64_t *out)
{
    for (unsigned n = 0; n < k; n++) {
        uint64_t coded = 0;
        unsigned shift = 0;
        for (; *at >> STEP_BITS; shift += STEP_BITS)
            coded |= (uint64_t)(*at++ & ((1u << STEP_BITS) - 1)) << shift;
        coded |= (uint64_t)*at++ << shift;
        const uint64_t half = coded / 2;
        out[n] = coded == 0 ? STP_PLACE_NONE : coded & 1 ? self - half - 1 : self + half;
    }
    return at;
}
