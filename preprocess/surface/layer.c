/* Finds the neighbours on a point's own sheet. */
#include "preprocess/surface/layer.h"

#include "preprocess/cloud/nearest_list.h"

/* Goes from the point's own height up and down to the first gaps. */
stp_layer stp_layer_find(const stp_cloud *cloud, uint32_t self, vec3s normal, const uint32_t *list,
                         unsigned k, float gap)
{
    float heights[STP_NEIGHBOURS_LIMIT];
    unsigned count = 0;
    for (; count < k && list[count] != STP_NEIGHBOUR_NONE; count++)
        heights[count] = stp_layer_height(cloud, self, normal, list[count]);
    stp_layer layer = {0.0f, 0.0f};
    for (;;) { /* few rounds: most heights are within a gap of the point's own */
        stp_layer wider = layer;
        for (unsigned i = 0; i < count; i++) {
            float h = heights[i];
            wider.high = h > wider.high && h - layer.high <= gap ? h : wider.high;
            wider.low = h < wider.low && layer.low - h <= gap ? h : wider.low;
        }
        if (wider.low == layer.low && wider.high == layer.high)
            return layer;
        layer = wider;
    }
}
