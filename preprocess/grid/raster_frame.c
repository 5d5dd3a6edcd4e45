/* Finds where the samples of a raster lie. */
#include "preprocess/grid/raster_frame.h"

#include <math.h>

/* Of a bent raster: the plane through the middles of the sides of four nodes. */
static stp_raster_frame bent_frame(const stp_scan_raster *r, const stp_dvec3 *nodes,
                                   uint32_t column, uint32_t row)
{
    const uint32_t i = column / STP_RASTER_NODE, j = row / STP_RASTER_NODE;
    const size_t across = stp_raster_node_count(r->columns);
    const stp_dvec3 *n = nodes + j * across + i;
    stp_raster_frame out = {.first = {i * STP_RASTER_NODE, j * STP_RASTER_NODE}};
    const double columns = stp_raster_node_column(i + 1, r->columns) - out.first[0];
    const double rows = stp_raster_node_column(j + 1, r->rows) - out.first[1];
    const double corner[4][2] = {{n[0].x, n[0].y},
                                 {n[1].x, n[1].y},
                                 {n[across].x, n[across].y},
                                 {n[across + 1].x, n[across + 1].y}};
    for (int k = 0; k < 2; k++) {
        const double right = (corner[1][k] - corner[0][k]) + (corner[3][k] - corner[2][k]);
        const double down = (corner[2][k] - corner[0][k]) + (corner[3][k] - corner[1][k]);
        out.by_column[k] = 0.5 * right / columns;
        out.by_row[k] = 0.5 * down / rows;
        out.at[k] = 0.25 * (corner[0][k] + corner[1][k] + corner[2][k] + corner[3][k]) -
                    0.25 * (right + down);
    }
    return out;
}

stp_raster_frame stp_raster_frame_at(const stp_scan_raster *raster, const stp_dvec3 *nodes,
                                     uint32_t column, uint32_t row)
{
    stp_raster_frame out = {
        .at = {raster->x, raster->y}, .by_column = {raster->dx, 0.0}, .by_row = {0.0, -raster->dy}};
    if (nodes)
        out = bent_frame(raster, nodes, column, row);
    const double *c = out.by_column, *r = out.by_row;
    out.wide = hypot(c[0], c[1]);
    out.deep = hypot(r[0], r[1]);
    out.area = c[0] * r[1] - c[1] * r[0];
    return out;
}

stp_dvec3 stp_raster_frame_place(const stp_raster_frame *frame, double column, double row)
{
    const double c = column - frame->first[0], r = row - frame->first[1];
    return (stp_dvec3){frame->at[0] + c * frame->by_column[0] + r * frame->by_row[0],
                       frame->at[1] + c * frame->by_column[1] + r * frame->by_row[1], 0.0};
}

double stp_raster_cell(const stp_scan_raster *raster, const stp_dvec3 *nodes)
{
    const stp_raster_frame frame =
        stp_raster_frame_at(raster, nodes, raster->columns / 2, raster->rows / 2);
    return fmin(frame.wide, frame.deep);
}
