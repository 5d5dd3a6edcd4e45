/* Which neighbours of a point are on its own sheet. */
#include "preprocess/layer.h"

#define SHEET_GAP 0.35f /* spacings without a point between two sheets */

float stp_layer_height(const stp_cloud *cloud, uint32_t a, vec3s normal, uint32_t b)
{
    return glms_vec3_dot(normal, stp_dvec3_to_float(stp_dvec3_sub(cloud->points[b].position,
                                                                  cloud->points[a].position)));
}

static void insert_sorted(float *sorted, unsigned count, float value)
{
    for (; count > 0 && sorted[count - 1] > value; count--)
        sorted[count] = sorted[count - 1];
    sorted[count] = value;
}

/* Goes from the point's own height up and down to the first gap. */
stp_layer stp_layer_find(const stp_cloud *cloud, uint32_t self, vec3s normal, const uint32_t *list,
                         unsigned k)
{
    float heights[STP_NEIGHBOURS_LIMIT + 1] = {0.0f};
    float gap = SHEET_GAP * cloud->points[self].spacing;
    unsigned count = 1;
    for (unsigned i = 0; i < k && list[i] != STP_NEIGHBOUR_NONE; i++)
        insert_sorted(heights, count++, stp_layer_height(cloud, self, normal, list[i]));
    unsigned low = 0;
    while (heights[low] < 0.0f)
        low++;
    unsigned high = low;
    while (low > 0 && heights[low] - heights[low - 1] <= gap)
        low--;
    while (high + 1 < count && heights[high + 1] - heights[high] <= gap)
        high++;
    return (stp_layer){heights[low], heights[high]};
}
