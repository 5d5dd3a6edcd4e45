/* Finds the neighbours on a point's own sheet. */
#include "preprocess/surface/layer.h"

#include "base/wide.h"
#include "preprocess/cloud/nearest_list.h"

#include <string.h>

#define LANES 8
typedef float lanes __attribute__((vector_size(4 * LANES)));
typedef int32_t bits __attribute__((vector_size(4 * LANES)));

/* *to becomes `from` where chosen. */
static inline void choose(lanes *to, const bits *chosen, const lanes *from)
{
    *to = (lanes)((*chosen & (bits)*from) | (~*chosen & (bits)*to));
}

/* Goes from the point's own height up and down to the first gaps. */
STP_WIDE
stp_layer stp_layer_of(const float *heights, unsigned count, float gap)
{
    lanes h[STP_NEIGHBOURS_LIMIT / LANES] = {{0.0f}}; /* 0 is the point's own */
    const unsigned steps = (count + LANES - 1) / LANES;
    stp_layer layer = {0.0f, 0.0f};
    memcpy(h, heights, count * sizeof *heights);
    for (;;) { /* few rounds: most heights are within a gap of the point's own */
        stp_layer wider = layer;
        lanes low = layer.low - (lanes){0.0f}, high = layer.high - (lanes){0.0f};
        for (unsigned i = 0; i < steps; i++) {
            const bits above = (h[i] > high) & (h[i] - layer.high <= gap);
            const bits below = (h[i] < low) & (layer.low - h[i] <= gap);
            choose(&high, &above, &h[i]);
            choose(&low, &below, &h[i]);
        }
        for (unsigned i = 0; i < LANES; i++) {
            wider.high = high[i] > wider.high ? high[i] : wider.high;
            wider.low = low[i] < wider.low ? low[i] : wider.low;
        }
        if (wider.low == layer.low && wider.high == layer.high)
            return layer;
        layer = wider;
    }
}

stp_layer stp_layer_find(const stp_cloud *cloud, uint32_t self, vec3s normal, const uint32_t *list,
                         unsigned k, float gap)
{
    float heights[STP_NEIGHBOURS_LIMIT] = {0.0f};
    unsigned count = 0;
    for (; count < k && list[count] != STP_NEIGHBOUR_NONE; count++)
        heights[count] = stp_layer_height(cloud, self, normal, list[count]);
    return stp_layer_of(heights, count, gap);
}
