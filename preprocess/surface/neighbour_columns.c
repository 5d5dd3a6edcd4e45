/* Gathers neighbours in columns. */
#include "preprocess/surface/neighbour_columns.h"

#include "preprocess/cloud/nearest_list.h"

static void take_column(stp_neighbour_columns *out, const stp_unit *unit, uint32_t self,
                        unsigned lane, double scale)
{
    const uint32_t *list = unit->neighbours.indices + (size_t)self * out->k;
    const stp_cloud_point *points = unit->cloud.points;
    const stp_dvec3 p = points[self].position;
    const unsigned count = stp_neighbours_known(list, out->k);
    for (unsigned i = 0; i < count; i++) {
        const stp_cloud_point *q = &points[list[i]];
        out->places[i][0][lane] = (float)((q->position.x - p.x) * scale);
        out->places[i][1][lane] = (float)((q->position.y - p.y) * scale);
        out->places[i][2][lane] = (float)((q->position.z - p.z) * scale);
        out->spacings[i][lane] = (float)scale * q->spacing;
    }
    for (unsigned i = count; i < out->k; i++) {
        for (int a = 0; a < 3; a++)
            out->places[i][a][lane] = 0.0f;
        out->spacings[i][lane] = 0.0f;
    }
    out->counts[lane] = count;
}

void stp_neighbour_columns_take(stp_neighbour_columns *out, const stp_unit *unit, uint32_t first,
                                uint32_t end, double scale)
{
    out->first = first;
    out->k = unit->neighbours.k;
    for (uint32_t i = 0; i < STP_MOMENTS_LANES; i++)
        take_column(out, unit, first + i < end ? first + i : end - 1, i, scale);
}
