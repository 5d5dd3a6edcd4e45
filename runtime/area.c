/* Projects the corners of the root's box. */
#include "runtime/area.h"

#define MARGIN_PX 2.0

stp_rectangle stp_model_area(const stp_model *model, const stp_view *view)
{
    const stp_chunk_entry *root = &model->entries[0];
    const stp_rectangle whole = {0, 0, view->width, view->height};
    double x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY;
    for (int i = 0; i < 8; i++) {
        stp_dvec3 corner = {(double)(i & 1 ? root->box_max.x : root->box_min.x),
                            (double)(i & 2 ? root->box_max.y : root->box_min.y),
                            (double)(i & 4 ? root->box_max.z : root->box_min.z)};
        stp_dvec3 w = stp_view_project(view, stp_dvec3_add(root->origin, corner));
        if (!view->orthographic && w.z <= view->near_depth)
            return whole;
        x0 = fmin(x0, w.x);
        y0 = fmin(y0, w.y);
        x1 = fmax(x1, w.x);
        y1 = fmax(y1, w.y);
    }
    x0 = fmin(fmax(x0 - MARGIN_PX, 0.0), view->width);
    y0 = fmin(fmax(y0 - MARGIN_PX, 0.0), view->height);
    x1 = fmin(fmax(x1 + MARGIN_PX, 0.0), view->width);
    y1 = fmin(fmax(y1 + MARGIN_PX, 0.0), view->height);
    return (stp_rectangle){(int)x0, (int)y0, (int)ceil(x1) - (int)x0, (int)ceil(y1) - (int)y0};
}
