/* The divider's arithmetic. */
#include "tools/view/beside/view_divider.h"

#include <math.h>

int view_divider_column(const view_divider *d, int width)
{
    if (d->shows != VIEW_DIVIDER_BOTH)
        return d->shows == VIEW_DIVIDER_LEFT ? width : 0;
    return (int)floor(d->at * width + 0.5);
}

int view_divider_side(const view_divider *d, int width, double x)
{
    const bool right = x >= view_divider_column(d, width);
    return right != d->swapped;
}

bool view_divider_take(view_divider *d, int width, double x, double reach)
{
    const double offset = x - view_divider_column(d, width);
    if (d->shows != VIEW_DIVIDER_BOTH || !(fabs(offset) <= reach))
        return false;
    d->dragged = true;
    d->offset = offset;
    return true;
}

void view_divider_drag(view_divider *d, int width, double x)
{
    d->at = fmin(fmax((x - d->offset) / width, 0.0), 1.0);
}

void view_divider_step(view_divider *d, double by)
{
    d->shows = VIEW_DIVIDER_BOTH;
    d->at = fmin(fmax(d->at + by, 0.0), 1.0);
}
